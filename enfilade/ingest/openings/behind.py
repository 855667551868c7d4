"""What lies behind a hole in a wall: the other face of the wall, another room, or nothing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
import shapely
from shapely import Point, Polygon, STRtree, box

from enfilade.ingest.openings.evidence import FACING
from enfilade.ingest.openings.holes import Hole
from enfilade.ingest.openings.parameters import OpeningParameters
from enfilade.ingest.records import F64, Room
from enfilade.ingest.sides import Side

LEAST_GAP_M: Final = 0.02
"""Thinnest wall."""

FURTHER_M: Final = (0.1, 0.3, 0.5)
"""So far behind the thickest wall places are looked at ..."""

LEAST_OWN: Final = 0.75
"""... of which such a share is in the plan of a room that goes on there."""


def within_room(hole: Hole, room: Room, parameters: OpeningParameters) -> bool:
    """Whether a hole up to the ceiling, without glass, has its own room behind it, as a corridor's arm has."""
    ceiling = room.ceiling_elevation if room.ceiling_elevation is not None else room.bounds[5]
    glazed = hole.pane >= parameters.least_pane
    if glazed or not room.outline or hole.edges[3] < ceiling - parameters.min_lintel_m:
        return False
    across = np.linspace(hole.edges[0], hole.edges[2], 9)[1:-1]
    front = np.array([hole.side.point(u, float(hole.centre[2]))[:2] for u in across])
    places = [front - (parameters.max_gap_m + further) * hole.side.normal[:2] for further in FURTHER_M]
    own = shapely.contains_xy(Polygon(room.outline[0], room.outline[1:]), np.concatenate(places))
    return float(np.mean(own)) >= LEAST_OWN


class Behind:
    """Finds the walls that stand behind a hole, looking the other way, and the rooms whose plans lie there.

    Parameters
    ----------
    walls
        All walls.
    rooms
        By number.
    max_gap_m
        Thickest wall.
    """

    def __init__(self, walls: Sequence[Side], rooms: Mapping[int, Room], max_gap_m: float) -> None:
        self._walls = walls
        self._planned = [room for room in rooms.values() if room.outline]
        self._plans = STRtree([Polygon(room.outline[0]) for room in self._planned])
        self._max_gap_m = max_gap_m
        corners = [np.array([wall.point(wall.bounds[i], wall.bounds[1])[:2] for i in (0, 2)]) for wall in walls]
        self._tree = STRtree([box(*pair.min(axis=0), *pair.max(axis=0)) for pair in corners])

    def rooms(self, hole: Hole) -> list[tuple[float, int]]:
        """Thickness of the wall and room behind it, for each wall behind a hole, the nearest first.

        The hole's own room is among them where a part of it goes around, or where it was given the back of a leaf.
        """
        centre = hole.centre
        near = self._tree.query(Point(centre[:2]).buffer(self._max_gap_m))
        gaps = [(self._gap(self._walls[i], hole, centre), self._walls[i].room) for i in near]
        return sorted((gap, room) for gap, room in gaps if LEAST_GAP_M < gap < self._max_gap_m)

    def _gap(self, wall: Side, hole: Hole, centre: F64) -> float:
        """Thickness between a hole and a wall that faces away and reaches across it, else infinity."""
        u, v = centre @ wall.u, centre @ wall.v
        low, high = wall.bounds[:2], wall.bounds[2:]
        across = low[0] < u < high[0] and low[1] < v < high[1]
        if not across or wall.normal @ hole.side.normal > FACING:
            return float("inf")
        return float(wall.normal @ centre - wall.offset) * -1.0

    def room_of_plan(self, hole: Hole) -> int | None:
        """Another room whose plan lies behind a hole; the plan of its own may have parts that were seen through it."""
        level = float(hole.centre[2])
        depths = (self._max_gap_m, 2 * self._max_gap_m)
        places = [Point((hole.centre - depth * hole.side.normal)[:2]) for depth in depths]
        for k in np.unique(self._plans.query(places, predicate="within")[1]):
            room: Room = self._planned[int(k)]
            ceiling = room.ceiling_elevation if room.ceiling_elevation is not None else room.bounds[5]
            if room.number != hole.side.room and room.floor_elevation < level < ceiling:
                return room.number
        return None
