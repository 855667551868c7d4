"""How thick outer walls are: from the reveals of their windows and doors, which scans from inside show."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from enfilade.clouds import LabelledCloud

from .frame import PageFrame
from .walls import THICKEST_WALL_M, USUAL_THICKNESS_M, Gap

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]

_CELL_M: Final = 0.5
_STEP_M: Final = 0.02
_LEAST_POINTS: Final = 12
_BESIDE_M: Final = 0.08
_BREAK_STEPS: Final = 4
_LEAST_THICKNESS_M: Final = 0.12


@dataclass(frozen=True, slots=True)
class PlanGrid:
    """Points of a cloud on the page, sorted by cell, so that those of a small area are found at once.

    Attributes
    ----------
    positions
        ``(N, 3)`` points on the page, metres, by cell.
    room
        ``(N,)`` number of the room of each.
    keys
        ``(N,)`` cell of each, ascending.
    """

    positions: F64
    room: NDArray[np.int32]
    keys: I64

    def within(self, centre: F64, reach_m: float) -> NDArray[np.intp]:
        """Return indices of the points in the cells that a square around a place touches."""
        low = np.floor((centre - reach_m) / _CELL_M).astype(np.int64)
        high = np.floor((centre + reach_m) / _CELL_M).astype(np.int64)
        columns = np.arange(low[0], high[0] + 1) << 32
        first = np.searchsorted(self.keys, columns + low[1], "left")
        last = np.searchsorted(self.keys, columns + high[1], "right")
        return np.concatenate([np.arange(a, b) for a, b in zip(first, last, strict=True)])


def plan_grid(cloud: LabelledCloud, frame: PageFrame) -> PlanGrid:
    """Sort the points of a cloud by where they lie on the page."""
    positions = np.column_stack([frame.points(cloud.positions[:, :2]), cloud.positions[:, 2]])
    cells = np.floor(positions[:, :2] / _CELL_M).astype(np.int64)
    keys = (cells[:, 0] << 32) + cells[:, 1]
    order = np.argsort(keys, kind="stable")
    return PlanGrid(positions[order], cloud.room[order], keys[order])


def outer_thickness(gaps: Iterable[Gap], grid: PlanGrid) -> float:
    """Return the thickness of outer walls, metres: the upper quartile of the reveals' depths, else a usual one.

    A pane may hide the outer part of a reveal, so the deeper ones tell more.
    """
    outer = (one for one in gaps if len(one.opening.rooms) == 1)
    depths = [depth for one in outer if (depth := _reveal(one, grid)) >= _LEAST_THICKNESS_M]
    return float(np.percentile(depths, 75)) if depths else USUAL_THICKNESS_M


def _reveal(one: Gap, grid: PlanGrid) -> float:
    """How far points follow the jambs of an opening outwards from the room, without a break."""
    if len(one.inward) != 1:
        return 0.0
    opening, side = one.opening, next(iter(one.inward.values()))
    points = grid.positions[grid.within(opening.position, opening.width / 2 + THICKEST_WALL_M)]
    away = points[:, :2] - opening.position
    beside = np.abs(np.abs(away @ opening.along) - opening.width / 2) < _BESIDE_M
    level = np.abs(points[:, 2] - opening.middle) < 0.4 * opening.height
    depth = side * (one.face(side) - away[beside & level] @ opening.across)
    steps = np.bincount((depth[(depth > 0) & (depth < THICKEST_WALL_M)] / _STEP_M).astype(np.int64))
    filled = np.flatnonzero(steps)
    if steps.sum() < _LEAST_POINTS or filled[0] > _BREAK_STEPS:
        return 0.0
    breaks = np.flatnonzero(np.diff(filled) > _BREAK_STEPS)
    return float((filled[breaks[0]] if len(breaks) else filled[-1]) + 1) * _STEP_M
