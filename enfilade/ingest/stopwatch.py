"""How long each stage took: a listener that passes on what it hears."""

from __future__ import annotations

import time

from enfilade.progress import Progress


class Stopwatch:
    """Times the stages that are started through it."""

    def __init__(self, listener: Progress) -> None:
        self._listener = listener
        self._starts: list[tuple[str, float]] = []

    def start(self, stage: str, total: float | None = None) -> None:
        """Begin a stage; ends the one before."""
        self._starts.append((stage, time.perf_counter()))
        self._listener.start(stage, total)

    def advance(self, amount: float = 1.0) -> None:
        """Pass on that so much more is done."""
        self._listener.advance(amount)

    def note(self, sentence: str) -> None:
        """Pass on what should be known of the input."""
        self._listener.note(sentence)

    def stop(self) -> dict[str, float]:
        """End the last stage and return the seconds of each, in order."""
        moments = [moment for _, moment in self._starts] + [time.perf_counter()]
        return {stage: after - before for (stage, before), after in zip(self._starts, moments[1:], strict=True)}
