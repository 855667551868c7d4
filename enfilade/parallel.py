"""Work on all processors: threads, for compiled code and most of NumPy, SciPy and Shapely let go of Python's lock."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Any, Final, TypeVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

R = TypeVar("R")
T = TypeVar("T", bound=np.generic)
Index = NDArray[np.int32] | NDArray[np.int64]

_SLICES_A_THREAD: Final = 4
"""More than one, so that a thread that other programs hold up keeps the rest waiting for a small slice only."""
_LEAST: Final = 256
"""Fewer elements are done sooner than a thread begins."""


def at_once(function: Callable[..., R], calls: Iterable[tuple[Any, ...]]) -> list[R]:
    """Call ``function(*arguments)`` for all `calls`, at the same time; return what it returned, in their order."""
    waiting = list(calls)
    if len(waiting) == 1:
        return [function(*waiting[0])]
    with ThreadPoolExecutor(processors()) as threads:
        runs = [threads.submit(function, *arguments) for arguments in waiting]
    return [run.result() for run in runs]


def in_slices(function: Callable[..., R], count: int, *arguments: Any, least: int = _LEAST) -> list[R]:
    """Call ``function(first, past, *arguments)`` for slices that make up ``range(count)``, at the same time.

    The function has to be compiled with ``nogil``, and what it tells of an element, written into its arguments or
    returned, must be told by that element alone: then the result does not depend on the number of processors. Python's
    threads are used, for Numba's may neither be called from two threads nor survive a fork. Fewer than `least`
    elements are not worth a thread.

    Returns
    -------
    What the function returned for each slice, in their order; nothing for an empty range.
    """
    return at_once(function, ((first, past, *arguments) for first, past in slices(count, least)))


def slices(count: int, least: int = _LEAST) -> list[tuple[int, int]]:
    """Return the first and past-last of the slices that make up ``range(count)``, some for each processor."""
    number = min(-(-count // least), _SLICES_A_THREAD * processors())
    return list(pairwise(count * k // number for k in range(number + 1))) if number else []


def taken(values: NDArray[T], index: Index) -> NDArray[T]:
    """``values[index]`` of the rows of an array; -1 is the last."""
    found = np.empty((len(index), *values.shape[1:]), values.dtype)
    in_slices(_take, len(index), found, values, index)
    return found


def processors() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@njit(cache=True, nogil=True)
def _take(first: int, past: int, found: NDArray[T], values: NDArray[T], index: Index) -> None:
    for i in range(first, past):
        found[i] = values[index[i]]
