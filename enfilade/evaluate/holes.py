"""Openings of both graphs in terms of true rooms, sorted by what may be asked of them, and which is which."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from enfilade.schema.graph import Node

from .matching import Matching
from .sides import Side, label

F64 = NDArray[np.float64]

REACH_M: Final = 0.3
"""An opening is the same one within this distance of the centres."""
NEAR_M: Final = 1.0
"""What lies within this distance may be the same opening, put in the wrong place."""
DOORS: Final = ("door", "passage")
STAIRS: Final = ("stairs", "hatch")
WALKABLE: Final = (*DOORS, *STAIRS)
_BESIDE_M: Final = 0.4


@dataclass(frozen=True)
class Hole:
    """An opening with the true rooms that it joins.

    Attributes
    ----------
    id, name, properties
        Of its node; the name says what rooms it joins there.
    rooms
        True rooms by number, None for rooms that are nobody's match; the outside is left out.
    apart
        Whether it leads to a room that no scan stands in, or from a room to itself.
    """

    id: str
    name: str
    properties: dict[str, Any]
    rooms: tuple[int | None, ...]
    apart: bool = False

    @property
    def joins(self) -> frozenset[int] | None:
        """The true rooms that it leads to, or None where one of them is not known, or where it leads to none."""
        known = frozenset(room for room in self.rooms if room is not None)
        return known if self.rooms and len(known) == len(self.rooms) else None

    @property
    def kind(self) -> str:
        """Kind, empty where unknown."""
        return str(self.properties.get("kind", ""))

    @property
    def state(self) -> str | None:
        """How its leaf was seen: open, ajar or closed; a passage has no leaf, so it is open; None where unsaid."""
        state: str | None = self.properties.get("state")
        return "open" if state is None and self.kind != "door" else state

    @property
    def closed(self) -> bool:
        """Whether its leaf was closed."""
        return self.properties.get("state") == "closed"

    @cached_property
    def position(self) -> F64 | None:
        """Centre, metres; None where unsaid."""
        given = self.properties.get("position")
        return None if given is None else np.asarray(given, dtype=np.float64)

    def distance(self, other: Hole) -> float:
        """Distance of the centres, metres; infinite where one is not known."""
        if self.position is None or other.position is None:
            return float("inf")
        return float(np.linalg.norm(self.position - other.position))


def true_holes(truth: Side) -> list[Hole]:
    """Return the openings of the truth."""
    return [
        Hole(node.id, _name(node, truth), node.properties, rooms, _apart(node, rooms, truth))
        for node in truth.graph.of_label("Opening")
        for rooms in [truth.rooms_of(node.id)]
    ]


def predicted_holes(matching: Matching) -> list[Hole]:
    """Return the openings of the prediction, in terms of true rooms."""
    prediction, true_of = matching.prediction, matching.true_of
    return [
        Hole(
            node.id,
            _name(node, prediction),
            node.properties,
            tuple(map(true_of.get, rooms)),
            any(room in matching.unscanned for room in rooms),
        )
        for node in prediction.graph.of_label("Opening")
        for rooms in [prediction.rooms_of(node.id)]
    ]


class Places:
    """Finds the openings about a place."""

    def __init__(self, holes: Iterable[Hole]) -> None:
        self.holes = [hole for hole in holes if hole.position is not None]
        self._tree = cKDTree(np.array([hole.position for hole in self.holes]).reshape(-1, 3))

    def about(self, hole: Hole, reach_m: float) -> list[Hole]:
        """Return those within reach of another one, the nearest first."""
        if hole.position is None or not self.holes:
            return []
        found = [self.holes[place] for place in self._tree.query_ball_point(hole.position, reach_m)]
        return sorted(found, key=lambda other: (hole.distance(other), other.id))


def pair_holes(
    found: Sequence[Hole],
    true: Sequence[Hole],
    *,
    reach_m: float = REACH_M,
    agree: Callable[[Hole, Hole], bool] = lambda found, true: True,
) -> dict[str, Hole]:
    """Pair openings one to one that lead to the same rooms within reach, nearest first.

    Parameters
    ----------
    agree
        Pairs for which this holds go before all others.

    Returns
    -------
    dict
        The predicted opening of each true one, by the id of the true one.
    """
    by_rooms: dict[frozenset[int], list[Hole]] = {}
    for hole in true:
        if hole.joins is not None:
            by_rooms.setdefault(hole.joins, []).append(hole)
    near = [
        (not agree(here, there), here.distance(there), here.id, there.id, here)
        for here in found
        if here.joins is not None
        for there in by_rooms.get(here.joins, [])
    ]
    pairs: dict[str, Hole] = {}
    taken: set[str] = set()
    for _, distance, here_id, there_id, here in sorted(near, key=lambda pair: pair[:4]):
        if distance <= reach_m and here_id not in taken and there_id not in pairs:
            pairs[there_id] = here
            taken.add(here_id)
    return pairs


def _apart(node: Node, rooms: tuple[int, ...], truth: Side) -> bool:
    outdoors = len(rooms) == 1 and not _within(node, rooms[0], truth)
    return not rooms or not truth.scanned.issuperset(rooms) or (len(rooms) == 1 and not outdoors)


def _within(node: Node, room: int, truth: Side) -> bool:
    """Whether both sides of an upright opening lie in the plan of the one room that it is said to lead to."""
    outline, position, normal = (
        truth.value(room, "outline"),
        node.properties.get("position"),
        node.properties.get("normal"),
    )
    if not outline or position is None or normal is None or abs(normal[2]) > np.sqrt(0.5):
        return False
    shell, *holes = (np.reshape(ring, (-1, 2)) for ring in outline)
    if len(shell) < 3:
        return False
    polygon = shapely.Polygon(shell, [hole for hole in holes if len(hole) >= 3])
    sides = np.array(position)[:2] + np.outer((-_BESIDE_M, _BESIDE_M), np.array(normal)[:2])
    return bool(shapely.contains_xy(polygon, sides).all())


def _name(node: Node, where: Side) -> str:
    """Key and name of an opening, with the rooms that it joins."""
    rooms = " – ".join(where.name(room) for room in where.rooms_of(node.id))
    return f"{label(node)} ({rooms or 'no room'})"
