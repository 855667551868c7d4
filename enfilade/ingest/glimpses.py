"""Rooms that no scan stands in, but that an open door, a window or a stair well let a scanner look into.

What was seen of such a room lies in no plan. Its floor tells where it is: floor over which there is a roof, as far as
it was seen, and behind which the line of sight ends at a wall. The ground outside has neither; a balcony may have a
roof, but no wall behind.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import cKDTree

from .cells import CellGrid
from .records import F32, I32, Bool, Planes, RoomLabels, Surfels
from .structure import Structure

I64 = NDArray[np.int64]
_UP: Final = np.array([[0.0, 0.0, 1.0]], np.float32)
_LIFT_M: Final = 0.05


@dataclass(frozen=True, slots=True)
class GlimpseParameters:
    """What counts as a room that was only looked into.

    Attributes
    ----------
    cell_m
        Side of the cells of floor that are looked at.
    least_floor_m2
        Least floor seen of such a room.
    eye_m
        Height over the floor at which walls are looked for.
    reach_m
        How far walls may be.
    least_roofed, least_walled
        Shares of its floor that have something above, of which a scanner on the other side of the door sees little,
        and that have a wall behind.
    link_m
        Floor closer than this in plan with no wall between is of one room.
    furniture_m
        What looks like floor up to this height over other floor is the top of furniture.
    take_m
        Surfels this close to its floor in plan, with nothing between, are of the room.
    close_doors_m
        Openings under a lintel up to this height part rooms.
    """

    cell_m: float = 0.20
    least_floor_m2: float = 1.0
    eye_m: float = 1.2
    reach_m: float = 12.0
    least_roofed: float = 0.15
    least_walled: float = 0.7
    link_m: float = 0.5
    furniture_m: float = 1.3
    take_m: float = 1.0
    close_doors_m: float = 2.4


@dataclass(frozen=True, slots=True)
class _Glimpses:
    """Floor of rooms looked into: ``(n, 3)`` places, the room of each from 0, and how sure each room is."""

    places: F32
    room: I32
    confidence: F32


def add_glimpsed_rooms(
    surfels: Surfels,
    planes: Planes,
    labels: RoomLabels,
    scanner_positions: F32,
    parameters: GlimpseParameters = GlimpseParameters(),
) -> RoomLabels:
    """Make rooms of what lies in no plan but has floor, roof and walls; they get the numbers after the others.

    Parameters
    ----------
    surfels, planes, scanner_positions
        The building.
    labels
        Rooms after `keep_inside`; surfels of no room are looked at.
    """
    structure = Structure(planes, close_doors_m=parameters.close_doors_m)
    floor = _floor(surfels, planes, labels, parameters.cell_m)
    if not len(floor):
        return labels
    glimpses = _find_glimpses(surfels.positions[floor], scanner_positions[surfels.scan[floor]], structure, planes, parameters)
    if not len(glimpses.confidence):
        return labels
    free = np.flatnonzero(labels.after < 0)
    member, place = _within_sight(surfels, free, glimpses.places, structure, parameters)
    after, agreement = labels.after.copy(), labels.agreement.copy()
    after[member] = labels.room_count + glimpses.room[place]
    agreement[member] = glimpses.confidence[glimpses.room[place]]
    return replace(labels, after=after, agreement=agreement, room_count=labels.room_count + len(glimpses.confidence))


def _floor(surfels: Surfels, planes: Planes, labels: RoomLabels, cell_m: float) -> I64:
    """``(n,)``: one surfel a cell of the level planes that face up, lie in no room and were seen from one."""
    upward = np.append(planes.horizontal & (planes.normals[:, 2] > 0.0), False)
    seen_from_inside = labels.scan_room[surfels.scan] >= 0
    floor = np.flatnonzero((labels.after < 0) & upward[planes.surfel_plane] & seen_from_inside)
    if not len(floor):
        return floor
    in_plan = surfels.positions[floor] * np.array([1.0, 1.0, 0.0], np.float32)
    key = CellGrid.around(in_plan, cell_m).keys(in_plan, planes.surfel_plane[floor])
    return floor[np.unique(key, return_index=True)[1]]


def _find_glimpses(
    places: F32, scanners: F32, structure: Structure, planes: Planes, parameters: GlimpseParameters
) -> _Glimpses:
    """Find which places ``(n, 3)`` of floor, each with the scanner that saw it, are of rooms."""
    component = _linked(places, structure, parameters)
    size = np.bincount(component)
    roofed = np.bincount(component, _roofed(places, structure)) / size
    walled = np.bincount(component, _walled(places, scanners, structure, planes, parameters)) / size
    kept = (size * parameters.cell_m**2 >= parameters.least_floor_m2) & (roofed >= parameters.least_roofed)
    kept &= walled >= parameters.least_walled
    mean = np.stack([np.bincount(component, places[:, axis]) for axis in range(3)], axis=1) / size[:, None]
    order = np.lexsort((mean[:, 1], mean[:, 0], np.round(mean[:, 2])))
    order = order[kept[order]]
    number = np.full(len(size), -1, np.int32)
    number[order] = np.arange(len(order), dtype=np.int32)
    own = number[component] >= 0
    # Seen in part and from outside: never as sure as a room that a scanner stood in.
    confidence = 0.25 * (1.0 + roofed[order]) * walled[order]
    return _Glimpses(places[own], number[component[own]], confidence.astype(np.float32))


def _linked(places: F32, structure: Structure, parameters: GlimpseParameters) -> I32:
    """``(n,)`` component of each place: of one are those close together in plan with no wall between, tables too."""
    eye = parameters.eye_m * _UP
    flat = places * np.array([1.0, 1.0, parameters.link_m / parameters.furniture_m], np.float32)
    pairs = cKDTree(flat).query_pairs(parameters.link_m, output_type="ndarray")
    free = ~structure.blocked(places[pairs[:, 0]] + eye, places[pairs[:, 1]] + eye)
    links = sparse.coo_array((np.ones(free.sum(), np.int8), tuple(pairs[free].T)), shape=(len(places), len(places)))
    return np.asarray(sparse.csgraph.connected_components(links, directed=False)[1], np.int32)


def _roofed(places: F32, structure: Structure) -> Bool:
    """``(n,)``: which places have something above."""
    return np.greater_equal(structure.cast(places + _LIFT_M * _UP, np.repeat(_UP, len(places), axis=0)).plane, 0)


def _walled(
    places: F32, scanners: F32, structure: Structure, planes: Planes, parameters: GlimpseParameters
) -> Bool:
    """``(n,)``: behind which places, seen from their scanners, there is a wall."""
    onwards = (places - scanners) * np.array([1.0, 1.0, 0.0], np.float32)
    onwards /= np.maximum(np.linalg.norm(onwards, axis=1, keepdims=True), 1e-6)
    hits = structure.cast(places + parameters.eye_m * _UP, onwards)
    return np.asarray((hits.distance < parameters.reach_m) & np.append(planes.vertical, False)[hits.plane])


def _within_sight(
    surfels: Surfels, free: I64, places: F32, structure: Structure, parameters: GlimpseParameters
) -> tuple[I64, I64]:
    """Free surfels near a place in plan that is in their sight, and the place, as index arrays."""
    positions = surfels.positions[free] + _LIFT_M * surfels.normals[free]
    found = cKDTree(places[:, :2]).query(positions[:, :2], distance_upper_bound=parameters.take_m)
    distance, place = np.asarray(found[0]), np.asarray(found[1])
    near = np.isfinite(distance)
    free, place, positions = free[near], place[near], positions[near]
    seen = ~structure.blocked(places[place] + parameters.eye_m * _UP, positions)
    return free[seen], place[seen]
