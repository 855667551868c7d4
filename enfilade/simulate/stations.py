"""Where to set up the scanner: enough positions in every room to see it, away from everything."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from .casting import Caster
from .scene import Room, Scene
from .solids import F64

_CANDIDATE_STEP_M = 0.25
_SAMPLE_STEP_M = 0.5
_SAMPLE_HEIGHT_M = 0.4
_FLOOR_TOLERANCE_M = 0.05
_TRIPOD_SHARES = (0.25, 0.5, 0.75)
_FREEDOM_WEIGHT = 0.3
_FAR_ENOUGH_M = 4.0


@dataclass(frozen=True, slots=True)
class Setup:
    """How scanner positions are chosen.

    Attributes
    ----------
    height_m
        Of the scanner over the floor.
    clearance_m, tripod_clearance_m
        Least distance of the scanner, and of its tripod, to any surface; no scanner stands nearer to the edge of its
        room than the former, so none stands in a doorway.
    area_a_scan_m2
        A room gets at least one position for so much floor.
    seen_share
        Positions are added to a room until so much of its floor is seen past walls.
    gain_share
        No position is added that shows less than so much more.
    """

    height_m: float = 1.5
    clearance_m: float = 0.4
    tripod_clearance_m: float = 0.3
    area_a_scan_m2: float = 25.0
    seen_share: float = 0.95
    gain_share: float = 0.05


def find_stations(scene: Scene, setup: Setup) -> F64:
    """``(S, 3)`` scanner positions, room by room; rooms without a free place, or not to be scanned, get none."""
    solids = Caster(scene.mesh)
    structure = Caster(scene.submesh((scene.furnishing < 0) & ~scene.glass))
    found = [_in_room(scene, room, setup, solids, structure) for room in scene.rooms if room.scanned]
    return np.concatenate([np.empty((0, 3)), *found])


def _in_room(scene: Scene, room: Room, setup: Setup, solids: Caster, structure: Caster) -> F64:
    candidates, clearance = _free_places(room, setup, solids)
    if not len(candidates):
        return candidates
    samples = _grid(room.polygon, _SAMPLE_STEP_M, room.floor_elevation + _SAMPLE_HEIGHT_M)
    seen = _visibility(structure, candidates, samples)
    chosen = _near_stairs(scene, room, candidates)
    _cover(chosen, seen, clearance, setup)
    _spread(chosen, candidates, clearance, round(room.area / setup.area_a_scan_m2))
    return candidates[chosen]


def _free_places(room: Room, setup: Setup, solids: Caster) -> tuple[F64, F64]:
    """Places on a grid in the room from which nothing is too near, under which is the floor, and their clearance."""
    inner = room.polygon.buffer(-setup.clearance_m)
    places = _grid(inner, _CANDIDATE_STEP_M, room.floor_elevation + setup.height_m)
    drop = solids.cast(places, np.broadcast_to([0.0, 0.0, -1.0], places.shape))[0]
    near = solids.distance(places).astype(np.float64)
    free = (np.abs(drop - setup.height_m) < _FLOOR_TOLERANCE_M) & (near >= setup.clearance_m)
    for share in _TRIPOD_SHARES:
        free &= solids.distance(places - [0.0, 0.0, share * setup.height_m]) >= setup.tripod_clearance_m
    return places[free], near[free]


def _grid(area: BaseGeometry, step: float, z: float) -> F64:
    """Points of a grid, centred on an area of the plan, that lie in it."""
    if area.is_empty:
        return np.empty((0, 3))
    x0, y0, x1, y1 = area.bounds
    xs, ys = ((low + high) / 2 + _symmetric(high - low, step) for low, high in ((x0, x1), (y0, y1)))
    plan = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
    plan = plan[shapely.contains_xy(area, plan)]
    return np.column_stack([plan, np.full(len(plan), z)])


def _symmetric(length: float, step: float) -> F64:
    half = int(length / 2 / step)
    return step * np.arange(-half, half + 1, dtype=np.float64)


def _visibility(structure: Caster, candidates: F64, samples: F64) -> NDArray[np.bool_]:
    """``(C, F)`` which floor sample each candidate sees past structure."""
    starts = np.repeat(candidates, len(samples), axis=0)
    return ~structure.blocked(starts, np.tile(samples, (len(candidates), 1))).reshape(len(candidates), -1)


def _near_stairs(scene: Scene, room: Room, candidates: F64) -> list[int]:
    """Return the candidate nearest to each end of stairs in this room."""
    ends = [
        opening.ends[side]
        for opening in scene.openings
        if opening.ends is not None
        for side in (0, 1)
        if opening.rooms[side] == room.number
    ]
    nearest = [int(np.argmin(np.linalg.norm(candidates[:, :2] - end[:2], axis=1))) for end in ends]
    return list(dict.fromkeys(nearest))


def _cover(chosen: list[int], seen: NDArray[np.bool_], clearance: F64, setup: Setup) -> None:
    """Add what shows most new floor, the freer place of two alike, until enough is seen."""
    total = max(1, seen.shape[1])
    covered = seen[chosen].any(axis=0)
    while len(chosen) < len(seen):
        gain = (seen & ~covered).sum(axis=1) / total
        if chosen and (covered.sum() >= setup.seen_share * total or gain.max() < setup.gain_share):
            return
        worth = gain + _FREEDOM_WEIGHT * clearance
        best = int(np.argmax(np.where(gain >= setup.gain_share, worth, -np.inf) if chosen else worth))
        chosen.append(best)
        covered |= seen[best]


def _spread(chosen: list[int], candidates: F64, clearance: F64, least: int) -> None:
    """Add free places far from the chosen ones until there are `least`."""
    while len(chosen) < min(least, len(candidates)):
        distance = np.linalg.norm(candidates[:, None] - candidates[chosen][None], axis=2).min(axis=1)
        chosen.append(int(np.argmax(np.minimum(distance, _FAR_ENOUGH_M) + clearance)))
