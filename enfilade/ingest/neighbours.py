"""Room neighbours: rooms that share a wall, a floor or a ceiling (§5.1)."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from shapely import STRtree, box

from enfilade.ingest.records import Neighbour, Planes, Room, RoomLabels, Surfels
from enfilade.ingest.sides import Patch, axes, cut_by_room


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
        Least area that the two sides share.
    max_angle_deg
        How far two sides may be from parallel.
    cell_m
        Cell of the grid in which sides are laid over each other.
    min_surfels
        Least number of surfels of a plane in a room.
    """

    max_gap_m: float = 0.6
    max_slab_m: float = 0.8
    min_area_m2: float = 0.3
    max_angle_deg: float = 10.0
    cell_m: float = 0.1
    min_surfels: int = 30


@dataclass(frozen=True, slots=True)
class _Contact:
    """Two patches back to back."""

    planes: tuple[int, int]
    gap: float
    area: float


def find_neighbours(
    surfels: Surfels,
    planes: Planes,
    labels: RoomLabels,
    rooms: tuple[Room, ...],
    parameters: NeighbourParameters | None = None,
) -> tuple[Neighbour, ...]:
    """Find the pairs of rooms that stand back to back.

    Parts of planes, one a room, whose normals point away from each other and that are closer than a wall is thick
    are laid over each other in their common plane; the cells that hold points of both are the shared area.

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
    Neighbours ordered by room numbers; the gap is the mean over all pairs of planes, weighted with their area.
    """
    chosen = parameters if parameters is not None else NeighbourParameters()
    known = {room.number for room in rooms}
    patches = [p for p in cut_by_room(surfels, planes, labels, chosen.min_surfels) if p.room in known]
    contacts: defaultdict[tuple[int, int], list[_Contact]] = defaultdict(list)
    for first, second in _candidates(patches, surfels, chosen):
        a, b = (first, second) if first.room < second.room else (second, first)
        contact = _overlay(a, b, surfels, chosen)
        if contact is not None:
            contacts[a.room, b.room].append(contact)
    found = (_neighbour(pair, contacts[pair]) for pair in sorted(contacts))
    return tuple(neighbour for neighbour in found if neighbour.area >= chosen.min_area_m2)


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
    shared = np.intersect1d(_cells(a, a, surfels, parameters.cell_m), _cells(b, a, surfels, parameters.cell_m))
    if len(shared) == 0:
        return None
    behind = a.offset - surfels.positions[b.surfels] @ a.normal
    on_shared = np.isin(_cell_keys(b, a, surfels, parameters.cell_m), shared)
    gap = float(np.median(behind[on_shared]))
    return _Contact((a.plane, b.plane), gap, len(shared) * parameters.cell_m**2)


def _cell_keys(patch: Patch, frame: Patch, surfels: Surfels, cell_m: float) -> NDArray[np.int64]:
    """``(n,)`` packed grid cell of each surfel of a patch, in the plane of another."""
    in_plane = surfels.positions[patch.surfels] @ np.column_stack(axes(frame.normal))
    cells = np.floor(in_plane / cell_m).astype(np.int64)
    return np.asarray((cells[:, 0] << 32) + cells[:, 1], dtype=np.int64)


def _cells(patch: Patch, frame: Patch, surfels: Surfels, cell_m: float) -> NDArray[np.int64]:
    return np.unique(_cell_keys(patch, frame, surfels, cell_m))


def _neighbour(pair: tuple[int, int], contacts: list[_Contact]) -> Neighbour:
    areas = np.array([contact.area for contact in contacts])
    gaps = np.array([contact.gap for contact in contacts])
    planes = tuple(sorted(contact.planes for contact in contacts))
    return Neighbour(pair[0], pair[1], float(np.average(gaps, weights=areas)), float(areas.sum()), planes)
