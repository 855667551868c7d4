"""Doors, passages, windows and stairs: how many were found, and how large they are said to be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Final

from .figures import Figures, middle, share
from .holes import Hole
from .openings import Verdict, Verdicts

_SIZES: Final = ("width", "height", "sill")


@dataclass(frozen=True, slots=True)
class KindFigures(Figures):
    """How well openings of one kind were found.

    Attributes
    ----------
    true, found, invented
        Openings asked for, those of them that were found, and predicted ones that are not there.
    position_errors_m, width_errors_m, height_errors_m, sill_errors_m
        Of those found.
    """

    DERIVED: ClassVar[tuple[str, ...]] = (
        "predicted",
        "precision",
        "recall",
        "position_error_m",
        "width_error_m",
        "height_error_m",
        "sill_error_m",
    )

    true: int = 0
    found: int = 0
    invented: int = 0
    position_errors_m: tuple[float, ...] = ()
    width_errors_m: tuple[float, ...] = ()
    height_errors_m: tuple[float, ...] = ()
    sill_errors_m: tuple[float, ...] = ()

    @property
    def predicted(self) -> int:
        """Predicted openings that are judged."""
        return self.found + self.invented

    @property
    def precision(self) -> float | None:
        """Of the predicted ones, the share that is there."""
        return share(self.found, self.predicted)

    @property
    def recall(self) -> float | None:
        """Of the true ones, the share that was found."""
        return share(self.found, self.true)

    @property
    def position_error_m(self) -> float | None:
        """Median distance of the centres."""
        return middle(self.position_errors_m)

    @property
    def width_error_m(self) -> float | None:
        """Median error of the widths."""
        return middle(self.width_errors_m)

    @property
    def height_error_m(self) -> float | None:
        """Median error of the heights."""
        return middle(self.height_errors_m)

    @property
    def sill_error_m(self) -> float | None:
        """Median error of the sills."""
        return middle(self.sill_errors_m)


@dataclass(frozen=True, slots=True)
class OpeningFigures(Figures):
    """How well openings were found.

    Attributes
    ----------
    open, ajar, closed, unstated
        Doors and passages between two scanned rooms, by the state that the truth says; a predicted one that is not
        there counts as invented among the open ones, or among the closed ones where it says that it is closed.
    outside
        Doors and passages from a scanned room to the outside, in any state.
    windows
        Windows of scanned rooms.
    stairs
        Stairs and hatches between scanned rooms, by the rooms alone.
    apart
        Doors and passages from a scanned room to one that no scan stands in.
    kinds_right_count
        Open ones found that are a door where there is a door, a passage where there is a passage.
    closed_marked, ajar_marked
        Closed, and ajar, doors that were found and say so.
    closed_confidences
        What the closed doors that were found say of their confidence.
    missed, invented, closed_invented
        Names of open ones missed, and of open and of closed ones that are not there.
    """

    DERIVED: ClassVar[tuple[str, ...]] = (
        "true",
        "predicted",
        "precision",
        "recall",
        "width_error_m",
        "position_error_m",
        "kinds_right",
        "closed_true",
        "closed_found",
        "closed_confidence",
        "stairs_true",
        "stairs_found",
        "stairs_invented",
    )

    open: KindFigures = KindFigures()
    ajar: KindFigures = KindFigures()
    closed: KindFigures = KindFigures()
    unstated: KindFigures = KindFigures()
    outside: KindFigures = KindFigures()
    windows: KindFigures = KindFigures()
    stairs: KindFigures = KindFigures()
    apart: KindFigures = KindFigures()
    kinds_right_count: int = 0
    closed_marked: int = 0
    ajar_marked: int = 0
    closed_confidences: tuple[float, ...] = ()
    missed: tuple[str, ...] = ()
    invented: tuple[str, ...] = ()
    closed_invented: tuple[str, ...] = ()

    @property
    def true(self) -> int:
        """Open doors and passages between scanned rooms."""
        return self.open.true

    @property
    def predicted(self) -> int:
        """Predicted ones, without those of closed and ajar doors."""
        return self.open.predicted

    @property
    def precision(self) -> float | None:
        """Of `predicted`, the share that joins the right two rooms within reach of the true centre."""
        return self.open.precision

    @property
    def recall(self) -> float | None:
        """Of `true`, the share that was found so."""
        return self.open.recall

    @property
    def width_error_m(self) -> float | None:
        """Median error of the widths of open ones."""
        return self.open.width_error_m

    @property
    def position_error_m(self) -> float | None:
        """Median distance of the centres of open ones."""
        return self.open.position_error_m

    @property
    def kinds_right(self) -> float | None:
        """Share of the open ones found whose kind is right."""
        return share(self.kinds_right_count, self.open.found)

    @property
    def closed_true(self) -> int:
        """Closed doors between scanned rooms."""
        return self.closed.true

    @property
    def closed_found(self) -> int:
        """Those found, in whatever state."""
        return self.closed.found

    @property
    def closed_confidence(self) -> float | None:
        """Median confidence of the closed doors found."""
        return middle(self.closed_confidences)

    @property
    def stairs_true(self) -> int:
        """Stairs and hatches between scanned rooms."""
        return self.stairs.true

    @property
    def stairs_found(self) -> int:
        """Those found."""
        return self.stairs.found

    @property
    def stairs_invented(self) -> int:
        """Predicted ones that are not there."""
        return self.stairs.invented


def opening_figures(verdicts: Verdicts) -> OpeningFigures:
    """Count what was found, by kind and state."""
    doors = verdicts.doors
    told = any(true.properties.get("state") is not None for true in doors.true if true.kind == "door")

    def of(state: str) -> list[tuple[Hole, Hole]]:
        return [pair for pair in doors.pairs if _state(pair[1], told=told) == state]

    def number(state: str) -> int:
        return sum(_state(hole, told=told) == state for hole in doors.true)

    invented = [hole for hole in doors.invented if not hole.closed]
    closed_invented = [hole for hole in doors.invented if hole.closed]
    right = [(found, true) for found, true in of("open") if not found.closed]
    wrong_state = [true for found, true in of("open") if found.closed]
    missed = [true for true in doors.missed if _state(true, told=told) == "open"]
    confidences = [found.properties.get("confidence") for found, _ in of("closed")]
    return OpeningFigures(
        open=_figures(right, number("open"), len(invented)),
        ajar=_figures(of("ajar"), number("ajar"), 0),
        closed=_figures(of("closed"), number("closed"), len(closed_invented)),
        unstated=_figures(of("unstated"), number("unstated"), 0),
        outside=_of_verdict(verdicts.outside),
        windows=_of_verdict(verdicts.windows),
        stairs=_of_verdict(verdicts.stairs),
        apart=_of_verdict(verdicts.apart),
        kinds_right_count=sum(found.kind == true.kind for found, true in right),
        closed_marked=sum(found.closed for found, _ in of("closed")),
        ajar_marked=sum(found.state == "ajar" for found, _ in of("ajar")),
        closed_confidences=tuple(float(value) for value in confidences if value is not None),
        missed=tuple(hole.name for hole in _in_order([*missed, *wrong_state], doors)),
        invented=tuple(hole.name for hole in invented),
        closed_invented=tuple(hole.name for hole in closed_invented),
    )


def _state(true: Hole, *, told: bool) -> str:
    """State of a true door; where the truth says no state of any door they are all taken as open."""
    return true.state or ("unstated" if told else "open")


def _figures(right: Sequence[tuple[Hole, Hole]], true: int, invented: int) -> KindFigures:
    errors = {size: _errors(right, size) for size in _SIZES}
    positions = (
        found.distance(hole) for found, hole in right if found.position is not None and hole.position is not None
    )
    return KindFigures(true, len(right), invented, tuple(positions), *(errors[size] for size in _SIZES))


def _of_verdict(verdict: Verdict) -> KindFigures:
    return _figures(verdict.pairs, len(verdict.pairs) + len(verdict.missed), len(verdict.invented))


def _errors(right: Sequence[tuple[Hole, Hole]], size: str) -> tuple[float, ...]:
    sizes = [(found.properties.get(size), true.properties.get(size)) for found, true in right]
    return tuple(abs(here - there) for here, there in sizes if here is not None and there is not None)


def _in_order(holes: list[Hole], verdict: Verdict) -> list[Hole]:
    order = {hole.id: place for place, hole in enumerate(sorted(verdict.true, key=lambda hole: _number(hole.id)))}
    return sorted(holes, key=lambda hole: order[hole.id])


def _number(id: str) -> int:
    return int(id.rsplit("p", 1)[-1])
