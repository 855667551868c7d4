"""What else objects could be compared by, each as a vector a shape and a distance of vectors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray

from enfilade.native import open3d

F64 = NDArray[np.float64]

D2_PAIRS: Final = 20_000
D2_BIN_M: Final = 0.05
D2_BINS: Final = 64
FPFH_VOXEL_M: Final = 0.03
NORMAL_RADIUS_M: Final = 0.1
FPFH_RADIUS_M: Final = 0.25


@dataclass(frozen=True, slots=True)
class Peer:
    """A way to compare shapes.

    Attributes
    ----------
    describe
        From ``(n, 3)`` points, metres, to a vector.
    apart
        From a vector and ``(n, k)`` others to their ``(n,)`` distances.
    """

    describe: Callable[[F64], F64]
    apart: Callable[[F64, F64], F64]


def chi_square(one: F64, others: F64) -> F64:
    """Symmetric χ² of one histogram and many, with 0 for 0/0."""
    total = one + others
    terms = np.divide((one - others) ** 2, total, out=np.zeros_like(total), where=total > 0)
    return np.asarray(terms.sum(axis=1))


def size(points: F64) -> F64:
    """``(3,)``: logarithms of length, width of the least upright box around the points, and of its height."""
    around = shapely.minimum_rotated_rectangle(shapely.MultiPoint(points[:, :2]))
    sides = np.array([around.length, 0.0])
    if isinstance(around, shapely.Polygon):
        sides = np.linalg.norm(np.diff(np.asarray(around.exterior.coords)[:3], axis=0), axis=1)
    return np.log(np.maximum([sides.max(), sides.min(), np.ptp(points[:, 2])], 0.02))


def d2(points: F64) -> F64:
    """``(64,)`` shares of the distances between random pairs of points (Osada 2002), in bins of 5 cm."""
    rng = np.random.default_rng(0)
    a, b = rng.integers(len(points), size=(2, D2_PAIRS))
    apart = np.linalg.norm(points[a] - points[b], axis=1)
    bins = np.minimum((apart / D2_BIN_M).astype(np.int64), D2_BINS - 1)
    return np.asarray(np.bincount(bins, minlength=D2_BINS) / D2_PAIRS)


def fpfh(points: F64) -> F64:
    """``(33,)`` mean of Open3D's fast point feature histograms over the points (Rusu 2009), sum 1."""
    o3d = open3d()
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points)).voxel_down_sample(FPFH_VOXEL_M)
    cloud.estimate_normals(o3d.geometry.KDTreeSearchParamHybrid(NORMAL_RADIUS_M, 30))
    search = o3d.geometry.KDTreeSearchParamHybrid(FPFH_RADIUS_M, 100)
    mean = np.asarray(o3d.pipelines.registration.compute_fpfh_feature(cloud, search).data).mean(axis=1)
    return np.asarray(mean / max(mean.sum(), 1e-9))


PEERS: Final = {
    "size alone": Peer(size, lambda one, others: np.abs(one - others).sum(axis=1)),
    "D2 shape distribution": Peer(d2, chi_square),
    "pooled FPFH": Peer(fpfh, chi_square),
}
