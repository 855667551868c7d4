"""The cells that a side covers, and how far points stand off the sides of their room."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from enfilade.ingest.records import F64, I32, Bool, Surfels
from enfilade.ingest.sides import Side

I64 = NDArray[np.int64]

CELL_M: Final = 0.1
BEYOND_M: Final = 0.3
BACK_M: Final = 0.05
"""A scanner that looks at the back of a side is farther behind it."""


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


@dataclass(frozen=True, slots=True)
class Face:
    """A side of structure with the cells that it covers.

    Attributes
    ----------
    side
        Wall, floor, ceiling or slope.
    behind_m
        How far behind it things are part of it.
    mask
        Its cells.
    """

    side: Side
    behind_m: float
    mask: Mask

    def crossings(self, start: F64, ends: F64) -> tuple[I64, F64]:
        """Find which ways from a start, ``(3,)``, to ends, ``(n, 3)``, come in through the back, and where.

        Things hide what is behind them, so that all within the bounds of the side counts as wall.
        """
        before = float(start @ self.side.normal) - self.side.offset
        if before > -BACK_M:
            return np.zeros(0, dtype=np.int64), np.zeros((0, 3))
        depth = ends @ self.side.normal - self.side.offset
        way = np.flatnonzero(depth > 0)
        places = start + (before / (before - depth[way]))[:, None] * (ends[way] - start)
        on_plane = places @ np.column_stack([self.side.u, self.side.v])
        within = ((on_plane > self.side.bounds[:2]) & (on_plane < self.side.bounds[2:])).all(axis=1)
        return way[within], places[within]


def standing_off(points: F64, sparse: Bool, faces: Iterable[Face], reach_m: float) -> F64:
    """Measure how far points stand in front of the nearest side; what lies behind one stands off not at all.

    Parameters
    ----------
    points
        ``(n, 3)`` metres.
    sparse
        ``(n,) bool``, points without a surfel: where these are, a side may well be without, too.
    faces
        Of the room.
    reach_m
        Farther than this is infinitely far.

    Returns
    -------
    ``(n,)`` metres, negative for what lies within the wall.
    """
    least = np.full(len(points), np.inf)
    for face in faces:
        depth = points @ face.side.normal - face.side.offset
        close = np.flatnonzero((depth < np.minimum(reach_m, least)) & (depth > -face.behind_m))
        close = close[face.mask.covers(points[close]) | (sparse[close] & _within(face.side, points[close]))]
        least[close] = np.minimum(least[close], depth[close])
    return least


def _within(side: Side, points: F64) -> Bool:
    """Whether points lie within the bounds of a side, or a little beyond."""
    place = points @ np.column_stack([side.u, side.v])
    return np.asarray(((place > side.bounds[:2] - BEYOND_M) & (place < side.bounds[2:] + BEYOND_M)).all(axis=1))
