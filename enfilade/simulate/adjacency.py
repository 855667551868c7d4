"""Which rooms lie wall to wall or floor to ceiling, from their plans."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from .polygons import boundary_columns, distance_along
from .scene import Room

WALL_AT_MOST_M = 0.6
SLAB_AT_MOST_M = 0.8
_AREA_AT_LEAST_M2 = 0.5


@dataclass(frozen=True, slots=True)
class Adjacency:
    """Two rooms (by number) with a wall or slab of thickness `gap` (metres) between them over `area` (m²)."""

    first: int
    second: int
    gap: float
    area: float


def adjacent_rooms(rooms: Sequence[Room]) -> list[Adjacency]:
    """Find the pairs of rooms that share more than half a square metre of wall or slab."""
    polygons = np.array([room.polygon for room in rooms], dtype=object)
    near = shapely.STRtree(polygons).query(polygons, predicate="dwithin", distance=WALL_AT_MOST_M)
    pairs = sorted((int(a), int(b)) for a, b in near.T if a < b)
    found = (_side_by_side(rooms[a], rooms[b]) or _one_over_other(rooms[a], rooms[b]) for a, b in pairs)
    return [adjacency for adjacency in found if adjacency is not None]


def _side_by_side(a: Room, b: Room) -> Adjacency | None:
    height = min(a.ceiling_elevation, b.ceiling_elevation) - max(a.floor_elevation, b.floor_elevation)
    columns = boundary_columns(a.polygon)
    gap = distance_along(columns.points, columns.outwards, b.polygon, WALL_AT_MOST_M)
    facing = np.isfinite(gap)
    area = float(columns.widths[facing].sum()) * height
    if height <= 0 or area < _AREA_AT_LEAST_M2:
        return None
    return Adjacency(a.number, b.number, float(np.median(gap[facing])), area)


def _one_over_other(a: Room, b: Room) -> Adjacency | None:
    lower, upper = sorted((a, b), key=lambda room: room.floor_elevation)
    gap = upper.floor_elevation - lower.ceiling_elevation
    area = float(a.polygon.intersection(b.polygon).area)
    if not 0 <= gap <= SLAB_AT_MOST_M or area < _AREA_AT_LEAST_M2:
        return None
    return Adjacency(a.number, b.number, gap, area)
