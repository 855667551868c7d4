"""Doors and windows of a building model: their frames, their leaves, their clear holes and the rooms beside."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .casting import Caster
from .ifc_model import Element
from .locate import Locator, commonest
from .scene import Opening
from .solids import F64

_JAMB_M = 0.1
_SILL_M = 0.05
_BEYOND_M = 0.3
_RAYS = 7


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
    """Return the frame with the clear hole as its extent: rays from its middle to jambs, head and threshold.

    Where rays meet nothing near the element's own edge, that edge counts.
    """
    middle, half = (frame.low + frame.high) / 2, (frame.high - frame.low) / 2
    low, high = frame.low.copy(), frame.high.copy()
    across = np.linspace(low[1] + 0.01, high[1] - 0.01, _RAYS)
    levels = np.linspace(low[2] + 0.3, high[2] - 0.3, _RAYS)
    starts = np.array([[middle[0], y, z] for y in across for z in levels])
    right, left = (_reach(frame, fabric, starts, sign * frame.axes[0], half[0]) for sign in (1, -1))
    low[0], high[0] = middle[0] - _jamb(left), middle[0] + _jamb(right)
    centre = (low[0] + high[0]) / 2
    starts = np.array([[centre + shift, y, middle[2]] for y in across for shift in (-0.1, 0.0, 0.1)])
    up, down = (_reach(frame, fabric, starts, sign * frame.axes[2], half[2]).min() for sign in (1, -1))
    low[2], high[2] = middle[2] - down, middle[2] + up
    return Frame(frame.axes, frame.origin, low, high)


def _jamb(reach: F64) -> float:
    """Least distance over the depth of the wall of the median over the height."""
    return float(np.median(reach.reshape(_RAYS, _RAYS), axis=1).min())


def _reach(frame: Frame, fabric: Caster, starts: F64, direction: F64, expected: float) -> F64:
    """``(K,)`` distance to what is met, `expected` where that lies well beyond."""
    ranges, _ = fabric.cast(frame.world(starts), np.tile(direction, (len(starts), 1)))
    return np.where(ranges > expected + _BEYOND_M, expected, ranges.astype(np.float64))


def opening_of(kind: str, state: str | None, frame: Frame, rooms: tuple[int, int], floor: float) -> Opening:
    """Make the opening of a hole; `floor` is the elevation its sill counts from."""
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
        found.append(commonest(locator.rooms_of(frame.world(probes))))
    return found[0], found[1]
