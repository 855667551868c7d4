"""Which surfels are structure: walls, floors, ceilings, slopes and stairs (§6.1).

The paper takes away all points on planes, and with them table tops and cupboard fronts. Here a side is structure
only if it is a wall that reaches the ceiling or stands on the room's outline, a floor, a ceiling, or a large slope.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Final

import numpy as np
import shapely
from numba import njit
from numpy.typing import NDArray
from scipy import ndimage

from enfilade.ingest.objects.masks import CELL_M, Mask
from enfilade.ingest.objects.parameters import ObjectParameters
from enfilade.ingest.objects.relief import find_boards
from enfilade.ingest.objects.stairs import WIDTH_M, Flight, find_flights
from enfilade.ingest.records import F64, I32, Bool, Opening, Planes, Room, RoomLabels, Surfels
from enfilade.ingest.sides import Patch, Side, axes, cut_by_room, join_patches
from enfilade.parallel import at_once

I64 = NDArray[np.int64]

AREA_CELL_M: Final = 0.1
PLAN_CELL_M: Final = 0.25
APART_M: Final = 1.0
ALONG: Final = 0.7
"""Share of a side that must lie along the outline, or behind which there must be a wall."""


class CeilingMap:
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

    def below(self, side: Side, surfels: Surfels) -> F64:
        """``(n,)`` how far the surfels of a wall lie below the ceiling before it, nowhere above the room's own."""
        positions = surfels.positions[side.surfels].astype(np.float64)
        return self.over(positions + 0.1 * side.normal) - positions[:, 2]

    def over(self, places: F64) -> F64:
        """``(n,)`` how high the ceiling is over places, nowhere higher than the room's own."""
        cells = self._cells(places)
        return np.asarray(np.minimum(self._height[cells[:, 0], cells[:, 1]], self._top), dtype=np.float64)


@dataclass(frozen=True, slots=True)
class Structure:
    """Surfels that are structure, the sides of each room that they lie on, and the stairs.

    Attributes
    ----------
    surfels
        ``(M,) bool``.
    boards
        ``(M,) bool``, what is fixed flat to a wall, or built into it, and is none.
    sides
        By room: walls, floors, ceilings, slopes.
    ceilings
        By room: how high the ceiling is over its plan.
    flights
        Of the building.
    """

    surfels: Bool
    boards: Bool
    sides: Mapping[int, tuple[Side, ...]]
    ceilings: Mapping[int, CeilingMap]
    flights: Sequence[Flight]


def find_structure(
    surfels: Surfels,
    planes: Planes,
    labels: RoomLabels,
    rooms: Mapping[int, Room],
    parameters: ObjectParameters,
) -> Structure:
    """Tell walls, floors, ceilings, slopes and stairs from furniture.

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
    A scrap of a plane too small to be a side is structure where the plane is structure in another room.
    """
    patches = [p for p in cut_by_room(surfels, planes, labels, parameters.min_side_surfels) if p.room in rooms]
    of_rooms = [(rooms[number], list(own)) for number, own in groupby(patches, key=lambda patch: patch.room)]
    found = at_once(_structure_of_room, ((room, own, surfels, parameters) for room, own in of_rooms))
    fixed, boards, in_side = np.zeros((3, len(surfels.positions)), dtype=bool)
    plane_fixed = np.zeros(len(planes.offsets) + 1, dtype=bool)
    kept: dict[int, tuple[Side, ...]] = {}
    ceilings = {number: CeilingMap([], room, surfels) for number, room in rooms.items()}
    for (room, _), (seen, structure, ceiling, own) in zip(of_rooms, found, strict=True):
        kept[room.number], ceilings[room.number] = structure, ceiling
        for side in seen:
            in_side[side.surfels] = True
        for side in structure:
            fixed[side.surfels] = True
            plane_fixed[list(side.planes)] = True
        fixed[own] = False
        boards[own] = True
    fixed |= ~in_side & plane_fixed[planes.surfel_plane]
    level = [side.surfels for sides in kept.values() for side in sides if side.horizontal and _may_be_tread(side)]
    treads = ~fixed
    treads[np.concatenate([np.zeros(0, dtype=np.int32), *level])] = True
    return Structure(fixed, boards, kept, ceilings, find_flights(surfels, treads))


def _may_be_tread(side: Side) -> bool:
    """Whether a level side is as small as a tread: from below one of the upper ones looks like a ceiling."""
    return bool(np.hypot(*(side.bounds[2:] - side.bounds[:2])) < WIDTH_M[1])


def in_openings(points: F64, openings: Iterable[Opening], parameters: ObjectParameters) -> Bool:
    """Tell which points lie within the thickness of the wall in a door or window: leaf, frame, sill and glass.

    In a passage there is neither, but the ends of the wall beside it.

    Parameters
    ----------
    points
        ``(n, 3)`` metres.
    openings
        Of the room that the points belong to; those in slabs are left out.
    parameters
        Depth of reveals and width of frames.

    Returns
    -------
    ``(n,) bool``.
    """
    inside = np.zeros(len(points), dtype=bool)
    for opening in openings:
        if opening.orientation == "horizontal":
            frame = np.array([*axes(opening.normal), opening.normal])
            before = parameters.frame_m if opening.room_b is None else parameters.max_reveal_m / 2
            behind = parameters.max_reveal_m if opening.room_b is None else parameters.max_reveal_m / 2
            half = np.array([opening.width, opening.height]) / 2 + parameters.frame_m
            low, high = np.array([*-half, -behind]), np.array([*half, before])
            bare = opening.kind == "passage"
            inner = half - 2 * parameters.frame_m if bare else np.zeros(2)
            _add_inside(inside, points, opening.position.astype(np.float64), frame, low, high, inner)
    return inside


@njit(cache=True, nogil=True)
def _add_inside(inside: Bool, points: F64, centre: F64, frame: F64, low: F64, high: F64, inner: F64) -> None:
    """Mark the points that lie between two corners, given along the axes of a frame, ``(3, 3)`` in rows.

    What is nearer to the centre than `inner`, ``(2,)`` along the first two axes, is not marked.
    """
    for i in range(len(points)):
        within, open_space = True, True
        for axis in range(3):
            along = 0.0
            for k in range(3):
                along += (points[i, k] - centre[k]) * frame[axis, k]
            within &= low[axis] < along < high[axis]
            open_space &= axis > 1 or abs(along) < inner[axis]
        inside[i] |= within and not open_space


def _structure_of_room(
    room: Room, patches: list[Patch], surfels: Surfels, parameters: ObjectParameters
) -> tuple[list[Side], tuple[Side, ...], CeilingMap, I32]:
    """Return the sides of one room, those that are structure, its ceiling, and the surfels that stand off a wall."""
    sides = join_patches(
        patches, surfels, max_angle_deg=parameters.join_angle_deg, max_offset_m=parameters.join_offset_m
    )
    level = [side for side in sides if not side.vertical and _is_level(side, room, surfels, parameters)]
    ceiling = CeilingMap([side for side in level if side.normal[2] < 0], room, surfels)
    upright = [run for side in sides if side.vertical for run in _runs(side, surfels)]
    tall = [_reaches_ceiling(side, ceiling, surfels, parameters) for side in upright]
    walls = [side for side, reaches in zip(upright, tall, strict=True) if reaches]
    others = [side for side, reaches in zip(upright, tall, strict=True) if not reaches]
    outline = shapely.Polygon(room.outline[0], room.outline[1:]).boundary if room.outline else None
    if outline is not None:
        walls += [side for side in others if _is_parapet(side, outline, walls, surfels, parameters)]
    boards = [np.zeros(0, dtype=np.int32)]
    boards += [side.surfels[find_boards(side, ceiling.below(side, surfels), surfels, parameters)] for side in walls]
    return sides, (*level, *walls), ceiling, np.concatenate(boards)


def _runs(side: Side, surfels: Surfels) -> list[Side]:
    """Cut a side where nothing of it is for long: the end of a cupboard may lie in the plane of a wall far away."""
    positions = surfels.positions[side.surfels].astype(np.float64)
    along = positions @ side.u
    order = np.argsort(along, kind="stable")
    runs = np.split(order, np.flatnonzero(np.diff(along[order]) > APART_M) + 1)
    return [_run(side, np.sort(run), positions) for run in runs] if len(runs) > 1 else [side]


def _run(side: Side, run: I64, positions: F64) -> Side:
    places = positions[run] @ np.column_stack([side.u, side.v])
    return replace(side, surfels=side.surfels[run], bounds=np.concatenate([places.min(axis=0), places.max(axis=0)]))


def _is_level(side: Side, room: Room, surfels: Surfels, parameters: ObjectParameters) -> bool:
    """Whether a side that is no wall is a floor, a ceiling, a roof or a ramp."""
    positions = surfels.positions[side.surfels].astype(np.float64)
    height = float(positions[:, 2].mean()) - room.floor_elevation
    if side.horizontal and side.normal[2] < 0:
        return height > parameters.min_headroom_m
    if side.horizontal and abs(height) < parameters.floor_reach_m:
        return True
    if side.horizontal and parameters.min_top_m < height < parameters.max_top_m:
        return False
    least = parameters.min_platform_m2 if side.horizontal else parameters.min_slope_m2
    return _largest_piece(positions @ np.column_stack([side.u, side.v])) > least


def _largest_piece(places: F64) -> float:
    """Area of the largest piece that hangs together, m²: many tables as high as one another are no floor."""
    cell = np.floor(places / AREA_CELL_M).astype(np.int64)
    cell -= cell.min(axis=0)
    cells = np.zeros(cell.max(axis=0) + 1, dtype=bool)
    cells[tuple(cell.T)] = True
    number, count = ndimage.label(cells, np.ones((3, 3)))
    return float(np.bincount(number[cells], minlength=count + 1).max()) * AREA_CELL_M**2


def _reaches_ceiling(side: Side, ceiling: CeilingMap, surfels: Surfels, parameters: ObjectParameters) -> bool:
    """Whether at least a third of a wall's columns end at the ceiling."""
    positions = surfels.positions[side.surfels].astype(np.float64)
    column = np.floor((positions @ side.u - side.bounds[0]) / CELL_M).astype(int)
    least = np.full(column.max() + 1, np.inf)
    np.minimum.at(least, column, ceiling.below(side, surfels))
    seen = np.isfinite(least)
    return bool((least[seen] < parameters.ceiling_reach_m).mean() > 1 / 3)


def _is_parapet(
    side: Side, outline: shapely.Geometry, walls: Iterable[Side], surfels: Surfels, parameters: ObjectParameters
) -> bool:
    """Whether a side runs along the room's outline with no wall close behind it, as below a wide window."""
    positions = surfels.positions[side.surfels].astype(np.float64)
    along = shapely.distance(outline, shapely.points(positions[:, :2])) < parameters.outline_reach_m
    if along.mean() < ALONG:
        return False
    behind = np.zeros(len(positions), dtype=bool)
    for wall in walls:
        depth = positions @ wall.normal - wall.offset
        before = np.flatnonzero((depth > 0) & (depth < 2 * parameters.outline_reach_m) & ~behind)
        if wall.normal @ side.normal > ALONG and len(before):
            behind[before] = Mask(wall, surfels).covers(positions[before])
    return bool(behind.mean() < ALONG)
