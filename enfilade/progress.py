"""How long work tells how far it is, without knowing who listens."""

from __future__ import annotations

from typing import Protocol


class Progress(Protocol):
    """Hears of stages and of the way through each."""

    def start(self, stage: str, total: float | None = None) -> None:
        """Begin a stage; `total` is what `advance` will add up to, if known. Ends the stage before."""

    def advance(self, amount: float = 1.0) -> None:
        """Say that so much more of the stage is done."""

    def note(self, sentence: str) -> None:
        """Say something about the input that its owner should know."""


class Silent:
    """Listens to nothing."""

    def start(self, stage: str, total: float | None = None) -> None:
        """Ignore it."""

    def advance(self, amount: float = 1.0) -> None:
        """Ignore it."""

    def note(self, sentence: str) -> None:
        """Ignore it."""
