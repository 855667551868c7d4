"""The time limit of a question, as an engine's callback looks at it."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Iterator
from typing import Final, TypeVar

from enfilade.errors import StoreError

ITEMS_BETWEEN_LOOKS: Final = 1024
"""Items that we go through ourselves, a few milliseconds, after which the clock is looked at."""

T = TypeVar("T")


class Deadline:
    """Knows when a question has taken too long.

    Parameters
    ----------
    limit_s
        Seconds from now, or None for no limit.
    """

    def __init__(self, limit_s: float | None) -> None:
        self._limit_s = limit_s
        self._end = math.inf if limit_s is None else time.monotonic() + limit_s
        self._interrupted = False
        self.rows = 0
        """Rows found so far, for the reason."""

    def passed(self) -> bool:
        """Whether the engine must stop, at the limit or because somebody pressed Ctrl-C."""
        try:
            return time.monotonic() > self._end
        except KeyboardInterrupt:  # it would be lost in the engine, so that `reason` raises it again
            self._interrupted = True
            return True

    def left_s(self) -> float | None:
        """Seconds left, at least a thousandth; None without a limit."""
        return None if self._limit_s is None else max(self._end - time.monotonic(), 0.001)

    def check(self) -> None:
        """Raise the reason where the time is over."""
        if self.passed():
            raise self.reason()

    def watched(self, items: Iterable[T]) -> Iterator[T]:
        """Yield the items, looking at the clock now and then."""
        for number, item in enumerate(items):
            if number % ITEMS_BETWEEN_LOOKS == 0:
                self.check()
            yield item

    def reason(self) -> BaseException:
        """Return what to raise after the engine has stopped."""
        if self._interrupted:
            return KeyboardInterrupt()
        far = f" ({self.rows:,} rows were found so far)" if self.rows else ""
        return StoreError(
            f"the question took longer than {self._limit_s:g} s{far}; make it narrower or raise --timeout"
        )
