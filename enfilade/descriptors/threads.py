"""Compiled functions over the rows of arrays, on all processors."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Final

_PARTS_A_PROCESSOR: Final = 4
"""More than one, so that a thread that other programs hold up keeps the rest waiting for a small part only."""


def over_rows(function: Callable[..., Any], count: int, least_rows: int, *arguments: Any) -> None:
    """Call ``function(first, past, *arguments)`` for parts of ``range(count)``, at the same time.

    Fewer than `least_rows` are not worth a thread. The function is compiled with ``nogil`` and writes, of each row,
    only what that row alone tells. Threads of Python's are used, not Numba's: those may neither be called from two
    threads nor survive a fork.
    """
    processors = os.cpu_count() or 1
    size = max(least_rows, -(-count // (_PARTS_A_PROCESSOR * processors)))
    parts = [(first, min(first + size, count)) for first in range(0, count, size)]
    if len(parts) < 2:
        for first, past in parts:
            function(first, past, *arguments)
        return
    with ThreadPoolExecutor(processors) as pool:
        for done in [pool.submit(function, first, past, *arguments) for first, past in parts]:
            done.result()
