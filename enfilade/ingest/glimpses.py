"""Rooms that no scan stands in, but that an open door, a window or a stair well let a scanner look into.

What was seen of such a room lies in no plan. Its floor tells where it is: floor over which there is a roof, as far as
it was seen, and behind which the line of sight ends at a wall. The ground outside has neither; a balcony may have a
roof, but no wall behind.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import cKDTree

from .cells import CellGrid, members_of
from .far_ends import give_far_ends
from .records import F32, F64, I32, Bool, Plan, Planes, RoomLabels, Surfels
from .structure import Structure

I64 = NDArray[np.int64]
_UP: Final = np.array([[0.0, 0.0, 1.0]], np.float32)
_LIFT_M: Final = 0.05
_TRIPOD_M: Final = 2.5
"""Highest that a scanner stands over its floor."""


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
        Height over the floor at which places see each other.
    wall_eye_m
        Height over the floor at which walls are looked for: above parapets, below the heads of doors.
    reach_m
        How far walls may be.
    along_m
        How far scanners look along their room to the end of it.
    least_roofed, least_walled
        Shares of its floor that have something above, of which a scanner on the other side of the door sees little,
        and that have a wall behind.
    headroom_m, most_low
        At most such a share may have less than so much height above: the space under a flight of stairs is no room.
    least_in_sight, step_m, storey_m
        What lies under a roof, in the sight of its scanners to such a share, is no other room; it is of theirs if it
        lies no deeper below their floor than the one, and of another storey from the other on.
    link_m
        Floor closer than this in plan with no wall between is of one room.
    level_m, least_between_m2
        Floor between those of other rooms and farther than that from any is a landing of stairs unless so large.
    least_links
        So many cells of floor beside a room's own, with no wall between, are of that room.
    fragment_m
        So far apart may be two pieces of the floor of a room that was looked into.
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
    wall_eye_m: float = 1.7
    reach_m: float = 12.0
    along_m: float = 25.0
    least_roofed: float = 0.15
    least_walled: float = 0.7
    headroom_m: float = 1.7
    most_low: float = 0.5
    least_in_sight: float = 0.5
    step_m: float = 0.5
    storey_m: float = 2.0
    link_m: float = 0.5
    level_m: float = 0.6
    least_between_m2: float = 4.0
    least_links: int = 3
    fragment_m: float = 2.0
    furniture_m: float = 1.3
    take_m: float = 1.0
    close_doors_m: float = 2.4


@dataclass(frozen=True, slots=True)
class _Signs:
    """What is told about each place on a floor, ``(n,)``.

    Whether something is above, and low; whether there is a wall behind, seen from its scanner; whether nothing is
    between, with doors and windows closed.
    """

    roofed: Bool
    low: Bool
    walled: Bool
    in_sight: Bool


@dataclass(frozen=True, slots=True)
class _Scans:
    """Where scanners stood, ``(S, 3)``; their rooms, -1 outside, and these rooms' floors, ``(S,)``."""

    positions: F32
    room: I32
    floors: F64


def add_glimpsed_rooms(
    surfels: Surfels,
    planes: Planes,
    labels: RoomLabels,
    plans: Sequence[Plan],
    scanner_positions: F32,
    parameters: GlimpseParameters = GlimpseParameters(),
    *,
    viewpoints: F32 | None = None,
) -> RoomLabels:
    """Make rooms of what lies in no plan but has floor, roof and walls; they get the numbers after the others.

    What a room goes on into with no wall between is given to that room, and so is what its scanners see inside
    with no door, window or lintel between.

    Parameters
    ----------
    surfels, planes, scanner_positions
        The building.
    labels
        Rooms after `keep_inside`; surfels of no room are looked at.
    plans
        Of these rooms.
    viewpoints
        ``(S, 3) float32`` scanners, lifted to just below their ceilings; where they stood if None.
    """
    structure = Structure(planes, close_doors_m=parameters.close_doors_m)
    floor = _one_a_cell(surfels, planes, _free_floor(surfels, planes, labels), parameters.cell_m)
    if not len(floor):
        return labels
    places = surfels.positions[floor]
    component = _linked(places, structure, parameters.link_m, parameters)
    known = _known_floor(surfels, planes, labels, plans, parameters.furniture_m)
    known = _one_a_cell(surfels, planes, known, parameters.cell_m)
    room = _adjoining(places, component, surfels.positions[known], labels.after[known], structure, parameters)
    _give_to_scans(room, places, component, scanner_positions, labels.scan_room, structure, parameters)
    signs = _signs(places, scanner_positions[surfels.scan[floor]], structure, planes, parameters)
    floors = np.array([plan.floor_elevation for plan in plans])[labels.scan_room]
    seen_from = _Scans(scanner_positions, labels.scan_room, floors)
    own = _open_to_scanners(places, component, floors[surfels.scan[floor]], signs, parameters)
    _give_to_lookers(room, places, component, own, seen_from, structure, parameters)
    give_far_ends(
        room,
        places,
        component,
        _from_elsewhere(component, signs, parameters),
        labels.scan_room,
        floors,
        scanner_positions if viewpoints is None else viewpoints,
        structure,
        along_m=parameters.along_m,
        step_m=parameters.step_m,
        least_in_sight=parameters.least_in_sight,
    )
    looked_into = ~own & (room < 0) & (_shares(component, signs.walled) >= parameters.least_walled)
    component = _fragments_joined(places, component, looked_into, structure, parameters)
    sure = _sure(component, signs, parameters)
    sure[: len(room)] = 0.0
    sure[_landings(places, component, plans, parameters)] = 0.0
    room = np.append(room, np.full(len(sure) - len(room), -1, np.int32))
    new = np.flatnonzero(sure > 0.0)
    new = new[np.lexsort(np.round(_means(places, component)[new], 1).T[[1, 0, 2]])]
    room[new] = labels.room_count + np.arange(len(new), dtype=np.int32)
    return _taken_in(surfels, labels, places, room[component], sure[component], structure, len(new), parameters)


def _free_floor(surfels: Surfels, planes: Planes, labels: RoomLabels) -> I64:
    """Surfels of level planes that face up, lie in no room and were seen from one."""
    upward = np.append(planes.horizontal & (planes.normals[:, 2] > 0.0), False)
    seen_from_inside = labels.scan_room[surfels.scan] >= 0
    return np.flatnonzero((labels.after < 0) & upward[planes.surfel_plane] & seen_from_inside)


def _known_floor(
    surfels: Surfels, planes: Planes, labels: RoomLabels, plans: Sequence[Plan], furniture_m: float
) -> I64:
    """Surfels of level planes that face up, in the plan of their room: what lies in a doorway is not.

    Nor are the tops of what is higher than tables: they come near the floor of the next storey.
    """
    upward = np.append(planes.horizontal & (planes.normals[:, 2] > 0.0), False)[planes.surfel_plane]
    members = []
    for plan, upper in zip(plans, members_of(np.where(upward, labels.after, -1), len(plans)), strict=True):
        outline = shapely.Polygon(plan.outline[0])
        shapely.prepare(outline)
        own = upper[surfels.positions[upper, 2] < plan.floor_elevation + furniture_m]
        members.append(own[shapely.contains_xy(outline, *surfels.positions[own, :2].T.astype(np.float64))])
    return np.concatenate([np.zeros(0, np.int64), *members])


def _one_a_cell(surfels: Surfels, planes: Planes, chosen: I64, cell_m: float) -> I64:
    """One of the chosen surfels for each plane and cell of the plan."""
    if not len(chosen):
        return chosen
    in_plan = surfels.positions[chosen] * np.array([1.0, 1.0, 0.0], np.float32)
    key = CellGrid.around(in_plan, cell_m).keys(in_plan, planes.surfel_plane[chosen])
    return chosen[np.unique(key, return_index=True)[1]]


def _means(places: F32, component: I32) -> F64:
    size = np.bincount(component)
    return (
        np.stack([np.bincount(component, places[:, axis]) for axis in range(3)], axis=1) / np.maximum(size, 1)[:, None]
    )


def _signs(places: F32, scanners: F32, structure: Structure, planes: Planes, parameters: GlimpseParameters) -> _Signs:
    above = structure.cast(places + _LIFT_M * _UP, np.repeat(_UP, len(places), axis=0)).distance
    in_sight = ~structure.blocked(places + _LIFT_M * _UP, scanners)
    walled = _walled(places, scanners, structure, planes, parameters)
    return _Signs(np.isfinite(above), above < parameters.headroom_m, walled, in_sight)


def _shares(component: I32, sign: Bool) -> F64:
    """Share of the places of each component that have a sign."""
    return np.asarray(np.bincount(component, sign) / np.maximum(np.bincount(component), 1), np.float64)


def _sure(component: I32, signs: _Signs, parameters: GlimpseParameters) -> F32:
    """How sure it is that each component is a room; 0 where it is not.

    Seen in part and from outside, a room is never as sure as one that a scanner stood in.
    """
    roofed, walled = _shares(component, signs.roofed), _shares(component, signs.walled)
    kept = np.bincount(component) * parameters.cell_m**2 >= parameters.least_floor_m2
    kept &= (roofed >= parameters.least_roofed) & (walled >= parameters.least_walled)
    kept &= _shares(component, signs.low) <= parameters.most_low
    return np.where(kept, 0.25 * (1.0 + roofed) * walled, 0.0).astype(np.float32)


def _landings(places: F32, component: I32, plans: Sequence[Plan], parameters: GlimpseParameters) -> Bool:
    """``(components,)``: which are small floors between those of the rooms that are known."""
    height = _means(places, component)[:, 2]
    rises = height[:, None] - np.array([plan.floor_elevation for plan in plans])
    between = (rises > 0.0).any(axis=1) & (rises < 0.0).any(axis=1) & (np.abs(rises) > parameters.level_m).all(axis=1)
    return np.asarray(between & (np.bincount(component) * parameters.cell_m**2 < parameters.least_between_m2))


def _open_to_scanners(places: F32, component: I32, floors: F64, signs: _Signs, parameters: GlimpseParameters) -> Bool:
    """Components of places that are inside and seen over no threshold by scanners over `floors`, one for each place.

    Such are landings, the space under a flight, the foot of a slope. What lies far below its scanner's floor is of
    another storey, seen down the stairs.
    """
    near = signs.in_sight & (floors - places[:, 2] < parameters.storey_m)
    enclosed = _shares(component, signs.walled) >= parameters.least_walled
    enclosed |= _shares(component, signs.low) > parameters.most_low
    enclosed &= _shares(component, signs.roofed) >= parameters.least_in_sight
    return np.asarray(enclosed & (_shares(component, near) >= parameters.least_in_sight))


def _from_elsewhere(component: I32, signs: _Signs, parameters: GlimpseParameters) -> Bool:
    """Components of some size, with walls behind, that for the most part were measured over thresholds alone."""
    asked = np.bincount(component) * parameters.cell_m**2 >= parameters.least_floor_m2
    asked &= _shares(component, signs.walled) >= parameters.least_walled
    return np.asarray(asked & (_shares(component, signs.in_sight) < parameters.least_in_sight))


def _give_to_lookers(
    room: I32,
    places: F32,
    component: I32,
    own: Bool,
    scans: _Scans,
    structure: Structure,
    parameters: GlimpseParameters,
) -> None:
    """Give components that are open to scanners to the room, with no higher floor, from which most of them is seen."""
    inside = np.flatnonzero(scans.room >= 0)
    place = np.flatnonzero(own[component] & (room[component] < 0))
    place = np.repeat(place, len(inside))
    scan = np.tile(inside, len(place) // max(len(inside), 1))
    near = np.linalg.norm(scans.positions[scan] - places[place], axis=1) < parameters.along_m
    near &= scans.floors[scan] - places[place, 2] < parameters.step_m
    near &= scans.positions[scan, 2] > places[place, 2]  # from below, the upper side of a floor is not seen
    place, scan = place[near], scan[near]
    sees = ~structure.blocked(places[place] + _LIFT_M * _UP, scans.positions[scan])
    pairs = np.unique(np.stack([place[sees], scans.room[scan[sees]]]), axis=1)
    votes, count = np.unique(np.stack([component[pairs[0]], pairs[1]]), axis=1, return_counts=True)
    order = np.argsort(count, kind="stable")
    room[votes[0, order]] = votes[1, order]


def _fragments_joined(
    places: F32, component: I32, looked_into: Bool, structure: Structure, parameters: GlimpseParameters
) -> I32:
    """Components with those that were looked into numbered anew, so that furniture before a floor does not part it."""
    chosen = np.flatnonzero(looked_into[component])
    joined = component.copy()
    joined[chosen] = len(looked_into) + _linked(places[chosen], structure, parameters.fragment_m, parameters)
    return joined


def _adjoining(
    places: F32, component: I32, known: F32, known_room: I32, structure: Structure, parameters: GlimpseParameters
) -> I32:
    """Room that each component goes on from with no wall between, -1 for none."""
    room = np.full(int(component.max()) + 1, -1, np.int32)
    if not len(known):
        return room
    flat = _flattened(parameters.link_m, parameters)
    nearest = cKDTree(known * flat).query(places * flat, distance_upper_bound=parameters.link_m)
    place = np.flatnonzero(np.isfinite(nearest[0]))
    other = np.asarray(nearest[1])[place]
    eye = parameters.eye_m * _UP
    free = ~structure.blocked(places[place] + eye, known[other] + eye)
    pairs, count = np.unique(np.stack([component[place[free]], known_room[other[free]]]), axis=1, return_counts=True)
    for at in np.argsort(count, kind="stable"):
        if count[at] >= parameters.least_links:
            room[pairs[0, at]] = pairs[1, at]
    return room


def _give_to_scans(
    room: I32,
    places: F32,
    component: I32,
    scanners: F32,
    scan_room: I32,
    structure: Structure,
    parameters: GlimpseParameters,
) -> None:
    """Give components on which a scanner stood to its room: the user may have joined rooms that do not touch."""
    inside = np.flatnonzero(scan_room >= 0)
    distance, nearest = cKDTree(places[:, :2]).query(scanners[inside, :2], distance_upper_bound=parameters.take_m)
    near = np.isfinite(distance)
    scan, place = inside[near], np.asarray(nearest)[near]
    height = scanners[scan, 2] - places[place, 2]
    under = (height > 0.0) & (height < _TRIPOD_M)
    under &= ~structure.blocked(places[place] + _LIFT_M * _UP, scanners[scan])
    room[component[place[under]]] = scan_room[scan[under]]


def _taken_in(
    surfels: Surfels,
    labels: RoomLabels,
    places: F32,
    room: I32,
    sure: F32,
    structure: Structure,
    new: int,
    parameters: GlimpseParameters,
) -> RoomLabels:
    """Labels with the free surfels in sight of the places of rooms given to these."""
    of_room = room >= 0
    if not of_room.any():
        return labels
    free = np.flatnonzero(labels.after < 0)
    member, place = _within_sight(surfels, free, places[of_room], structure, parameters)
    after, agreement = labels.after.copy(), labels.agreement.copy()
    after[member] = room[of_room][place]
    new_member = after[member] >= labels.room_count
    agreement[member[new_member]] = sure[of_room][place[new_member]]
    return replace(labels, after=after, agreement=agreement, room_count=labels.room_count + new)


def _flattened(reach_m: float, parameters: GlimpseParameters) -> F32:
    """Scale of x, y, z in which tops of furniture are near the floor beside them."""
    return np.array([1.0, 1.0, reach_m / parameters.furniture_m], np.float32)


def _linked(places: F32, structure: Structure, reach_m: float, parameters: GlimpseParameters) -> I32:
    """``(n,)`` component of each place: of one are those close together in plan with no wall between, tables too."""
    eye = parameters.eye_m * _UP
    pairs = cKDTree(places * _flattened(reach_m, parameters)).query_pairs(reach_m, output_type="ndarray")
    free = ~structure.blocked(places[pairs[:, 0]] + eye, places[pairs[:, 1]] + eye)
    links = sparse.coo_array((np.ones(free.sum(), np.int8), tuple(pairs[free].T)), shape=(len(places), len(places)))
    return np.asarray(sparse.csgraph.connected_components(links, directed=False)[1], np.int32)


def _walled(places: F32, scanners: F32, structure: Structure, planes: Planes, parameters: GlimpseParameters) -> Bool:
    """``(n,)``: behind which places, seen from their scanners, there is a wall."""
    onwards = (places - scanners) * np.array([1.0, 1.0, 0.0], np.float32)
    onwards /= np.maximum(np.linalg.norm(onwards, axis=1, keepdims=True), 1e-6)
    hits = structure.cast(places + parameters.wall_eye_m * _UP, onwards)
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
