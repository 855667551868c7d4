"""Which scans share a room: seen from under the ceiling, where a lintel closes every door (§4, first phase).

The paper merges the scan positions of a room by hand. Here each scanner is lifted to just below its ceiling, and
free places around it at that height are sampled. Two scans share a room where their places see each other and few
have a wall between them: round the corner of a room there is no wall, only more than one; through a door the wall
above it is in the way of all; through a passage without lintel only those see each other that are in line with it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .records import F32, F64, I32, Bool, Groups, Planes
from .sight import SightParameters, Views, compare_views
from .structure import Hits, Structure

I64 = NDArray[np.int64]
_LEVEL: Final = 0.7
_OVERHEAD: Final = 0.25
"""What faces down by so much, even a steep roof, is overhead."""
_SOFFIT: Final = 0.95
"""What faces down by so much is level."""
_ASIDE: Final = 8
"""Directions in which a scanner may step aside."""
_SAME_M: Final = 0.05
"""Soffits this close to the clearance over a scanner are what it was measured to."""
_UP: Final = np.array([0.0, 0.0, 1.0], np.float32)
_TRIPOD_M: Final = 2.5
"""Highest that a scanner stands over its floor."""


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
    least_open
        Share of the boundary between two scans that must be open.
    doubtful_open
        A scan this open to another room does not vote on where rooms end,
    least_overlooked
        if those of its own room that vote overlook such a share of what it does.
    least_roofed
        Share of the directions upwards in which a scan inside a building meets a ceiling or a roof. Those of fewer
        stood outside; if all do, none looked up.
    storey_gap_m
        Scanners more than this apart in height, with none between, are numbered as different storeys.
    aside_m
        How far a scanner that stood under the head of a door or window steps aside before it is lifted,
    least_head_m
        if the ceiling there is so much higher,
    least_higher
        and such a share of what it sees overhead.
    sight
        How views are compared.
    """

    below_ceiling_m: float = 0.15
    headroom_m: float = 1.1
    least_open: float = 0.6
    doubtful_open: float = 0.48
    least_overlooked: float = 0.75
    least_roofed: float = 0.3
    storey_gap_m: float = 1.2
    aside_m: float = 0.6
    least_head_m: float = 0.15
    least_higher: float = 0.25
    sight: SightParameters = field(default_factory=SightParameters)


def group_scans(
    planes: Planes,
    scanner_positions: F32,
    given: Mapping[int, str] | None = None,
    parameters: GroupParameters = GroupParameters(),
) -> Groups:
    """Find which scans share a room; rooms are numbered from below, then along x and y, and outside is none.

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
    lifted = _lifted(structure, planes, scanner_positions, parameters)
    inside = _inside(structure, planes, scanner_positions, given or {}, parameters.least_roofed)
    scanners = scanner_positions[inside]
    views = compare_views(structure, planes, scanners, lifted[inside], parameters.sight)
    group = _joined(len(inside), views, parameters.least_open)
    rank = {int(scan): place for place, scan in enumerate(inside)}
    group = _overridden(group, {rank[scan]: room for scan, room in (given or {}).items()}, scanners)
    own = _numbered(group, scanners.astype(np.float64), parameters.storey_gap_m)
    scan_room, votes = np.full(len(lifted), -1, np.int32), np.zeros(len(lifted), bool)
    scan_room[inside], votes[inside] = own, _votes(own, views, structure, lifted[inside], parameters)
    floors = (scanner_positions[:, 2] - _clearance(structure, planes, scanner_positions, -1.0)).astype(np.float32)
    return Groups(scan_room, lifted, floors, votes)


def _lifted(structure: Structure, planes: Planes, scanners: F32, parameters: GroupParameters) -> F32:
    """Lift scanners to just below the ceiling, ``(S, 3)``; from under a head of a door or window they step aside first.

    From under a head one looks through it as if it were none. They step to where fewest of the others look.
    """
    most = parameters.below_ceiling_m + parameters.headroom_m
    clearance = np.minimum(_clearance(structure, planes, scanners, 1.0), most)
    lifted = scanners + _UP * np.maximum(clearance - parameters.below_ceiling_m, 0.0)[:, None]
    result = lifted.copy()
    azimuth = 2.0 * np.pi * np.arange(_ASIDE) / _ASIDE
    ring = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(_ASIDE)], axis=1) * parameters.aside_m
    for scan in _under_heads(structure, planes, scanners, clearance, parameters):
        asked = (scanners[scan] + ring).astype(np.float32)
        there = _clearance(structure, planes, asked, 1.0)
        free = np.isfinite(there) & (there >= clearance[scan] + parameters.least_head_m)
        free &= ~structure.blocked(np.broadcast_to(scanners[scan], asked.shape), asked)
        if free.any():
            raised = asked[free] + _UP * (np.minimum(there[free], most) - parameters.below_ceiling_m)[:, None]
            near = np.linalg.norm(lifted - lifted[scan], axis=1) < parameters.sight.reach_m
            near[scan] = False
            result[scan] = raised[np.argmin(_lookers(structure, raised, lifted[near]))]
    return result.astype(np.float32)


def _lookers(structure: Structure, places: F32, viewpoints: F32) -> I64:
    """``(n,)`` by how many of the viewpoints each place is overlooked."""
    starts, ends = np.repeat(places, len(viewpoints), axis=0), np.tile(viewpoints, (len(places), 1))
    return np.asarray((~structure.blocked(starts, ends)).reshape(len(places), -1).sum(axis=1), np.int64)


def _under_heads(
    structure: Structure, planes: Planes, scanners: F32, clearance: F32, parameters: GroupParameters
) -> I64:
    """Find scans whose lowest ceiling is level, while a good part of what they see overhead is higher."""
    hits, cone = _cone(structure, scanners, 1.0)
    facing = -np.append(planes.normals[:, 2], 0.0)[hits.plane] * hits.front
    height = hits.distance * np.tile(cone[:, 2], len(scanners))
    level = np.where(facing > _SOFFIT, height, np.inf).reshape(len(scanners), -1).min(axis=1)
    higher = np.where(facing > _LEVEL, height, -np.inf).reshape(len(scanners), -1)
    above = (higher > clearance[:, None] + parameters.least_head_m).sum(axis=1)
    share = above / np.maximum(np.isfinite(higher).sum(axis=1), 1)
    low = level < np.minimum(clearance + _SAME_M, parameters.below_ceiling_m + parameters.headroom_m)
    return np.flatnonzero(low & (share >= parameters.least_higher))


def _inside(structure: Structure, planes: Planes, scanners: F32, given: Mapping[int, str], least_roofed: float) -> I64:
    """Find scans under a roof, or in a room that the user named; all scans where none is under a roof."""
    hits, cone = _cone(structure, scanners, 1.0)
    roof = hits.front & (np.append(planes.normals[:, 2], 0.0)[hits.plane] < -_OVERHEAD)
    roofed = roof.reshape(-1, len(cone)).mean(axis=1) >= least_roofed
    if not roofed.any():
        return np.arange(len(scanners))
    roofed[list(given)] = True
    return np.flatnonzero(roofed)


def _joined(count: int, views: Views, least_open: float) -> I64:
    """Join scans, the most open pairs first, unless that would put two into one room that a wall clearly parts.

    So a scanner that stood in a wide passage goes with one side and does not join the two.
    """
    parted = {(int(a), int(b)) for a, b in views.pairs[views.openness < least_open]}
    rooms = [{scan} for scan in range(count)]
    linked = np.flatnonzero(views.openness >= least_open)
    for a, b in views.pairs[linked[np.argsort(-views.openness[linked], kind="stable")]]:
        one, other = rooms[a], rooms[b]
        if one is not other and not any((min(p, q), max(p, q)) in parted for p in one for q in other):
            one |= other
            for scan in other:
                rooms[scan] = one
    return np.array([min(room) for room in rooms], np.int64)


def _votes(scan_room: I32, views: Views, structure: Structure, lifted: F32, parameters: GroupParameters) -> Bool:
    """``(S,)``: False where a scan is very open to another room, and others of its own that vote overlook the same.

    In a passage others do; at the corner of a corridor with walls of glass none may look at the other arm.
    """
    a, b = views.pairs[views.openness >= parameters.doubtful_open].T
    across = scan_room[a] != scan_room[b]
    votes = np.ones(len(scan_room), bool)
    for scan in np.unique(np.concatenate([a[across], b[across]])):
        votes[scan] = False
        mates = np.flatnonzero((scan_room == scan_room[scan]) & votes)
        seen = np.zeros(len(views.places[scan]), bool)
        for mate in mates:
            near = np.linalg.norm(views.places[scan] - lifted[mate], axis=1) < parameters.sight.reach_m
            seen |= near & ~structure.blocked(views.places[scan], np.broadcast_to(lifted[mate], (len(near), 3)))
        votes[scan] = seen.mean() < parameters.least_overlooked
    return votes


def _clearance(structure: Structure, planes: Planes, scanners: F32, sign: float) -> F32:
    """``(S,)`` metres up (`sign` 1) to the ceiling or down (-1) to the floor, infinite where there is none.

    It is the lower quartile of the level faces that rays in three or four cones meet, so that a skylight over the
    scanner or a stair well under it is not taken for the whole ceiling or floor. Where a scanner on a landing sees
    little of it, more of the floors below, it stands on what lies no deeper than a tripod is high.
    """
    hits, cone = _cone(structure, scanners, sign)
    directions = np.tile(cone, (len(scanners), 1))
    facing = hits.front & (sign * np.append(planes.normals[:, 2], 0.0)[hits.plane] < -_LEVEL)
    height = np.where(facing, hits.distance * np.abs(directions[:, 2]), np.nan).reshape(len(scanners), -1)
    if sign < 0.0:
        standing = height < _TRIPOD_M
        height[~standing & standing.any(axis=1, keepdims=True)] = np.nan
    seen = np.isfinite(height).any(axis=1)
    clearance = np.full(len(scanners), np.inf, np.float32)
    clearance[seen] = np.nanquantile(height[seen], 0.25, axis=1)
    return clearance


def _cone(structure: Structure, scanners: F32, sign: float) -> tuple[Hits, F32]:
    """Cast rays in cones up or down from each scanner, one after the other; return what they meet and one's ``(n, 3)``.

    Down there is one cone more, which meets a narrow landing beyond what the tripod hides.
    """
    tilt = np.tile([0.1, 0.4, 0.8] if sign > 0.0 else [0.1, 0.4, 0.6, 0.8], 8 if sign > 0.0 else 12)
    azimuth = 2.0 * np.pi * np.arange(len(tilt)) / len(tilt)
    rays = np.stack([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), sign * np.cos(tilt)], axis=1)
    cone = rays.astype(np.float32)
    return structure.cast(np.repeat(scanners, len(cone), axis=0), np.tile(cone, (len(scanners), 1))), cone


def _overridden(group: I64, rooms: Mapping[int, str], scanners: F32) -> I64:
    """Put listed scans where the table says, and each other after the nearest listed scan of its group."""
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
    """Give groups numbers by level, then x, then y of their scanners' mean, whatever the order of the scans."""
    _, group = np.unique(group, return_inverse=True)
    size = np.bincount(group)
    mean = np.stack([np.bincount(group, scanners[:, axis]) / size for axis in range(3)], axis=1)
    by_height = np.argsort(mean[:, 2], kind="stable")
    level = np.empty(len(size), np.int64)
    level[by_height] = np.cumsum(np.diff(mean[by_height, 2], prepend=mean[by_height[:1], 2]) > storey_gap_m)
    rank = np.empty(len(size), np.int32)
    rank[np.lexsort((mean[:, 1], mean[:, 0], level))] = np.arange(len(size), dtype=np.int32)
    return rank[group]
