"""The time limit of a question, as an engine's callback looks at it."""

from __future__ import annotations

import math
import time

from enfilade.errors import StoreError


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

    def reason(self) -> BaseException:
        """Return what to raise after the engine has stopped."""
        if self._interrupted:
            return KeyboardInterrupt()
        return StoreError(f"the question took longer than {self._limit_s:g} s; make it narrower or raise --timeout")
