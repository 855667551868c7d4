"""Segments: connected components of what is left of a room without its structure (§6.1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from enfilade.ingest.cells import Gathered, extent
from enfilade.ingest.objects.parameters import ObjectParameters
from enfilade.ingest.records import F64, Bool

I64 = NDArray[np.int64]


def connect(points: F64, sparse: Bool, parameters: ObjectParameters) -> list[I64]:
    """Split points into groups that hang together, leaving out outliers and small groups.

    Points are thinned to one a voxel, voxels linked up to `link_m`: the work is linear in the points. Sparse points
    are what far and thin things are seen by, and what hangs in the air between near and far ones: they join what is
    next to them but never link two groups.

    Parameters
    ----------
    points
        ``(n, 3)`` metres.
    sparse
        ``(n,) bool``, points without a surfel.
    parameters
        Voxel, link, outliers and smallest size.

    Returns
    -------
    Indices of the points of each group, ordered by the groups' mean x, y, z.
    """
    if len(points) == 0:
        return []
    order = np.argsort(sparse, kind="stable")
    first, voxel = thin(points[order], parameters.voxel_m)
    centres, lone = points[order][first], sparse[order][first]
    part = np.full(len(first), -1, dtype=np.int64)
    kept = np.flatnonzero(without_outliers(centres, parameters))
    part[kept] = _parts(centres[kept], lone[kept], parameters)
    voxels = np.bincount(part + 1)[1:]
    point_part = np.empty(len(points), dtype=np.int64)
    point_part[order] = part[voxel]
    by_part = np.argsort(point_part, kind="stable")
    groups = np.split(by_part, np.cumsum(np.bincount(point_part + 1, minlength=len(voxels) + 1)))[1:-1]
    large = [
        group
        for group, size in zip(groups, voxels, strict=True)
        if size >= parameters.min_voxels and np.ptp(points[group], axis=0).max() >= parameters.min_extent_m
    ]
    return sorted(large, key=lambda group: tuple(points[group].mean(axis=0)))


def without_outliers(points: F64, parameters: ObjectParameters) -> Bool:
    """Tell which points have their neighbours near: mean distance to the k nearest at most μ + ασ (Rusu 2009).

    Parameters
    ----------
    points
        ``(n, 3)`` metres, one a voxel.
    parameters
        k and α, and the distance that is near in any case: where all is dense, what is less so is no outlier.

    Returns
    -------
    ``(n,) bool``, false for outliers.
    """
    k = parameters.outlier_neighbours
    if len(points) <= k:
        return np.zeros(len(points), dtype=bool)
    distance = np.asarray(cKDTree(points).query(points, k=k + 1)[0])
    mean = distance[:, 1:].mean(axis=1)
    most = float(mean.mean() + parameters.outlier_deviations * mean.std())
    return np.asarray(mean <= max(most, parameters.sparse_link_m), dtype=np.bool_)


def thin(points: F64, voxel_m: float) -> tuple[I64, I64]:
    """Keep the first point of each voxel; returns their indices, and the voxel of every point."""
    low, high = extent(points)
    cells = np.floor((points - low) / voxel_m).astype(np.int64)
    shape = np.floor((high - low) / voxel_m).astype(np.int64) + 1
    gathered = Gathered.by((cells[:, 2] * shape[1] + cells[:, 1]) * shape[0] + cells[:, 0])
    voxel = np.empty(len(points), dtype=np.int64)
    voxel[gathered.order] = np.repeat(np.arange(len(gathered)), np.diff(gathered.bounds))
    return gathered.order[gathered.bounds[:-1]], voxel


def _parts(centres: F64, lone: Bool, parameters: ObjectParameters) -> I64:
    """``(n,)`` number of the group of each voxel; lone ones join a group or make one, but never link two."""
    part = np.full(len(centres), -1, dtype=np.int64)
    dense, rest = np.flatnonzero(~lone), np.flatnonzero(lone)
    part[dense] = _components(centres[dense], parameters.link_m)
    own = _components(centres[rest], parameters.sparse_link_m)
    touches = np.zeros(int(own.max(initial=-1)) + 1, dtype=bool)
    if len(dense) and len(rest):
        apart, nearest = cKDTree(centres[dense]).query(centres[rest])
        np.logical_or.at(touches, own, apart <= parameters.link_m)
        part[rest] = part[dense[nearest]]
    alone = ~touches[own]
    part[rest[alone]] = part[dense].max(initial=-1) + 1 + np.unique(own[alone], return_inverse=True)[1]
    return part


def _components(centres: F64, link_m: float) -> I64:
    if not len(centres):
        return np.zeros(0, dtype=np.int64)
    a, b = cKDTree(centres).query_pairs(link_m, output_type="ndarray").T
    graph = coo_array((np.ones(len(a), dtype=bool), (a, b)), shape=(len(centres), len(centres)))
    return connected_components(graph, directed=False)[1].astype(np.int64)
