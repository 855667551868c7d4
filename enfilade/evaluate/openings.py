"""Doors, passages and stairs: are they there, between the right rooms, as wide as they should be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .rooms import Matching
from .sides import Side, label

REACH_M = 0.3
"""An opening is the same one within this distance of the centres."""
_DOORS = ("door", "passage")
_STAIRS = ("stairs", "hatch")


@dataclass(frozen=True, slots=True)
class OpeningFigures:
    """How well openings between scanned rooms were found.

    Attributes
    ----------
    true, predicted
        Numbers of doors and passages that are open, between two scanned rooms.
    precision, recall
        Of those: right where they join the right two rooms within `REACH_M` of the true centre.
    width_error_m, position_error_m
        Median errors of those found.
    kinds_right
        Share of those found that are a door where the truth has a door, a passage where it has a passage.
    missed, invented
        Those that were not found, and those that are not there.
    closed_true, closed_found, closed_marked
        Closed doors, how many of them were found, and how many of these are marked as closed.
    closed_invented
        Predicted closed doors that are not there; they do not count in `precision`.
    stairs_true, stairs_found, stairs_invented
        Stairs and hatches, by the rooms that they join.
    """

    true: int
    predicted: int
    precision: float | None
    recall: float | None
    width_error_m: float | None
    position_error_m: float | None
    kinds_right: float | None
    missed: tuple[str, ...]
    invented: tuple[str, ...]
    closed_true: int
    closed_found: int
    closed_marked: int
    closed_invented: tuple[str, ...]
    stairs_true: int
    stairs_found: int
    stairs_invented: int


@dataclass(frozen=True, slots=True)
class Hole:
    """An opening with the true rooms that it joins; None for rooms that are nobody's match, the outside left out."""

    name: str
    properties: dict[str, Any]
    rooms: tuple[int | None, ...]

    @property
    def joins(self) -> frozenset[int] | None:
        """The two true rooms that it joins, or None where it does not join two that are known."""
        known = frozenset(room for room in self.rooms if room is not None)
        return known if len(self.rooms) == 2 and len(known) == 2 else None

    @property
    def kind(self) -> str:
        """Kind, empty where unknown."""
        return str(self.properties.get("kind", ""))

    @property
    def closed(self) -> bool:
        """Whether its leaf was closed."""
        return self.properties.get("state") == "closed"

    def distance(self, other: Hole) -> float:
        """Distance of the centres, metres."""
        return float(np.linalg.norm(self._position() - other._position()))

    def _position(self) -> NDArray[np.float64]:
        return np.asarray(self.properties.get("position", (np.inf, np.inf, np.inf)), dtype=np.float64)


def true_holes(truth: Side) -> list[Hole]:
    """Return the openings of the truth."""
    nodes = truth.graph.of_label("Opening")
    return [Hole(_name(node.id, truth), node.properties, truth.rooms_of(node.id)) for node in nodes]


def predicted_holes(prediction: Side, matching: Matching) -> list[Hole]:
    """Return the openings of the prediction, in terms of true rooms."""
    true_of = matching.true_of()
    return [
        Hole(_name(node.id, prediction), node.properties, tuple(map(true_of.get, prediction.rooms_of(node.id))))
        for node in prediction.graph.of_label("Opening")
    ]


def opening_figures(found: list[Hole], true: list[Hole], scanned: frozenset[int]) -> OpeningFigures:
    """Compare doors and passages one to one, nearest first, and stairs by the rooms that they join."""
    doors = [hole for hole in true if hole.kind in _DOORS]
    inner = [hole for hole in doors if hole.joins is not None and hole.joins <= scanned]
    beyond = [hole for hole in doors if hole.joins is None or not hole.joins <= scanned]
    candidates = [hole for hole in found if hole.kind in _DOORS and len(hole.rooms) == 2]
    pairs = _pair(candidates, inner)
    opened = [(p, t) for p, t in pairs if not inner[t].closed]
    closed = [(p, t) for p, t in pairs if inner[t].closed]
    loose = _unpaired(candidates, [p for p, _ in pairs])
    loose = [hole for hole in loose if not any(hole.distance(other) <= REACH_M for other in beyond)]
    invented = [hole for hole in loose if not hole.closed]
    wanted = [hole for hole in inner if not hole.closed]
    predicted = len(opened) + len(invented)
    right = [(candidates[p], inner[t]) for p, t in opened]
    stairs_true, stairs_found, stairs_invented = _stairs(found, true, scanned)
    return OpeningFigures(
        true=len(wanted),
        predicted=predicted,
        precision=len(right) / predicted if predicted else None,
        recall=len(right) / len(wanted) if wanted else None,
        width_error_m=_width_error(right),
        position_error_m=median(p.distance(t) for p, t in right) if right else None,
        kinds_right=sum(p.kind == t.kind for p, t in right) / len(right) if right else None,
        missed=_names(hole for hole in _unpaired(inner, [t for _, t in pairs]) if not hole.closed),
        invented=_names(invented),
        closed_true=sum(hole.closed for hole in inner),
        closed_found=len(closed),
        closed_marked=sum(candidates[p].closed for p, _ in closed),
        closed_invented=_names(hole for hole in loose if hole.closed),
        stairs_true=stairs_true,
        stairs_found=stairs_found,
        stairs_invented=stairs_invented,
    )


def _pair(found: Sequence[Hole], true: Sequence[Hole]) -> list[tuple[int, int]]:
    """Pairs (place in found, place in true) that join the same two rooms within reach, nearest first."""
    by_rooms: dict[frozenset[int] | None, list[int]] = {}
    for t, hole in enumerate(true):
        by_rooms.setdefault(hole.joins, []).append(t)
    near = [
        (hole.distance(true[t]), p, t)
        for p, hole in enumerate(found)
        if hole.joins is not None
        for t in by_rooms.get(hole.joins, [])
    ]
    pairs: dict[int, int] = {}
    for distance, p, t in sorted(near):
        if distance <= REACH_M and p not in pairs and t not in pairs.values():
            pairs[p] = t
    return list(pairs.items())


def _unpaired(holes: Sequence[Hole], taken: Sequence[int]) -> list[Hole]:
    gone = set(taken)
    return [hole for place, hole in enumerate(holes) if place not in gone]


def _stairs(found: list[Hole], true: list[Hole], scanned: frozenset[int]) -> tuple[int, int, int]:
    """Return numbers of true stairs between scanned rooms, of those found, and of predicted ones that are not there."""
    wanted = {hole.joins for hole in true if hole.kind in _STAIRS and hole.joins and hole.joins <= scanned}
    excused = {hole.joins for hole in true if hole.kind in _STAIRS}
    predicted = [hole.joins for hole in found if hole.kind in _STAIRS and len(hole.rooms) == 2]
    right = wanted & set(predicted)
    return len(wanted), len(right), sum(1 for joins in predicted if joins is None or joins not in excused)


def _width_error(right: list[tuple[Hole, Hole]]) -> float | None:
    widths = [(p.properties.get("width"), t.properties.get("width")) for p, t in right]
    errors = [abs(here - there) for here, there in widths if here is not None and there is not None]
    return median(errors) if errors else None


def _names(holes: Any) -> tuple[str, ...]:
    return tuple(hole.name for hole in holes)


def _name(opening: str, where: Side) -> str:
    """Key and name of an opening, with the rooms that it joins."""
    rooms = " – ".join(where.name(room) for room in where.rooms_of(opening))
    return f"{label(where.graph.nodes[opening])} ({rooms or 'no room'})"
