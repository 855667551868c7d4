"""Holes in the walls between rooms that no door stands in: passages, and doorways under a lintel."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .casting import Caster
from .frames import Frame, measured_hole, opening_of
from .polygons import COLUMN_STEP_M
from .scene import Opening, Room
from .spaces import Border

_HEIGHT_M = 1.8
_WIDTH_M = 0.5
_LEAST_DEPTH_M = 0.2
_ONE_WALL_M = 0.4


def doorways(
    borders: Sequence[Border],
    unit: NDArray[np.int32],
    rooms: Sequence[Room],
    walls: Caster,
    doors: Sequence[Opening],
) -> list[Opening]:
    """Find holes that one can walk through, other than the doors that are known.

    Parameters
    ----------
    borders
        What stands between spaces.
    unit
        ``(spaces,)`` room of each space.
    walls
        Everything that parts rooms, to measure the holes by.
    """
    found = [
        _doorway(border, run, rooms, walls)
        for border in borders_of_rooms(borders, unit)
        for run in border.stretches(np.flatnonzero(border.clear >= _HEIGHT_M))
        if len(run) * COLUMN_STEP_M >= _WIDTH_M
    ]
    return [opening for opening in found if not any(_same_place(opening, door) for door in doors)]


def borders_of_rooms(borders: Sequence[Border], unit: NDArray[np.int32]) -> list[Border]:
    """Put borders between spaces together that part the same two rooms, their columns in order along the wall."""
    between = defaultdict(list)
    for border in borders:
        ends = int(unit[border.first]), int(unit[border.second])
        if ends[0] != ends[1]:
            between[min(ends), max(ends)].append((border, 1.0 if ends[0] < ends[1] else -1.0))
    return [_merged(first, second, parts) for (first, second), parts in between.items()]


def _merged(first: int, second: int, parts: Sequence[tuple[Border, float]]) -> Border:
    middle = np.concatenate([border.middle for border, _ in parts])
    across = np.concatenate([sign * border.across for border, sign in parts])
    along = middle[:, 1] * across[:, 0] - middle[:, 0] * across[:, 1]
    line = np.round(np.einsum("ij,ij->i", middle, across), 1)
    order = np.lexsort((along, line, *np.round(across, 1).T))
    clear, open_top, gap = (
        np.concatenate([getattr(border, name) for border, _ in parts])[order] for name in ("clear", "open_top", "gap")
    )
    return Border(first, second, clear, open_top, middle[order], across[order], gap)


def _doorway(border: Border, run: NDArray[np.intp], rooms: Sequence[Room], walls: Caster) -> Opening:
    across = border.across[run].mean(axis=0)
    across /= np.linalg.norm(across)
    axes = np.array([[across[1], -across[0], 0.0], [*across, 0.0], [0.0, 0.0, 1.0]])
    floor = max(rooms[border.first].floor_elevation, rooms[border.second].floor_elevation)
    half = np.array([len(run) * COLUMN_STEP_M, max(float(np.median(border.gap[run])), _LEAST_DEPTH_M)]) / 2
    origin = np.array([*border.middle[run].mean(axis=0), floor])
    rough = Frame(axes, origin, np.array([*-half, 0.0]), np.array([*half, float(np.median(border.clear[run]))]))
    passage = bool(border.open_top[run].mean() > 0.5)
    hole = measured_hole(rough, walls)
    sides = (border.first, border.second)
    return opening_of("passage" if passage else "door", None if passage else "open", hole, sides, floor)


def _same_place(opening: Opening, door: Opening) -> bool:
    """Whether the two lie in one wall and overlap."""
    apart = np.abs((door.position - opening.position) @ np.stack([opening.normal, opening.axis], axis=1))
    return bool(apart[0] < _ONE_WALL_M and apart[1] < (opening.width + door.width) / 2)
