"""What the plans of two rooms have in common: a stretch of wall between them, or a floor over a ceiling."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely import Polygon

from .records import F64, Room

_STEP_M = 0.1
_IN_FRONT_M = 0.01
"""Plans may overlap so far where a wall is thin."""


@dataclass(frozen=True, slots=True)
class Border:
    """Wall or slab between two rooms: its thickness in metres, its area in m², and whether it is a slab."""

    gap: float
    area: float
    level: bool


def plan_of(room: Room) -> Polygon | None:
    """Polygon of a room's outline, None where it has none."""
    if not room.outline:
        return None
    polygon = shapely.make_valid(Polygon(room.outline[0], room.outline[1:]))
    parts = [part for part in shapely.get_parts(polygon) if isinstance(part, Polygon)]
    return max(parts, key=lambda part: float(part.area), default=None)


def plan_borders(
    rooms: Sequence[Room], plans: Mapping[int, Polygon], *, max_gap_m: float, max_slab_m: float
) -> Iterator[tuple[int, int, Border]]:
    """Yield pairs of rooms with their border, the lower number first: every pair whose plans come that close.

    Parameters
    ----------
    rooms
        The rooms.
    plans
        Their polygons by number; rooms without one have no border.
    max_gap_m, max_slab_m
        Thickest wall, thickest slab.
    """
    known = [room for room in rooms if room.number in plans]
    polygons = np.array([plans[room.number] for room in known], dtype=object)
    first, second = shapely.STRtree(polygons).query(polygons, predicate="dwithin", distance=max_gap_m)
    for i, j in sorted(zip(first[first < second].tolist(), second[first < second].tolist(), strict=True)):
        a, b = (known[i], known[j]) if known[i].number < known[j].number else (known[j], known[i])
        border = _slab(a, b, plans, max_slab_m) or _wall(a, b, plans, max_gap_m)
        if border is not None:
            yield a.number, b.number, border


def _slab(a: Room, b: Room, plans: Mapping[int, Polygon], max_slab_m: float) -> Border | None:
    """Ceiling of one under the floor of the other."""
    lower, upper = (a, b) if a.floor_elevation <= b.floor_elevation else (b, a)
    if lower.ceiling_elevation is None:
        return None
    gap = upper.floor_elevation - lower.ceiling_elevation
    if not 0.0 < gap < max_slab_m:
        return None
    return Border(gap, float(plans[a.number].intersection(plans[b.number]).area), level=True)


def _wall(a: Room, b: Room, plans: Mapping[int, Polygon], max_gap_m: float) -> Border | None:
    """Stretch of the boundary of one from where the other is straight ahead, as high as both rooms are."""
    height = min(top(a), top(b)) - max(a.floor_elevation, b.floor_elevation)
    if height <= 0.0:
        return None
    starts, outwards, widths = _boundary(plans[a.number])
    near = shapely.dwithin(plans[b.number], shapely.points(starts), max_gap_m)
    starts, outwards, widths = starts[near], outwards[near], widths[near]
    ends = np.stack([starts + _IN_FRONT_M * outwards, starts + max_gap_m * outwards], axis=1)
    there = shapely.intersection(shapely.linestrings(ends), plans[b.number])
    gap = np.asarray(shapely.distance(shapely.points(starts), there))
    ahead = np.isfinite(gap) & ~shapely.intersects_xy(plans[b.number], starts[:, 0], starts[:, 1])
    if not ahead.any():
        return None
    return Border(float(np.median(gap[ahead])), float(widths[ahead].sum()) * height, level=False)


def top(room: Room) -> float:
    """Height of a room's ceiling, or of what is highest in it."""
    return float(room.bounds[5]) if room.ceiling_elevation is None else room.ceiling_elevation


def _boundary(polygon: Polygon) -> tuple[F64, F64, F64]:
    """Middles of short pieces of a polygon's boundary, unit vectors out of it there, and lengths of the pieces."""
    rings = shapely.get_rings(shapely.orient_polygons(polygon))
    lines = [shapely.get_coordinates(shapely.segmentize(ring, _STEP_M)) for ring in rings]
    starts = np.concatenate([line[:-1] for line in lines])
    ways = np.concatenate([np.diff(line, axis=0) for line in lines])
    length = np.hypot(*ways.T)
    long = length > 1e-6
    starts, ways, length = starts[long], ways[long], length[long]
    outwards = np.column_stack([ways[:, 1], -ways[:, 0]]) / length[:, None]
    return starts + ways / 2, outwards, length
