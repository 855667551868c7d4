"""Doors, windows, doorways and stairs of a building model: their holes, leaves and the rooms they join."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from .casting import Caster
from .ifc_model import Element
from .locate import Locator
from .polygons import COLUMN_STEP_M
from .scene import OUTSIDE, Opening, Room
from .solids import F64, Mesh, unit_normals
from .spaces import DOORWAY_HEIGHT_M, DOORWAY_WIDTH_M, Border, Space

_JAMB_M = 0.1
_SILL_M = 0.05
_UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True)
class Frame:
    """A door or window in its own frame.

    Attributes
    ----------
    axes
        ``(3, 3)`` rows: along the width, across the wall, up.
    origin
        ``(3,)`` of the frame, metres.
    low, high
        ``(3,)`` extent of the element in the frame; across the wall it is the wall's.
    """

    axes: F64
    origin: F64
    low: F64
    high: F64

    def world(self, local: F64) -> F64:
        """``(..., 3)`` points of the frame in world coordinates."""
        moved: F64 = local @ self.axes + self.origin
        return moved

    def local(self, world: F64) -> F64:
        """``(..., 3)`` world points in the frame."""
        moved: F64 = (world - self.origin) @ self.axes.T
        return moved


def frame_of(element: Element, host: Element | None) -> Frame:
    """Return the frame of a door or window in its wall."""
    axes = element.placement[:3, :3].T
    extent = np.ptp(element.mesh.vertices @ axes.T, axis=0)
    if extent[1] > extent[0]:
        axes = np.stack([axes[1], -axes[0], axes[2]])
    origin = element.placement[:3, 3]
    local = (element.mesh.vertices - origin) @ axes.T
    low, high = local.min(axis=0), local.max(axis=0)
    if host is not None:
        across = (host.mesh.vertices - origin) @ axes[1]
        if np.ptp(across) < 0.8:
            low[1], high[1] = across.min(), across.max()
    return Frame(axes, origin, low, high)


def in_the_way(element: Element, frame: Frame) -> NDArray[np.bool_]:
    """``(T,)`` the parts of a door or window that fill its hole: leaf, handles, panes; not the frame along the edges.

    A part (one item of the body) fills the hole if one of its triangles reaches into the inner rectangle. Where
    the whole body is one item, those triangles go.
    """
    corners = frame.local(element.mesh.vertices)[element.mesh.triangles]
    low, high = corners.min(axis=1), corners.max(axis=1)
    inner_low, inner_high = frame.low + np.array([_JAMB_M, 0, _SILL_M]), frame.high - np.array([_JAMB_M, 0, _JAMB_M])
    touches = (low < inner_high).all(axis=1, where=[True, False, True])
    touches &= (high > inner_low).all(axis=1, where=[True, False, True])
    parts = np.isin(element.item, np.unique(element.item[touches]))
    return touches if parts.all() else parts


def measured_hole(frame: Frame, fabric: Caster) -> Frame:
    """Return the frame with the clear hole as its extent: rays from its middle to jambs, head and threshold."""
    middle = (frame.low + frame.high) / 2
    across = np.linspace(frame.low[1] + 0.01, frame.high[1] - 0.01, 7)
    levels = np.linspace(frame.low[2] + 0.3, frame.high[2] - 0.3, 7)
    low, high = frame.low.copy(), frame.high.copy()
    starts = np.array([[middle[0], y, z] for y in across for z in levels])
    right, left = (_reach(frame, fabric, starts, sign * frame.axes[0]).reshape(7, 7) for sign in (1, -1))
    low[0], high[0] = middle[0] - _jamb(left), middle[0] + _jamb(right)
    starts = np.array([[(low[0] + high[0]) / 2 + shift, y, middle[2]] for y in across for shift in (-0.1, 0.0, 0.1)])
    up, down = (_reach(frame, fabric, starts, sign * frame.axes[2]).min() for sign in (1, -1))
    low[2], high[2] = middle[2] - down, middle[2] + up
    return Frame(frame.axes, frame.origin, low, high)


def _jamb(reach: F64) -> float:
    """Least distance over the depth of the wall of the median over the height."""
    return float(np.median(reach, axis=1).min())


def _reach(frame: Frame, fabric: Caster, starts: F64, direction: F64) -> F64:
    ranges, _ = fabric.cast(frame.world(starts), np.tile(direction, (len(starts), 1)))
    return np.minimum(ranges.astype(np.float64), 3.0)


def opening_of(kind: str, state: str, frame: Frame, rooms: tuple[int, int], floor: float) -> Opening:
    """Make the opening of a door or window from its hole; `floor` is the elevation its sill counts from."""
    size = frame.high - frame.low
    position = frame.world((frame.low + frame.high) / 2)
    sill = float(position[2] - size[2] / 2 - floor)
    return Opening(
        kind, state, position, frame.axes[0], frame.axes[1], float(size[0]), float(size[2]), float(size[1]), sill, rooms
    )


def rooms_beside(frame: Frame, locator: Locator) -> tuple[int, int]:
    """Rooms before and behind a door or window, `OUTSIDE` for none."""
    middle, size = (frame.low + frame.high) / 2, frame.high - frame.low
    found = []
    for face, sign in ((frame.low[1], -1), (frame.high[1], 1)):
        probes = np.array(
            [
                [middle[0] + shift * size[0], face + sign * step, frame.low[2] + height * size[2]]
                for step in (0.06, 0.15, 0.3, 0.5)
                for shift in (-0.25, 0.0, 0.25)
                for height in (0.3, 0.6)
            ]
        )
        found.append(_most(locator.rooms_of(frame.world(probes))))
    return found[0], found[1]


def _most(rooms: NDArray[np.int32]) -> int:
    """Return the commonest room, `OUTSIDE` where there is none."""
    counted = Counter(rooms[rooms >= 0].tolist())
    return counted.most_common(1)[0][0] if counted else OUTSIDE


def doorways(
    border: Border, unit: NDArray[np.int32], spaces: Sequence[Space], rooms: Sequence[Room], doors: Sequence[Opening]
) -> list[Opening]:
    """Holes in the wall between two spaces that no door stands in: passages, and doorways under a lintel."""
    first, second = int(unit[border.first]), int(unit[border.second])
    if first == second or first < 0 or second < 0:
        return []
    floor = rooms[first].floor_elevation
    found = [_doorway(border, run, (first, second), floor, spaces) for run in _runs(border)]
    return [opening for opening in found if not any(_same_place(opening, door) for door in doors)]


def _runs(border: Border) -> list[NDArray[np.intp]]:
    """Neighbouring columns that one can walk through, at least so wide as a doorway."""
    columns = np.flatnonzero(border.clear >= DOORWAY_HEIGHT_M)
    return [run for run in border.stretches(columns) if len(run) * COLUMN_STEP_M >= DOORWAY_WIDTH_M]


def _doorway(
    border: Border, run: NDArray[np.intp], rooms: tuple[int, int], floor: float, spaces: Sequence[Space]
) -> Opening:
    ends = border.middle[run[[0, -1]]]
    across = np.array([*border.across[run].mean(axis=0), 0.0])
    across /= np.linalg.norm(across)
    passage = border.open_top[run].mean() > 0.5
    top = min(spaces[border.first].top, spaces[border.second].top)
    height = top - floor if passage else float(np.median(border.clear[run]))
    return Opening(
        "passage" if passage else "door",
        None if passage else "open",
        np.array([*ends.mean(axis=0), floor + height / 2]),
        np.array([-across[1], across[0], 0.0]),
        across,
        float(np.linalg.norm(ends[1] - ends[0])) + COLUMN_STEP_M,
        height,
        max(float(np.median(border.gap[run])), 0.02),
        0.0,
        rooms,
    )


def _same_place(opening: Opening, door: Opening) -> bool:
    return bool(np.linalg.norm((opening.position - door.position)[:2]) < (opening.width + door.width) / 2)


def stairs_between(mesh: Mesh, rooms: Sequence[Room], locator: Locator, fabric: Caster) -> Opening | None:
    """Link the rooms that a flight of stairs stands in and leads to; None where there are no two."""
    treads = _tread_points(mesh)
    foot_points = treads[treads[:, 2] < treads[:, 2].min() + 0.6]
    lower = _most(locator.rooms_of(_around(foot_points, 0.4)))
    if lower == OUTSIDE:
        return None
    floor = rooms[lower].floor_elevation
    higher = [room for room in rooms if floor + 1.5 < room.floor_elevation < treads[:, 2].max() + 0.4]
    if not higher:
        return None
    level = min(room.floor_elevation for room in higher)
    head_points = treads[np.abs(treads[:, 2] - level) < 0.6]
    found = locator.rooms_of(_around(head_points, 0.4 + np.abs(treads[:, 2] - level).min()))
    upper = _most(found[np.isin(found, [room.number for room in higher])])
    if upper == OUTSIDE:
        return None
    ends = np.stack([foot_points.mean(axis=0), head_points.mean(axis=0)])
    return _well(mesh, rooms[lower], rooms[upper], ends, fabric)


def _tread_points(mesh: Mesh) -> F64:
    """Centres of the upward triangles that are large enough to step on."""
    corners = mesh.vertices[mesh.triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    level = (np.abs(unit_normals(mesh)[:, 2]) > 0.95) & (area > 0.02)
    centres: F64 = corners.mean(axis=1)
    return centres[level] if level.any() else centres


def _around(points: F64, lift: float) -> F64:
    """Points on rings of up to 0.9 m about each point, lifted."""
    angles = np.arange(8) * np.pi / 4
    rings = np.array([[r * np.cos(a), r * np.sin(a), lift] for r in (0.0, 0.3, 0.6, 0.9) for a in angles])
    around: F64 = (points[:, None] + rings[None]).reshape(-1, 3)
    return around


def _well(mesh: Mesh, lower: Room, upper: Room, ends: F64, fabric: Caster) -> Opening:
    """Measure the hole in the slab above the stairs: cells from which a ray falls through it."""
    bottom, top = lower.ceiling_elevation, upper.floor_elevation
    (x0, y0, _), (x1, y1, _) = mesh.bounds + np.array([[-0.3, -0.3, 0.0], [0.3, 0.3, 0.0]])
    plan = np.stack(np.meshgrid(np.arange(x0, x1, 0.1), np.arange(y0, y1, 0.1)), axis=-1).reshape(-1, 2)
    plan = plan[shapely.contains_xy(upper.polygon.buffer(0.05), plan)]
    above = np.column_stack([plan, np.full(len(plan), top + 0.1)])
    below = np.column_stack([plan, np.full(len(plan), min(bottom, top - 0.05) - 0.05)])
    free = plan[~fabric.blocked(above, below)]
    if len(free) < 20:
        free = mesh.vertices[:, :2]
    low, high = free.min(axis=0), free.max(axis=0)
    axis = np.argmin(high - low)
    size = np.sort(high - low)
    return Opening(
        "stairs",
        None,
        np.array([*((low + high) / 2), (min(bottom, top) + top) / 2]),
        np.eye(3)[axis],
        _UP,
        float(size[0]),
        float(size[1]),
        max(top - bottom, 0.05),
        None,
        (lower.number, upper.number),
        ends,
    )
