"""Where doors and windows go: stretches of wall between spaces, and what is set into them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely import Polygon

from .polygons import boundary_columns, distance_along
from .solids import F64

_WALL_AT_MOST_M = 0.75
_CURVED_AT_MOST_M = 1.3
_SAME_M = 0.011


@dataclass(frozen=True, slots=True)
class Stretch:
    """A straight stretch of wall between two spaces.

    Attributes
    ----------
    start, end
        ``(2,)`` its ends in plan, on the side of the space it was asked of.
    across
        ``(2,)`` unit vector through the wall.
    gap
        Thickness of the wall, metres.
    """

    start: F64
    end: F64
    across: F64
    gap: float

    @property
    def length(self) -> float:
        """Metres."""
        return float(np.linalg.norm(self.end - self.start))

    def middle(self, along: float) -> tuple[float, float]:
        """Return the place in the middle of the wall, `along` metres from its start."""
        place = self.start + along * (self.end - self.start) / self.length + self.across * self.gap / 2
        return float(place[0]), float(place[1])

    def span(self, along: float, width: float, margin: float, reach: float) -> Polygon:
        """Return what a hole of some width at `along` takes in plan, `reach` metres into the spaces on both sides."""
        unit = (self.end - self.start) / self.length
        centre = np.array(self.middle(along))
        half, deep = unit * (width / 2 + margin), self.across * (self.gap / 2 + reach)
        return Polygon([centre - half - deep, centre + half - deep, centre + half + deep, centre - half + deep])


def stretches(a: Polygon, b: Polygon, others: Sequence[Polygon], *, curved: bool = False) -> list[Stretch]:
    """Find where the straight sides of `a` face `b` through a wall; `curved` says that `b` has no straight ones.

    Parameters
    ----------
    a, b
        Two spaces, or what is outside.
    others
        Spaces that must not lie between.
    """
    columns = boundary_columns(a)
    reach = _CURVED_AT_MOST_M if curved else _WALL_AT_MOST_M
    near = shapely.dwithin(shapely.points(columns.points), b, reach)
    start, across = columns.points[near], columns.outwards[near]
    if not len(start):
        return []
    gap = distance_along(start, across, b, reach)
    facing = np.isfinite(gap)
    if len(others):
        lines = shapely.linestrings(
            np.stack([start + 0.01 * across, start + np.minimum(gap, reach)[:, None] * across], 1)
        )
        facing &= ~shapely.intersects(lines, shapely.union_all(list(others)))
    half = columns.widths[near] / 2
    return _runs(start[facing], across[facing], gap[facing], half[facing], curved=curved)


def _runs(points: F64, across: F64, gap: F64, half: F64, *, curved: bool) -> list[Stretch]:
    if not len(points):
        return []
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    turns = np.einsum("ij,ij->i", across[1:], across[:-1]) < 0.999
    jumps = np.zeros(len(steps), dtype=np.bool_) if curved else np.abs(np.diff(gap)) > _SAME_M
    found = []
    for run in np.split(np.arange(len(points)), np.flatnonzero((steps > 0.25) | turns | jumps) + 1):
        along = np.array([-across[run[0]][1], across[run[0]][0]])
        start, end = points[run[0]] - along * half[run[0]], points[run[-1]] + along * half[run[-1]]
        if curved:
            start, end, thickness = _nearest_part(points[run], gap[run], along)
        else:
            thickness = float(np.median(gap[run]))
        found.append(Stretch(start, end, across[run[0]], thickness))
    return [stretch for stretch in found if stretch.length > 0.3]


def _nearest_part(points: F64, gap: F64, along: F64) -> tuple[F64, F64, float]:
    """Return the part of a stretch where a curved wall is nearest, wide enough for one door."""
    best = points[int(np.argmin(gap))]
    half = min(0.7, float(np.linalg.norm(best - points[0])), float(np.linalg.norm(best - points[-1])))
    return best - half * along, best + half * along, float(gap.min())
