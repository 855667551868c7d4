"""From the points of an object to its descriptor (Eqs. 8-10)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from enfilade.schema.counts import quantise

from .layout import DEFAULT_LAYOUT, Layout

F64 = NDArray[np.float64]


def describe(points: NDArray[np.floating], base_z: float, layout: Layout = DEFAULT_LAYOUT) -> NDArray[np.uint16]:
    """Describe the shape of an object.

    Points outside the slices or shells count in the nearest one, sectors wrap, and the box filter of Eq. 9
    follows the same rules at the borders.

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
    if len(points) == 0 or not np.isfinite(points).all():
        raise ValueError("a descriptor needs at least one point, and finite ones")
    votes = _votes(np.asarray(points, dtype=np.float64), layout.cell_m)
    slice_, shell, sector = _bins(votes, base_z, layout)
    histogram = np.zeros(layout.shape)
    weights = 1.0 / (2 * shell + 1) if layout.annulus_weight else 1.0
    np.add.at(histogram, (slice_, shell, sector), weights)
    return quantise(_box_filter(histogram).ravel())


def _votes(points: F64, cell_m: float) -> F64:
    """Return one mean position a cubic cell, or the points themselves if the cell has no size."""
    if cell_m <= 0:
        return points
    cells = np.floor((points - points.min(axis=0)) / cell_m).astype(np.int64)
    extent = cells.max(axis=0) + 1
    keys = (cells[:, 2] * extent[1] + cells[:, 1]) * extent[0] + cells[:, 0]
    _, cell, count = np.unique(keys, return_inverse=True, return_counts=True)
    sums = [np.bincount(cell, weights=points[:, axis], minlength=len(count)) for axis in range(3)]
    return np.column_stack(sums) / count[:, None]


def _bins(votes: F64, base_z: float, layout: Layout) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Slice, shell and sector of each vote, around the vertical axis through their mean."""
    x, y = (votes[:, :2] - votes[:, :2].mean(axis=0)).T
    slice_ = np.floor((votes[:, 2] - base_z) / layout.slice_height_m).astype(np.int64)
    shell = np.floor(np.hypot(x, y) / layout.shell_width_m).astype(np.int64)
    sector = np.floor(np.arctan2(y, x) * (layout.sectors / (2 * np.pi))).astype(np.int64)
    return slice_.clip(0, layout.slices - 1), shell.clip(0, layout.shells - 1), sector % layout.sectors


def _box_filter(histogram: F64) -> F64:
    """Sum over 3 × 3 × 3 bins (Eq. 9); the outermost slice and shell repeat, sectors wrap."""
    padded = np.pad(histogram, ((1, 1), (1, 1), (0, 0)), mode="edge")
    padded = np.pad(padded, ((0, 0), (0, 0), (1, 1)), mode="wrap")
    for axis in range(3):
        size = padded.shape[axis]
        before, here, after = (padded.take(np.arange(step, size - 2 + step), axis=axis) for step in range(3))
        padded = before + here + after
    return padded
