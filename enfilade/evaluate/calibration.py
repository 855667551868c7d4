"""Does a confidence mean what it says: of openings said to be .9 sure, nine in ten should be there."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from .figures import Figures
from .matching import Matching
from .openings import Verdict, Verdicts

BINS: Final = 10


@dataclass(frozen=True, slots=True)
class Calibration(Figures):
    """What was said, and whether it is so.

    Attributes
    ----------
    said
        Confidences, 0 to 1.
    right
        1 where the thing is there, else 0.
    """

    DERIVED: ClassVar[tuple[str, ...]] = ("expected_error", "brier", "bins")

    said: tuple[float, ...] = ()
    right: tuple[int, ...] = ()

    @property
    def expected_error(self) -> float | None:
        """Expected calibration error: how far, bin by bin, the share of right ones is from what is said."""
        if not self.said:
            return None
        return float(sum(b["count"] * abs(b["said"] - b["right"]) for b in self.bins)) / len(self.said)

    @property
    def brier(self) -> float | None:
        """Brier score: mean square of what was said less what is so."""
        return float(np.mean((np.array(self.said) - self.right) ** 2)) if self.said else None

    @property
    def bins(self) -> list[dict[str, Any]]:
        """Bins of equal width that hold something: from, to, count, mean said, share right."""
        said, right = np.array(self.said), np.array(self.right, dtype=float)
        place: NDArray[np.int_] = np.minimum((said * BINS).astype(int), BINS - 1)
        return [
            {
                "from": k / BINS,
                "to": (k + 1) / BINS,
                "count": int((place == k).sum()),
                "said": float(said[place == k].mean()),
                "right": float(right[place == k].mean()),
            }
            for k in np.unique(place).tolist()
        ]


@dataclass(frozen=True, slots=True)
class CalibrationFigures(Figures):
    """Calibration of openings, all and by kind, and of rooms.

    Attributes
    ----------
    openings
        All kinds but those that lead to unscanned rooms.
    doors, closed_doors
        Between rooms: said to be open or ajar, and said to be closed.
    outside, windows, stairs
        Doors to the outside, windows, stairs and hatches.
    rooms
        Right where matched at an intersection over union of .5.
    """

    openings: Calibration = Calibration()
    doors: Calibration = Calibration()
    closed_doors: Calibration = Calibration()
    outside: Calibration = Calibration()
    windows: Calibration = Calibration()
    stairs: Calibration = Calibration()
    rooms: Calibration = Calibration()


def calibration_figures(verdicts: Verdicts, matching: Matching) -> CalibrationFigures:
    """Compare what is said with what is so."""
    kinds = (verdicts.doors, verdicts.outside, verdicts.windows, verdicts.stairs)
    doors = list(_said(verdicts.doors))
    return CalibrationFigures(
        openings=_calibration(pair for kind in kinds for _, *pair in _said(kind)),
        doors=_calibration(pair for closed, *pair in doors if not closed),
        closed_doors=_calibration(pair for closed, *pair in doors if closed),
        outside=_calibration(pair for _, *pair in _said(verdicts.outside)),
        windows=_calibration(pair for _, *pair in _said(verdicts.windows)),
        stairs=_calibration(pair for _, *pair in _said(verdicts.stairs)),
        rooms=_calibration(_said_of_rooms(matching)),
    )


def _calibration(pairs: Iterable[Any]) -> Calibration:
    given = [(float(said), int(right)) for said, right in pairs if said is not None and 0 <= said <= 1]
    return Calibration(tuple(said for said, _ in given), tuple(right for _, right in given))


def _said(verdict: Verdict) -> Iterable[tuple[bool, Any, bool]]:
    """Whether each predicted opening is said to be closed, its confidence, and whether it is there."""
    for hole in (found for found, _ in verdict.pairs):
        yield hole.closed, hole.properties.get("confidence"), True
    for hole in verdict.invented:
        yield hole.closed, hole.properties.get("confidence"), False


def _said_of_rooms(matching: Matching) -> Iterable[tuple[Any, bool]]:
    for room, node in matching.prediction.rooms.items():
        if room in matching.true_of or room not in matching.unscanned:
            yield node.properties.get("confidence"), room in matching.true_of
