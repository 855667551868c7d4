"""The plan of every room: floor and ceiling, area and outline (§4)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from enfilade.faces import WallFaces
from enfilade.parallel import at_once

from .cells import CellGrid, Gathered, extent, members_of
from .outlines import Outline, OutlineParameters, draw_outline
from .records import F32, I32, Bool, Plan, Planes, RoomLabels, Surfels, ThinnedCloud
from .structure import OCCUPIED, Structure

I64 = NDArray[np.int64]
_ABOVE_FLOOR_M: Final = 0.05
_COLUMN_M: Final = 0.25
_ROOF_M: Final = 0.6
"""So far above a sloped ceiling, its thickness included, there is nothing; over a flight of stairs there is."""
_LEAST_SLOPE_M2: Final = 2.0
"""Sashes of open windows and backs of chairs are smaller than slopes of a roof."""
_BESIDE_M: Final = 0.3
_LEAST_FACE: Final = 8
"""Surfels under the ceiling that make a plane a wall along which an outline is drawn."""
_IN_PLAN: Final = np.array([1.0, 1.0, 0.0], np.float32)
_ONE_LEVEL_M: Final = 0.1
_TRIPOD_M: Final = 0.5
"""Lowest that a scanner stands over its floor: a landing at its height is none."""
_LOW_TRIPOD_M: Final = 1.0
"""Nearer above a level than this, a scanner stands on a lower one, if there is one: a table hides the floor."""


@dataclass(frozen=True, slots=True)
class RoomPlanParameters:
    """How the plans of rooms are drawn.

    Attributes
    ----------
    least_floor, least_around, furniture_m
        A level plane with so much of the surface of the largest one, whose convex hull in plan has so much of that of
        both, and that lies at most so far below it, is the floor, and the largest one is furniture.
    least_height_m
        A ceiling is at least so far above the floor.
    lintel_m
        Height of the strip under the ceiling that tells where walls are: above doors, windows and furniture.
    least_ceiling
        Share of the outline by all that the one by ceiling must cover to be used.
    outline
        How outlines are drawn.
    """

    least_floor: float = 0.1
    least_around: float = 0.7
    furniture_m: float = 1.2
    least_height_m: float = 1.5
    lintel_m: float = 0.35
    least_ceiling: float = 0.5
    outline: OutlineParameters = field(default_factory=OutlineParameters)


@dataclass(frozen=True, slots=True)
class _Parts:
    """The surfels of one room, ``(n, ...)``.

    Where they are, on which plane, from where they were seen, whether by a scan of the room, whether level with a
    roof above, whether of a sloped ceiling.
    """

    positions: F32
    plane: I32
    scanners: F32
    seen_here: Bool
    roofed: Bool
    slope: Bool


def draw_plans(
    cloud: ThinnedCloud,
    surfels: Surfels,
    planes: Planes,
    labels: RoomLabels,
    parameters: RoomPlanParameters = RoomPlanParameters(),
    *,
    by_floors: bool = True,
) -> tuple[Plan, ...]:
    """Draw the plan of every room, in order of number.

    `by_floors` says whether floors under a roof count besides ceilings: not for a draft, before `keep_inside` has
    put right the labels of floors near wide doors.
    """
    roofed = _roofed(surfels, planes) if by_floors else np.zeros(len(surfels.positions), bool)
    slope = _slopes(surfels, planes)

    def of_room(number: int, members: I64) -> Plan:
        scan = surfels.scan[members]
        parts = _Parts(
            surfels.positions[members],
            planes.surfel_plane[members],
            cloud.scanner_positions[scan],
            labels.scan_room[scan] == number,
            roofed[members],
            slope[members],
        )
        return _plan(parts, planes, cloud.scanner_positions[labels.scan_room == number], parameters)

    return tuple(at_once(of_room, enumerate(members_of(labels.after, labels.room_count))))


def _plan(parts: _Parts, planes: Planes, scanners: F32, parameters: RoomPlanParameters) -> Plan:
    floor = _floor(planes, parts, scanners, parameters)
    on_floor = parts.positions[parts.plane == floor, 2] if floor >= 0 else parts.positions[:, 2].min(keepdims=True)
    elevation = float(on_floor.mean(dtype=np.float64))
    ceiling = _ceiling(planes, parts, elevation + parameters.least_height_m)
    outline = _outline(planes, parts, floor, ceiling, parameters)
    return Plan(outline.area, outline.centre, outline.rings, elevation, ceiling, floor)


def _on(kind: Bool, plane: I32) -> Bool:
    """Where `plane` is one of a kind."""
    return np.asarray((plane >= 0) & np.append(kind, False)[plane])


def _floor(planes: Planes, parts: _Parts, scanners: F32, parameters: RoomPlanParameters) -> int:
    """Plane that holds most of the room's floor (Eq. 7), of those below its scanners if it has any; -1 for none.

    A bed or a table that hides most of the floor holds more points than what is left of it, so a lower plane that
    reaches around it goes before it, and any lower one where scanners stood too near above it to stand on it.
    """
    upward = _on(planes.horizontal & (planes.normals[:, 2] > 0.0), parts.plane)
    lowest = float(scanners[:, 2].min()) if len(scanners) else np.inf
    upward &= parts.positions[:, 2] < lowest - _TRIPOD_M
    if not upward.any():
        return -1
    number, plane = np.unique(parts.plane[upward], return_inverse=True)
    size = np.bincount(plane)
    level = np.bincount(plane, parts.positions[upward, 2]) / size
    largest = np.argmax(size)
    rises = level[largest] - level
    of_level = (np.abs(level[:, None] - level) < _ONE_LEVEL_M) @ size
    below = of_level >= parameters.least_floor * size[largest]
    below &= (rises > _ONE_LEVEL_M) & (rises < parameters.furniture_m)
    xy = parts.positions[upward, :2]
    for lower in np.flatnonzero(below)[np.argsort(-size[below], kind="stable")]:
        around = _hull_area(xy[plane == lower])
        both = _hull_area(xy[(plane == lower) | (plane == largest)])
        if lowest - level[largest] < _LOW_TRIPOD_M or around >= parameters.least_around * both:
            return int(number[lower])
    return int(number[largest])


def _hull_area(xy: F32) -> float:
    return float(shapely.MultiPoint(xy).convex_hull.area)


def _ceiling(planes: Planes, parts: _Parts, lowest: float) -> float | None:
    """Mean height of the plane that holds most of the room's ceiling, None where there is none above `lowest`."""
    downward = _on(planes.horizontal & (planes.normals[:, 2] < 0.0), parts.plane)
    downward &= parts.positions[:, 2] > lowest
    if not downward.any():
        return None
    ceiling = np.argmax(np.bincount(parts.plane[downward]))
    return float(parts.positions[downward & (parts.plane == ceiling), 2].mean(dtype=np.float64))


def _roofed(surfels: Surfels, planes: Planes) -> Bool:
    """``(M,)``: level surfels that face up and have structure above them."""
    upward = np.flatnonzero(_on(planes.horizontal & (planes.normals[:, 2] > 0.0), planes.surfel_plane))
    starts = surfels.positions[upward] + np.array([0.0, 0.0, _ABOVE_FLOOR_M], np.float32)
    upwards = np.tile(np.array([[0.0, 0.0, 1.0]], np.float32), (len(upward), 1))
    roofed = np.zeros(len(surfels.positions), bool)
    roofed[upward] = Structure(planes).cast(starts, upwards).front
    return roofed


def _slopes(surfels: Surfels, planes: Planes) -> Bool:
    """``(M,)``: surfels of sloped ceilings; these have nothing over them, as undersides of stairs have."""
    large = np.array([(bitmap.occupancy > OCCUPIED).sum() * bitmap.cell_m**2 for bitmap in planes.bitmaps])
    sloped = ~planes.horizontal & ~planes.vertical & (planes.normals[:, 2] < 0.0) & (large >= _LEAST_SLOPE_M2)
    sloped = _on(sloped, planes.surfel_plane)
    if not sloped.any():
        return sloped
    standing = np.flatnonzero(planes.surfel_plane >= 0)
    positions = surfels.positions[standing]
    columns = Gathered.by(CellGrid.around(positions * _IN_PLAN, _COLUMN_M).keys(positions * _IN_PLAN))
    highest = np.maximum.reduceat(positions[columns.order, 2], columns.bounds[:-1])
    above = np.full(len(surfels.positions), np.inf, np.float32)
    above[standing[columns.order]] = np.repeat(highest, np.diff(columns.bounds))
    return np.asarray(sloped & (above - surfels.positions[:, 2] < _ROOF_M))


def _below_ceiling(planes: Planes, parts: _Parts, ceiling: float | None) -> F32:
    """``(n,)``: how far each surfel lies below the room's ceiling over it, level or sloped, metres."""
    height = np.full(len(parts.positions), np.inf if ceiling is None else ceiling)
    slopes = np.flatnonzero(parts.slope)
    if len(slopes):
        tree = cKDTree(parts.positions[slopes, :2])
        near = np.asarray(tree.query(parts.positions[:, :2], distance_upper_bound=_BESIDE_M)[1])
        beside = np.flatnonzero(near < len(slopes))
        plane = parts.plane[slopes[near[beside]]]
        normals = planes.normals[plane]
        flat = planes.offsets[plane] - np.einsum("ij,ij->i", normals[:, :2], parts.positions[beside, :2])
        height[beside] = np.minimum(height[beside], flat / normals[:, 2])
    return np.asarray(height - parts.positions[:, 2], np.float32)


def _outline(
    planes: Planes, parts: _Parts, floor: int, ceiling: float | None, parameters: RoomPlanParameters
) -> Outline:
    """Outline by ceiling, roofed floor and what is seen under the ceiling, or by the floor where that tells little.

    So neither furniture hides a part of the room nor is the ground taken for it that a window shows.
    """
    wall = _on(planes.vertical, parts.plane)
    if ceiling is None and not parts.slope.any():
        everything = np.ones(len(wall), bool)
        return _drawn(parts, everything, wall, everything, _faces(planes, parts, wall), None, parameters.outline)
    level = _on(planes.horizontal, parts.plane)
    below = _below_ceiling(planes, parts, ceiling)
    strip = (below < parameters.lintel_m) | parts.slope
    upper_wall = wall & strip
    faces = _faces(planes, parts, upper_wall)
    highest = np.inf if ceiling is None else ceiling + _ONE_LEVEL_M
    own = ((level & (np.abs(below) < _ONE_LEVEL_M)) | parts.slope) & (parts.positions[:, 2] < highest)
    by_floor = strip | (parts.plane == floor)
    covers = (level & strip) | parts.slope | parts.roofed
    upper = None
    if covers.any():
        upper = _drawn(parts, covers, upper_wall, strip | parts.roofed, faces, own, parameters.outline)
        if upper.area >= parameters.least_ceiling * _most_area(parts.positions[by_floor], parameters.outline):
            return upper
    covers = (level & by_floor) | parts.slope
    whole = _drawn(parts, covers, upper_wall, by_floor, faces, own, parameters.outline)
    return upper if upper is not None and upper.area >= parameters.least_ceiling * whole.area else whole


def _most_area(positions: F32, parameters: OutlineParameters) -> float:
    """Area of the box in plan around positions and the gaps beside them: no outline by these is larger, m²."""
    low, high = extent(positions[:, :2])
    return float(np.prod(high - low + 2.0 * parameters.gap_m))


def _faces(planes: Planes, parts: _Parts, wall: Bool) -> WallFaces:
    """Return the lines in plan of the planes that hold some surfels of walls."""
    plane, row = np.unique(parts.plane[wall], return_inverse=True)
    enough = np.bincount(row, minlength=len(plane)) >= _LEAST_FACE
    plane = plane[enough]
    normals = planes.normals[plane, :2].astype(np.float64)
    normals /= np.hypot(*normals.T)[:, None]
    along = np.column_stack([-normals[:, 1], normals[:, 0]])
    centre, span = np.empty((len(plane), 2)), np.empty((len(plane), 2))
    for face, number in enumerate(plane):
        xy = parts.positions[parts.plane == number, :2].astype(np.float64)
        middle = xy.mean(axis=0)
        centre[face] = middle + normals[face] * (np.median((xy - middle) @ normals[face]))
        places = (xy - middle) @ along[face]
        span[face] = places.min(), places.max()
    return WallFaces(centre, along, span)


def _drawn(
    parts: _Parts,
    level: Bool,
    wall: Bool,
    tells: Bool,
    faces: WallFaces,
    ceiling: Bool | None,
    parameters: OutlineParameters,
) -> Outline:
    seen = parts.seen_here & tells
    return draw_outline(
        parts.positions[level, :2],
        parts.positions[wall, :2],
        parts.scanners[seen, :2],
        parts.positions[seen, :2],
        parameters,
        faces=faces,
        ceiling=None if ceiling is None else parts.positions[ceiling, :2],
    )
