"""Room neighbours: rooms that share a wall, a floor or a ceiling (§5.1)."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray
from shapely import Polygon, STRtree, box

from enfilade.ingest.borders import Border, plan_borders, plan_of, top
from enfilade.ingest.records import F32, F64, I32, Bool, Neighbour, Planes, Room, RoomLabels, Surfels
from enfilade.ingest.sides import Patch, axes, cut_by_room, in_plane
from enfilade.parallel import at_once

_AGAINST_PLANS: Final = 2.0
"""So many times the least area of planes back to back makes two rooms neighbours whose plans do not: labels stray."""


@dataclass(frozen=True, slots=True)
class NeighbourParameters:
    """What makes two rooms neighbours.

    Attributes
    ----------
    max_gap_m
        Thickest wall.
    max_slab_m
        Thickest floor slab, suspended ceiling included.
    min_area_m2
        Least area of the wall or slab between two rooms.
    max_angle_deg
        How far two sides may be from parallel.
    cell_m
        Cell of the grid in which sides are laid over each other.
    min_surfels
        Least number of surfels of a plane in a room.
    """

    max_gap_m: float = 0.6
    max_slab_m: float = 0.8
    min_area_m2: float = 0.5
    max_angle_deg: float = 10.0
    cell_m: float = 0.1
    min_surfels: int = 30


@dataclass(frozen=True, slots=True)
class _Contact:
    """Two patches back to back."""

    planes: tuple[int, int]
    gap: float
    area: float
    level: bool


def find_neighbours(
    surfels: Surfels,
    planes: Planes,
    labels: RoomLabels,
    rooms: tuple[Room, ...],
    parameters: NeighbourParameters | None = None,
) -> tuple[Neighbour, ...]:
    """Find the pairs of rooms that stand back to back.

    Two rooms are neighbours if their plans say so: where the other room begins straight ahead behind a wall, or its
    floor is over the ceiling. Parts of planes, one a room, whose normals point away from each other and that are
    closer than a wall is thick, say which planes these are and how far apart: they are laid over each other in their
    common plane, and the cells that hold points of both are the shared area. They count alone where a plan is not known
    or ends short of the wall.

    Parameters
    ----------
    surfels, planes, labels
        What the stages before found.
    rooms
        Only pairs of these are looked at.
    parameters
        Thickness, area and grid.

    Returns
    -------
    Neighbours ordered by room numbers; the gap is the mean over all pairs of planes, weighted with their area, or
    that of the plans where there is none.
    """
    chosen = parameters if parameters is not None else NeighbourParameters()
    known = {room.number for room in rooms}
    patches = [p for p in cut_by_room(surfels, planes, labels, chosen.min_surfels) if p.room in known]
    contacts: defaultdict[tuple[int, int], list[_Contact]] = defaultdict(list)
    close = [(a, b) if a.room < b.room else (b, a) for a, b in _candidates(patches, surfels, chosen)]
    for (a, b), contact in zip(close, at_once(_overlay, ((*pair, surfels, chosen) for pair in close)), strict=True):
        if contact is not None:
            contacts[a.room, b.room].append(contact)
    plans = {room.number: plan for room in rooms if (plan := plan_of(room)) is not None}
    borders = {
        (a, b): border
        for a, b, border in plan_borders(rooms, plans, max_gap_m=chosen.max_gap_m, max_slab_m=chosen.max_slab_m)
    }
    number = {room.number: room for room in rooms}
    found = (
        _neighbour((number[a], number[b]), contacts.get((a, b), []), borders.get((a, b)), plans, chosen.min_area_m2)
        for a, b in sorted(contacts.keys() | borders.keys())
    )
    return tuple(neighbour for neighbour in found if neighbour is not None)


def _candidates(patches: list[Patch], surfels: Surfels, parameters: NeighbourParameters) -> list[tuple[Patch, Patch]]:
    """Pairs of patches of two rooms with opposite normals, back to back, whose boxes come close."""
    if len(patches) < 2:
        return []
    reach = max(parameters.max_gap_m, parameters.max_slab_m)
    positions = [surfels.positions[patch.surfels] for patch in patches]
    low = np.array([p.min(axis=0) for p in positions]) - reach / 2
    high = np.array([p.max(axis=0) for p in positions]) + reach / 2
    centre = np.array([p.mean(axis=0) for p in positions])
    boxes = box(low[:, 0], low[:, 1], high[:, 0], high[:, 1])
    i, j = STRtree(boxes).query(boxes)
    i, j = i[i < j], j[i < j]
    normals = np.array([patch.normal for patch in patches])
    rooms = np.array([patch.room for patch in patches])
    offsets = np.array([patch.offset for patch in patches])
    gap = offsets[i] - np.einsum("ij,ij->i", normals[i], centre[j])
    thickest = np.where(np.abs(normals[i, 2]) > np.sqrt(0.5), parameters.max_slab_m, parameters.max_gap_m)
    keep = (
        (rooms[i] != rooms[j])
        & (np.einsum("ij,ij->i", normals[i], normals[j]) < -np.cos(np.radians(parameters.max_angle_deg)))
        & (low[i, 2] < high[j, 2])
        & (low[j, 2] < high[i, 2])
        & (gap > 0)
        & (gap < thickest)
    )
    return [(patches[a], patches[b]) for a, b in zip(i[keep], j[keep], strict=True)]


def _overlay(a: Patch, b: Patch, surfels: Surfels, parameters: NeighbourParameters) -> _Contact | None:
    """Lay two patches over each other in the plane of the first; None where they share no cell."""
    frame = axes(a.normal)
    shared, cells = _shared(surfels.positions, a.surfels, b.surfels, *frame, parameters.cell_m)
    if cells == 0:
        return None
    gap = float(np.median(a.offset - surfels.positions[b.surfels[shared]] @ a.normal))
    return _Contact((a.plane, b.plane), gap, cells * parameters.cell_m**2, abs(a.normal[2]) > np.sqrt(0.5))


@njit(cache=True, nogil=True)
def _shared(positions: F32, own: I32, other: I32, u: F64, v: F64, cell_m: float) -> tuple[Bool, int]:
    """``(n,)`` which of the other patch's surfels lie in cells that hold some of the own one's; how many such cells."""
    cells = _cells(positions, other, u, v, cell_m)
    low, high = cells[0].copy(), cells[0].copy()
    for cell in cells:
        low, high = np.minimum(low, cell), np.maximum(high, cell)
    seen = np.zeros((high[0] - low[0] + 1, high[1] - low[1] + 1), np.int8)
    for row, column in _cells(positions, own, u, v, cell_m):
        if low[0] <= row <= high[0] and low[1] <= column <= high[1]:
            seen[row - low[0], column - low[1]] = 1
    shared, count = np.zeros(len(other), np.bool_), 0
    for i in range(len(other)):
        row, column = cells[i, 0] - low[0], cells[i, 1] - low[1]
        shared[i] = seen[row, column] > 0
        if seen[row, column] == 1:
            seen[row, column] = 2
            count += 1
    return shared, count


@njit(cache=True, nogil=True)
def _cells(positions: F32, members: I32, u: F64, v: F64, cell_m: float) -> NDArray[np.int64]:
    """``(n, 2)`` cells of some surfels in the plane of two axes."""
    return np.floor(in_plane(positions, members, u, v) / cell_m).astype(np.int64)


def _neighbour(
    rooms: tuple[Room, Room],
    contacts: list[_Contact],
    border: Border | None,
    plans: Mapping[int, Polygon],
    least: float,
) -> Neighbour | None:
    """Make an edge of what planes and plans say of two rooms; None where that is less than the least area."""
    if border is not None:
        contacts = [contact for contact in contacts if contact.level == border.level] or contacts
    seen = sum(contact.area for contact in contacts if _possible(contact, rooms, plans, least))
    by_plans = 0.0 if border is None else border.area
    known = rooms[0].number in plans and rooms[1].number in plans
    if by_plans < least and seen < (least if not known else _AGAINST_PLANS * least):
        return None
    gap = 0.0 if border is None else border.gap
    if contacts:
        gap = float(np.average([c.gap for c in contacts], weights=[c.area for c in contacts]))
    pairs = tuple(sorted(contact.planes for contact in contacts))
    return Neighbour(rooms[0].number, rooms[1].number, gap, max(seen, by_plans), pairs)


def _possible(contact: _Contact, rooms: tuple[Room, Room], plans: Mapping[int, Polygon], least: float) -> bool:
    """Whether planes of two rooms can be back to back: one room over the other, or both at one height."""
    a, b = rooms
    if not contact.level:
        return min(top(a), top(b)) > max(a.floor_elevation, b.floor_elevation)
    if a.number not in plans or b.number not in plans:
        return True
    return bool(plans[a.number].intersection(plans[b.number]).area >= least)
