"""Which scans share a room: seen from under the ceiling, where a lintel closes every door (§4, first phase).

The paper merges the scan positions of a room by hand. Here each scanner is lifted to just below its ceiling, and
free places around it at that height are sampled. Two scans share a room where their places see each other and few
have a wall between them: round the corner of a room there is no wall, only more than one; through a door the wall
above it is in the way of all; through a passage without lintel only those see each other that are in line with it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from .records import F32, F64, I32, Bool, Groups, Planes
from .structure import Structure

I64 = NDArray[np.int64]
_PAIRS_AT_ONCE: Final = 2048
_RIVALS: Final = 6
_SHORT_OF_WALL: Final = 0.95
_GOLDEN: Final = (np.sqrt(5.0) - 1.0) / 2.0


@dataclass(frozen=True, slots=True)
class GroupParameters:
    """When two scans share a room.

    Attributes
    ----------
    below_ceiling_m
        How far under the ceiling scanners are lifted to look around.
    headroom_m
        How far a scanner is lifted at most, and where no ceiling is seen: beyond the head of any door, not into a
        gallery.
    level_m
        Scanners farther apart than this in height are in different rooms.
    azimuths
        Directions in which a lifted scanner looks around.
    places
        Places sampled in the area that it overlooks.
    reach_m
        Scans farther apart than this are not compared.
    sight_pairs
        Pairs of places that are tested for each pair of scans.
    least_sight
        Share of those pairs that must see each other.
    wall_m
        What is opaque for less than this along a line is a wall.
    least_open
        Of the pairs that see each other or have one wall between them, the share that must see each other.
    least_evidence
        Share of pairs that see each other or have one wall between them, below which they say nothing.
    storey_gap_m
        Scanners more than this apart in height, with none between, are numbered as different storeys.
    """

    below_ceiling_m: float = 0.15
    headroom_m: float = 1.1
    level_m: float = 1.6
    azimuths: int = 180
    places: int = 61
    reach_m: float = 20.0
    sight_pairs: int = 610
    least_sight: float = 0.05
    wall_m: float = 0.6
    least_open: float = 0.45
    least_evidence: float = 0.15
    storey_gap_m: float = 1.2


def group_scans(
    planes: Planes,
    scanner_positions: F32,
    given: Mapping[int, str] | None = None,
    parameters: GroupParameters = GroupParameters(),
) -> Groups:
    """Find which scans share a room; rooms are numbered from below, then along x and y.

    Parameters
    ----------
    planes
        The building's structure.
    scanner_positions
        ``(S, 3) float32``, metres.
    given
        Rooms of some or all scans as the user names them. They override the automatic groups, and a scan that is
        not among them follows the nearest given scan of its automatic group, if there is one.
    """
    structure = Structure(planes)
    lifted = scanner_positions.copy()
    rise = _clearance(structure, scanner_positions, 1.0) - parameters.below_ceiling_m
    lifted[:, 2] += np.clip(rise, 0.0, parameters.headroom_m)
    views = _compare_views(structure, scanner_positions, lifted, parameters)
    group = _joined(len(lifted), views, parameters)
    group = _overridden(group, given or {}, scanner_positions)
    scan_room = _numbered(group, scanner_positions.astype(np.float64), parameters.storey_gap_m)
    floors = (scanner_positions[:, 2] - _clearance(structure, scanner_positions, -1.0)).astype(np.float32)
    return Groups(scan_room, lifted, floors, _votes(scan_room, views, parameters))


@dataclass(frozen=True, slots=True)
class _Views:
    """How pairs of scans see each other's surroundings: ``(n, 2)`` pairs, shares of place pairs ``(n,)``."""

    pairs: I64
    seen: F64
    walled: F64

    def openness(self, least_evidence: float) -> F64:
        """``(n,)``: of what is seen or walled, the share that is seen; 0.5 where too little is either."""
        evidence = self.seen + self.walled
        share = np.full(len(evidence), 0.5)
        return np.divide(self.seen, evidence, out=share, where=evidence >= least_evidence)


def _compare_views(structure: Structure, scanners: F32, lifted: F32, parameters: GroupParameters) -> _Views:
    pairs = np.sort(cKDTree(scanners).query_pairs(parameters.reach_m, output_type="ndarray"), axis=1)
    pairs = pairs[np.abs(scanners[pairs[:, 0], 2] - scanners[pairs[:, 1], 2]) <= parameters.level_m]
    pairs = pairs[np.lexsort(pairs.T[::-1])]
    places = _free_places(structure, lifted, parameters)
    own = _own_places(structure, lifted, places)
    return _Views(pairs, *_sight(structure, places, own, pairs, parameters))


def _joined(count: int, views: _Views, parameters: GroupParameters) -> I64:
    """Join scans, the most open pairs first, unless that would put two into one room that a wall clearly parts.

    So a scanner that stood in a wide passage goes with one side and does not join the two.
    """
    openness = views.openness(parameters.least_evidence)
    parted = {(int(a), int(b)) for a, b in views.pairs[openness < parameters.least_open]}
    rooms = [{scan} for scan in range(count)]
    linked = np.flatnonzero((views.seen >= parameters.least_sight) & (openness >= parameters.least_open))
    for a, b in views.pairs[linked[np.argsort(-openness[linked], kind="stable")]]:
        one, other = rooms[a], rooms[b]
        if one is not other and not any((min(p, q), max(p, q)) in parted for p in one for q in other):
            one |= other
            for scan in other:
                rooms[scan] = one
    return np.array([min(room) for room in rooms], np.int64)


def _votes(scan_room: I32, views: _Views, parameters: GroupParameters) -> Bool:
    """``(S,)``: False where a scan is as open to another room as to its own, if its room has other scans that vote."""
    openness = views.openness(parameters.least_evidence)
    open_pairs = (views.seen >= parameters.least_sight) & (openness >= parameters.least_open)
    a, b = views.pairs[open_pairs].T
    across = scan_room[a] != scan_room[b]
    votes = np.ones(len(scan_room), bool)
    for scan in np.unique(np.concatenate([a[across], b[across]])):
        mates = np.flatnonzero((scan_room == scan_room[scan]) & votes)
        votes[scan] = len(mates) == 1
    return votes


def _free_places(structure: Structure, lifted: F32, parameters: GroupParameters) -> F32:
    """``(S, K, 3)``: places spread evenly over the area that each lifted scanner overlooks at its height."""
    azimuth = 2.0 * np.pi * np.arange(parameters.azimuths) / parameters.azimuths
    rays = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros_like(azimuth)], axis=1).astype(np.float32)
    starts = np.repeat(lifted, len(rays), axis=0)
    distance = structure.cast(starts, np.tile(rays, (len(lifted), 1))).distance
    free = np.minimum(distance, parameters.reach_m / 2.0).reshape(len(lifted), len(rays))
    share = (np.arange(parameters.places) + 0.5) / parameters.places
    area = np.cumsum(free**2, axis=1)
    ray = np.array([np.searchsorted(row, share * row[-1]) for row in area])
    ray = np.minimum(ray, len(rays) - 1)
    outwards = np.sqrt((share * _GOLDEN * parameters.places) % 1.0).astype(np.float32)
    reach = np.take_along_axis(free, ray, axis=1) * outwards * _SHORT_OF_WALL
    return np.asarray(lifted[:, None] + rays[ray] * reach[..., None], np.float32)


def _clearance(structure: Structure, scanners: F32, sign: float) -> F32:
    """``(S,)`` metres up (`sign` 1) to the ceiling or down (-1) to the floor, infinite where there is none.

    It is the median of what the front faces in a steep cone of rays say.
    """
    azimuth = 2.0 * np.pi * np.arange(16) / 16.0
    tilt = np.tile([0.1, 0.35], 8)
    cone = np.stack([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), sign * np.cos(tilt)], axis=1)
    directions = np.tile(cone.astype(np.float32), (len(scanners), 1))
    hits = structure.cast(np.repeat(scanners, len(cone), axis=0), directions)
    height = np.where(hits.front, hits.distance * np.abs(directions[:, 2]), np.nan).reshape(len(scanners), -1)
    seen = np.isfinite(height).any(axis=1)
    clearance = np.full(len(scanners), np.inf, np.float32)
    clearance[seen] = np.nanmedian(height[seen], axis=1)
    return clearance


def _own_places(structure: Structure, lifted: F32, places: F32) -> Bool:
    """``(S, K)``: places of which no other scanner that overlooks them is nearer than their own."""
    count, around = places.shape[:2]
    flat = places.reshape(-1, 3)
    scan = np.repeat(np.arange(count), around)
    rivals = np.atleast_2d(cKDTree(lifted).query(flat, k=min(_RIVALS, count))[1].reshape(len(flat), -1))
    distance = _distance(flat[:, None], lifted[rivals])
    nearer = distance < _distance(flat, lifted[scan])[:, None]
    place, rank = np.nonzero(nearer)
    overlooked = ~structure.blocked(lifted[rivals[place, rank]], flat[place])
    own = np.ones(len(flat), bool)
    own[place[overlooked]] = False
    return own.reshape(count, around)


def _sight(structure: Structure, places: F32, own: Bool, pairs: I64, parameters: GroupParameters) -> tuple[F64, F64]:
    """For each pair of scans: the share of place pairs that see each other, and that have one wall between them.

    Only a scan's own places count, so that what it overlooks through a passage does not count as here.
    """
    around, count = places.shape[1], parameters.sight_pairs
    a = np.arange(count) % around
    b = (np.arange(count) * 23 + np.arange(count) // around * 7) % around
    seen, walled = np.zeros(len(pairs)), np.zeros(len(pairs))
    for first in range(0, len(pairs), _PAIRS_AT_ONCE):
        one, other = pairs[first : first + _PAIRS_AT_ONCE].T
        counts = own[one][:, a] & own[other][:, b]
        thickness = _opaque_thickness(structure, places[one][:, a][counts], places[other][:, b][counts])
        pair, total = np.nonzero(counts)[0], np.maximum(counts.sum(axis=1), 1)
        thin = (thickness > 0.0) & (thickness < parameters.wall_m)
        seen[first : first + len(one)] = np.bincount(pair, thickness == 0.0, len(one)) / total
        walled[first : first + len(one)] = np.bincount(pair, thin, len(one)) / total
    return seen, walled


def _distance(a: F32, b: F32) -> F32:
    return np.asarray(np.linalg.norm(a - b, axis=-1), np.float32)


def _opaque_thickness(structure: Structure, starts: F32, ends: F32) -> F32:
    """``(n,)`` metres between what `starts` see first towards `ends` and what `ends` see first towards `starts`.

    Zero where they see each other.
    """
    length = _distance(starts, ends)
    towards = (ends - starts) / np.maximum(length, 1e-6)[:, None]
    forth = structure.cast(starts, towards).distance
    back = structure.cast(ends, -towards).distance
    blocked = forth < length
    thickness = np.where(blocked, length - forth - np.minimum(back, length), 0.0)
    return np.where(blocked, np.maximum(thickness, 1e-3), 0.0).astype(np.float32)


def _overridden(group: I64, rooms: Mapping[int, str], scanners: F32) -> I64:
    """Groups with the listed scans where the table says, and the others after the nearest listed of their group."""
    if not rooms:
        return group
    listed = np.array(sorted(rooms))
    names = {name: number for number, name in enumerate(dict.fromkeys(rooms.values()))}
    beyond = int(group.max()) + 1
    result = group.copy()
    for scan in range(len(group)):
        mates = listed[group[listed] == group[scan]]
        if scan in rooms:
            result[scan] = beyond + names[rooms[scan]]
        elif len(mates):
            nearest = mates[np.argmin(np.linalg.norm(scanners[mates] - scanners[scan], axis=1))]
            result[scan] = beyond + names[rooms[int(nearest)]]
    return result


def _numbered(group: I64, scanners: F64, storey_gap_m: float) -> I32:
    """Number groups by level, then x, then y of their scanners' mean, whatever the order of the scans."""
    _, group = np.unique(group, return_inverse=True)
    size = np.bincount(group)
    mean = np.stack([np.bincount(group, scanners[:, axis]) / size for axis in range(3)], axis=1)
    by_height = np.argsort(mean[:, 2], kind="stable")
    level = np.empty(len(size), np.int64)
    level[by_height] = np.cumsum(np.diff(mean[by_height, 2], prepend=mean[by_height[:1], 2]) > storey_gap_m)
    rank = np.empty(len(size), np.int32)
    rank[np.lexsort((mean[:, 1], mean[:, 0], level))] = np.arange(len(size), dtype=np.int32)
    return rank[group]
