"""Which room each point belongs to: that of its surfel, or of what lies beside it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import shapely
from numba import njit
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from enfilade.ingest.cells import CellGrid
from enfilade.ingest.records import F32, F64, I32, Bool, Room, RoomLabels, Surfels, ThinnedCloud
from enfilade.parallel import in_slices

I64 = NDArray[np.int64]


def rooms_of_points(
    points: I32,
    cloud: ThinnedCloud,
    surfels: Surfels,
    labels: RoomLabels,
    rooms: Mapping[int, Room],
    *,
    reach_m: float,
) -> I32:
    """Give points a room.

    Far and thin things are hit so sparsely that they have no surfels, and so no label. Their points go with the
    nearest surfel within `reach_m`, or to the room in whose outline, between floor and ceiling, they lie.

    Parameters
    ----------
    points
        ``(n,)`` indices.
    cloud, surfels, labels
        What the stages before found.
    rooms
        By number.
    reach_m
        How far a surfel tells the room, metres.

    Returns
    -------
    ``(n,) int32``, -1 for none.
    """
    surfel = surfels.point_surfel[points]
    room = np.append(labels.after, np.int32(-1))[surfel].astype(np.int32)
    orphans = np.flatnonzero(surfel < 0)
    if not len(orphans) or not len(surfels.positions):
        return room
    positions = cloud.positions[points[orphans]]
    near = _near(surfels.positions, positions, reach_m)
    tree = cKDTree(surfels.positions[near])
    apart, nearest = map(np.asarray, tree.query(positions, distance_upper_bound=reach_m))
    beside = np.isfinite(apart)
    room[orphans[beside]] = labels.after[near[nearest[beside]]]
    alone = orphans[~beside]
    room[alone] = _in_outlines(positions[~beside].astype(np.float64), list(rooms.values()))
    return room


def _near(positions: F32, others: F32, reach_m: float) -> I64:
    """Return the positions, by index, in the cells of others or next to these: all within reach, and some more."""
    grid = CellGrid.around(np.concatenate([positions, others]), reach_m)
    step = np.arange(3)
    around = (grid.row_offsets()[:, None] + step).ravel()
    wanted = np.unique(np.unique(grid.keys(others))[:, None] + around)
    near = np.zeros(len(positions), dtype=bool)
    in_slices(_mark, len(positions), near, grid.keys(positions), wanted)
    return np.flatnonzero(near)


@njit(cache=True, nogil=True)
def _mark(first: int, past: int, found: Bool, keys: I64, wanted: I64) -> None:
    """Mark the keys that are among the wanted ones, which are sorted."""
    for i in range(first, past):
        at = np.searchsorted(wanted, keys[i])
        found[i] = at < len(wanted) and wanted[at] == keys[i]


def _in_outlines(positions: F64, rooms: list[Room]) -> I32:
    """``(n,)`` number of the room that holds each position, the one with the highest floor of several, or -1."""
    found = np.full(len(positions), -1, dtype=np.int32)
    drawn = sorted((room for room in rooms if room.outline), key=lambda room: (room.floor_elevation, -room.number))
    if not drawn or not len(positions):
        return found
    tree = shapely.STRtree([shapely.Polygon(room.outline[0], room.outline[1:]) for room in drawn])
    point, rank = tree.query(shapely.points(positions[:, :2]), predicate="within")
    low = np.array([room.floor_elevation for room in drawn])
    high = np.array([room.bounds[5] if room.ceiling_elevation is None else room.ceiling_elevation for room in drawn])
    fits = (positions[point, 2] > low[rank]) & (positions[point, 2] < high[rank])
    highest = np.full(len(positions), -1, dtype=np.int64)
    np.maximum.at(highest, point[fits], rank[fits])
    numbers = np.array([room.number for room in drawn] + [-1], dtype=np.int32)
    return numbers[highest]
