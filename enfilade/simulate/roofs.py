"""What is above a space: a level ceiling, cut by the slopes of a roof where it has them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import shapely
from numpy.typing import ArrayLike
from shapely import Polygon

from .polygons import plan_samples
from .solids import F64

Plane = tuple[float, float, float]
"""a, b, c of ``z = a x + b y + c``."""
_FAR_M = 1e4


@dataclass(frozen=True, slots=True)
class Roof:
    """The lowest of a level ceiling and any number of slopes."""

    ceiling: float
    slopes: tuple[Plane, ...] = ()

    @property
    def planes(self) -> F64:
        """``(P, 3)`` a, b, c of each plane, the level one first."""
        return np.array([(0.0, 0.0, self.ceiling), *self.slopes], dtype=np.float64)

    def heights(self, places: ArrayLike) -> F64:
        """``(K,)`` elevation over each of ``(K, 2)`` places."""
        plan = np.asarray(places, dtype=np.float64).reshape(-1, 2)
        height: F64 = (plan @ self.planes[:, :2].T + self.planes[:, 2]).min(axis=1)
        return height

    def median_height(self, polygon: Polygon) -> float:
        """Median elevation over a polygon."""
        if not self.slopes:
            return self.ceiling
        return float(np.median(self.heights(plan_samples(polygon, 0.0, 0.2)[:, :2])))

    def raised(self, by: float) -> Roof:
        """Return the roof shifted upwards, as its outer side lies over its inner one."""
        return Roof(
            self.ceiling + by, tuple((a, b, c + by * float(np.hypot(1, np.hypot(a, b)))) for a, b, c in self.slopes)
        )

    def regions(self, polygon: Polygon) -> list[tuple[Polygon, Plane]]:
        """Parts of a polygon with the plane above each."""
        if not self.slopes:
            return [(polygon, (0.0, 0.0, self.ceiling))]
        found = []
        for k, plane in enumerate(self.planes):
            part: shapely.Geometry = polygon
            for other in np.delete(self.planes, k, axis=0):
                part = shapely.intersection(part, _where_negative(plane - other))
            pieces = [piece for piece in shapely.get_parts(part) if isinstance(piece, Polygon) and piece.area > 1e-6]
            found += [(piece, (float(plane[0]), float(plane[1]), float(plane[2]))) for piece in pieces]
        return found

    def profile(self, start: ArrayLike, end: ArrayLike) -> list[tuple[float, float]]:
        """(metres from start, elevation) along a line of the plan, at its ends and wherever the plane above changes."""
        first, last = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
        length = float(np.linalg.norm(last - first))
        at = (self.planes[:, :2] @ first + self.planes[:, 2], self.planes[:, :2] @ last + self.planes[:, 2])
        breaks = {0.0, 1.0, *_crossings(*at)}
        return [(share * length, float(self.heights(first + share * (last - first))[0])) for share in sorted(breaks)]


def _crossings(at_start: F64, at_end: F64) -> Sequence[float]:
    """Where, as shares of the way, two of the lines cross."""
    found = []
    for i, j in combinations(range(len(at_start)), 2):
        before, after = at_start[i] - at_start[j], at_end[i] - at_end[j]
        if before * after < 0:
            found.append(float(before / (before - after)))
    return found


def _where_negative(plane: F64) -> Polygon:
    """Return the half of the plan where ``a x + b y + c <= 0``."""
    normal, offset = plane[:2], plane[2]
    length = float(np.linalg.norm(normal))
    if length < 1e-9:
        return shapely.box(-_FAR_M, -_FAR_M, _FAR_M, _FAR_M) if offset <= 0 else Polygon()
    unit = normal / length
    foot, along = -offset / length * unit, np.array([-unit[1], unit[0]]) * _FAR_M
    return Polygon([foot - along, foot + along, foot + along - _FAR_M * unit, foot - along - _FAR_M * unit])
