"""Sparse points far from their scanner: surfels and planes go on as far as the scanner saw, ring by ring.

At 8 m the rings that a scanner draws on a floor lie decimetres apart: too few points for a normal of their own. But
they lie on a plane that is known nearer by. Each such point that a known plane comes near to becomes a surfel of that
plane, and makes the plane known to the next ring.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import cKDTree

from .cells import CellGrid
from .records import F32, F64, I32, Bitmap, Planes, Surfels, ThinnedCloud

I64 = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class SparseParameters:
    """How planes go on over sparse points.

    Attributes
    ----------
    cell_m
        Side of the cells of which the sparse points of one scan become one surfel.
    reach_m
        Farthest step from what is known of a plane to the next point on it.
    distance_m
        Farthest that a point lies from the plane.
    neighbours, least_agreeing
        So many points around one are asked, and such a share of them must lie on the plane as well: where a plane
        meets another surface, it does not go on along the line in which they cross.
    rounds
        Most steps outwards.
    wall_gap_m
        On walls, where a gap may be an opening, no more than this is covered between two points.
    seed_m
        What is known of a plane is looked for in one place of each cell of this side.
    """

    cell_m: float = 0.05
    reach_m: float = 0.7
    distance_m: float = 0.03
    neighbours: int = 8
    least_agreeing: float = 0.6
    rounds: int = 24
    wall_gap_m: float = 0.2
    seed_m: float = 0.2


@dataclass(frozen=True, slots=True)
class _Loose:
    """Cells of points without a surfel, ``(n, ...)``, and the cell of each such point, ``(k,)``."""

    positions: F64
    towards: F64
    scan: I32
    points: I64
    cell: I64


def extend_planes(
    cloud: ThinnedCloud, surfels: Surfels, planes: Planes, parameters: SparseParameters = SparseParameters()
) -> tuple[Surfels, Planes]:
    """Make surfels of the sparse points that lie on planes, and let the planes' bitmaps cover what is between them.

    Parameters
    ----------
    cloud
        The thinned cloud.
    surfels, planes
        As found where points are dense.

    Returns
    -------
    The surfels with further ones at the end, and the planes with these on them.
    """
    if not len(planes.bitmaps) or not (surfels.point_surfel < 0).any():
        return surfels, planes
    loose = _gather(cloud, surfels, parameters.cell_m)
    plane, step = _spread(loose, surfels, planes, parameters)
    taken = np.flatnonzero(plane >= 0)
    number = np.full(len(plane), -1, np.int32)
    number[taken] = len(surfels.positions) + np.arange(len(taken), dtype=np.int32)
    point_surfel = surfels.point_surfel.copy()
    point_surfel[loose.points] = number[loose.cell]
    positions = loose.positions[taken].astype(np.float32)
    grown = Surfels(
        np.concatenate([surfels.positions, positions]),
        np.concatenate([surfels.normals, planes.normals[plane[taken]]]),
        np.concatenate([surfels.scan, loose.scan[taken]]),
        point_surfel,
    )
    gap = np.where(planes.vertical[plane[taken]], np.minimum(step[taken], parameters.wall_gap_m), step[taken])
    bitmaps = _covered(planes.bitmaps, positions, plane[taken], gap)
    surfel_plane = np.concatenate([planes.surfel_plane, plane[taken]])
    return grown, replace(planes, surfel_plane=surfel_plane, bitmaps=bitmaps)


def _gather(cloud: ThinnedCloud, surfels: Surfels, cell_m: float) -> _Loose:
    points = np.flatnonzero(surfels.point_surfel < 0)
    positions, scan = cloud.positions[points], cloud.scan[points]
    key = CellGrid.around(positions, cell_m).keys(positions, scan)
    _, first, cell = np.unique(key, return_index=True, return_inverse=True)
    size = np.bincount(cell)
    mean = np.stack([np.bincount(cell, positions[:, axis]) / size for axis in range(3)], axis=1)
    return _Loose(mean, cloud.scanner_positions[scan[first]] - mean, scan[first], points, cell)


def _spread(loose: _Loose, surfels: Surfels, planes: Planes, parameters: SparseParameters) -> tuple[I32, F64]:
    """Plane of each loose cell, -1 for none, and how far the step to it was, metres."""
    plane = np.full(len(loose.positions), -1, np.int32)
    step = np.zeros(len(plane))
    seeds, of_seed = _seeds(surfels, planes, parameters.seed_m)
    everything = np.concatenate([loose.positions, seeds])
    around = np.asarray(
        cKDTree(everything).query(loose.positions, k=min(parameters.neighbours, len(everything)), workers=-1)[1]
    )
    around = around.reshape(len(plane), -1)
    for _ in range(parameters.rounds):
        free = np.flatnonzero(plane < 0)
        if not len(free) or not len(seeds):
            break
        chosen, distance = _nearest_plane(loose, free, seeds, of_seed, planes, parameters)
        height = np.einsum("ikj,ij->ik", everything[around[free]], planes.normals[chosen].astype(np.float64))
        agreeing = np.abs(height - planes.offsets[chosen, None]) < parameters.distance_m
        chosen[agreeing.mean(axis=1) < parameters.least_agreeing] = -1
        reached = free[chosen >= 0]
        plane[reached], step[reached] = chosen[chosen >= 0], distance[chosen >= 0]
        seeds, of_seed = loose.positions[reached].astype(np.float32), plane[reached]
    return plane, step


def _seeds(surfels: Surfels, planes: Planes, seed_m: float) -> tuple[F32, I32]:
    """One surfel of each plane and cell, with its plane."""
    on_plane = np.flatnonzero(planes.surfel_plane >= 0)
    key = CellGrid.around(surfels.positions, seed_m).keys(surfels.positions[on_plane], planes.surfel_plane[on_plane])
    kept = on_plane[np.unique(key, return_index=True)[1]]
    return surfels.positions[kept], planes.surfel_plane[kept]


def _nearest_plane(
    loose: _Loose, free: I64, seeds: F32, of_seed: I32, planes: Planes, parameters: SparseParameters
) -> tuple[I32, F64]:
    """For each free cell the plane of a seed nearby that it lies on and faces, the closest one; and the way to it."""
    count = min(6, len(seeds))
    positions = loose.positions[free]
    found = cKDTree(seeds).query(positions, k=count, distance_upper_bound=parameters.reach_m, workers=-1)
    distance = np.asarray(found[0]).reshape(len(free), count)
    candidate = np.append(of_seed, np.int32(-1))[np.asarray(found[1]).reshape(len(free), count)]
    normals = planes.normals[candidate].astype(np.float64)
    height = np.abs(np.einsum("ij,ikj->ik", positions, normals) - planes.offsets[candidate])
    faces = np.einsum("ij,ikj->ik", loose.towards[free], normals) > 0.0
    height = np.where((candidate >= 0) & faces, height, np.inf)
    best = np.argmin(height, axis=1)
    rows = np.arange(len(free))
    chosen = np.where(height[rows, best] < parameters.distance_m, candidate[rows, best], -1)
    return chosen.astype(np.int32), distance[rows, best]


def _covered(bitmaps: tuple[Bitmap, ...], positions: F32, plane: I32, gap: F64) -> tuple[Bitmap, ...]:
    """Bitmaps that cover half of the way from each new surfel to its neighbours as well."""
    order = np.argsort(plane, kind="stable")
    numbers, first = np.unique(plane[order], return_index=True)
    grown = list(bitmaps)
    for number, members in zip(numbers.tolist(), np.split(order, first[1:]), strict=True) if len(order) else ():
        grown[number] = _cover(bitmaps[number], positions[members], gap[members])
    return tuple(grown)


def _cover(bitmap: Bitmap, positions: F32, gap: F64) -> Bitmap:
    relative = positions - bitmap.origin
    cell = np.floor(np.stack([relative @ bitmap.v, relative @ bitmap.u], axis=1) / bitmap.cell_m).astype(np.int64)
    width = np.ceil(gap / 2.0 / bitmap.cell_m).astype(np.int64)
    margin = int(width.max()) + 1
    low = np.minimum(cell.min(axis=0) - margin, 0)
    high = np.maximum(cell.max(axis=0) + margin + 1, bitmap.occupancy.shape)
    occupancy = np.zeros(high - low, np.float32)
    rows, columns = bitmap.occupancy.shape
    occupancy[-low[0] : rows - low[0], -low[1] : columns - low[1]] = bitmap.occupancy
    for reach in np.unique(width):
        marked = np.zeros(occupancy.shape, bool)
        marked[tuple((cell[width == reach] - low).T)] = True
        occupancy[ndimage.binary_dilation(marked, np.ones((2 * reach + 1, 2 * reach + 1), bool))] = 1.0
    corner = bitmap.origin + bitmap.cell_m * (low[1] * bitmap.u + low[0] * bitmap.v)
    return replace(bitmap, origin=corner.astype(np.float32), occupancy=occupancy)
