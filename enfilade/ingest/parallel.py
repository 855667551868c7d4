"""Compiled loops on all processors: threads, for compiled code lets go of Python's lock."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any


def in_slices(function: Callable[..., None], count: int, *arguments: Any) -> None:
    """Call ``function(first, past, *arguments)`` for slices that make up ``range(count)``, at the same time.

    The function has to be compiled with ``nogil`` and to write what it finds into its arguments, each element by
    itself: then the result does not depend on the number of processors.
    """
    slices = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    ends = [count * k // slices for k in range(slices + 1)]
    with ThreadPoolExecutor(slices) as threads:
        runs = [threads.submit(function, a, b, *arguments) for a, b in zip(ends, ends[1:], strict=False) if b > a]
    for run in runs:
        run.result()
