"""Which points are structure: walls, floors, ceilings and the reveals of their holes (§6.1).

The paper takes away all points on planes, and with them table tops and cupboard fronts. Here a plane is structure
only if it is a wall that reaches the ceiling, a floor, a ceiling, or a large slope.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import groupby
from typing import Final

import numpy as np
from scipy import ndimage

from enfilade.ingest.objects.parameters import ObjectParameters
from enfilade.ingest.objects.stairs import find_treads
from enfilade.ingest.records import F64, I32, Bool, Opening, Planes, Room, RoomLabels, Surfels
from enfilade.ingest.sides import Side, axes, cut_by_room, join_patches

MASK_CELL_M: Final = 0.1
AREA_CELL_M: Final = 0.1
FRAME_M: Final = 0.06
"""Width of the frame around the clear opening."""
PLAN_CELL_M: Final = 0.25


@dataclass(frozen=True, slots=True)
class Structure:
    """Planes that are structure, and the sides of each room that lie on such.

    Attributes
    ----------
    planes
        ``(P,) bool``.
    sides
        By room: walls, floors, ceilings, slopes.
    treads
        By room: steps of stairs.
    """

    planes: Bool
    sides: Mapping[int, tuple[Side, ...]]
    treads: Mapping[int, tuple[Side, ...]]


def find_structure(
    surfels: Surfels,
    planes: Planes,
    labels: RoomLabels,
    rooms: Mapping[int, Room],
    parameters: ObjectParameters,
) -> Structure:
    """Tell walls, floors, ceilings and slopes from the planes of furniture.

    Parameters
    ----------
    surfels, planes, labels
        What the stages before found.
    rooms
        By number.
    parameters
        How near to the ceiling a wall must come, and so on.

    Returns
    -------
    A plane that is structure in one room is so in all.
    """
    patches = [p for p in cut_by_room(surfels, planes, labels, parameters.min_side_surfels) if p.room in rooms]
    sides = join_patches(
        patches, surfels, max_angle_deg=parameters.join_angle_deg, max_offset_m=parameters.join_offset_m
    )
    is_structure = np.zeros(len(planes.offsets), dtype=bool)
    kept: dict[int, tuple[Side, ...]] = {}
    steps: dict[int, tuple[Side, ...]] = {}
    for number, own in groupby(sides, key=lambda side: side.room):
        room, all_sides = rooms[number], list(own)
        level = [side for side in all_sides if not side.vertical and _is_level(side, room, surfels, parameters)]
        ceiling = _CeilingMap([side for side in level if side.normal[2] < 0], room, surfels)
        walls = [side for side in all_sides if side.vertical and _reaches_ceiling(side, ceiling, surfels, parameters)]
        kept[number] = (*level, *walls)
        steps[number] = tuple(find_treads(all_sides, surfels))
        for side in (*kept[number], *steps[number]):
            is_structure[list(side.planes)] = True
    return Structure(is_structure, kept, steps)


def on_structure(points: F64, structure: Structure, room: Room, surfels: Surfels, parameters: ObjectParameters) -> Bool:
    """Tell which points of a room lie on its structure, in the reveal of a door or window, or right under a tread.

    Parameters
    ----------
    points
        ``(n, 3)`` metres.
    structure
        Of all rooms.
    room
        The room.
    surfels
        Those that the sides index.
    parameters
        Clearance and depth of reveals.

    Returns
    -------
    ``(n,) bool``.
    """
    on = np.abs(points[:, 2] - room.floor_elevation) < parameters.clearance_m
    depths = [
        (side, parameters.max_reveal_m if side.vertical else parameters.clearance_m)
        for side in structure.sides.get(room.number, ())
    ]
    depths += [(tread, parameters.max_riser_m) for tread in structure.treads.get(room.number, ())]
    for side, behind in depths:
        depth = points @ side.normal - side.offset
        close = np.flatnonzero((depth < parameters.clearance_m) & (depth > -behind) & ~on)
        on[close] = _Mask(side, surfels).covers(points[close])
    return on


def in_openings(points: F64, openings: Iterable[Opening], parameters: ObjectParameters) -> Bool:
    """Tell which points lie within the thickness of the wall in a door or window: leaf, frame, sill and glass.

    Parameters
    ----------
    points
        ``(n, 3)`` metres.
    openings
        Of the room that the points belong to; those in slabs are left out.
    parameters
        Depth of reveals.

    Returns
    -------
    ``(n,) bool``.
    """
    inside = np.zeros(len(points), dtype=bool)
    for opening in openings:
        if opening.orientation == "horizontal":
            u, v = axes(opening.normal)
            apart = points - opening.position
            half = np.array([opening.width, opening.height]) / 2 + FRAME_M
            across = (np.abs(apart @ np.column_stack([u, v])) < half).all(axis=1)
            depth = apart @ opening.normal
            before = parameters.clearance_m if opening.room_b is None else parameters.max_reveal_m / 2
            behind = parameters.max_reveal_m if opening.room_b is None else parameters.max_reveal_m / 2
            inside |= across & (depth < before) & (depth > -behind)
    return inside


class _CeilingMap:
    """Height of the ceiling over each cell of a room's plan, which slopes under a roof."""

    def __init__(self, ceilings: list[Side], room: Room, surfels: Surfels) -> None:
        self._corner = room.bounds[:2] - PLAN_CELL_M
        self._shape = np.ceil((room.bounds[3:5] - self._corner) / PLAN_CELL_M).astype(int) + 2
        self._height = np.full(tuple(self._shape), -np.inf)
        for side in ceilings:
            positions = surfels.positions[side.surfels].astype(np.float64)
            cells = self._cells(positions)
            np.maximum.at(self._height, (cells[:, 0], cells[:, 1]), positions[:, 2])
        self._height = ndimage.maximum_filter(self._height, 3)
        self._top = room.ceiling_elevation if room.ceiling_elevation is not None else float(room.bounds[5])
        self._height[~np.isfinite(self._height)] = self._top

    def _cells(self, places: F64) -> I32:
        cells = np.floor((places[:, :2] - self._corner) / PLAN_CELL_M).astype(np.int32)
        return np.clip(cells, 0, self._shape - 1).astype(np.int32)

    def above(self, places: F64) -> F64:
        """``(n,)`` heights over places, none above the room's own ceiling."""
        cells = self._cells(places)
        return np.asarray(np.minimum(self._height[cells[:, 0], cells[:, 1]], self._top), dtype=np.float64)


def _is_level(side: Side, room: Room, surfels: Surfels, parameters: ObjectParameters) -> bool:
    """Whether a side that is no wall is a floor, a ceiling, a roof or a ramp."""
    positions = surfels.positions[side.surfels].astype(np.float64)
    height = float(positions[:, 2].mean()) - room.floor_elevation
    area = (
        len(np.unique(np.floor(positions @ np.column_stack([side.u, side.v]) / AREA_CELL_M), axis=0)) * AREA_CELL_M**2
    )
    if not side.horizontal:
        return area > parameters.min_slope_m2
    if side.normal[2] < 0:
        return height > parameters.min_headroom_m
    return abs(height) < parameters.floor_reach_m or area > parameters.min_platform_m2


def _reaches_ceiling(side: Side, ceiling: _CeilingMap, surfels: Surfels, parameters: ObjectParameters) -> bool:
    """Whether at least a third of a wall's columns end at the ceiling."""
    positions = surfels.positions[side.surfels].astype(np.float64)
    column = np.floor((positions @ side.u - side.bounds[0]) / MASK_CELL_M).astype(int)
    short = ceiling.above(positions + 0.1 * side.normal) - positions[:, 2]
    least = np.full(column.max() + 1, np.inf)
    np.minimum.at(least, column, short)
    seen = np.isfinite(least)
    return bool((least[seen] < parameters.ceiling_reach_m).mean() > 1 / 3)


class _Mask:
    """The cells that a side covers, and one cell around: the reveals of its holes lie there."""

    def __init__(self, side: Side, surfels: Surfels) -> None:
        self._frame = np.column_stack([side.u, side.v])
        self._corner = side.bounds[:2] - 2 * MASK_CELL_M
        self._shape = np.ceil((side.bounds[2:] - self._corner) / MASK_CELL_M).astype(int) + 2
        cells = np.zeros(tuple(self._shape), dtype=bool)
        found = self._cells(surfels.positions[side.surfels].astype(np.float64))
        cells[found[:, 0], found[:, 1]] = True
        square = np.ones((3, 3), dtype=bool)
        cells = np.asarray(ndimage.binary_closing(cells, square), dtype=np.bool_)
        self._covered: Bool = np.asarray(ndimage.binary_dilation(cells, square), dtype=np.bool_)

    def _cells(self, places: F64) -> I32:
        return np.floor((places @ self._frame - self._corner) / MASK_CELL_M).astype(np.int32)

    def covers(self, places: F64) -> Bool:
        """``(n,) bool``: which places lie in front of, on or behind the side."""
        cells = self._cells(places)
        inside: Bool = np.all((cells >= 0) & (cells < self._shape), axis=1)
        cells = np.where(inside[:, None], cells, 0)
        return np.asarray(inside & self._covered[cells[:, 0], cells[:, 1]], dtype=np.bool_)
