"""What only one scan saw, and others looked through: people who walked by, and images in mirrors.

Every ray says that all between the scanner and the point it measured is empty.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from enfilade.ingest.objects.parameters import ObjectParameters
from enfilade.ingest.objects.segments import thin
from enfilade.ingest.records import F32, F64, I32, ThinnedCloud

I64 = NDArray[np.int64]

BIN_DEG: Final = 0.3
MOST_SCANS: Final = 6
"""So many scans are asked, the nearest ones, be it through a door: the work stays linear in the scans."""
LEAST_IN_VIEW: Final = 0.3
"""A scan that sees a smaller share of a thing's place says nothing about it."""
ONE_SCAN: Final = 0.99
FARTHEST_M: Final = 8.0
"""From farther away rays are too sparse to tell what lies between them."""
KEPT_MAPS: Final = 32


class Sightlines:
    """Asks the scans around whether they look through something.

    Parameters
    ----------
    cloud
        All points, with the scan of each.
    parameters
        How far behind a thing a ray must end.
    """

    def __init__(self, cloud: ThinnedCloud, parameters: ObjectParameters) -> None:
        self._cloud, self._parameters = cloud, parameters
        self._order = np.argsort(cloud.scan, kind="stable")
        self._ends = np.cumsum(np.bincount(cloud.scan, minlength=len(cloud.scanner_positions)))
        self._depths = lru_cache(KEPT_MAPS)(self._measure_depths)

    def are_a_ghost(self, members: I32) -> bool:
        """Whether points, by index, are seen by one scan while another looks through most of them."""
        scan, count = np.unique(self._cloud.scan[members], return_counts=True)
        if count.max() < ONE_SCAN * len(members):
            return False
        points = self._cloud.positions[members].astype(np.float64)
        points = points[thin(points, self._parameters.voxel_m)[0]]
        apart = np.linalg.norm(self._cloud.scanner_positions - points.mean(axis=0), axis=1)
        apart[scan[count.argmax()]] = np.inf
        nearest = np.argsort(apart, kind="stable")[:MOST_SCANS]
        nearest = nearest[apart[nearest] < FARTHEST_M]
        return any(
            self._share_seen_through(points, int(other)) > self._parameters.min_seen_through for other in nearest
        )

    def _share_seen_through(self, points: F64, scan: int) -> float:
        """Share of the points, of those that nothing hides from a scan, behind which its rays end."""
        row, column, distance = _bins(points - self._cloud.scanner_positions[scan])
        depth = self._depths(scan)[row, column]
        margin = self._parameters.min_behind_m
        in_view = depth > distance - margin
        behind = np.isfinite(depth) & (depth > distance + margin)
        return float(behind.sum() / in_view.sum()) if in_view.mean() > LEAST_IN_VIEW else 0.0

    def _measure_depths(self, scan: int) -> F32:
        """Least distance that a scan measured in each direction, that of the next ones where it measured none."""
        own = self._order[self._ends[scan - 1] if scan else 0 : self._ends[scan]]
        row, column, distance = _bins(
            self._cloud.positions[own].astype(np.float64) - self._cloud.scanner_positions[scan]
        )
        depths = np.full((round(180 / BIN_DEG) + 1, round(360 / BIN_DEG) + 1), np.inf, dtype=np.float32)
        np.minimum.at(depths, (row, column), distance.astype(np.float32))
        around = ndimage.minimum_filter(depths, 3, mode=("nearest", "wrap"))
        return np.where(np.isfinite(depths), depths, around).astype(np.float32)


def _bins(rays: F64) -> tuple[I64, I64, F64]:
    """Rows (by elevation) and columns (by azimuth) of the directions, and the lengths."""
    distance = np.linalg.norm(rays, axis=1)
    elevation = np.degrees(np.arcsin(np.clip(rays[:, 2] / np.maximum(distance, 1e-9), -1, 1))) + 90
    azimuth = np.degrees(np.arctan2(rays[:, 1], rays[:, 0])) + 180
    return (elevation / BIN_DEG).astype(np.int64), (azimuth / BIN_DEG).astype(np.int64), distance
