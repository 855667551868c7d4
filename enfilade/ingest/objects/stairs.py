"""Treads of stairs: small level sides that climb in even steps. They are structure, not furniture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from enfilade.ingest.records import Surfels
from enfilade.ingest.sides import Side

RISE_M: Final = (0.12, 0.23)
GOING_M: Final = (0.12, 0.55)
LEAST_TREADS: Final = 4


def find_treads(sides: Sequence[Side], surfels: Surfels) -> list[Side]:
    """Find the sides of a room that are treads of a stair.

    Parameters
    ----------
    sides
        Of one room.
    surfels
        Those that the sides index.

    Returns
    -------
    Level sides that look up and follow one another, each a step higher and a step further, four or more.
    """
    level = [side for side in sides if side.horizontal and side.normal[2] > 0]
    if len(level) < LEAST_TREADS:
        return []
    centres = np.array([surfels.positions[side.surfels].mean(axis=0, dtype=np.float64) for side in level])
    pairs = cKDTree(centres).query_pairs(float(np.hypot(RISE_M[1], GOING_M[1])), output_type="ndarray")
    apart = np.abs(centres[pairs[:, 0]] - centres[pairs[:, 1]])
    going = np.hypot(apart[:, 0], apart[:, 1])
    step = (apart[:, 2] > RISE_M[0]) & (apart[:, 2] < RISE_M[1]) & (going > GOING_M[0]) & (going < GOING_M[1])
    a, b = pairs[step].T
    graph = coo_array((np.ones(len(a), dtype=bool), (a, b)), shape=(len(level), len(level)))
    _, flight = connected_components(graph, directed=False)
    long_enough = np.bincount(flight)[flight] >= LEAST_TREADS
    return [side for side, kept in zip(level, long_enough, strict=True) if kept]
