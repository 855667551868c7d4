"""Surfels: cells of the thinned cloud with a mean position and a normal turned towards the scanner (§4)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .cells import CellGrid, neighbour_rows
from .moments import MOMENTS, fit_plane, moments_of
from .records import F32, F64, I32, Surfels, ThinnedCloud

I64 = NDArray[np.int64]
_VIEWS_AT_ONCE: Final = 1 << 16


@dataclass(frozen=True, slots=True)
class SurfelParameters:
    """How the thinned cloud becomes surfels.

    Attributes
    ----------
    cell_m
        Side of the cells that become one surfel a side.
    least_points
        Points of one scan that the 27 cells around must hold for a normal.
    least_spread_m
        Standard deviation across the line that points on a line lack: below, there is no normal.
    """

    cell_m: float = 0.05
    least_points: int = 6
    least_spread_m: float = 0.004


def make_surfels(cloud: ThinnedCloud, parameters: SurfelParameters = SurfelParameters()) -> Surfels:
    """Gather the points of each cell into surfels, one for each side that the cell was seen from.

    Normals come from the points of *one* scan in the 27 cells around: no scanner sees both faces of a wall at one
    place, so the two faces of a thin wall never mix. What several scans saw of a cell is then joined where their
    normals agree, and kept apart, as the two sides of something thin, where they oppose each other.
    """
    grid = CellGrid.around(cloud.positions, parameters.cell_m)
    key = grid.keys(cloud.positions, cloud.scan)
    order = np.argsort(key, kind="stable")
    starts = np.flatnonzero(np.diff(key[order], prepend=-1))
    view_key = key[order[starts]]
    low = np.asarray(grid.lowest * grid.cell_m, np.float64)
    moments = _moments(cloud.positions, order, starts, low)
    view_scan = (view_key // grid.size).astype(np.int32)
    towards = cloud.scanner_positions[view_scan].astype(np.float64) - low
    normals = _normals(view_key, grid.row_offsets(), moments, towards, parameters)
    view_surfel = _join_views(view_key % grid.size, moments[:, 0], normals)
    point_surfel = np.empty(len(key), np.int32)
    point_surfel[order] = np.repeat(view_surfel, np.diff(starts, append=len(key)))
    return _gather(view_surfel, view_scan, moments, normals, low, point_surfel)


def _moments(positions: F32, order: I64, starts: I64, low: F64) -> F64:
    """``(n, 10)`` moments of each view, its points being ``order[starts[i]:starts[i + 1]]``; some views at a time."""
    moments = np.empty((len(starts), MOMENTS))
    bounds = np.append(starts, len(order))
    for first in range(0, len(starts), _VIEWS_AT_ONCE):
        past = min(first + _VIEWS_AT_ONCE, len(starts))
        points = positions[order[bounds[first] : bounds[past]]].astype(np.float64) - low
        moments[first:past] = np.add.reduceat(moments_of(points), bounds[first:past] - bounds[first], axis=0)
    return moments


def _normals(keys: I64, offsets: I64, moments: F64, towards: F64, parameters: SurfelParameters) -> F64:
    """``(n, 3)`` normals, zero where the neighbourhood holds too little."""
    rows = neighbour_rows(keys, offsets)
    least_variance = parameters.least_spread_m**2
    return np.asarray(
        _fit_neighbourhoods(keys, offsets, rows, moments, towards, parameters.least_points, least_variance), np.float64
    )


@njit(cache=True)
def _fit_neighbourhoods(
    keys: I64, offsets: I64, rows: I32, moments: F64, towards: F64, least_points: int, least_variance: float
) -> F64:
    n = len(keys)
    normals = np.zeros((n, 3))
    total = np.empty(MOMENTS)
    normal = np.empty(3)
    for i in range(n):
        total[:] = 0.0
        for k in range(9):
            at = rows[i, k]
            while at < n and keys[at] <= keys[i] + offsets[k] + 2:
                total += moments[at]
                at += 1
        if total[0] < least_points:
            continue
        _, middle, _ = fit_plane(total, normal)
        if middle < least_variance:
            continue
        side = 0.0
        for axis in range(3):
            side += normal[axis] * (towards[i, axis] - moments[i, 1 + axis] / moments[i, 0])
        for axis in range(3):
            normals[i, axis] = normal[axis] if side >= 0.0 else -normal[axis]
    return normals


def _join_views(cell: I64, count: F64, normals: F64) -> I32:
    """Return which surfel each (scan, cell) view belongs to, -1 for none; in order of cells.

    The view with most points leads; views of the cell that look at it from the other side make a second surfel.
    Views without a normal go with the leader.
    """
    has_normal = np.asarray(normals.any(axis=1))
    order = np.lexsort((-count, ~has_normal, cell))
    first = np.flatnonzero(np.diff(cell[order], prepend=-1))
    leader = np.repeat(order[first], np.diff(first, append=len(order)))
    opposed = np.asarray(np.einsum("ij,ij->i", normals[order], normals[leader]) < 0.0)
    side: I64 = np.where(has_normal[leader], 2 * cell[order] + opposed, np.int64(-1))
    names, number = np.unique(side, return_inverse=True)
    surfel = np.empty(len(cell), np.int32)
    surfel[order] = number - np.count_nonzero(names == -1)
    return surfel


def _gather(view_surfel: I32, view_scan: I32, moments: F64, normals: F64, low: F64, point_surfel: I32) -> Surfels:
    """Sum the views of each surfel; its scan is the one that measured most of it."""
    used = np.flatnonzero(view_surfel >= 0)
    used = used[np.lexsort((-moments[used, 0], view_surfel[used]))]
    starts = np.flatnonzero(np.diff(view_surfel[used], prepend=-1))
    if not len(starts):
        empty = np.zeros((0, 3), np.float32)
        return Surfels(empty, empty, np.zeros(0, np.int32), point_surfel)
    sums = np.add.reduceat(moments[used, :4], starts, axis=0)
    positions = (sums[:, 1:] / sums[:, :1] + low).astype(np.float32)
    normal = np.add.reduceat(normals[used] * moments[used, :1], starts, axis=0)
    return Surfels(positions, _unit(normal), view_scan[used[starts]], point_surfel)


def _unit(vectors: F64) -> F32:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True), np.float32)
