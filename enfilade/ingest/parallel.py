"""Compiled loops on all processors: threads, for compiled code lets go of Python's lock."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Any, Final, TypeVar

T = TypeVar("T")
_SLICES_A_THREAD: Final = 4
"""More than one, so that a thread that other programs hold up keeps the rest waiting for a small slice only."""


def in_slices(function: Callable[..., T], count: int, *arguments: Any) -> list[T]:
    """Call ``function(first, past, *arguments)`` for slices that make up ``range(count)``, at the same time.

    The function has to be compiled with ``nogil``, and what it tells of an element, written into its arguments or
    returned, must be told by that element alone: then the result does not depend on the number of processors.

    Returns
    -------
    What the function returned for each slice, in their order; nothing for an empty range.
    """
    threads = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    slices = min(count, _SLICES_A_THREAD * threads)
    ends = [count * k // slices for k in range(slices + 1)] if slices else []
    with ThreadPoolExecutor(threads) as pool:
        runs = [pool.submit(function, a, b, *arguments) for a, b in pairwise(ends)]
    return [run.result() for run in runs]
