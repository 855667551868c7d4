"""Planar patches with occupancy bitmaps, one patch a side of a wall (§4), by region growing on the surfels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import ndimage, sparse

from enfilade.parallel import in_slices

from .cells import CellGrid, Gathered, neighbour_rows
from .moments import MOMENTS, add_point, fit_plane
from .records import F32, F64, I32, Bitmap, Planes, Surfels

I64 = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class PlaneParameters:
    """What counts as one plane.

    Attributes
    ----------
    surfel_cell_m
        Side of the surfels' cells.
    distance_m
        Farthest that a surfel lies from its plane.
    angle_deg
        Greatest angle between a surfel's normal and its plane's.
    least_area_m2
        Area of surfels below which a patch is no plane.
    merge_angle_deg, merge_distance_m, merge_gap_m
        Patches of one side become one where their normals, their distances along them and the free stretch between
        them differ by no more than this.
    bitmap_cell_m
        Side of a cell of the occupancy bitmaps.
    """

    surfel_cell_m: float = 0.05
    distance_m: float = 0.03
    angle_deg: float = 25.0
    least_area_m2: float = 0.15
    merge_angle_deg: float = 4.0
    merge_distance_m: float = 0.03
    merge_gap_m: float = 0.6
    bitmap_cell_m: float = 0.10


def find_planes(surfels: Surfels, parameters: PlaneParameters = PlaneParameters()) -> Planes:
    """Find the planar patches of the surfels, each with the surfels that lie on it and its occupancy bitmap."""
    plane = _merge_fragments(surfels, _grow_planes(surfels, parameters), parameters)
    normals, centres = _fit(surfels.positions, surfels.normals, plane)
    bitmaps = _bitmaps(surfels.positions, plane, normals, centres, parameters.bitmap_cell_m)
    offsets = np.einsum("ij,ij->i", normals, centres)
    return Planes(normals.astype(np.float32), offsets.astype(np.float32), plane, bitmaps)


# --- growing ---------------------------------------------------------------------------------------------------


def _grow_planes(surfels: Surfels, parameters: PlaneParameters) -> I32:
    """``(M,) int32`` plane of each surfel, -1 for none, from patches grown one after the other."""
    if not len(surfels.positions):
        return np.zeros(0, np.int32)
    grid = CellGrid.around(surfels.positions, parameters.surfel_cell_m)
    keys, offsets = grid.keys(surfels.positions), grid.row_offsets()
    order = Gathered.by(keys).order
    keys = keys[order]
    rows = neighbour_rows(keys, offsets)
    positions, normals = surfels.positions[order], surfels.normals[order]
    tolerance, cosine = parameters.distance_m, float(np.cos(np.radians(parameters.angle_deg)))
    flat = np.zeros(len(keys), np.int32)
    in_slices(_count_flat, len(keys), flat, keys, offsets, rows, positions, normals)
    seeds = np.argsort(-flat.astype(np.int16), kind="stable")  # linear in short integers
    least = int(np.ceil(parameters.least_area_m2 / parameters.surfel_cell_m**2))
    grown = _grow(keys, offsets, rows, positions, normals, seeds, tolerance, cosine, least)
    fitted, centres = _fit(positions, normals, grown)
    plane = np.empty(len(keys), np.int32)
    plane[order] = _take_in_edges(keys, offsets, rows, positions, normals, grown, fitted, centres, tolerance)
    return plane


@njit(cache=True, nogil=True)
def _count_flat(
    first: int, past: int, flat: I32, keys: I64, offsets: I64, rows: I32, positions: F32, normals: F32
) -> None:
    """Count, for surfels `first` to `past`, the neighbours with much the same normal on much the same plane."""
    n = len(keys)
    for i in range(first, past):
        for k in range(9):
            at = rows[i, k]
            while at < n and keys[at] <= keys[i] + offsets[k] + 2:
                cosine = 0.0
                height = 0.0
                for axis in range(3):
                    cosine += np.float64(normals[i, axis]) * normals[at, axis]
                    height += normals[i, axis] * (np.float64(positions[at, axis]) - positions[i, axis])
                if cosine > 0.98 and abs(height) < 0.01:
                    flat[i] += 1
                at += 1


@njit(cache=True, nogil=True)
def _grow(
    keys: I64,
    offsets: I64,
    rows: I32,
    positions: F32,
    normals: F32,
    seeds: I64,
    tolerance: float,
    cosine: float,
    least: int,
) -> I32:
    """Grow a patch from each seed that is still free; the plane is fitted anew whenever the patch has doubled."""
    n = len(keys)
    plane = np.full(n, -1, np.int32)
    tried = np.full(n, -1, np.int32)
    queue = np.empty(n, np.int32)
    normal = np.empty(3)
    found = 0
    for trial in range(n):
        seed = seeds[trial]
        if plane[seed] >= 0 or tried[seed] >= 0:
            continue
        size = _grow_from(
            seed, trial, keys, offsets, rows, positions, normals, plane, tried, queue, normal, tolerance, cosine
        )
        if size >= least:
            for at in range(size):
                plane[queue[at]] = found
            found += 1
    return plane


@njit(cache=True, nogil=True)
def _grow_from(
    seed: int,
    trial: int,
    keys: I64,
    offsets: I64,
    rows: I32,
    positions: F32,
    normals: F32,
    plane: I32,
    tried: I32,
    queue: I32,
    normal: F64,
    tolerance: float,
    cosine: float,
) -> int:
    """Fill `queue` with the patch around a seed and return its size."""
    n = len(keys)
    moments = np.zeros(MOMENTS)
    normal[:] = normals[seed]
    offset = 0.0
    for axis in range(3):
        offset += normal[axis] * positions[seed, axis]
    queue[0] = seed
    tried[seed] = trial
    size, head, refit = 1, 0, 8
    while head < size:
        i = queue[head]
        head += 1
        add_point(moments, np.float64(positions[i, 0]), np.float64(positions[i, 1]), np.float64(positions[i, 2]))
        if head == refit:
            offset = _refit(moments, normals[seed], normal)
            refit *= 2
        for k in range(9):
            at = rows[i, k]
            while at < n and keys[at] <= keys[i] + offsets[k] + 2:
                if plane[at] < 0 and tried[at] != trial:
                    along, height = 0.0, -offset
                    for axis in range(3):
                        along += normal[axis] * normals[at, axis]
                        height += normal[axis] * positions[at, axis]
                    if along > cosine and abs(height) < tolerance:
                        tried[at] = trial
                        queue[size] = at
                        size += 1
                at += 1
    return size


@njit(cache=True, nogil=True)
def _refit(moments: F64, side: F32, normal: F64) -> float:
    """Fit the plane anew, its normal on the side of `side`; return its offset."""
    fit_plane(moments, normal)
    if normal[0] * side[0] + normal[1] * side[1] + normal[2] * side[2] < 0.0:
        normal[:] = -normal
    total = normal[0] * moments[1] + normal[1] * moments[2] + normal[2] * moments[3]
    return float(total / moments[0])


@njit(cache=True, nogil=True)
def _take_in_edges(
    keys: I64,
    offsets: I64,
    rows: I32,
    positions: F32,
    normals: F32,
    plane: I32,
    plane_normals: F64,
    centres: F64,
    tolerance: float,
) -> I32:
    """Give free surfels beside a patch, whose normals an edge has blurred, to the nearest plane that they face."""
    n = len(keys)
    taken = plane.copy()
    for i in range(n):
        if plane[i] >= 0:
            continue
        nearest = tolerance
        for k in range(9):
            at = rows[i, k]
            while at < n and keys[at] <= keys[i] + offsets[k] + 2:
                p = plane[at]
                if p >= 0:
                    along, height = 0.0, 0.0
                    for axis in range(3):
                        along += plane_normals[p, axis] * normals[i, axis]
                        height += plane_normals[p, axis] * (positions[i, axis] - centres[p, axis])
                    if along > 0.2 and abs(height) < nearest:
                        nearest = abs(height)
                        taken[i] = p
                at += 1
    return taken


# --- merging and fitting ---------------------------------------------------------------------------------------


def _fit(positions: F32, normals: F32, plane: I32) -> tuple[F64, F64]:
    """Least-squares normals ``(P, 3)``, on the side of the surfels' own, and centres ``(P, 3)`` of all planes."""
    centres, sides, scatter = _scatter(positions, normals, plane, int(plane.max(initial=-1)) + 1)
    fitted = np.linalg.eigh(scatter)[1][:, :, 0]
    side = np.einsum("ij,ij->i", fitted, sides)
    return np.where(side[:, None] < 0.0, -fitted, fitted), centres


@njit(cache=True, nogil=True)
def _scatter(positions: F32, normals: F32, plane: I32, count: int) -> tuple[F64, F64, F64]:
    """Centres ``(P, 3)``, sums of normals ``(P, 3)`` and scatter matrices ``(P, 3, 3)`` of the planes."""
    size, centres = np.zeros(count), np.zeros((count, 3))
    sides, scatter = np.zeros((count, 3)), np.zeros((count, 3, 3))
    for i in range(len(plane)):
        p = plane[i]
        if p >= 0:
            size[p] += 1.0
            for axis in range(3):
                centres[p, axis] += positions[i, axis]
                sides[p, axis] += normals[i, axis]
    for p in range(count):
        centres[p] /= size[p]
    for i in range(len(plane)):
        p = plane[i]
        if p >= 0:
            for a in range(3):
                for b in range(3):
                    scatter[p, a, b] += (positions[i, a] - centres[p, a]) * (positions[i, b] - centres[p, b])
    return centres, sides, scatter


def _merge_fragments(surfels: Surfels, plane: I32, parameters: PlaneParameters) -> I32:
    """Join patches of one side that lie on one plane close together; number the planes, the largest first."""
    count = int(plane.max(initial=-1)) + 1
    if count == 0:
        return plane
    size = np.bincount(plane[plane >= 0], minlength=count)
    normals, centres = _fit(surfels.positions, surfels.normals, plane)
    cosine = float(np.cos(np.radians(parameters.merge_angle_deg)))
    fit = size, normals, centres, cosine, parameters.merge_distance_m
    boxes = _boxes(surfels.positions, plane, parameters.merge_gap_m)
    pairs = np.concatenate(in_slices(_fragments, len(boxes[0]), *boxes, parameters.merge_gap_m, *fit))
    links = sparse.coo_array((np.ones(len(pairs), np.int8), tuple(pairs.T)), shape=(count, count))
    merged = sparse.csgraph.connected_components(links, directed=False)[1]
    rank = np.argsort(np.argsort(-np.bincount(merged, size), kind="stable"))
    return np.where(plane >= 0, rank[merged[plane]], -1).astype(np.int32)


def _boxes(positions: F32, plane: I32, gap_m: float) -> tuple[I64, I64, I32, I64, F32, F32]:
    """Boxes around the surfels of a patch in each cell, ``(n,)``, sorted so that those within a gap are found.

    Returns
    -------
    Keys of a grid so coarse that boxes within a gap are in one cell or in neighbours, with the offsets and rows of
    `neighbour_rows`; patch, least and greatest coordinates of each box.
    """
    on_plane = np.flatnonzero(plane >= 0)
    grid = CellGrid.around(positions, gap_m / 2.0)
    cells = Gathered.by(grid.keys(positions[on_plane], plane[on_plane]))
    low, high = np.empty((len(cells), 3), np.float32), np.empty((len(cells), 3), np.float32)
    in_slices(_box, len(cells), low, high, positions, on_plane[cells.order], cells.bounds)
    coarse = CellGrid.around(low, 1.5 * gap_m)
    keys, offsets = coarse.keys(low), coarse.row_offsets()
    order = Gathered.by(keys).order
    keys = keys[order]
    return keys, offsets, neighbour_rows(keys, offsets), (cells.keys // grid.size)[order], low[order], high[order]


@njit(cache=True, nogil=True)
def _fragments(
    first: int,
    past: int,
    keys: I64,
    offsets: I64,
    rows: I32,
    patch: I64,
    low: F32,
    high: F32,
    gap_m: float,
    size: I64,
    normals: F64,
    centres: F64,
    cosine: float,
    distance_m: float,
) -> I64:
    """``(k, 2)`` pairs of patches on one plane of which boxes lie within a gap, told by boxes `first` to `past`."""
    n = len(keys)
    pairs, count = np.empty((64, 2), np.int64), 0
    joined = np.full(len(size), -1, np.int64)
    for i in range(first, past):
        a = patch[i]
        for k in range(9):
            at = rows[i, k]
            while at < n and keys[at] <= keys[i] + offsets[k] + 2:
                b = patch[at]
                if a < b and joined[b] != a and _on_one_plane(a, b, size, normals, centres, cosine, distance_m):
                    apart = 0.0
                    for axis in range(3):
                        apart += max(low[i, axis] - high[at, axis], low[at, axis] - high[i, axis], 0.0) ** 2
                    if apart <= gap_m**2:
                        if count == len(pairs):
                            pairs = np.concatenate((pairs, np.empty_like(pairs)))
                        pairs[count] = a, b
                        joined[b] = a
                        count += 1
                at += 1
    return pairs[:count]


@njit(cache=True, nogil=True)
def _on_one_plane(a: int, b: int, size: I64, normals: F64, centres: F64, cosine: float, distance_m: float) -> bool:
    """Whether two patches of one side lie on the plane of the larger one, of equals the one named first."""
    small, large = (a, b) if size[a] < size[b] else (b, a)
    along, height = 0.0, 0.0
    for axis in range(3):
        along += normals[small, axis] * normals[large, axis]
        height += normals[large, axis] * (centres[small, axis] - centres[large, axis])
    return bool(along > cosine and abs(height) < distance_m)


@njit(cache=True, nogil=True)
def _box(first: int, past: int, low: F32, high: F32, positions: F32, order: I64, bounds: I64) -> None:
    """Fill in the least and greatest coordinates of groups `first` to `past`."""
    for group in range(first, past):
        for axis in range(3):
            low[group, axis], high[group, axis] = np.inf, -np.inf
            for at in range(bounds[group], bounds[group + 1]):
                low[group, axis] = min(low[group, axis], positions[order[at], axis])
                high[group, axis] = max(high[group, axis], positions[order[at], axis])


# --- bitmaps ---------------------------------------------------------------------------------------------------


def _bitmaps(positions: F32, plane: I32, normals: F64, centres: F64, cell_m: float) -> tuple[Bitmap, ...]:
    """Bitmaps of all planes: 1 where a cell holds a surfel, then smoothed by a box filter of 3 x 3 cells."""
    if not len(normals):
        return ()
    u, v = _axes(normals)
    on_plane = np.flatnonzero(plane >= 0)
    members = Gathered.by(plane[on_plane].astype(np.int64))
    order = on_plane[members.order]
    i, j = cells = np.empty((2, len(order)), np.int64)
    in_slices(_find_cells, len(order), cells, positions, order, plane, centres, v, u, cell_m)
    starts, ends = members.bounds[:-1], members.bounds[1:]
    low_i, low_j = np.minimum.reduceat(i, starts) - 1, np.minimum.reduceat(j, starts) - 1
    rows, columns = np.maximum.reduceat(i, starts) - low_i + 2, np.maximum.reduceat(j, starts) - low_j + 2
    corners = centres + cell_m * (low_j[:, None] * u + low_i[:, None] * v)
    bitmaps = []
    for p, (start, end) in enumerate(zip(starts, ends, strict=True)):
        occupied = np.zeros((rows[p], columns[p]), np.float32)
        occupied[i[start:end] - low_i[p], j[start:end] - low_j[p]] = 1.0
        smooth = ndimage.uniform_filter(occupied, size=3, mode="constant")
        bitmaps.append(Bitmap(_f32(corners[p]), _f32(u[p]), _f32(v[p]), cell_m, smooth))
    return tuple(bitmaps)


@njit(cache=True, nogil=True)
def _find_cells(
    first: int,
    past: int,
    cells: I64,
    positions: F32,
    order: I64,
    plane: I32,
    centres: F64,
    v: F64,
    u: F64,
    cell_m: float,
) -> None:
    """Fill in row and column, from the centre of its plane, of the cells of surfels `first` to `past` in an order."""
    for at in range(first, past):
        p = plane[order[at]]
        up, along = 0.0, 0.0
        for axis in range(3):
            relative = positions[order[at], axis] - centres[p, axis]
            up += relative * v[p, axis]
            along += relative * u[p, axis]
        cells[0, at], cells[1, at] = int(np.floor(up / cell_m)), int(np.floor(along / cell_m))


def _axes(normals: F64) -> tuple[F64, F64]:
    """Two unit axes in each plane, ``(P, 3)``: `u` level, `v` up the slope; x and y on a level plane."""
    level = np.abs(normals[:, 2]) > 0.95
    along_x = np.array([1.0, 0.0, 0.0]) - normals[:, :1] * normals
    across = np.stack([-normals[:, 1], normals[:, 0], np.zeros(len(normals))], axis=1)
    u = np.where(level[:, None], along_x, across)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(normals, u)
    return u, np.where((level | (v[:, 2] >= 0.0))[:, None], v, -v)


def _f32(vector: F64) -> F32:
    return vector.astype(np.float32)
