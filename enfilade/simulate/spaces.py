"""From the spaces of a building model to rooms that walls bound: the units of truth.

Spaces without a wall between them are one room; a space over two storeys is cut at the upper floor; spaces that hold
others, lie in the open or cannot be entered are none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from shapely import Polygon

from .casting import Caster
from .polygons import COLUMN_STEP_M, boundary_columns, distance_along, extrude, footprint, plan_samples
from .solids import F64, Mesh

_LEVEL_TOLERANCE_M = 0.5
_SPANS_MORE_M = 1.5
_HELD_SHARE = 0.6
_ROOF_WITHIN_M = 15.0
_WALL_AT_MOST_M = 0.6
_ROW_STEP_M = 0.15
_HEIGHT_AT_LEAST_M = 1.0
WALL_LESS_SHARE = 0.5
"""Two spaces are one room where more than this of the wall between them is open up to the ceiling, ..."""
WALL_LESS_M = 2.2
"""... or so much of it in one piece."""
_WHOLE = 0.9
_SIDE_AT_LEAST_M = 0.8
_STRAIGHT = 0.9


@dataclass(frozen=True, slots=True)
class Space:
    """A space of the model: its name, closed boundary mesh, plan polygon, lowest and highest level."""

    name: str
    boundary: Mesh
    polygon: Polygon
    bottom: float
    top: float


@dataclass(frozen=True, slots=True)
class Border:
    """What stands between two spaces or rooms (by place in their list) along their common boundary.

    Attributes
    ----------
    clear
        ``(C,)`` height above the floor up to which each column, `COLUMN_STEP_M` wide, can be passed.
    open_top
        ``(C,)`` whether it can be passed up to the ceiling.
    middle
        ``(C, 2)`` the middle of the wall there, in plan.
    across
        ``(C, 2)`` unit vectors from the first space to the second.
    gap
        ``(C,)`` distance between the two, metres.
    """

    first: int
    second: int
    clear: F64
    open_top: NDArray[np.bool_]
    middle: F64
    across: F64
    gap: F64

    @property
    def wall_less(self) -> bool:
        """Whether no wall or lintel parts the two.

        So it is where most of the boundary, a whole side of it, or more than the width of any door is open up to the
        ceiling.
        """
        if any(len(run) * COLUMN_STEP_M >= WALL_LESS_M for run in self.stretches(np.flatnonzero(self.open_top))):
            return True
        whole_side = any(
            len(side) * COLUMN_STEP_M >= _SIDE_AT_LEAST_M and self.open_top[side].mean() > _WHOLE
            for side in self.sides()
        )
        return whole_side or bool(self.open_top.mean() > WALL_LESS_SHARE)

    def sides(self) -> list[NDArray[np.intp]]:
        """Columns of each straight stretch."""
        return self.stretches(np.arange(len(self.clear)))

    def stretches(self, columns: NDArray[np.intp]) -> list[NDArray[np.intp]]:
        """Split columns where they are no neighbours on one straight line."""
        steps = np.linalg.norm(np.diff(self.middle[columns], axis=0), axis=1)
        turns = np.einsum("ij,ij->i", self.across[columns[1:]], self.across[columns[:-1]])
        return np.split(columns, np.flatnonzero((steps > 1.5 * COLUMN_STEP_M) | (turns < _STRAIGHT)) + 1)


def space_of(name: str, mesh: Mesh) -> Space | None:
    """Make a space from its body; None for a body without a plan."""
    polygon = footprint(mesh)
    if polygon.is_empty or polygon.area < 0.2:
        return None
    low, high = mesh.bounds[:, 2]
    return Space(name, mesh, polygon, float(low), float(high))


def sound_spaces(spaces: Sequence[Space], levels: Sequence[float], walls: Caster) -> list[Space]:
    """Leave out spaces that hold others or have no roof, cut those over several storeys at the upper floors."""
    tree = shapely.STRtree(_polygons(spaces))
    near = [[spaces[k] for k in tree.query(space.polygon, predicate="intersects")] for space in spaces]
    sound = [s for s, others in zip(spaces, near, strict=True) if not _holds_others(s, others) and _covered(s, walls)]
    return [piece for space in sound for piece in _cut(space, levels)]


def _polygons(spaces: Sequence[Space]) -> NDArray[np.object_]:
    return np.array([space.polygon for space in spaces], dtype=object)


def _cut(space: Space, levels: Sequence[float]) -> list[Space]:
    cuts = [z for z in levels if space.bottom + _SPANS_MORE_M < z < space.top - _SPANS_MORE_M]
    if not cuts:
        return [space]
    heights = [space.bottom, *cuts, space.top]
    return [
        Space(space.name, extrude(space.polygon, low, high), space.polygon, low, high)
        for low, high in pairwise(heights)
    ]


def _holds_others(space: Space, others: Sequence[Space]) -> bool:
    """Whether other spaces, which its plan meets, fill most of its volume."""
    held = 0.0
    for other in others:
        common = min(space.top, other.top) - max(space.bottom, other.bottom)
        if other is not space and common > 0 and other.polygon.area < space.polygon.area:
            held += common * space.polygon.intersection(other.polygon).area
    return held > _HELD_SHARE * space.polygon.area * (space.top - space.bottom)


def _covered(space: Space, walls: Caster) -> bool:
    """Whether it has a floor below and, maybe some storeys up, a roof above."""
    points = plan_samples(space.polygon, (space.bottom + space.top) / 2)
    above, below = (walls.cast(points, np.tile([0.0, 0.0, z], (len(points), 1)))[0] for z in (1.0, -1.0))
    reach = (space.top - space.bottom) / 2 + 1.0
    return bool(np.mean(above < _ROOF_WITHIN_M) > 0.5 and np.mean(below < reach) > 0.5)


def borders_of(spaces: Sequence[Space], fabric: Caster) -> list[Border]:
    """Look at what stands between every two spaces of a level that lie side by side."""
    polygons = _polygons(spaces)
    near = shapely.STRtree(polygons).query(polygons, predicate="dwithin", distance=_WALL_AT_MOST_M)
    pairs = [
        (int(a), int(b)) for a, b in near.T if a < b and abs(spaces[a].bottom - spaces[b].bottom) < _LEVEL_TOLERANCE_M
    ]
    found = (_border(spaces, a, b, fabric) for a, b in sorted(pairs))
    return [border for border in found if border is not None]


def _border(spaces: Sequence[Space], a: int, b: int, fabric: Caster) -> Border | None:
    """Columns of rays from the boundary of one space straight across to the other."""
    columns = boundary_columns(spaces[a].polygon)
    gap = distance_along(columns.points, columns.outwards, spaces[b].polygon, _WALL_AT_MOST_M)
    beside = np.isfinite(gap)
    bottom, top = max(spaces[a].bottom, spaces[b].bottom), min(spaces[a].top, spaces[b].top)
    if not beside.any() or top - bottom < _HEIGHT_AT_LEAST_M:
        return None
    start, across, gap = columns.points[beside], columns.outwards[beside], gap[beside]
    heights = np.arange(bottom + 0.1, top - 0.05, _ROW_STEP_M)
    blocked = _blocked_columns(start, across, gap, heights, fabric)
    first = np.where(blocked.any(axis=1), blocked.argmax(axis=1), len(heights))
    clear = np.where(first > 0, 0.1 + _ROW_STEP_M * first, 0.0)
    return Border(a, b, clear, first == len(heights), start + across * gap[:, None] / 2, across, gap)


def _blocked_columns(start: F64, across: F64, gap: F64, heights: F64, fabric: Caster) -> NDArray[np.bool_]:
    """``(C, heights)`` whether something stands in the way, from 8 cm before to 8 cm behind."""
    ends = [start - 0.08 * across, start + (gap + 0.08)[:, None] * across]
    first, second = (
        np.concatenate([np.repeat(plan, len(heights), axis=0), np.tile(heights, len(plan))[:, None]], axis=1)
        for plan in ends
    )
    return fabric.blocked(first, second).reshape(len(start), len(heights))


def unite(spaces: Sequence[Space], borders: Sequence[Border]) -> NDArray[np.int32]:
    """``(spaces,)`` number of the unit of each space: spaces without a wall between them are one."""
    joined = [(b.first, b.second) for b in borders if b.wall_less]
    rows, columns = np.array(joined, dtype=np.int64).reshape(-1, 2).T
    links = coo_array((np.ones(len(rows)), (rows, columns)), shape=(len(spaces), len(spaces)))
    return connected_components(links, directed=False)[1].astype(np.int32)
