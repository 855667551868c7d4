"""The cells that a side covers, and how far points stand off the sides of their room."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np
from scipy import ndimage

from enfilade.ingest.records import F64, I32, Bool, Surfels
from enfilade.ingest.sides import Side

CELL_M: Final = 0.1
BEYOND_M: Final = 0.3


class Mask:
    """The cells that a side covers, and one cell around: the reveals of its holes lie there."""

    def __init__(self, side: Side, surfels: Surfels) -> None:
        self._frame = np.column_stack([side.u, side.v])
        self._corner = side.bounds[:2] - 2 * CELL_M
        self._shape = np.ceil((side.bounds[2:] - self._corner) / CELL_M).astype(int) + 2
        cells = np.zeros(tuple(self._shape), dtype=bool)
        found = self._cells(surfels.positions[side.surfels].astype(np.float64))
        cells[found[:, 0], found[:, 1]] = True
        square = np.ones((3, 3), dtype=bool)
        cells = np.asarray(ndimage.binary_closing(cells, square), dtype=np.bool_)
        self._covered: Bool = np.asarray(ndimage.binary_dilation(cells, square), dtype=np.bool_)

    def _cells(self, places: F64) -> I32:
        return np.floor((places @ self._frame - self._corner) / CELL_M).astype(np.int32)

    def covers(self, places: F64) -> Bool:
        """``(n,) bool``: which places lie in front of, on or behind the side."""
        cells = self._cells(places)
        inside: Bool = np.all((cells >= 0) & (cells < self._shape), axis=1)
        cells = np.where(inside[:, None], cells, 0)
        return np.asarray(inside & self._covered[cells[:, 0], cells[:, 1]], dtype=np.bool_)


def standing_off(
    points: F64, sparse: Bool, sides: Iterable[tuple[Side, float]], surfels: Surfels, reach_m: float
) -> F64:
    """Measure how far points stand in front of the nearest side; what lies behind one stands off not at all.

    Parameters
    ----------
    points
        ``(n, 3)`` metres.
    sparse
        ``(n,) bool``, points without a surfel: where these are, a side may well be without, too.
    sides
        Each with how far behind it things are part of it, metres.
    surfels
        Those that the sides index.
    reach_m
        Farther than this is infinitely far.

    Returns
    -------
    ``(n,)`` metres, negative for what lies within the wall.
    """
    least = np.full(len(points), np.inf)
    for side, behind in sides:
        depth = points @ side.normal - side.offset
        close = np.flatnonzero((depth < np.minimum(reach_m, least)) & (depth > -behind))
        close = close[Mask(side, surfels).covers(points[close]) | (sparse[close] & _within(side, points[close]))]
        least[close] = np.minimum(least[close], depth[close])
    return least


def _within(side: Side, points: F64) -> Bool:
    """Whether points lie within the bounds of a side, or a little beyond."""
    place = points @ np.column_stack([side.u, side.v])
    return np.asarray(((place > side.bounds[:2] - BEYOND_M) & (place < side.bounds[2:] + BEYOND_M)).all(axis=1))
