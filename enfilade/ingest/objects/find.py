"""Find the objects of all rooms: segments, their neighbours and their combinations."""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enfilade.descriptors import DEFAULT_LAYOUT, Layout
from enfilade.ingest.objects.bays import cut_bays, cut_slits
from enfilade.ingest.objects.belonging import rooms_of_points
from enfilade.ingest.objects.combinations import combine, describe_all, find_near
from enfilade.ingest.objects.masks import Face, Mask, standing_off
from enfilade.ingest.objects.parameters import ObjectParameters
from enfilade.ingest.objects.people import is_person
from enfilade.ingest.objects.remains import Remains
from enfilade.ingest.objects.segments import connect
from enfilade.ingest.objects.sightlines import Suspect, find_ghosts, of_one_scan
from enfilade.ingest.objects.structure import Structure, find_structure, in_openings
from enfilade.ingest.objects.terraces import cut_row, split
from enfilade.ingest.records import (
    F32,
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
from enfilade.parallel import at_once, in_slices, taken

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
    point_room = rooms_of_points(loose, cloud, surfels, labels, known, reach_m=chosen.room_reach_m)
    loose_in = _by_room(point_room, loose)
    opening_in: defaultdict[int | None, list[Opening]] = defaultdict(list)
    for opening in openings:
        opening_in[opening.room_a].append(opening)
        opening_in[opening.room_b].append(opening)
    on_board = np.append(structure.boards, False)

    def suspects_in(number: int) -> list[Suspect]:
        members = loose_in.get(number, np.zeros(0, dtype=np.int32))
        faces = _faces(structure.sides.get(number, ()), surfels, chosen)
        flights = [each for each in structure.flights if each.touches(known[number].bounds, chosen.outline_reach_m)]
        remains = Remains(known[number], opening_in[number], flights, structure.ceilings[number], chosen)
        groups = _groups(cloud, members, remains, on_board, faces, surfels.point_surfel)
        return [Suspect(group, faces, remains.openings) for group in groups]

    numbers = sorted(known)
    found = at_once(suspects_in, ((number,) for number in numbers))
    room_of = np.repeat(numbers, [len(suspects) for suspects in found])
    groups = [suspect.members for suspects in found for suspect in suspects]
    ghost = find_ghosts(cloud, [suspect for suspects in found for suspect in suspects], chosen)
    segments: list[Segment] = []
    for number, group in zip(room_of[~ghost].tolist(), itertools.compress(groups, ~ghost), strict=True):
        segment = _segment(len(segments), known[number], group, cloud.positions[group].astype(np.float64))
        if not _is_somebody(segment, known[number], cloud, surfels):
            segments.append(segment)
    near = find_near(segments, cloud.positions, chosen)
    described = tuple(describe_all(combine(near, segments, chosen), segments, cloud.positions, known, layout))
    return Objects(tuple(segments), described, tuple(near))


def _loose(cloud: ThinnedCloud, surfels: Surfels, structure: Structure, parameters: ObjectParameters) -> Bool:
    """``(N,)``: points not of the structure nor of a veil, a surface that rays met at a sharp angle."""
    veil = np.empty(len(surfels.positions), dtype=bool)
    sharpest = float(np.sin(np.radians(parameters.min_incidence_deg)))
    given = surfels.positions, surfels.normals, surfels.scan, cloud.scanner_positions, sharpest
    in_slices(_find_veils, len(veil), veil, *given)
    usable = np.append(~veil & ~structure.surfels, True)
    return taken(usable, surfels.point_surfel)


@njit(cache=True, nogil=True)
def _find_veils(
    first: int, past: int, veil: Bool, positions: F32, normals: F32, scan: I32, scanners: F32, sharpest: float
) -> None:
    """Tell of surfels `first` to `past` which a ray met at an angle of which the sine is less."""
    for i in range(first, past):
        length, along, has_normal = 0.0, 0.0, False
        for axis in range(3):
            ray = positions[i, axis] - scanners[scan[i], axis]
            length += ray * ray
            along += ray * normals[i, axis]
            has_normal |= normals[i, axis] != 0.0
        veil[i] = has_normal and abs(along) < sharpest * np.sqrt(length)


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
        whole = np.flatnonzero(piece == number)
        for slit in cut_slits(positions[whole], parameters):
            own = whole[slit]
            for part in cut_bays(positions[own], parameters):
                yield from (own[part[module]] for module in cut_row(positions[own[part]], floor_m, parameters))


def _faces(sides: Iterable[Side], surfels: Surfels, parameters: ObjectParameters) -> list[Face]:
    """Give the sides of a room that are structure the cells they cover; walls are as deep as reveals are."""
    return [
        Face(side, parameters.max_reveal_m if side.vertical else parameters.clearance_m, Mask(side, surfels))
        for side in sides
    ]


def _is_somebody(segment: Segment, room: Room, cloud: ThinnedCloud, surfels: Surfels) -> bool:
    """Whether a segment is a person whom one scan alone saw."""
    if not of_one_scan(cloud, segment.points):
        return False
    own = np.unique(surfels.point_surfel[segment.points])
    positions = cloud.positions[segment.points].astype(np.float64)
    return is_person(positions, surfels.normals[own[own >= 0]], room.floor_elevation)


def _segment(number: int, room: Room, members: I32, positions: F64) -> Segment:
    floor_offset = float(positions[:, 2].min()) - room.floor_elevation
    return Segment(number, room.number, members, np.ptp(positions, axis=0), positions.mean(axis=0), floor_offset)
