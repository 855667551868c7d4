"""How the leaf of a door stands: a leaf that stands ajar is an upright plate that reaches from a jamb out of the hole.

All ways in which it may stand are tried: hung left or right, swung to either side, in either face of the wall. Those
surfels that lie along such a plate and face across it have to cover much of it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import product
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from enfilade.ingest.records import F64, Bool, Opening, Surfels

I64 = NDArray[np.int64]

ANGLES_DEG: Final = np.arange(0.0, 46.0, 3.0)
"""Ways in which a leaf is looked for; one that is turned more is open."""

CLOSED_DEG: Final = 5.0
"""One that is turned less is closed."""

DEPTHS_M: Final = np.arange(-0.3, 0.301, 0.04)
"""Where the hinge may be, across the wall, from its middle."""

PLATE_M: Final = 0.035
"""Half the thickness in which the surfels of a leaf lie, with those of both its faces."""

ACROSS: Final = 0.3
"""Most that the normal of a surfel of the leaf goes along it."""

CELL_M: Final = 0.15
"""Side of the cells of a leaf that are looked for."""

WIDEST_M: Final = 1.3
"""Wider holes have no single leaf."""

FOOT_M: Final = 0.2
"""Nothing is asked so close to the floor and to the head of the door."""

REACH: Final = 1.6
"""A leaf that stands ajar ends no farther from the middle of its door, in widths of it."""

COVERED: Final = 0.7
"""Share of a leaf that was seen, at least."""


def with_leaves(openings: Iterable[Opening], surfels: Surfels) -> list[Opening]:
    """Say of the doors whose leaf stands ajar that it does.

    Parameters
    ----------
    openings
        Of any kind.
    surfels
        Of the building.

    Returns
    -------
    All of them, in the order given.
    """
    upright = np.flatnonzero(np.abs(surfels.normals[:, 2]) < ACROSS)
    tree = cKDTree(surfels.positions[upright, :2], compact_nodes=False, balanced_tree=False)
    return [
        replace(opening, state="ajar")
        if opening.kind == "door" and opening.width < WIDEST_M and stands_ajar(opening, surfels, upright, tree)
        else opening
        for opening in openings
    ]


def stands_ajar(opening: Opening, surfels: Surfels, upright: I64, tree: cKDTree) -> bool:
    """Whether surfels cover the leaf of a door, and face as one that stands ajar does."""
    covered, angle_deg = leaf_of(opening, surfels, upright, tree)
    return covered > COVERED and angle_deg > CLOSED_DEG


def leaf_of(opening: Opening, surfels: Surfels, upright: I64, tree: cKDTree) -> tuple[float, float]:
    """Return the share of a door's leaf that surfels cover if it stands in the best of all ways, and its angle.

    Parameters
    ----------
    opening
        The door.
    surfels
        Of the building.
    upright, tree
        Indices of the surfels that face sideways, and a tree of where they are in plan.

    Returns
    -------
    Share, 0 to 1, and the angle that its surfels are turned from the wall, degrees: a plate is thick, so that of its
    place is less sharp.
    """
    normal = opening.normal[:2] / np.linalg.norm(opening.normal[:2])
    axes = np.array([[-normal[1], normal[0]], normal])
    near = upright[tree.query_ball_point(opening.position[:2], REACH * opening.width)]
    height = surfels.positions[near, 2] - (opening.position[2] - opening.height / 2)
    inside = (height > FOOT_M) & (height < opening.height - FOOT_M)
    near, level = near[inside], np.floor(height[inside] / CELL_M).astype(np.int64)
    place, facing = (surfels.positions[near, :2] - opening.position[:2]) @ axes.T, surfels.normals[near, :2] @ axes.T
    cells = (opening.width - CELL_M / 2) * (opening.height - 2 * FOOT_M) / CELL_M**2
    angle = np.radians(ANGLES_DEG)
    best, turn = 0, 0.0
    for hand, swing in product((-1.0, 1.0), repeat=2):
        along, hinge = np.stack([-hand * np.cos(angle), swing * np.sin(angle)], axis=1), hand * opening.width / 2
        covered = _covered(place, facing, level, hinge, along, opening.width)
        if covered.max() > best:
            best = int(covered.max())
            depth, k = np.unravel_index(covered.argmax(), covered.shape)
            on = _on_leaf(place, facing, hinge, DEPTHS_M[depth], along[k], opening.width)
            turn = float(np.median(np.abs(facing[on, 0])))
    return min(best / cells, 1.0), float(np.degrees(np.arcsin(min(turn, 1.0))))


@njit(cache=True, nogil=True)
def _covered(place: F64, facing: F64, level: I64, hinge: float, along: F64, width: float) -> I64:
    """``(depths, angles)`` cells of a leaf that surfels cover, for each depth of its hinge and way ``(angles, 2)``."""
    rows, columns = int(width / CELL_M) + 1, level.max() + 1 if len(level) else 1
    counts = np.zeros((len(DEPTHS_M), len(along)), np.int64)
    met = np.full((len(DEPTHS_M), rows * columns), -1)
    for k in range(len(along)):
        for i in range(len(place)):
            if abs(facing[i, 0] * along[k, 0] + facing[i, 1] * along[k, 1]) < ACROSS:
                for depth in range(len(DEPTHS_M)):
                    reach = _reach(place[i, 0] - hinge, place[i, 1] - DEPTHS_M[depth], along[k], width)
                    cell = int(reach / CELL_M) * columns + level[i]
                    if reach > 0.0 and met[depth, cell] != k:
                        met[depth, cell] = k
                        counts[depth, k] += 1
    return counts


@njit(cache=True, nogil=True)
def _on_leaf(place: F64, facing: F64, hinge: float, depth: float, along: F64, width: float) -> Bool:
    """``(n,)``: surfels that lie on a leaf and face across it."""
    on = np.abs(facing @ along) < ACROSS
    for i in range(len(place)):
        on[i] &= _reach(place[i, 0] - hinge, place[i, 1] - depth, along, width) > 0.0
    return on


@njit(cache=True, nogil=True, inline="always")
def _reach(x: float, y: float, along: F64, width: float) -> float:
    """How far from the hinge a place on a leaf is; -1 of one that is not on it."""
    reach = x * along[0] + y * along[1]
    on = abs(x * along[1] - y * along[0]) < PLATE_M and CELL_M / 2 < reach < width
    return reach if on else -1.0
