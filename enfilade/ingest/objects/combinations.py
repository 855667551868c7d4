"""Nearby segments, and their combinations of up to three, each with its descriptors (§6.2)."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, groupby

import numpy as np
from scipy.spatial import cKDTree
from shapely import STRtree, box

from enfilade.descriptors import Layout, describe_votes, gather_votes
from enfilade.ingest.objects.parameters import ObjectParameters
from enfilade.ingest.objects.segments import thin
from enfilade.ingest.records import F32, F64, Combination, Room, Segment

Near = tuple[int, int, float]
"""Two segments and the least distance of their points, metres."""


def find_near(segments: Sequence[Segment], positions: F32, parameters: ObjectParameters) -> list[Near]:
    """Find the pairs of segments of one room that lie close together.

    Parameters
    ----------
    segments
        Ordered by room, numbered by their place.
    positions
        ``(N, 3)`` the thinned cloud.
    parameters
        How close, and the voxel at which distances are taken.

    Returns
    -------
    Ordered by the numbers of both, the lower one first.
    """
    near: list[Near] = []
    for _, own in groupby(segments, key=lambda segment: segment.room):
        near.extend(_near_in_room(list(own), positions, parameters))
    return sorted(near)


def combine(near: Sequence[Near], segments: Sequence[Segment], parameters: ObjectParameters) -> list[tuple[int, ...]]:
    """List the single segments, then the pairs, then the triples that hang together and are not too large.

    A segment has at most `partners` partners, the nearest, so that the list grows with the segments, not their square.

    Parameters
    ----------
    near
        Pairs of segments.
    segments
        By number.
    parameters
        Gap, number of partners, largest size.

    Returns
    -------
    Ascending numbers of segments, in order of length, then number.
    """
    pairs = _closest_pairs(near, parameters)
    partners: defaultdict[int, set[int]] = defaultdict(set)
    for a, b in pairs:
        partners[a].add(b)
        partners[b].add(a)
    triples = {
        tuple(sorted((middle, *ends)))
        for middle, others in partners.items()
        for ends in combinations(sorted(others), 2)
    }
    fitting = [group for group in (*sorted(pairs), *sorted(triples)) if _fits(group, segments, parameters)]
    return [*((segment.number,) for segment in segments), *fitting]


def describe_all(
    groups: Sequence[tuple[int, ...]],
    segments: Sequence[Segment],
    positions: F32,
    rooms: Mapping[int, Room],
    layout: Layout,
) -> Iterator[Combination]:
    """Measure and describe each group of segments, with the base at the room's floor and at its own foot.

    The points of a segment are read once; combinations are measured from what each segment gathered of them.
    """
    gathered = [_Gathered(positions[segment.points].astype(np.float64), layout.cell_m) for segment in segments]
    for group in groups:
        parts = [gathered[number] for number in group]
        low = np.min([part.low for part in parts], axis=0)
        high = np.max([part.high for part in parts], axis=0)
        counts = np.array([part.point_count for part in parts])
        floor, foot = rooms[segments[group[0]].room].floor_elevation, float(low[2])
        votes = parts[0].votes if len(parts) == 1 else _together(parts, layout.cell_m)
        descriptor, foot_descriptor = describe_votes(votes, (floor, foot), layout)
        yield Combination(
            segments=group,
            size=high - low,
            position=np.average([part.centre for part in parts], axis=0, weights=counts),
            floor_offset=foot - floor,
            point_count=int(counts.sum()),
            descriptor=descriptor,
            foot_descriptor=foot_descriptor,
        )


class _Gathered:
    """What combinations need to know of a segment's points."""

    def __init__(self, points: F64, cell_m: float) -> None:
        self.votes, self.counts = gather_votes(points, cell_m)
        self.low, self.high = points.min(axis=0), points.max(axis=0)
        self.centre = points.mean(axis=0)
        self.point_count = len(points)


def _together(parts: Sequence[_Gathered], cell_m: float) -> F64:
    """Votes of some segments together: a cell that several have points in votes once."""
    votes = np.concatenate([part.votes for part in parts])
    counts = np.concatenate([part.counts for part in parts])
    return gather_votes(votes, cell_m, counts)[0]


def _near_in_room(segments: list[Segment], positions: F32, parameters: ObjectParameters) -> Iterator[Near]:
    points = [_thinned(positions[segment.points].astype(np.float64), parameters.voxel_m) for segment in segments]
    trees = [cKDTree(own) for own in points]
    low = np.array([own.min(axis=0)[:2] for own in points]) - parameters.near_m / 2
    high = np.array([own.max(axis=0)[:2] for own in points]) + parameters.near_m / 2
    boxes = box(low[:, 0], low[:, 1], high[:, 0], high[:, 1])
    for i, j in STRtree(boxes).query(boxes).T:
        if i < j:
            small, large = (i, j) if len(points[i]) < len(points[j]) else (j, i)
            least = float(trees[large].query(points[small], distance_upper_bound=parameters.near_m)[0].min())
            if np.isfinite(least):
                yield segments[i].number, segments[j].number, least


def _thinned(points: F64, voxel_m: float) -> F64:
    return np.asarray(points[thin(points, voxel_m)[0]], dtype=np.float64)


def _closest_pairs(near: Sequence[Near], parameters: ObjectParameters) -> set[tuple[int, int]]:
    """Pairs within the gap, nearest first, until one of the two has all its partners."""
    count: defaultdict[int, int] = defaultdict(int)
    pairs: set[tuple[int, int]] = set()
    for a, b, distance in sorted(near, key=lambda pair: (pair[2], pair[:2])):
        if distance <= parameters.gap_m and max(count[a], count[b]) < parameters.partners:
            pairs.add((a, b))
            count[a] += 1
            count[b] += 1
    return pairs


def _fits(group: tuple[int, ...], segments: Sequence[Segment], parameters: ObjectParameters) -> bool:
    """Whether a group is no longer than a piece of furniture; from centres and sizes, without touching points."""
    low = np.min([segments[n].position - segments[n].size / 2 for n in group], axis=0)
    high = np.max([segments[n].position + segments[n].size / 2 for n in group], axis=0)
    return bool((high - low).max() <= parameters.max_combination_m)
