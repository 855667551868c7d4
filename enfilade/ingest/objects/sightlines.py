"""What only one scan saw, and others looked through: people who walked by, and images in mirrors.

Every ray says that all between the scanner and the point it measured is empty.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enfilade.ingest.cells import members_of
from enfilade.ingest.objects.masks import Face
from enfilade.ingest.objects.parameters import ObjectParameters
from enfilade.ingest.objects.segments import thin
from enfilade.ingest.objects.structure import in_openings
from enfilade.ingest.records import F32, F64, I32, Bool, Opening, ThinnedCloud
from enfilade.parallel import at_once

I64 = NDArray[np.int64]

BIN_DEG: Final = 0.3
MOST_SCANS: Final = 6
"""So many scans are asked, the nearest ones, be it through a door: the work stays linear in the scans."""
LEAST_IN_VIEW: Final = 0.3
"""A scan that sees a smaller share of a thing's place says nothing about it."""
ONE_SCAN: Final = 0.99
FARTHEST_M: Final = 8.0
"""From farther away rays are too sparse to tell what lies between them."""


@dataclass(frozen=True, slots=True)
class Suspect:
    """What may have been there for one scan only.

    Attributes
    ----------
    members
        ``(n,)`` indices of its points.
    faces
        Structure of its room.
    openings
        Of its room.
    """

    members: I32
    faces: Sequence[Face] = ()
    openings: Sequence[Opening] = ()


@dataclass(frozen=True, slots=True)
class _Question:
    """A suspect, by its number, with one of its points a voxel, ``(n, 3)``."""

    number: int
    suspect: Suspect
    points: F64


def of_one_scan(cloud: ThinnedCloud, members: I32) -> bool:
    """Whether nearly all of the points, by index, are of one scan."""
    return bool(np.bincount(cloud.scan[members]).max() >= ONE_SCAN * len(members))


def find_ghosts(cloud: ThinnedCloud, suspects: Sequence[Suspect], parameters: ObjectParameters) -> Bool:
    """Tell which suspects are seen by one scan while another looks through most of them.

    A ray that comes into the room through the back of one of its faces, and through no opening, was thrown back
    by a mirror: what it met lies elsewhere, and so does its way. What a scan measured is drawn once, whomever it is
    asked about.

    Parameters
    ----------
    cloud
        All points, with the scan of each.
    suspects
        Who is asked about.
    parameters
        How far behind a thing a ray must end, and how many have to.

    Returns
    -------
    ``(n,) bool``.
    """
    asked: defaultdict[int, list[_Question]] = defaultdict(list)
    for number, suspect in enumerate(suspects):
        if of_one_scan(cloud, suspect.members):
            points = cloud.positions[suspect.members].astype(np.float64)
            points = points[thin(points, parameters.voxel_m)[0]]
            own = int(np.bincount(cloud.scan[suspect.members]).argmax())
            for scan in _scans_around(points, own, cloud.scanner_positions):
                asked[scan].append(_Question(number, suspect, points))
    found = np.zeros(len(suspects), dtype=bool)
    if asked:
        seen = members_of(cloud.scan, len(cloud.scanner_positions))
        for numbers in at_once(
            _seen_through, ((cloud, scan, seen[scan], asked[scan], parameters) for scan in sorted(asked))
        ):
            found[numbers] = True
    return found


def _scans_around(points: F64, own: int, scanners: F32) -> list[int]:
    """Return the scans next to points, the nearest first, but for the one that saw them."""
    apart = np.linalg.norm(scanners - points.mean(axis=0), axis=1)
    apart[own] = np.inf
    nearest = np.argsort(apart, kind="stable")[:MOST_SCANS]
    return [int(scan) for scan in nearest[apart[nearest] < FARTHEST_M]]


def _seen_through(
    cloud: ThinnedCloud, scan: int, seen: I64, questions: Sequence[_Question], parameters: ObjectParameters
) -> list[int]:
    """Numbers of the suspects that a scan looks through."""
    scanner = cloud.scanner_positions[scan].astype(np.float64)
    depths = _draw(cloud.positions, seen, scanner)
    return [
        question.number
        for question in questions
        if _share_seen_through(question, depths, scanner, parameters) > parameters.min_seen_through
    ]


def _share_seen_through(question: _Question, depths: F32, scanner: F64, parameters: ObjectParameters) -> float:
    """Share of the points, of those that nothing hides from a scan, behind which its rays end."""
    rays = question.points - scanner
    distance, depth = np.linalg.norm(rays, axis=1), _look_up(depths, rays)
    margin = parameters.min_behind_m
    in_view = depth > distance - margin
    if in_view.mean() <= LEAST_IN_VIEW:
        return 0.0
    behind = np.flatnonzero(np.isfinite(depth) & (depth > distance + margin))
    mirrored = np.zeros(len(behind), dtype=bool)
    for face in question.suspect.faces:
        way, places = face.crossings(scanner, question.points[behind])
        mirrored[way] |= ~in_openings(places, question.suspect.openings, parameters)
    return float((~mirrored).sum() / in_view.sum())


@njit(cache=True, nogil=True)
def _draw(positions: F32, seen: I64, scanner: F64) -> F32:
    """Draw the least distance that a scan measured in each bin of elevation (rows) and azimuth, or infinity."""
    depths = np.full((round(180 / BIN_DEG) + 1, round(360 / BIN_DEG) + 1), np.inf, np.float32)
    for i in seen:
        x, y, z = positions[i, 0] - scanner[0], positions[i, 1] - scanner[1], positions[i, 2] - scanner[2]
        row, column, distance = _bin(x, y, z)
        depths[row, column] = min(depths[row, column], distance)
    return depths


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True, inline="always")
def _bin(x: float, y: float, z: float) -> tuple[int, int, float]:
    distance = max(np.sqrt(x * x + y * y + z * z), 1e-9)
    elevation = np.degrees(np.arcsin(z / distance)) + 90.0
    azimuth = np.degrees(np.arctan2(y, x)) + 180.0
    return int(elevation / BIN_DEG), int(azimuth / BIN_DEG), distance
