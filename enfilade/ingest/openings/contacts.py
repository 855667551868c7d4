"""Where two rooms meet without a wall: their floors touch, and rays go through from floor to ceiling.

An open plan that was split into rooms has no wall in which to look for a hole. The line along which the floors of
two rooms touch is taken for one: an upright side without surface, in which holes are found and measured as in walls.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from enfilade.ingest.openings.parameters import OpeningParameters
from enfilade.ingest.records import F64, I32, Opening, Room, RoomLabels, Surfels
from enfilade.ingest.sides import UP, Side

CELL_M: Final = 0.1
FLOOR_M: Final = 0.15
SHEET: Final = 1 << 21
"""Cells along each axis of the grid that keys are packed for."""


def contact_sides(
    surfels: Surfels,
    labels: RoomLabels,
    rooms: Mapping[int, Room],
    found: Iterable[Opening],
    parameters: OpeningParameters,
) -> list[Side]:
    """Make an upright side along every line where two floors touch and no opening was found.

    Parameters
    ----------
    surfels, labels
        What the stages before found.
    rooms
        By number.
    found
        Openings already known; lines at these are left out.
    parameters
        Least width.

    Returns
    -------
    Sides of the room with the lower number, ordered by room, without surfels.
    """
    room_a, room_b, place = _contacts(surfels, labels, rooms)
    key = room_a.astype(np.int64) * (labels.room_count + 1) + room_b
    order = np.argsort(key, kind="stable")
    sides = []
    for members in np.split(order, np.flatnonzero(np.diff(key[order])) + 1) if len(key) else []:
        a, b = int(room_a[members[0]]), int(room_b[members[0]])
        for line in _lines(place[members]):
            if not _known(line, a, b, found):
                side = _side_along(line, rooms[a], rooms[b], parameters)
                if side is not None:
                    sides.append(side)
    return sides


def _contacts(surfels: Surfels, labels: RoomLabels, rooms: Mapping[int, Room]) -> tuple[I32, I32, F64]:
    """Room pairs (lower number first) and places where cells of two floors lie next to each other."""
    floor = np.full(labels.room_count + 1, np.nan)
    for known in rooms.values():
        floor[known.number] = known.floor_elevation
    height = surfels.positions[:, 2] - floor[labels.after]
    on_floor = np.flatnonzero((surfels.normals[:, 2] > 0.9) & (np.abs(height) < FLOOR_M))
    position, room = surfels.positions[on_floor].astype(np.float64), labels.after[on_floor]
    cells = np.floor(position[:, :2] / CELL_M).astype(np.int64)
    level = np.floor(floor[room] / 0.5).astype(np.int64)
    key = _pack(cells, level)
    keys, first = np.unique(key, return_index=True)
    pairs: list[tuple[I32, I32, F64]] = []
    for step in ((1, 0), (0, 1), (1, 1), (1, -1), (2, 0), (0, 2)):
        other_key = _pack(cells[first] + np.array(step), level[first])
        other = np.minimum(np.searchsorted(keys, other_key), len(keys) - 1)
        hit = np.flatnonzero(keys[other] == other_key) if len(keys) else np.zeros(0, dtype=np.int64)
        i, j = first[hit], first[other[hit]]
        differ = room[i] != room[j]
        i, j = i[differ], j[differ]
        middle = (position[i] + position[j]) / 2
        pairs.append((np.minimum(room[i], room[j]), np.maximum(room[i], room[j]), middle))
    a, b, place = (np.concatenate(columns) for columns in zip(*pairs, strict=True))
    return a, b, place


def _pack(cells: NDArray[np.int64], level: NDArray[np.int64]) -> NDArray[np.int64]:
    half = SHEET // 2
    return ((level + half) * SHEET + cells[:, 0] + half) * SHEET + cells[:, 1] + half


def _lines(place: F64) -> list[F64]:
    """Split places into groups that hang together within 0.3 m."""
    first, second = cKDTree(place).query_pairs(0.3, output_type="ndarray").T
    graph = coo_array((np.ones(len(first)), (first, second)), shape=(len(place), len(place)))
    parts, number = connected_components(graph, directed=False)
    return [place[number == part] for part in range(parts)]


def _known(line: F64, a: int, b: int, found: Iterable[Opening]) -> bool:
    """Whether an opening between the two rooms lies on a line of contact."""
    for opening in found:
        if (opening.room_a, opening.room_b) == (a, b):
            apart = np.linalg.norm(line[:, :2] - opening.position[:2], axis=1)
            if apart.min() < opening.width / 2 + 0.3:
                return True
    return False


def _side_along(line: F64, a: Room, b: Room, parameters: OpeningParameters) -> Side | None:
    """Upright side through a line of contact, turned towards room a; None if the line is too short."""
    centre = line.mean(axis=0)
    u = np.zeros(3)
    u[:2] = np.linalg.svd(line[:, :2] - centre[:2], full_matrices=False)[2][0]
    normal = np.cross(u, UP)
    if (a.centroid - b.centroid) @ normal < 0:
        u, normal = -u, -normal
    along = line @ u
    low, high = float(along.min()) - CELL_M, float(along.max()) + CELL_M
    if high - low < parameters.min_width_m:
        return None
    ceilings = [r.ceiling_elevation for r in (a, b) if r.ceiling_elevation is not None]
    top = max(ceilings) if ceilings else centre[2] + 2.5
    bounds = np.array([low, centre[2], high, top])
    return Side(a.number, (), normal, float(centre @ normal), u, UP, bounds, np.zeros(0, dtype=np.int32))
