"""Compiled functions over the rows of arrays, on all processors."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any


def over_rows(function: Callable[..., Any], count: int, rows_a_part: int, *arguments: Any) -> None:
    """Call ``function(first, past, *arguments)`` for parts of ``range(count)``, at the same time.

    The function is compiled with ``nogil`` and writes, of each row, only what that row alone tells. Threads of
    Python's are used, not Numba's: those may neither be called from two threads nor survive a fork.
    """
    parts = [(first, min(first + rows_a_part, count)) for first in range(0, count, rows_a_part)]
    if len(parts) < 2:
        for first, past in parts:
            function(first, past, *arguments)
        return
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for done in [pool.submit(function, first, past, *arguments) for first, past in parts]:
            done.result()
