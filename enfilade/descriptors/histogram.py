"""From the points of an object to its descriptor (Eqs. 8-10)."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enfilade.schema.counts import quantise

from .layout import DEFAULT_LAYOUT, Layout

F64 = NDArray[np.float64]


def describe(points: NDArray[np.floating], base_z: float, layout: Layout = DEFAULT_LAYOUT) -> NDArray[np.uint16]:
    """Describe the shape of an object.

    Points outside the slices or shells count in the nearest one, sectors wrap; interpolation and the box filter of
    Eq. 9 follow the same rules at the borders.

    Parameters
    ----------
    points
        ``(n, 3)``, metres, n >= 1.
    base_z
        Height of the lower end of the descriptor: the room's floor, or the object's own foot. Metres.
    layout
        The bins, and what votes for them.

    Returns
    -------
    numpy.ndarray
        ``(bins,) uint16`` counts that sum to `TOTAL`; slice, shell, sector, the sector fastest.

    Raises
    ------
    ValueError
        If there are no points, or some are not finite.
    """
    votes, _ = gather_votes(points, layout.cell_m)
    return np.asarray(describe_votes(votes, (base_z,), layout)[0])


def gather_votes(
    points: NDArray[np.floating], cell_m: float, counts: NDArray[np.int64] | None = None
) -> tuple[F64, NDArray[np.int64]]:
    """Gather points by cubic cells, whose corners are multiples of their side.

    Votes gathered before may be gathered again together with others, `counts` points each: parts of an object need
    their points read but once.

    Parameters
    ----------
    points
        ``(n, 3)``, metres, n >= 1.
    cell_m
        Side of a cell; 0 for none, which gives the points back.
    counts
        ``(n,)`` how many points each stands for; one if None.

    Returns
    -------
    votes
        ``(m, 3) float64`` mean of the points of each cell, metres.
    counts
        ``(m,) int64`` their number.

    Raises
    ------
    ValueError
        If there are no points, or some are not finite.
    """
    if len(points) == 0 or not np.isfinite(points).all():
        raise ValueError("a descriptor needs at least one point, and finite ones")
    positions = np.asarray(points, dtype=np.float64)
    number = np.ones(len(points), dtype=np.int64) if counts is None else counts
    if cell_m <= 0:
        return positions, number
    cells = np.floor(positions / cell_m).astype(np.int64)
    cells -= cells.min(axis=0)
    extent = cells.max(axis=0) + 1
    keys = (cells[:, 2] * extent[1] + cells[:, 1]) * extent[0] + cells[:, 0]
    _, cell = np.unique(keys, return_inverse=True)
    total = np.bincount(cell, weights=number)
    sums = [np.bincount(cell, weights=positions[:, axis] * number) for axis in range(3)]
    return np.column_stack(sums) / total[:, None], total.astype(np.int64)


def describe_votes(votes: F64, bases_z: Sequence[float], layout: Layout = DEFAULT_LAYOUT) -> NDArray[np.uint16]:
    """Describe a shape by its votes, once for each base.

    Parameters
    ----------
    votes
        ``(m, 3)`` metres, as `gather_votes` gives them.
    bases_z
        Heights of the lower end, B of them.
    layout
        The bins.

    Returns
    -------
    numpy.ndarray
        ``(B, bins) uint16``.
    """
    x, y = (votes[:, :2] - votes[:, :2].mean(axis=0)).T
    radius = np.hypot(x, y) / layout.shell_width_m
    turn = np.arctan2(y, x) * (layout.sectors / (2 * np.pi))
    described = []
    for base in bases_z:
        height = (votes[:, 2] - base) / layout.slice_height_m
        histogram = np.zeros(layout.shape)
        if layout.interpolate:
            _share(height, radius, turn, _weights(radius, layout), histogram)
        else:
            _count(height, radius, turn, _weights(radius, layout), histogram)
            histogram = _box_filter(histogram)
        filled = histogram > 0
        histogram[filled] **= layout.exponent
        described.append(quantise(histogram.ravel()))
    return np.stack(described)


def _weights(radius: F64, layout: Layout) -> F64:
    """Weight of each vote (Eq. 8); `radius` counts shells."""
    if not layout.annulus_weight:
        return np.ones(len(radius))
    shell = np.minimum(np.floor(radius), layout.shells - 1)
    return np.asarray(1.0 / (2 * shell + 1))


def _count_votes(height: F64, radius: F64, turn: F64, weights: F64, histogram: F64) -> None:
    """Give each vote to the bin it lies in; heights, radii and angles are in bins, the histogram is changed."""
    slices, shells, sectors = histogram.shape
    for i in range(len(height)):
        s = min(max(math.floor(height[i]), 0), slices - 1)
        r = min(math.floor(radius[i]), shells - 1)
        histogram[s, r, math.floor(turn[i]) % sectors] += weights[i]


def _share_votes(height: F64, radius: F64, turn: F64, weights: F64, histogram: F64) -> None:
    """Share each vote by the eight bins whose middles are nearest (trilinear); else as `_count_votes`."""
    slices, shells, sectors = histogram.shape
    for i in range(len(height)):
        s0, r0, a0 = math.floor(height[i] - 0.5), math.floor(radius[i] - 0.5), math.floor(turn[i] - 0.5)
        ds, dr, da = height[i] - 0.5 - s0, radius[i] - 0.5 - r0, turn[i] - 0.5 - a0
        for upper in range(2):
            s = min(max(s0 + upper, 0), slices - 1)
            in_slice = weights[i] * (ds if upper else 1 - ds)
            for outer in range(2):
                r = min(max(r0 + outer, 0), shells - 1)
                in_ring = in_slice * (dr if outer else 1 - dr)
                histogram[s, r, a0 % sectors] += in_ring * (1 - da)
                histogram[s, r, (a0 + 1) % sectors] += in_ring * da


_count = njit(cache=True, nogil=True)(_count_votes)
_share = njit(cache=True, nogil=True)(_share_votes)


def _box_filter(histogram: F64) -> F64:
    """Sum over 3 × 3 × 3 bins (Eq. 9); the outermost slice and shell repeat, sectors wrap."""
    padded = np.pad(histogram, ((1, 1), (1, 1), (0, 0)), mode="edge")
    padded = np.pad(padded, ((0, 0), (0, 0), (1, 1)), mode="wrap")
    for axis in range(3):
        size = padded.shape[axis]
        before, here, after = (padded.take(np.arange(step, size - 2 + step), axis=axis) for step in range(3))
        padded = before + here + after
    return padded
