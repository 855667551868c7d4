"""The far ends of rooms, which only scanners in other rooms saw well, through open doors.

From the scanners of a long corridor the floor at its end is rings far apart, and no surfels; through a door of a room
beside it the scanner of that room sees a piece of it well. But the corridor's own scanners look at that piece with
nothing between, which they do at no other room: from under the ceiling, where lintels close all doors and neither
furniture nor the leaves of doors are in the way.
"""

from __future__ import annotations

import numpy as np

from .records import F32, F64, I32, Bool
from .structure import Structure


def give_far_ends(
    room: I32,
    places: F32,
    component: I32,
    asked: Bool,
    scan_room: I32,
    scan_floors: F64,
    viewpoints: F32,
    structure: Structure,
    *,
    along_m: float,
    step_m: float,
    least_in_sight: float,
) -> None:
    """Give pieces of floor that are of no room to the one whose viewpoints look along at most of their places.

    Parameters
    ----------
    room
        ``(C,) int32`` room of each piece, -1 for none; changed in place.
    places
        ``(n, 3) float32`` places on floors, metres.
    component
        ``(n,) int32`` the piece that each place is in.
    asked
        ``(C,) bool`` pieces that may be far ends.
    scan_room, scan_floors
        ``(S,)`` room of each scan, -1 outside, and that room's floor.
    viewpoints
        ``(S, 3) float32`` scanners, lifted to just below their ceilings.
    structure
        The building, with doors closed.
    along_m
        How far viewpoints look.
    step_m
        Floors that differ by less are level.
    least_in_sight
        Share of the places of a piece that one room has to look at.
    """
    place = np.flatnonzero(asked[component] & (room[component] < 0))
    inside = np.flatnonzero(scan_room >= 0)
    place, scan = np.repeat(place, len(inside)), np.tile(inside, len(place))
    near = np.abs(scan_floors[scan] - places[place, 2]) < step_m
    near &= np.linalg.norm(viewpoints[scan, :2] - places[place, :2], axis=1) < along_m
    place, scan = place[near], scan[near]
    raised = np.column_stack([places[place, :2], viewpoints[scan, 2]])
    sees = ~structure.blocked(raised, viewpoints[scan])
    pairs = np.unique(np.stack([place[sees], scan_room[scan[sees]]]), axis=1)
    votes, count = np.unique(np.stack([component[pairs[0]], pairs[1]]), axis=1, return_counts=True)
    for at in np.argsort(count, kind="stable"):
        if count[at] >= least_in_sight * np.count_nonzero(component == votes[0, at]):
            room[votes[0, at]] = votes[1, at]
