"""Surfels: cells of the thinned cloud with a mean position and a normal turned towards the scanner (§4)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enfilade.parallel import at_once, in_slices, slices

from .cells import CellGrid, Gathered
from .moments import MOMENTS, add_point, fit_plane
from .records import F32, F64, I32, Surfels, ThinnedCloud

I64 = NDArray[np.int64]
_VIEWS_AT_ONCE: Final = 1 << 19


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
    views = Gathered.by(grid.keys(cloud.positions, cloud.scan))
    scan, cell = np.divmod(views.keys, grid.size)
    low = np.asarray(grid.lowest * grid.cell_m, np.float64)
    totals, normals = _measured(cloud, views, scan, grid, low, parameters)
    view_surfel, leading, sums = _join(Gathered.by(cell), totals, normals)
    positions = (sums[:, 1:4] / sums[:, :1] + low).astype(np.float32)
    point_surfel = np.empty(len(cloud.positions), np.int32)
    in_slices(_spread, len(views), point_surfel, view_surfel, views.order, views.bounds)
    return Surfels(positions, _unit(sums[:, 4:]), scan[leading].astype(np.int32), point_surfel)


def _measured(
    cloud: ThinnedCloud, views: Gathered, scan: I64, grid: CellGrid, low: F64, parameters: SurfelParameters
) -> tuple[F64, F64]:
    """Return ``(n, 4)`` the points of each view and the sums of their x, y, z from `low`, and ``(n, 3)`` its normal.

    A few scans at a time: a scan's normals come from it alone, and all moments of all views would be the most that an
    ingest holds in memory.
    """
    towards = cloud.scanner_positions.astype(np.float64) - low
    least = parameters.least_points, parameters.least_spread_m**2
    totals, normals = np.empty((len(views), 4)), np.zeros((len(views), 3))
    ends = np.searchsorted(scan, np.arange(len(towards)), side="right")
    first = 0
    while first < len(views):
        past = int(ends[np.searchsorted(ends, min(first + _VIEWS_AT_ONCE, len(views)))])
        some = slice(first, past)
        moments = np.zeros((past - first, MOMENTS))
        in_slices(_add_points, past - first, moments, cloud.positions, views.order, views.bounds[first : past + 1], low)
        own = normals[some], views.keys[some], grid.row_offsets(), moments, scan[some]
        in_slices(_fit_normals, past - first, *own, towards, *least)
        totals[some] = moments[:, :4]
        first = past
    return totals, normals


@njit(cache=True, nogil=True)
def _add_points(first: int, past: int, moments: F64, positions: F32, order: I64, bounds: I64, low: F64) -> None:
    """Fill in the moments of views `first` to `past`; the points of view i are ``order[bounds[i]:bounds[i + 1]]``."""
    for i in range(first, past):
        for at in range(bounds[i], bounds[i + 1]):
            x, y, z = positions[order[at]]
            add_point(moments[i], x - low[0], y - low[1], z - low[2])


@njit(cache=True, nogil=True)
def _fit_normals(
    first: int,
    past: int,
    normals: F64,
    keys: I64,
    offsets: I64,
    moments: F64,
    scan: I64,
    towards: F64,
    least_points: int,
    least_variance: float,
) -> None:
    """Fill in the normals of views `first` to `past`; they stay zero where the neighbourhood holds too little."""
    n = len(keys)
    total, normal, begins = np.empty(MOMENTS), np.empty(3), np.empty(9, np.int64)
    for k in range(9):
        begins[k] = np.searchsorted(keys, keys[first] + offsets[k])
    for i in range(first, past):
        total[:] = 0.0
        for k in range(9):
            while begins[k] < n and keys[begins[k]] < keys[i] + offsets[k]:
                begins[k] += 1
            at = begins[k]
            while at < n and keys[at] <= keys[i] + offsets[k] + 2:
                for m in range(MOMENTS):
                    total[m] += moments[at, m]
                at += 1
        if total[0] < least_points:
            continue
        _, middle, _ = fit_plane(total, normal)
        if middle < least_variance:
            continue
        side = 0.0
        for axis in range(3):
            side += normal[axis] * (towards[scan[i], axis] - moments[i, 1 + axis] / moments[i, 0])
        for axis in range(3):
            normals[i, axis] = normal[axis] if side >= 0.0 else -normal[axis]


def _join(cells: Gathered, totals: F64, normals: F64) -> tuple[I32, I64, F64]:
    """Join the views of each cell into surfels, in order of cells; sorts the views of a cell.

    Returns
    -------
    Which surfel each view belongs to, -1 for none; of each surfel the view with most points, and its sums
    ``(m, 7)``: points, their x, y, z, and the views' normals, each as often as it has points.
    """
    view_surfel = np.full(len(cells.order), -1, np.int32)
    arguments = view_surfel, cells.order, cells.bounds, totals, normals
    parts = slices(len(cells))
    found = at_once(_join_views, ((*part, *arguments) for part in parts))
    before = np.cumsum([0, *(len(leading) for leading, _ in found)])
    at_once(
        _count_on,
        ((*part, view_surfel, cells.order, cells.bounds, done) for part, done in zip(parts, before, strict=False)),
    )
    leading = np.concatenate([np.zeros(0, np.int64), *(leading for leading, _ in found)])
    return view_surfel, leading, np.concatenate([np.zeros((0, 7)), *(sums for _, sums in found)])


@njit(cache=True, nogil=True)
def _join_views(
    first: int, past: int, view_surfel: I32, order: I64, bounds: I64, totals: F64, normals: F64
) -> tuple[I64, F64]:
    """Join the views of cells `first` to `past`, ``order[bounds[c]:bounds[c + 1]]``; surfels are counted from 0 on.

    The view with most points leads, of those that have a normal; views of the cell that look at it from the other
    side make a second surfel. Views without a normal go with the leader. Returns leaders and sums as `_join`.
    """
    most = bounds[past] - bounds[first]
    leading, sums = np.empty(most, np.int64), np.zeros((most, 7))
    count = 0
    for cell in range(first, past):
        views = order[bounds[cell] : bounds[cell + 1]]
        _sort_by_points(views, totals)
        leader = -1
        for view in views:
            if leader < 0 and _dot(normals[view], normals[view]) > 0.0:
                leader = view
        if leader < 0:
            continue
        for opposed in (False, True):
            found = False
            for view in views:
                if (_dot(normals[view], normals[leader]) < 0.0) == opposed:
                    if not found:
                        leading[count] = view
                    found = True
                    view_surfel[view] = count
                    for axis in range(4):
                        sums[count, axis] += totals[view, axis]
                    for axis in range(3):
                        sums[count, 4 + axis] += totals[view, 0] * normals[view, axis]
            count += found
    return leading[:count].copy(), sums[:count].copy()


@njit(cache=True, nogil=True)
def _count_on(first: int, past: int, view_surfel: I32, order: I64, bounds: I64, done: int) -> None:
    """Give the surfels of cells `first` to `past` numbers after those of the cells before."""
    for at in range(bounds[first], bounds[past]):
        if view_surfel[order[at]] >= 0:
            view_surfel[order[at]] += done


@njit(cache=True, nogil=True)
def _sort_by_points(views: I64, totals: F64) -> None:
    """Sort a few views, those with most points first, by insertion."""
    for i in range(1, len(views)):
        view, at = views[i], i
        while at > 0 and totals[views[at - 1], 0] < totals[view, 0]:
            views[at] = views[at - 1]
            at -= 1
        views[at] = view


@njit(cache=True, nogil=True)
def _dot(a: F64, b: F64) -> float:
    return float(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


@njit(cache=True, nogil=True)
def _spread(first: int, past: int, point_surfel: I32, view_surfel: I32, order: I64, bounds: I64) -> None:
    """Fill in the surfel of each point of views `first` to `past`."""
    for view in range(first, past):
        for at in range(bounds[view], bounds[view + 1]):
            point_surfel[order[at]] = view_surfel[view]


def _unit(vectors: F64) -> F32:
    units = np.empty(vectors.shape, np.float32)
    in_slices(_fill_units, len(vectors), units, vectors)
    return units


@njit(cache=True, nogil=True)
def _fill_units(first: int, past: int, units: F32, vectors: F64) -> None:
    """Fill in vectors `first` to `past` at a length of 1."""
    for i in range(first, past):
        length = math.sqrt(vectors[i, 0] ** 2 + vectors[i, 1] ** 2 + vectors[i, 2] ** 2)
        for axis in range(3):
            units[i, axis] = vectors[i, axis] / length
