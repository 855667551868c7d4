"""Where rooms end: what stands upright in the cloud, room by room."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from enfilade.clouds import LabelledCloud
from enfilade.schema.graph import BuildingGraph
from enfilade.schema.ids import parse

from .faces import upright_points
from .frame import PageFrame

F64 = NDArray[np.float64]

_ABOVE_FLOOR_M: Final = (0.3, 3.5)
"""Heights in which points show that there is a wall; under a roof it may be low."""
_UNDER_CEILING_M: Final = 0.25
"""What is closer to the ceiling belongs to it."""
_CELL_M: Final = 0.10
_LEAST_HEIGHT_M: Final = 0.25
"""What is no wall must reach so high in a cell to hide one; specks in the air do not."""
_BITS: Final = 21


def wall_cells(cloud: LabelledCloud, frame: PageFrame, graph: BuildingGraph) -> dict[int, F64]:
    """Return by number of a room the cells on the page, ``(n, 2)`` metres, in which a wall or what hides it stands.

    What stands along a wall hides it, so it tells as much as the wall itself that the room ends there.
    """
    low, high = _heights(graph, int(cloud.room.max(initial=-1)) + 1)
    upright = upright_points(cloud)
    z = cloud.positions[:, 2]
    chosen = (upright | (cloud.object >= 0) | (cloud.plane < 0)) & (cloud.room >= 0)
    chosen[chosen] &= (z[chosen] > low[cloud.room[chosen]]) & (z[chosen] < high[cloud.room[chosen]])
    if not chosen.any():
        return {}
    cells = np.round(frame.points(cloud.positions[chosen, :2]) / _CELL_M).astype(np.int64)
    least = cells.min(axis=0)
    cells -= least
    key = cloud.room[chosen].astype(np.int64) << 2 * _BITS | cells[:, 0] << _BITS | cells[:, 1]
    key = key[_standing(key, z[chosen], upright[chosen])]
    key = np.unique(key)
    place = (np.column_stack([key >> _BITS, key]) & (1 << _BITS) - 1) + least
    rooms, starts = np.unique(key >> 2 * _BITS, return_index=True)
    return dict(zip(rooms.tolist(), np.split(place * _CELL_M, starts[1:]), strict=True))


def _heights(graph: BuildingGraph, count: int) -> tuple[F64, F64]:
    """Heights between which points of each room tell of walls, by number; all where its floor is unknown."""
    low, high = np.full(count, -np.inf), np.full(count, np.inf)
    for room in graph.of_label("Room"):
        number = parse(room.id).numbers[0]
        floor, ceiling = (room.properties.get(f"{name}_elevation") for name in ("floor", "ceiling"))
        if number < count and floor is not None:
            low[number], high[number] = floor + np.array(_ABOVE_FLOOR_M)
            if ceiling is not None and ceiling - _UNDER_CEILING_M > low[number]:
                high[number] = min(high[number], ceiling - _UNDER_CEILING_M)
    return low, high


def _standing(key: NDArray[np.int64], z: F64, upright: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """``(n,)``: points of cells that have some of an upright plane, or points over enough of the height."""
    _, cell = np.unique(key, return_inverse=True)
    count = int(cell.max(initial=-1)) + 1
    bottom, top = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(bottom, cell, z)
    np.maximum.at(top, cell, z)
    kept = top - bottom >= _LEAST_HEIGHT_M
    kept[cell[upright]] = True
    return np.asarray(kept[cell])
