"""Find the objects of all rooms: segments, their neighbours and their combinations."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from enfilade.descriptors import DEFAULT_LAYOUT, Layout
from enfilade.ingest.objects.belonging import rooms_of_points
from enfilade.ingest.objects.combinations import combine, describe_all, find_near
from enfilade.ingest.objects.masks import Face, Mask, standing_off
from enfilade.ingest.objects.parameters import ObjectParameters
from enfilade.ingest.objects.people import is_person
from enfilade.ingest.objects.remains import Remains
from enfilade.ingest.objects.segments import connect
from enfilade.ingest.objects.sightlines import Sightlines
from enfilade.ingest.objects.structure import Structure, find_structure, in_openings
from enfilade.ingest.objects.terraces import cut_bays, cut_row, split
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
from enfilade.ingest.sides import Side

I64 = NDArray[np.int64]


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
    loose = np.flatnonzero(_loose(cloud, surfels, structure, chosen)).astype(np.int32)
    point_room = rooms_of_points(cloud, surfels, labels, known, reach_m=chosen.room_reach_m)
    loose_in = _by_room(point_room[loose], loose)
    opening_in: defaultdict[int | None, list[Opening]] = defaultdict(list)
    for opening in openings:
        opening_in[opening.room_a].append(opening)
        opening_in[opening.room_b].append(opening)
    sightlines = Sightlines(cloud, chosen)
    on_board = np.append(structure.boards, False)
    segments: list[Segment] = []
    for number in sorted(known):
        members = loose_in.get(number, np.zeros(0, dtype=np.int32))
        faces = _faces(structure.sides.get(number, ()), surfels, chosen)
        flights = [each for each in structure.flights if each.touches(known[number].bounds, chosen.outline_reach_m)]
        remains = Remains(known[number], opening_in[number], flights, structure.ceilings[number], chosen)
        for group in _groups(cloud, members, remains, on_board, faces, surfels.point_surfel):
            if not sightlines.are_a_ghost(group, faces, remains.openings):
                positions = cloud.positions[group].astype(np.float64)
                own = np.unique(surfels.point_surfel[group])
                normals = surfels.normals[own[own >= 0]]
                if sightlines.one_scan(group) and is_person(positions, normals, known[number].floor_elevation):
                    continue
                segments.append(_segment(len(segments), known[number], group, positions))
    near = find_near(segments, cloud.positions, chosen)
    groups = combine(near, segments, chosen)
    described = tuple(describe_all(groups, segments, cloud.positions, known, layout))
    return Objects(tuple(segments), described, tuple(near))


def _loose(cloud: ThinnedCloud, surfels: Surfels, structure: Structure, parameters: ObjectParameters) -> Bool:
    """``(N,)``: points not of the structure nor of a veil, a surface that rays met at a sharp angle."""
    ray = surfels.positions - cloud.scanner_positions[surfels.scan]
    ray /= np.maximum(np.linalg.norm(ray, axis=1, keepdims=True), 1e-6)
    incidence = np.abs(np.einsum("ij,ij->i", ray, surfels.normals))
    has_normal = np.abs(surfels.normals).sum(axis=1) > 0.5
    veil = has_normal & (incidence < np.sin(np.radians(parameters.min_incidence_deg)))
    usable = np.append(~veil & ~structure.surfels, True)
    return np.asarray(usable[surfels.point_surfel], dtype=np.bool_)


def _by_room(room_of: I32, points: I32) -> dict[int, I32]:
    """Points of each room, found with one sort."""
    order = np.argsort(room_of, kind="stable")
    numbers, first = np.unique(room_of[order], return_index=True)
    return dict(zip(numbers.tolist(), np.split(points[order], first[1:]), strict=True)) if len(points) else {}


def _groups(
    cloud: ThinnedCloud, members: I32, remains: Remains, on_board: Bool, faces: Sequence[Face], point_surfel: I32
) -> Iterator[I32]:
    """Split the loose points of a room into those of its segments."""
    parameters, room = remains.parameters, remains.room
    positions = cloud.positions[members].astype(np.float64)
    surfel = point_surfel[members]
    off = standing_off(positions, surfel < 0, faces, parameters.max_relief_m)
    fixed = (off < parameters.clearance_m) & ~on_board[surfel]
    for level in (room.floor_elevation, room.ceiling_elevation):
        if level is not None:
            fixed |= np.abs(positions[:, 2] - level) < parameters.clearance_m
    fixed |= in_openings(positions, remains.openings, parameters) | remains.on_stairs(positions)
    members, positions, off, surfel = members[~fixed], positions[~fixed], off[~fixed], surfel[~fixed]
    for group in connect(positions, surfel < 0, parameters):
        if not remains.is_remain(positions[group], off[group]):
            yield from (members[group[piece]] for piece in _pieces(positions[group], room.floor_elevation, parameters))


def _pieces(positions: F64, floor_m: float, parameters: ObjectParameters) -> Iterator[I64]:
    """Split what hangs together into pieces of furniture; scraps stay with the largest piece."""
    piece = split(positions, parameters)
    counts = np.bincount(piece)
    scrap = counts < parameters.min_voxels
    piece[scrap[piece]] = counts.argmax()
    for number in np.unique(piece):
        own = np.flatnonzero(piece == number)
        for part in cut_bays(positions[own], parameters):
            yield from (own[part[module]] for module in cut_row(positions[own[part]], floor_m, parameters))


def _faces(sides: Iterable[Side], surfels: Surfels, parameters: ObjectParameters) -> list[Face]:
    """Give the sides of a room that are structure the cells they cover; walls are as deep as reveals are."""
    return [
        Face(side, parameters.max_reveal_m if side.vertical else parameters.clearance_m, Mask(side, surfels))
        for side in sides
    ]


def _segment(number: int, room: Room, members: I32, positions: F64) -> Segment:
    floor_offset = float(positions[:, 2].min()) - room.floor_elevation
    return Segment(number, room.number, members, np.ptp(positions, axis=0), positions.mean(axis=0), floor_offset)
