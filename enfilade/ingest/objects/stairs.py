"""Stairs: level patches that climb in even steps, in whatever rooms. They are structure, not furniture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from enfilade.ingest.records import F64, Bool, Surfels

I64 = NDArray[np.int64]

RISE_M: Final = (0.12, 0.23)
GOING_M: Final = (0.15, 0.45)
LEAST_TREADS: Final = 4
TREAD_M: Final = 0.1
"""Treads are thinner."""
LEAST_CLIMB_M: Final = 0.45
"""Treads are seen from above, from below, or both; these climb as high as four do."""
LINK_M: Final = 0.09
LEVEL_M: Final = 0.025
LEAST_SURFELS: Final = 5
WIDTH_M: Final = (0.5, 4.0)
"""Treads are wide, and none is as large as a landing."""
SEEN_M: Final = 0.15
"""Of some that belong to a flight one sees no more than this."""


@dataclass(frozen=True, slots=True)
class Flight:
    """A flight of stairs.

    Attributes
    ----------
    treads
        ``(k, 3)`` their centres, metres, from the lowest.
    plan
        What they cover, seen from above.
    """

    treads: F64
    plan: shapely.Geometry

    def touches(self, bounds: F64, reach_m: float) -> bool:
        """Whether the flight lies within bounds, ``(6,)`` low and high corner, on the plan, or as near as that."""
        return bool(shapely.dwithin(shapely.box(bounds[0], bounds[1], bounds[3], bounds[4]), self.plan, reach_m))

    def near(self, points: F64, beside_m: float, below_m: float, above_m: float) -> Bool:
        """``(n,) bool``: which points lie over or under the flight, or beside it, by so much at most."""
        found = np.zeros(len(points), dtype=bool)
        low, high = self.treads[0, 2] - below_m, self.treads[-1, 2] + above_m
        level = np.flatnonzero((points[:, 2] > low) & (points[:, 2] < high))
        around = shapely.buffer(self.plan, beside_m)
        shapely.prepare(around)
        level = level[shapely.contains_xy(around, points[level, 0], points[level, 1])]
        if len(level):
            tread = cKDTree(self.treads[:, :2]).query(points[level, :2])[1]
            rise = points[level, 2] - self.treads[tread, 2]
            found[level] = (rise > -below_m) & (rise < above_m)
        return found


def find_flights(surfels: Surfels, loose: Bool) -> list[Flight]:
    """Find the flights of stairs of a building.

    Parameters
    ----------
    surfels
        All of them.
    loose
        ``(M,) bool``, those on no wall, floor or ceiling, but for floors and ceilings as small as treads.

    Returns
    -------
    Runs of level patches that follow one another, each a step higher and a step further, four or more.
    """
    patches: list[F64] = []
    above: list[bool] = []
    for facing in (1, -1):
        level = np.flatnonzero(loose & (facing * surfels.normals[:, 2] > 0.9))
        patches += _level_patches(surfels.positions[level].astype(np.float64))
        above += [facing > 0] * (len(patches) - len(above))
    if len(patches) < LEAST_TREADS:
        return []
    centres = np.array([patch.mean(axis=0) for patch in patches])
    wide = np.array([_width(patch) > WIDTH_M[0] for patch in patches])
    runs = _connected(_steps(centres, np.array(above)), len(patches), LEAST_TREADS)
    runs = [run for run in runs if wide[run].sum() >= LEAST_TREADS and np.ptp(centres[run, 2]) > LEAST_CLIMB_M]
    used = np.concatenate([np.zeros(0, dtype=np.int64), *runs])
    spare = [patches[i] for i in np.setdiff1d(np.arange(len(patches)), used) if wide[i]]
    return [_flight(_with_landings([patches[i] for i in run], spare)) for run in runs]


def _steps(centres: F64, above: Bool) -> I64:
    """``(m, 2)`` pairs of patches that are a step apart, or the two sides of one tread."""
    pairs = cKDTree(centres).query_pairs(float(np.hypot(RISE_M[1], GOING_M[1])), output_type="ndarray")
    apart = np.abs(centres[pairs[:, 0]] - centres[pairs[:, 1]])
    going = np.hypot(apart[:, 0], apart[:, 1])
    step = (apart[:, 2] > RISE_M[0]) & (apart[:, 2] < RISE_M[1]) & (going > GOING_M[0]) & (going < GOING_M[1])
    sides = (above[pairs[:, 0]] != above[pairs[:, 1]]) & (apart[:, 2] < TREAD_M) & (going < GOING_M[1])
    return np.asarray(pairs[step | sides], dtype=np.int64)


def _with_landings(treads: list[F64], spare: Sequence[F64]) -> list[F64]:
    """Add the level patches that lie beside a flight, a step below its lowest tread or above its highest."""
    heights = [float(tread[:, 2].mean()) for tread in treads]
    low, high = min(heights), max(heights)
    plan = cKDTree(np.concatenate(treads)[:, :2])
    found = []
    for patch in spare:
        height = float(patch[:, 2].mean())
        next_step = RISE_M[0] < max(height - high, low - height) < RISE_M[1]
        if next_step and float(np.min(plan.query(patch[:, :2])[0])) < GOING_M[0]:
            found.append(patch)
    return treads + found


def _level_patches(positions: F64) -> list[F64]:
    """Points of level patches of the size of a tread, or of what is seen of one."""
    if not len(positions):
        return []
    pairs = cKDTree(positions).query_pairs(LINK_M, output_type="ndarray")
    pairs = pairs[np.abs(positions[pairs[:, 0], 2] - positions[pairs[:, 1], 2]) < LEVEL_M]
    groups = [positions[members] for members in _connected(pairs, len(positions), LEAST_SURFELS)]
    return [group for group in groups if SEEN_M < _width(group) < WIDTH_M[1]]


def _width(patch: F64) -> float:
    return float(np.hypot(*np.ptp(patch[:, :2], axis=0)))


def _connected(pairs: I64, count: int, least: int) -> list[I64]:
    """Members of the connected groups of at least so many."""
    a, b = pairs.T
    graph = coo_array((np.ones(len(a), dtype=bool), (a, b)), shape=(count, count))
    _, group = connected_components(graph, directed=False)
    order = np.argsort(group, kind="stable")
    groups = np.split(order, np.cumsum(np.bincount(group))[:-1])
    return [members for members in groups if len(members) >= least]


def _flight(treads: Sequence[F64]) -> Flight:
    centres = np.array([tread.mean(axis=0) for tread in treads])
    plan = shapely.union_all([shapely.MultiPoint(tread[:, :2]).convex_hull for tread in treads])
    return Flight(centres[np.argsort(centres[:, 2], kind="stable")], shapely.buffer(plan, LINK_M))
