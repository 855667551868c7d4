"""Flights of stairs: where the scans show them to rise, and how far."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .reveals import PlanGrid
from .scene import PlannedOpening
from .thinning import thinned

F64 = NDArray[np.float64]
Bool = NDArray[np.bool_]

RISER_M: Final = 0.18
"""Usual height of a step."""
_REACH_M: Final = 4.0
_VOXEL_M: Final = 0.05
_SLOPES: Final = np.tan(np.radians(np.arange(22.0, 51.0, 2.0)))
_TURN_DEG: Final = 10
_NEAR_M: Final = 0.14
"""Steps stray so far from their slope."""
_MOST_IN_COLUMN: Final = 8
"""Columns with more voxels are walls or cupboards, not steps."""
_LEAST_VOXELS: Final = 60
_MOST_FLIGHTS: Final = 4
_LEAST_RISE: Final = 0.25
"""Of the whole, for one flight of several."""
_WIDTH_M: Final = (0.5, 3.5)
_SQUARE_SIN: Final = float(np.sin(np.radians(12)))
"""Stairs that rise so nearly along or up the page run with the walls."""
_LEAST_COVER: Final = 0.35
"""Share of a flight's surface that has points."""


@dataclass(frozen=True, slots=True)
class Flight:
    """A straight flight of steps.

    Attributes
    ----------
    foot
        ``(2,)`` middle of its lowest edge on the page, metres.
    up
        ``(2,)`` unit direction of its rise.
    length, width
        Metres.
    treads
        Their number.
    low, high
        Elevations that it leads from and to, metres.
    measured
        Whether scans showed it; else only the hole in the slab is known, and not which way the steps rise.
    """

    foot: F64
    up: F64
    length: float
    width: float
    treads: int
    low: float
    high: float
    measured: bool = True

    @property
    def corners(self) -> F64:
        """``(4, 2)`` on the page."""
        along, half = self.up * self.length, self.width / 2 * np.array([-self.up[1], self.up[0]])
        return np.array([self.foot - half, self.foot + half, self.foot + along + half, self.foot + along - half])


def find_flights(grid: PlanGrid, opening: PlannedOpening, low: float, high: float) -> list[Flight]:
    """Find the straight flights that lead up through a hole between two floors, the lowest first."""
    points = grid.positions[grid.within(opening.position, _REACH_M)]
    points = points[(points[:, 2] > low + 0.1) & (points[:, 2] < high - 0.02)]
    voxels = _off_the_walls(thinned(points, _VOXEL_M))
    found: list[Flight] = []
    while len(found) < _MOST_FLIGHTS and len(voxels) >= _LEAST_VOXELS:
        flight, members = _steepest_agreement(voxels, opening.position, low, high)
        if flight is None:
            break
        found.append(flight)
        voxels = voxels[~members]
        if sum(one.high - one.low for one in found) > 0.85 * (high - low):
            break
    return sorted(found, key=lambda one: one.low)


def _off_the_walls(voxels: F64) -> F64:
    """Leave out columns that reach through much of the height: walls and cupboards."""
    columns = np.round(voxels[:, :2] / _VOXEL_M).astype(np.int64)
    _, column, filled = np.unique(columns[:, 0] << 32 ^ columns[:, 1], return_inverse=True, return_counts=True)
    return np.asarray(voxels[filled[column] <= _MOST_IN_COLUMN])


def _steepest_agreement(voxels: F64, centre: F64, low: float, high: float) -> tuple[Flight | None, Bool]:
    """Return the slope that most voxels agree on, as a flight, and which they are; None where they make none."""
    away = voxels[:, :2] - centre
    best, most = None, _LEAST_VOXELS - 1
    for degrees in range(0, 360, _TURN_DEG):
        up = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
        place = away @ up
        for slope in _SLOPES:
            level = np.floor((voxels[:, 2] - slope * place - low) / _NEAR_M).astype(np.int64)
            votes = np.bincount(level - level.min())
            if votes.max() > most:
                most, best = int(votes.max()), (up, slope, level == level.min() + int(votes.argmax()))
    if best is None:
        return None, np.zeros(len(voxels), bool)
    plane, members = _refined(voxels, away, best[2])
    return _flight(voxels[members], away[members], centre, plane, low, high), members


def _refined(voxels: F64, away: F64, members: Bool) -> tuple[F64, Bool]:
    """Fit ``z = a x + b y + c`` to the members, and take as members what lies close to it, a few times over."""
    plane = np.zeros(3)
    system = np.column_stack([away, np.ones(len(away))])
    for _ in range(5):
        plane = np.linalg.lstsq(system[members], voxels[members, 2], rcond=None)[0]
        members = np.abs(voxels[:, 2] - system @ plane) < _NEAR_M
        if members.sum() < 3:
            break
    return plane, members


def _flight(voxels: F64, away: F64, centre: F64, plane: F64, low: float, high: float) -> Flight | None:
    """Measure a flight; None where what was found is too short, too narrow, too wide or too sparse for one."""
    slope = float(np.hypot(*plane[:2]))
    if len(voxels) < _LEAST_VOXELS or not 0.35 < slope < 1.4:
        return None
    up = _with_the_walls(plane[:2] / slope)
    kept = _together(away, up)
    place, aside = away[kept] @ up, away[kept] @ np.array([-up[1], up[0]])
    first, last = np.percentile(place, [1, 99])
    left, right = np.percentile(aside, [2, 98])
    bottom, top = plane[2] + slope * first, plane[2] + slope * last
    cells = len(thinned(away[kept], _VOXEL_M)) * _VOXEL_M**2
    covered = cells / max((last - first) * (right - left), 1e-6)
    if (
        top - bottom < _LEAST_RISE * (high - low)
        or not _WIDTH_M[0] < right - left < _WIDTH_M[1]
        or covered < _LEAST_COVER
    ):
        return None
    # The first step is one riser above the floor, and the last riser ends on the floor above.
    bottom = low if bottom - low < 2.5 * RISER_M else bottom
    top = high if high - top < 2.5 * RISER_M else top
    first = min(first, (bottom + RISER_M / 2 - plane[2]) / slope)
    foot = centre + up * first + np.array([-up[1], up[0]]) * (left + right) / 2
    risers = max(2, round((top - bottom) / RISER_M))
    return Flight(foot, up, float(last - first), float(right - left), risers - 1, float(bottom), float(top))


def _with_the_walls(up: F64) -> F64:
    """Turn a direction exactly along the page where it nearly is: a slope of few steps tells it but roughly."""
    nearest = np.eye(2)[int(np.argmax(np.abs(up)))] * np.sign(up[np.argmax(np.abs(up))])
    return np.asarray(nearest if abs(up[0] * nearest[1] - up[1] * nearest[0]) < _SQUARE_SIN else up)


def _together(away: F64, up: F64) -> Bool:
    """Members of the best filled strip along the slope: what lies in the same plane elsewhere is no part of it."""
    aside = away @ np.array([-up[1], up[0]])
    bins = np.floor(aside / 0.1).astype(np.int64)
    bins -= bins.min()
    filled = np.bincount(bins) >= 0.35 * np.bincount(bins).max()
    run = np.cumsum(~filled)
    weight = np.bincount(run[filled], weights=np.bincount(bins)[filled])
    return np.asarray(filled[bins] & (run[bins] == weight.argmax()))


def nominal_flight(opening: PlannedOpening, low: float, high: float, angle: float) -> Flight:
    """Return the hole in the slab, its longer side at an angle, as a flight that rises one cannot say which way."""
    width, length = sorted((opening.width, max(opening.height, opening.width)))
    up = np.array([np.cos(angle), np.sin(angle)])
    risers = max(2, round((high - low) / RISER_M))
    treads = min(risers - 1, max(2, int(length / 0.22)))
    return Flight(opening.position - up * length / 2, up, length, width, treads, low, high, measured=False)
