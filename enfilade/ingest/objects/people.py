"""People who stood about while one scan was made."""

from __future__ import annotations

from typing import Final

import numpy as np

from enfilade.ingest.records import F32, F64

HEIGHT_M: Final = (1.35, 1.95)
WIDTH_M: Final = 0.65
DEPTH_M: Final = 0.25
"""From one side one sees less than half of a person."""
OFF_FLOOR_M: Final = 0.3
FACING_DEG: Final = 15.0
MOST_FLAT: Final = 0.65
"""Of furniture so high and narrow most of what one sees faces one way."""


def is_person(points: F64, normals: F32, floor_m: float) -> bool:
    """Tell whether what one scan alone saw is as high, wide and round as a person who stands.

    Parameters
    ----------
    points
        ``(n, 3)`` metres.
    normals
        ``(m, 3)`` of its surfels.
    floor_m
        Height of the floor.
    """
    bottom, top = np.quantile(points[:, 2], (0.01, 0.99)) - floor_m
    level = points[:, :2] - points[:, :2].mean(axis=0)
    along = level @ np.linalg.eigh(level.T @ level)[1]
    depth, width = np.ptp(np.quantile(along, (0.02, 0.98), axis=0), axis=0)
    upright = normals[np.hypot(normals[:, 0], normals[:, 1]) > 0.5, :2].astype(np.float64)
    stands = bottom < OFF_FLOOR_M and HEIGHT_M[0] < top < HEIGHT_M[1]
    if not stands or width > WIDTH_M or depth > DEPTH_M or not len(upright):
        return False
    angle = np.degrees(np.arctan2(upright[:, 1], upright[:, 0]))
    ways = np.arange(0.0, 360.0, 5.0)
    facing = np.abs((angle[:, None] - ways + 180.0) % 360.0 - 180.0) < FACING_DEG
    return bool(facing.mean(axis=0).max() < MOST_FLAT)
