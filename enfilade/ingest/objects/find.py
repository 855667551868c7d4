"""Find the objects of all rooms: segments, their neighbours and their combinations."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
import shapely

from enfilade.descriptors import DEFAULT_LAYOUT, Layout
from enfilade.ingest.objects.combinations import combine, describe_all, find_near
from enfilade.ingest.objects.parameters import ObjectParameters
from enfilade.ingest.objects.segments import connect, without_outliers
from enfilade.ingest.objects.structure import Structure, find_structure, in_openings, on_structure
from enfilade.ingest.records import (
    F64,
    I32,
    Bool,
    Objects,
    Opening,
    Planes,
    Room,
    RoomLabels,
    Segment,
    Surfels,
    ThinnedCloud,
)

OUTSIDE_M: Final = 0.1
"""A segment may stand so far out of the room's outline."""


def find_objects(
    cloud: ThinnedCloud,
    surfels: Surfels,
    planes: Planes,
    labels: RoomLabels,
    rooms: tuple[Room, ...],
    parameters: ObjectParameters | None = None,
    layout: Layout = DEFAULT_LAYOUT,
    *,
    openings: Sequence[Opening] = (),
) -> Objects:
    """Find what stands or hangs in the rooms (§6).

    Points on walls, floors and ceilings are taken away, then veils and outliers; what hangs together is a segment.
    Up to three segments that lie close together are an object, too.

    Parameters
    ----------
    cloud, surfels, planes, labels, rooms
        What the stages before found.
    parameters
        Sizes and thresholds.
    layout
        Bins of the descriptors.
    openings
        Doors and windows: their leaves, frames and panes are no objects.

    Returns
    -------
    Segments numbered from 0, ordered by room and place; combinations, the single segments first.
    """
    chosen = parameters if parameters is not None else ObjectParameters()
    known = {room.number: room for room in rooms}
    structure = find_structure(surfels, planes, labels, known, chosen)
    loose = np.flatnonzero(_loose(cloud, surfels, planes, structure, chosen)).astype(np.int32)
    loose_in = _by_room(labels.after[surfels.point_surfel[loose]], loose)
    opening_in: defaultdict[int | None, list[Opening]] = defaultdict(list)
    for opening in openings:
        opening_in[opening.room_a].append(opening)
        opening_in[opening.room_b].append(opening)
    segments: list[Segment] = []
    for number in sorted(known):
        members = loose_in.get(number, np.zeros(0, dtype=np.int32))
        for group in _groups(cloud, members, known[number], structure, opening_in[number], surfels, chosen):
            segments.append(_segment(len(segments), known[number], group, cloud.positions[group].astype(np.float64)))
    near = find_near(segments, cloud.positions, chosen)
    groups = combine(near, segments, chosen)
    described = tuple(describe_all(groups, segments, cloud.positions, known, layout))
    return Objects(tuple(segments), described, tuple(near))


def _loose(
    cloud: ThinnedCloud, surfels: Surfels, planes: Planes, structure: Structure, parameters: ObjectParameters
) -> Bool:
    """``(N,)``: points on no plane of the structure and on no veil, a surface that rays met at a sharp angle."""
    ray = surfels.positions - cloud.scanner_positions[surfels.scan]
    ray /= np.maximum(np.linalg.norm(ray, axis=1, keepdims=True), 1e-6)
    incidence = np.abs(np.einsum("ij,ij->i", ray, surfels.normals))
    has_normal = np.abs(surfels.normals).sum(axis=1) > 0.5
    veil = has_normal & (incidence < np.sin(np.radians(parameters.min_incidence_deg)))
    fixed = np.append(structure.planes, False)[planes.surfel_plane]
    usable = np.append(~veil & ~fixed, False)
    return np.asarray(usable[surfels.point_surfel], dtype=np.bool_)


def _by_room(room_of: I32, points: I32) -> dict[int, I32]:
    """Points of each room, found with one sort."""
    order = np.argsort(room_of, kind="stable")
    numbers, first = np.unique(room_of[order], return_index=True)
    return dict(zip(numbers.tolist(), np.split(points[order], first[1:]), strict=True)) if len(points) else {}


def _groups(
    cloud: ThinnedCloud,
    members: I32,
    room: Room,
    structure: Structure,
    openings: Sequence[Opening],
    surfels: Surfels,
    parameters: ObjectParameters,
) -> Iterator[I32]:
    """Split the loose points of a room into those of its segments."""
    positions = cloud.positions[members].astype(np.float64)
    fixed = on_structure(positions, structure, room, surfels, parameters) | in_openings(positions, openings, parameters)
    members, positions = members[~fixed], positions[~fixed]
    kept = without_outliers(positions, parameters.outlier_neighbours, parameters.outlier_deviations)
    members, positions = members[kept], positions[kept]
    for group in connect(positions, parameters):
        if _inside(positions[group], room):
            yield members[group]


def _segment(number: int, room: Room, members: I32, positions: F64) -> Segment:
    floor_offset = float(positions[:, 2].min()) - room.floor_elevation
    return Segment(number, room.number, members, np.ptp(positions, axis=0), positions.mean(axis=0), floor_offset)


def _inside(positions: F64, room: Room) -> bool:
    """Whether at least half of the points lie in the room's outline; what is outside was seen through a window."""
    if not room.outline:
        return True
    outline = shapely.Polygon(room.outline[0]).buffer(OUTSIDE_M)
    some = positions[:: max(len(positions) // 200, 1)]
    return bool(shapely.contains_xy(outline, some[:, 0], some[:, 1]).mean() >= 0.5)
