"""Find the objects of all rooms: segments, their neighbours and their combinations."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

import numpy as np
import shapely

from enfilade.descriptors import DEFAULT_LAYOUT, Layout
from enfilade.ingest.objects.combinations import combine, describe_all, find_near
from enfilade.ingest.objects.parameters import ObjectParameters
from enfilade.ingest.objects.segments import connect, without_outliers
from enfilade.ingest.objects.structure import Structure, find_structure, on_structure
from enfilade.ingest.records import F64, I32, Bool, Objects, Planes, Room, RoomLabels, Segment, Surfels, ThinnedCloud

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

    Returns
    -------
    Segments numbered from 0, ordered by room and place; combinations, the single segments first.
    """
    chosen = parameters if parameters is not None else ObjectParameters()
    known = {room.number: room for room in rooms}
    structure = find_structure(surfels, planes, labels, known, chosen)
    loose = np.flatnonzero(_loose(cloud, surfels, planes, structure, chosen)).astype(np.int32)
    segments = list(_segments(cloud, surfels, labels, known, structure, loose, chosen))
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


def _segments(
    cloud: ThinnedCloud,
    surfels: Surfels,
    labels: RoomLabels,
    rooms: Mapping[int, Room],
    structure: Structure,
    loose: I32,
    parameters: ObjectParameters,
) -> Iterator[Segment]:
    room_of = labels.after[surfels.point_surfel[loose]]
    order = np.argsort(room_of, kind="stable")
    room_sorted = room_of[order]
    number = 0
    for room in sorted(rooms.values(), key=lambda room: room.number):
        low, high = np.searchsorted(room_sorted, [room.number, room.number + 1])
        members = loose[order[low:high]]
        positions = cloud.positions[members].astype(np.float64)
        off = ~on_structure(positions, structure.sides.get(room.number, ()), room, surfels, parameters)
        members, positions = members[off], positions[off]
        kept = without_outliers(positions, parameters.outlier_neighbours, parameters.outlier_deviations)
        members, positions = members[kept], positions[kept]
        for group in connect(positions, parameters):
            if _inside(positions[group], room):
                yield _segment(number, room, members[group], positions[group])
                number += 1


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
