"""Segments: connected components of what is left of a room without its structure (§6.1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from enfilade.ingest.objects.parameters import ObjectParameters
from enfilade.ingest.records import F64, Bool


def without_outliers(points: F64, neighbours: int, deviations: float) -> Bool:
    """Tell which points have their neighbours near: mean distance to the k nearest at most μ + ασ (Rusu 2009).

    Parameters
    ----------
    points
        ``(n, 3)`` metres.
    neighbours, deviations
        k and α.

    Returns
    -------
    ``(n,) bool``, false for outliers.
    """
    if len(points) <= neighbours:
        return np.zeros(len(points), dtype=bool)
    distance = np.asarray(cKDTree(points).query(points, k=neighbours + 1)[0])
    mean = distance[:, 1:].mean(axis=1)
    return np.asarray(mean <= mean.mean() + deviations * mean.std(), dtype=np.bool_)


def connect(points: F64, parameters: ObjectParameters) -> list[NDArray[np.int64]]:
    """Split points into groups that hang together, leaving out small ones.

    Points are thinned to one a voxel, voxels linked up to `link_m`: the work is linear in the points.

    Parameters
    ----------
    points
        ``(n, 3)`` metres.
    parameters
        Voxel, link and smallest size.

    Returns
    -------
    Indices of the points of each group, ordered by the groups' mean x, y, z.
    """
    if len(points) == 0:
        return []
    first, voxel = thin(points, parameters.voxel_m)
    a, b = cKDTree(points[first]).query_pairs(parameters.link_m, output_type="ndarray").T
    graph = coo_array((np.ones(len(a), dtype=bool), (a, b)), shape=(len(first), len(first)))
    _, part = connected_components(graph, directed=False)
    voxels = np.bincount(part)
    order = np.argsort(part[voxel], kind="stable")
    groups = np.split(order, np.cumsum(np.bincount(part[voxel]))[:-1])
    kept = [
        group
        for group, size in zip(groups, voxels, strict=True)
        if size >= parameters.min_voxels and np.ptp(points[group], axis=0).max() >= parameters.min_extent_m
    ]
    return sorted(kept, key=lambda group: tuple(points[group].mean(axis=0)))


def thin(points: F64, voxel_m: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Keep the first point of each voxel; returns their indices, and the voxel of every point."""
    cells = np.floor((points - points.min(axis=0)) / voxel_m).astype(np.int64)
    extent = cells.max(axis=0) + 1
    key = (cells[:, 2] * extent[1] + cells[:, 1]) * extent[0] + cells[:, 0]
    _, first, voxel = np.unique(key, return_index=True, return_inverse=True)
    return first, voxel
