"""Where the edges of a hole are, and how much of a rectangle places cover: loops over many points, compiled."""

from __future__ import annotations

from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enfilade.ingest.records import F64, Bool

REACH_M: Final = 0.15
"""How far from the outermost ray the wall beside a hole may begin."""

MOST_LINES: Final = 0.4
"""Share of the lines across a hole that have to show wall beside it."""


INNER: Final = 0.2
"""Share of the outermost places of the lines that lie farther out than an edge without wall beside it."""


@njit(cache=True, nogil=True)
def cells_of(places: F64, corner: F64, cell_m: float, columns: int) -> NDArray[np.int64]:
    """``(n,)`` index, row by row, of the cell of each of ``(n, 2)`` places, none before the corner of the grid."""
    cells = np.empty(len(places), np.int64)
    for i in range(len(places)):
        row, column = int((places[i, 0] - corner[0]) / cell_m), int((places[i, 1] - corner[1]) / cell_m)
        cells[i] = row * columns + column
    return cells


@njit(cache=True, nogil=True)
def within(places: F64, low: F64, high: F64) -> F64:
    """Those of ``(n, 2)`` places that lie between two corners."""
    kept, count = np.empty_like(places), 0
    for i in range(len(places)):
        if low[0] < places[i, 0] < high[0] and low[1] < places[i, 1] < high[1]:
            kept[count] = places[i]
            count += 1
    return kept[:count].copy()


def edges_of(places: F64, wall: F64, cell_m: float) -> tuple[F64, Bool]:
    """Find the edges of a hole, line by line across each.

    In each line an edge lies between the outermost place and the wall point next to it; the median over the middle
    lines is the edge. Lines without wall near their outermost place do not vote, unless most lines are like that.

    Parameters
    ----------
    places
        ``(n, 2) float64`` where there is no wall, metres.
    wall
        ``(w, 2) float64`` points of the wall, metres.
    cell_m
        Width of the lines, and how far in from the outermost place wall may be.

    Returns
    -------
    ``(4,)`` left, bottom, right, top, and ``(4,) bool`` whether there is wall beside each.
    """
    columns = np.ascontiguousarray(places.T)
    least, low, high, most = np.percentile(columns, [0.5, 10.0, 90.0, 99.5], axis=1)
    near = within(wall, least - 2 * REACH_M, most + 2 * REACH_M)
    edges, bounded = np.empty(4), np.empty(4, np.bool_)
    for number, (sign, axis) in enumerate(((1, 0), (1, 1), (-1, 0), (-1, 1))):
        lines = max(int((high[1 - axis] - low[1 - axis]) / cell_m), 1)
        first, last = outermost(places, near, axis, sign, float(low[1 - axis]), cell_m, lines)
        edges[number], bounded[number] = _edge(first, last, sign)
        if np.isnan(edges[number]):
            edges[number] = sign * (sign * places[:, axis]).min()
    return edges, bounded


@njit(cache=True, nogil=True)
def _edge(first: F64, last: F64, sign: int) -> tuple[float, bool]:
    """Where an edge is by the lines across it, as `outermost` says, and whether there is wall beside it.

    NaN if no line was crossed.
    """
    crossed = first[np.isfinite(first)]
    both = np.isfinite(first) & np.isfinite(last)
    if not len(crossed):
        return np.nan, False
    if both.sum() >= MOST_LINES * len(crossed):
        return sign * np.median((first[both] + last[both]) / 2), True
    return sign * _quantile(crossed, INNER), False


@njit(cache=True, nogil=True)
def _quantile(values: F64, share: float) -> float:
    """Return the value below which such a share of the values lies, to the last bit as NumPy does."""
    ordered = np.sort(values)
    place = (len(values) - 1) * share
    k = int(place)
    low, high = ordered[k], ordered[min(k + 1, len(values) - 1)]
    rest = place - k
    return float(low + (high - low) * rest if rest < 0.5 else high - (high - low) * (1.0 - rest))


@njit(cache=True, nogil=True)
def outermost(places: F64, wall: F64, axis: int, sign: int, low: float, cell_m: float, lines: int) -> tuple[F64, F64]:
    """``(lines,)`` first place of each line along an axis, turned by `sign`, and the last wall point before it.

    Infinite where there is none.
    """
    first, last = np.full(lines, np.inf), np.full(lines, -np.inf)
    for i in range(len(places)):
        line = int(np.floor((places[i, 1 - axis] - low) / cell_m))
        if 0 <= line < lines:
            first[line] = min(first[line], sign * places[i, axis])
    for i in range(len(wall)):
        line = int(np.floor((wall[i, 1 - axis] - low) / cell_m))
        if 0 <= line < lines:
            place = sign * wall[i, axis]
            if first[line] - REACH_M < place < first[line] + cell_m:
                last[line] = max(last[line], place)
    return first, last


def covered_share(places: F64, edges: F64, cell_m: float) -> float:
    """Share of the cells of a rectangle, without a margin of one cell, that hold one of ``(n, 2)`` places."""
    low, shape = _inside(edges, cell_m)
    covered = np.zeros((1, *shape), np.bool_)
    cover(covered, np.zeros(len(places), np.int64), places, low, cell_m)
    return float(covered.mean())


def pane_share(wall: F64, end: F64, depth: F64, edges: F64, cell_m: float, layer_m: float) -> float:
    """Share of a rectangle that a pane covers: two neighbouring layers, of all behind one another the best.

    Parameters
    ----------
    wall
        ``(w, 2) float64`` points of the first layer, metres.
    end, depth
        ``(n, 2)`` and ``(n,) float64`` points behind it, and how far.
    edges
        ``(4,)`` left, bottom, right, top of the rectangle.
    cell_m
        Side of its cells; a margin of one is left out.
    layer_m
        Thickness of a layer.
    """
    low, shape = _inside(edges, cell_m)
    layer = np.floor(depth / layer_m).astype(np.int64)
    covered = np.zeros((int(layer.max(initial=0)) + 2, *shape), np.bool_)
    cover(covered, np.zeros(len(wall), np.int64), wall, low, cell_m)
    cover(covered, layer, end, low, cell_m)
    return float((covered[:-1] | covered[1:]).mean(axis=(1, 2)).max())


def _inside(edges: F64, cell_m: float) -> tuple[F64, NDArray[np.int64]]:
    """Lower left corner and shape of the cells of a rectangle without those at its edges."""
    return edges[:2] + cell_m, np.maximum(((edges[2:] - edges[:2]) / cell_m).astype(np.int64) - 2, 1)


@njit(cache=True, nogil=True)
def cover(covered: NDArray[np.bool_], layer: NDArray[np.int64], places: F64, low: F64, cell_m: float) -> None:
    """Mark the cells ``(layer, row, column)`` that hold a place."""
    for i in range(len(places)):
        row = int(np.floor((places[i, 0] - low[0]) / cell_m))
        column = int(np.floor((places[i, 1] - low[1]) / cell_m))
        if 0 <= row < covered.shape[1] and 0 <= column < covered.shape[2]:
            covered[layer[i], row, column] = True
