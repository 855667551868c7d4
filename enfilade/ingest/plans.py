"""The plan of every room: floor and ceiling, area and outline (§4)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray

from .outlines import Outline, OutlineParameters, draw_outline
from .records import F32, I32, Bool, Plan, Planes, RoomLabels, Surfels, ThinnedCloud
from .structure import Structure

I64 = NDArray[np.int64]
_ABOVE_FLOOR_M: Final = 0.05
_ONE_LEVEL_M: Final = 0.1


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
    roof above.
    """

    positions: F32
    plane: I32
    scanners: F32
    seen_here: Bool
    roofed: Bool


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
    order = np.argsort(labels.after, kind="stable")
    ends = np.cumsum(np.bincount(labels.after + 1, minlength=labels.room_count + 1))
    roofed = _roofed(surfels, planes) if by_floors else np.zeros(len(surfels.positions), bool)
    plans = []
    for number in range(labels.room_count):
        members = order[ends[number] : ends[number + 1]]
        scan = surfels.scan[members]
        parts = _Parts(
            surfels.positions[members],
            planes.surfel_plane[members],
            cloud.scanner_positions[scan],
            labels.scan_room[scan] == number,
            roofed[members],
        )
        plans.append(_plan(parts, planes, cloud.scanner_positions[labels.scan_room == number], parameters))
    return tuple(plans)


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
    reaches around it goes before it.
    """
    upward = _on(planes.horizontal & (planes.normals[:, 2] > 0.0), parts.plane)
    if len(scanners):
        upward &= parts.positions[:, 2] < scanners[:, 2].min()
    if not upward.any():
        return -1
    plane, height = parts.plane[upward], parts.positions[upward, 2]
    size = np.bincount(plane)
    level = np.bincount(plane, height) / np.maximum(size, 1)
    largest = np.argmax(size)
    rises = level[largest] - level
    below = (size >= parameters.least_floor * size[largest]) & (rises > _ONE_LEVEL_M) & (rises < parameters.furniture_m)
    xy = parts.positions[upward, :2]
    for lower in np.flatnonzero(below)[np.argsort(-size[below], kind="stable")]:
        both = _hull_area(xy[(plane == lower) | (plane == largest)])
        if _hull_area(xy[plane == lower]) >= parameters.least_around * both:
            return int(lower)
    return int(largest)


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


def _outline(
    planes: Planes, parts: _Parts, floor: int, ceiling: float | None, parameters: RoomPlanParameters
) -> Outline:
    """Outline by ceiling, roofed floor and what is seen just under the ceiling, or by the floor where that tells little.

    So neither furniture hides a part of the room nor is the ground taken for it that a window shows.
    """
    wall = _on(planes.vertical, parts.plane)
    everything = np.ones(len(wall), bool)
    if ceiling is None:
        return _drawn(parts, everything, wall, everything, parameters.outline)
    level = _on(planes.horizontal, parts.plane)
    strip = parts.positions[:, 2] > ceiling - parameters.lintel_m
    by_floor = strip | (parts.plane == floor)
    whole = _drawn(parts, level & by_floor, wall & strip, by_floor, parameters.outline)
    covered = (level & strip) | parts.roofed
    if not covered.any():
        return whole
    upper = _drawn(parts, covered, wall & strip, strip | parts.roofed, parameters.outline)
    return upper if upper.area >= parameters.least_ceiling * whole.area else whole


def _drawn(parts: _Parts, level: Bool, wall: Bool, tells: Bool, parameters: OutlineParameters) -> Outline:
    seen = parts.seen_here & tells
    return draw_outline(
        parts.positions[level, :2],
        parts.positions[wall, :2],
        parts.scanners[seen, :2],
        parts.positions[seen, :2],
        parameters,
    )
