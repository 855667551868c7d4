"""Where to set up the scanner: enough positions in every room to see it, away from everything."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from enfilade.native import open3d

from .scanner import cast, caster
from .scene import Room, Scene
from .solids import F64

_CANDIDATE_STEP_M = 0.25
_SAMPLE_STEP_M = 0.5
_SAMPLE_HEIGHT_M = 0.4


@dataclass(frozen=True, slots=True)
class Setup:
    """How scanner positions are chosen.

    Attributes
    ----------
    height_m
        Of the scanner over the floor.
    clearance_m, tripod_clearance_m
        Least distance of the scanner, and of its tripod, to any surface.
    area_a_scan_m2
        A room gets at least one position for so much floor.
    seen_share
        Positions are added to a room until so much of its floor is seen past walls.
    gain_share
        No position is added that shows less than so much more.
    """

    height_m: float = 1.5
    clearance_m: float = 0.4
    tripod_clearance_m: float = 0.2
    area_a_scan_m2: float = 25.0
    seen_share: float = 0.95
    gain_share: float = 0.05


def find_stations(scene: Scene, setup: Setup) -> F64:
    """``(S, 3)`` scanner positions, room by room; rooms without a free place get none."""
    solids = caster(scene.mesh)
    structure = caster(scene.submesh((scene.furnishing < 0) & ~scene.glass))
    found = [_in_room(scene, room, setup, solids, structure) for room in scene.rooms]
    return np.concatenate([np.empty((0, 3)), *found])


def _in_room(scene: Scene, room: Room, setup: Setup, solids: Any, structure: Any) -> F64:
    candidates = _free_places(room, setup, solids)
    if not len(candidates):
        return candidates
    samples = _grid(room, _SAMPLE_STEP_M, room.floor_elevation + _SAMPLE_HEIGHT_M)
    seen = _visibility(structure, candidates, samples)
    wanted = _near_stairs(scene, room, candidates)
    least = max(1, round(room.area / setup.area_a_scan_m2))
    return candidates[_cover(candidates, seen, wanted, least, setup)]


def _free_places(room: Room, setup: Setup, solids: Any) -> F64:
    """Places on a grid in the room from which nothing is too near, and under which is the floor."""
    places = _grid(room, _CANDIDATE_STEP_M, room.floor_elevation + setup.height_m)
    down = np.broadcast_to([0.0, 0.0, -1.0], places.shape)
    drop = cast(solids, places, down)[0]
    near = _distance(solids, places)
    near_tripod = _distance(solids, places - [0.0, 0.0, setup.height_m / 2])
    on_floor = np.abs(drop - setup.height_m) < 0.05
    return places[on_floor & (near >= setup.clearance_m) & (near_tripod >= setup.tripod_clearance_m)]


def _distance(scene: Any, points: F64) -> NDArray[np.float32]:
    query = open3d().core.Tensor(points.astype(np.float32))
    distance: NDArray[np.float32] = scene.compute_distance(query).numpy()
    return distance


def _grid(room: Room, step: float, z: float) -> F64:
    """Points of a grid, centred on the room, that lie in its plan polygon."""
    polygon = room.polygon
    x0, y0, x1, y1 = polygon.bounds
    xs, ys = ((low + high) / 2 + _symmetric(high - low, step) for low, high in ((x0, x1), (y0, y1)))
    plan = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
    plan = plan[shapely.contains_xy(polygon, plan)]
    return np.column_stack([plan, np.full(len(plan), z)])


def _symmetric(length: float, step: float) -> F64:
    half = int(length / 2 / step)
    return step * np.arange(-half, half + 1, dtype=np.float64)


def _visibility(structure: Any, candidates: F64, samples: F64) -> NDArray[np.bool_]:
    """``(C, F)`` which floor sample each candidate sees past structure."""
    towards = samples[None] - candidates[:, None]
    ranges, _ = cast(structure, np.repeat(candidates, len(samples), axis=0), towards.reshape(-1, 3))
    return ranges.reshape(len(candidates), len(samples)) >= 1.0


def _near_stairs(scene: Scene, room: Room, candidates: F64) -> list[int]:
    """The candidate nearest to each end of stairs in this room."""
    ends = [
        opening.ends[side]
        for opening in scene.openings
        if opening.ends is not None
        for side in (0, 1)
        if opening.rooms[side] == room.number
    ]
    return [int(np.argmin(np.linalg.norm(candidates[:, :2] - end[:2], axis=1))) for end in ends]


def _cover(candidates: F64, seen: NDArray[np.bool_], wanted: list[int], least: int, setup: Setup) -> list[int]:
    """Greedy cover: always the candidate that shows most new floor; once all is seen, the farthest from the others."""
    chosen = list(dict.fromkeys(wanted))
    covered = seen[chosen].any(axis=0)
    total = max(1, seen.shape[1])
    while len(chosen) < len(seen):
        gain = (seen & ~covered).sum(axis=1)
        best = int(np.argmax(gain + seen.mean(axis=1)))
        enough = covered.sum() >= setup.seen_share * total or gain[best] < setup.gain_share * total
        if chosen and enough and len(chosen) >= least:
            break
        if chosen and enough:
            best = _farthest(candidates, chosen)
        chosen.append(best)
        covered |= seen[best]
    return chosen


def _farthest(candidates: F64, chosen: list[int]) -> int:
    distance = np.linalg.norm(candidates[:, None] - candidates[chosen][None], axis=2)
    return int(np.argmax(distance.min(axis=1)))
