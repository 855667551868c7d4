"""Lower bounds of the distance (Eq. 11) by merging bins.

The symmetric χ² is an f-divergence: where bins are merged it never grows. Summed over its sectors, a descriptor is the
same for every turn around the vertical axis; so the χ² of two such sums is at most their distance. Neighbouring
slices and shells merged two by two give a cheaper bound, which is at most that one.

Several views are bounded together by an *envelope*: the least and the greatest value that a merged bin takes in any of
them. A bin of the object that lies between adds nothing, one outside adds its term to the nearer end; as
(q - o)² / (q + o) grows with the distance of q from o on either side, that is at most the term of every view.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enfilade.parallel import in_slices
from enfilade.schema.counts import TOTAL

F32 = NDArray[np.float32]
U16 = NDArray[np.uint16]
Shape = tuple[int, int, int]

_HALF_ULP: Final = 2.0**-24
_ROWS_A_THREAD: Final = 1 << 15


def rings_of(counts: U16, shape: Shape) -> U16:
    """Merge the sectors: ``(n, bins)`` counts to ``(n, slices * shells)``, the shell fastest."""
    slices, shells, sectors = shape
    return np.asarray(counts.reshape(-1, slices * shells, sectors).sum(axis=2, dtype=np.uint16))


def blocks_of(rings: U16, shape: Shape) -> U16:
    """Merge neighbouring slices and shells two by two: ``(n, slices * shells)`` to ``(n, blocks)``."""
    slices, shells, _ = shape
    grid = rings.reshape(-1, slices, shells)
    grid = np.pad(grid, ((0, 0), (0, slices % 2), (0, shells % 2)))
    halves = grid.reshape(len(grid), (slices + 1) // 2, 2, (shells + 1) // 2, 2)
    return np.asarray(halves.sum(axis=(2, 4), dtype=np.uint16).reshape(len(grid), -1))


def envelope_of(merged: U16) -> tuple[F32, F32]:
    """Return the least and the greatest value of each merged bin over the views, ``(m,)`` each."""
    return merged.min(axis=0).astype(np.float32), merged.max(axis=0).astype(np.float32)


def slack(bins: int) -> float:
    """Return what rounding in float32 may add to a sum of so many terms, as a distance."""
    return 2.0 * (bins + 4) * _HALF_ULP


def envelope_bounds(envelope: tuple[F32, F32], merged: U16) -> F32:
    """Bound the distance of every row from the nearest of the views within an envelope.

    Parameters
    ----------
    envelope
        As `envelope_of` gives it.
    merged
        ``(n, m)`` merged counts of the objects.

    Returns
    -------
    numpy.ndarray
        ``(n,) float32``, at most the distance.
    """
    bounds = np.empty(len(merged), dtype=np.float32)
    less = np.float32(slack(merged.shape[1]))
    in_slices(_bound_all, len(merged), *envelope, merged, less, bounds, least=_ROWS_A_THREAD)
    return bounds


def envelope_bounds_of(envelope: tuple[F32, F32], merged: U16, rows: NDArray[np.int64]) -> F32:
    """Bound the distance of some rows, like `envelope_bounds`; ``(k,) float32``."""
    bounds = np.empty(len(rows), dtype=np.float32)
    less = np.float32(slack(merged.shape[1]))
    in_slices(_bound_some, len(rows), *envelope, merged, rows, less, bounds, least=_ROWS_A_THREAD)
    return bounds


def view_bounds_of(views: F32, merged: U16, rows: NDArray[np.int64]) -> F32:
    """Bound the distance of some rows view by view; the least of the views' bounds, ``(k,) float32``."""
    bounds = np.empty(len(rows), dtype=np.float32)
    less = np.float32(slack(merged.shape[1]))
    in_slices(_bound_views, len(rows), views, merged, rows, less, bounds, least=_ROWS_A_THREAD // len(views) + 1)
    return bounds


def _chi_square(low: F32, high: F32, merged: U16) -> np.float32:
    """χ² of one row's merged bins to an envelope, as a distance; all values are whole numbers."""
    total = np.float32(0)
    for j in range(merged.shape[0]):
        o = np.float32(merged[j])
        q = min(max(o, low[j]), high[j])
        apart = q - o
        total += apart * apart / max(q + o, np.float32(1))
    return total / np.float32(TOTAL)


# Sums in any order, so that they are done eight at a time: `slack` covers what that changes.
chi_square = njit(cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "nsz"})(_chi_square)


def _all_rows(first: int, past: int, low: F32, high: F32, merged: U16, less: np.float32, bounds: F32) -> None:
    for i in range(first, past):
        bounds[i] = chi_square(low, high, merged[i]) - less


def _some_rows(
    first: int, past: int, low: F32, high: F32, merged: U16, rows: NDArray[np.int64], less: np.float32, bounds: F32
) -> None:
    for k in range(first, past):
        bounds[k] = chi_square(low, high, merged[rows[k]]) - less


def _some_rows_by_view(
    first: int, past: int, views: F32, merged: U16, rows: NDArray[np.int64], less: np.float32, bounds: F32
) -> None:
    for k in range(first, past):
        least = chi_square(views[0], views[0], merged[rows[k]])
        for v in range(1, views.shape[0]):
            least = min(least, chi_square(views[v], views[v], merged[rows[k]]))
        bounds[k] = least - less


_bound_all = njit(cache=True, nogil=True)(_all_rows)
_bound_some = njit(cache=True, nogil=True)(_some_rows)
_bound_views = njit(cache=True, nogil=True)(_some_rows_by_view)
