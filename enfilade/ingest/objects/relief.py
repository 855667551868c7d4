"""Flat things that stand proud of a wall by little: fronts of built-in cupboards, boards, flat radiators."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from enfilade.ingest.objects.parameters import ObjectParameters
from enfilade.ingest.records import F64, Bool, Surfels
from enfilade.ingest.sides import Side

I64 = NDArray[np.int64]

CELL_M: Final = 0.05
LEAST_SURFELS: Final = 40
MOST_LEAN: Final = 0.02
WHOLE: Final = 0.7
"""What runs along more of a wall is its lining."""
STEADY_M: Final = 0.003
"""Walls do not scatter by less; so much is taken off no threshold."""


@dataclass(frozen=True, slots=True)
class _Wall:
    """Surfels of a wall: place in its plane, ``(n, 2)``, and how far they stand proud of its face, ``(n,)``."""

    places: F64
    proud: F64
    scatter_m: float


def find_boards(side: Side, under_ceiling: F64, surfels: Surfels, parameters: ObjectParameters) -> Bool:
    """Tell which surfels of a wall belong to something flat that is fixed to it, or built into it.

    The wall's own face is looked for where nothing stands before it, in the strip under the ceiling. What stands
    off that by more than the wall scatters, in one compact piece as large as furniture, is none of it.
    Skirting boards and frames are not compact, tiles run along the whole wall, piers reach the ceiling, and what is
    set back and shaped like a door is one.

    Parameters
    ----------
    side
        A wall.
    under_ceiling
        ``(n,)`` how far each of its surfels lies below the ceiling, metres.
    surfels
        Those that the side indexes.
    parameters
        Sizes.

    Returns
    -------
    ``(n,) bool`` of the side's surfels.
    """
    found = np.zeros(len(side.surfels), dtype=bool)
    if len(side.surfels) < LEAST_SURFELS or abs(side.normal[2]) > MOST_LEAN:
        return found
    wall = _wall(side, under_ceiling < parameters.wall_strip_m, surfels)
    least = max(parameters.min_relief_m, 4 * wall.scatter_m)
    for sign in (1, -1):
        off = np.flatnonzero((sign * wall.proud > least) & (under_ceiling > parameters.ceiling_reach_m))
        found[off] = _in_boards(wall.places[off], np.ptp(wall.places[:, 0]), sign < 0, parameters)
    return found


def _in_boards(places: F64, wall_m: float, set_back: bool, parameters: ObjectParameters) -> Bool:
    """``(n,) bool``: which places lie in a piece that is compact, large and no door nor as long as its wall."""
    if len(places) < LEAST_SURFELS:
        return np.zeros(len(places), dtype=bool)
    cell = np.floor((places - places.min(axis=0)) / CELL_M).astype(np.int64) + 1
    cells = np.zeros(cell.max(axis=0) + 2, dtype=bool)
    cells[tuple(cell.T)] = True
    cells = np.asarray(ndimage.binary_closing(cells, np.ones((3, 3), dtype=bool)), dtype=np.bool_)
    number, count = ndimage.label(cells)
    good = np.zeros(count + 1, dtype=bool)
    for piece, box in enumerate(ndimage.find_objects(number, count), start=1):
        own = number[box] == piece
        width, height = np.array(own.shape) * CELL_M
        compact = own.mean() >= parameters.min_fill and min(width, height) >= parameters.min_board_m
        door = set_back and width < parameters.max_leaf_m and height > parameters.min_leaf_m
        good[piece] = compact and not door and width < WHOLE * wall_m
    return np.asarray(good[number[tuple(cell.T)]], dtype=np.bool_)


def _wall(side: Side, strip: Bool, surfels: Surfels) -> _Wall:
    """Lay an upright face through the wall, straight along u, by its strip under the ceiling where that is seen."""
    positions = surfels.positions[side.surfels].astype(np.float64)
    upright = side.normal * [1.0, 1.0, 0.0]
    places, depth = positions @ np.column_stack([side.u, side.v]), positions @ (upright / np.linalg.norm(upright))
    seen = places[strip, 0]
    wide = len(seen) >= LEAST_SURFELS and np.ptp(seen) > 0.5 * np.ptp(places[:, 0])
    used = strip if wide else np.ones(len(depth), dtype=bool)
    line = np.column_stack([np.ones(len(depth)), places[:, 0] - places[:, 0].mean()])
    face, scatter = np.full(len(depth), np.median(depth[used])), 0.03
    for _ in range(3):
        near = used & (np.abs(depth - face) < 3 * scatter)
        if near.sum() < LEAST_SURFELS // 2:
            break
        face = line @ np.linalg.lstsq(line[near], depth[near], rcond=None)[0]
        scatter = max(1.4826 * float(np.median(np.abs(depth[near] - face[near]))), STEADY_M)
    return _Wall(places, depth - face, scatter)
