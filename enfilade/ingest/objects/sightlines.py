"""What only one scan saw, and others looked through: people who walked by, and images in mirrors.

Every ray says that all between the scanner and the point it measured is empty.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Final

import numpy as np
from numba import njit

from enfilade.ingest.objects.masks import Face
from enfilade.ingest.objects.parameters import ObjectParameters
from enfilade.ingest.objects.segments import thin
from enfilade.ingest.objects.structure import in_openings
from enfilade.ingest.records import F32, F64, I32, Opening, ThinnedCloud

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

    def one_scan(self, members: I32) -> bool:
        """Whether nearly all of the points, by index, are of one scan."""
        return bool(np.bincount(self._cloud.scan[members]).max() >= ONE_SCAN * len(members))

    def are_a_ghost(self, members: I32, faces: Sequence[Face] = (), openings: Sequence[Opening] = ()) -> bool:
        """Whether points, by index, are seen by one scan while another looks through most of them.

        A ray that comes into the room through the back of one of its faces, and through no opening, was thrown back
        by a mirror: what it met lies elsewhere, and so does its way.
        """
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
            self._share_seen_through(points, int(other), faces, openings) > self._parameters.min_seen_through
            for other in nearest
        )

    def _share_seen_through(
        self, points: F64, scan: int, faces: Sequence[Face], openings: Sequence[Opening]
    ) -> float:
        """Share of the points, of those that nothing hides from a scan, behind which its rays end."""
        scanner = self._cloud.scanner_positions[scan].astype(np.float64)
        rays = points - scanner
        distance, depth = np.linalg.norm(rays, axis=1), _look_up(self._depths(scan), rays)
        margin = self._parameters.min_behind_m
        in_view = depth > distance - margin
        if in_view.mean() <= LEAST_IN_VIEW:
            return 0.0
        behind = np.flatnonzero(np.isfinite(depth) & (depth > distance + margin))
        mirrored = np.zeros(len(behind), dtype=bool)
        for face in faces:
            way, places = face.crossings(scanner, points[behind])
            mirrored[way] |= ~in_openings(places, openings, self._parameters)
        return float((~mirrored).sum() / in_view.sum())

    def _measure_depths(self, scan: int) -> F32:
        """Least distance that a scan measured in each direction, infinite where it measured none."""
        own = self._order[self._ends[scan - 1] if scan else 0 : self._ends[scan]]
        return _draw(self._cloud.positions[own].astype(np.float64) - self._cloud.scanner_positions[scan])


@njit(cache=True)
def _draw(rays: F64) -> F32:
    """Draw the least length of the rays in each bin of elevation (rows) and azimuth."""
    depths = np.full((round(180 / BIN_DEG) + 1, round(360 / BIN_DEG) + 1), np.inf, np.float32)
    for i in range(len(rays)):
        row, column, distance = _bin(rays[i, 0], rays[i, 1], rays[i, 2])
        depths[row, column] = min(depths[row, column], distance)
    return depths


@njit(cache=True)
def _look_up(depths: F32, rays: F64) -> F32:
    """``(n,)`` depth in the direction of each ray, the least of the eight bins around where its own is empty."""
    rows, columns = depths.shape
    found = np.full(len(rays), np.inf, np.float32)
    for i in range(len(rays)):
        row, column, _ = _bin(rays[i, 0], rays[i, 1], rays[i, 2])
        found[i] = depths[row, column]
        if np.isinf(found[i]):
            for a in range(max(row - 1, 0), min(row + 2, rows)):
                for b in range(column - 1, column + 2):
                    found[i] = min(found[i], depths[a, b % columns])
    return found


@njit(cache=True)
def _bin(x: float, y: float, z: float) -> tuple[int, int, float]:
    distance = max(np.sqrt(x * x + y * y + z * z), 1e-9)
    elevation = np.degrees(np.arcsin(z / distance)) + 90.0
    azimuth = np.degrees(np.arctan2(y, x)) + 180.0
    return int(elevation / BIN_DEG), int(azimuth / BIN_DEG), distance
