"""Square cells on a side, and masks of them."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enfilade.ingest.openings.crossings import BORDER_M
from enfilade.ingest.openings.edges import cells_of
from enfilade.ingest.records import F64, Bool
from enfilade.ingest.sides import Side


class Grid:
    """Square cells on a side and a little around it, by u, then v."""

    def __init__(self, side: Side, cell_m: float) -> None:
        self._cell_m: Final = cell_m
        self._corner = side.bounds[:2] - BORDER_M - cell_m
        self.shape = tuple(np.ceil((side.bounds[2:] + BORDER_M - self._corner) / cell_m).astype(int) + 1)

    def cells(self, places: F64) -> NDArray[np.int64]:
        """``(n,)`` index of the cell of each of ``(n, 2)`` places in the flattened grid."""
        return cells_of(places, self._corner, self._cell_m, self.shape[1])

    def marked(self, cells: NDArray[np.int64]) -> Bool:
        """Cells that are among those of some places."""
        mask = np.zeros(self.shape, dtype=bool)
        mask.reshape(-1)[cells] = True
        return mask

    def mostly(self, cells: NDArray[np.int64], others: NDArray[np.int64]) -> Bool:
        """Cells in which at least as many of some places lie as of others, and one at least."""
        count, other = (np.bincount(which, minlength=int(np.prod(self.shape))) for which in (cells, others))
        return np.asarray(((count > 0) & (count >= other)).reshape(self.shape))

    def centres(self, cells: Bool, corner: tuple[int, int] = (0, 0)) -> F64:
        """``(n, 2)`` middles of the marked cells of a part of the grid that begins at a corner."""
        return np.asarray((np.argwhere(cells) + corner + 0.5) * self._cell_m + self._corner, dtype=np.float64)

    def inner(self, side: Side) -> Bool:
        """Cells that lie within the bounds of the side."""
        within = [
            (centre > low) & (centre < high)
            for centre, low, high in (
                ((np.arange(count) + 0.5) * self._cell_m + corner, low, high)
                for count, corner, low, high in zip(
                    self.shape, self._corner, side.bounds[:2], side.bounds[2:], strict=True
                )
            )
        ]
        return np.asarray(within[0][:, None] & within[1][None, :])


def bridged(mask: Bool, cells: float) -> Bool:
    """Close gaps in a mask up to so many cells wide."""
    reach = max(round(cells / 2), 1)
    padded = np.pad(mask, reach + 1)
    closed = ~_spread(~_spread(padded, reach), reach)
    return np.asarray(closed[reach + 1 : -reach - 1, reach + 1 : -reach - 1], dtype=np.bool_)


def opened(mask: Bool) -> Bool:
    """Leave out of a mask what is less than three cells wide."""
    padded = np.pad(mask, 1)
    return np.asarray(_spread(~_spread(~padded, 1), 1)[1:-1, 1:-1], dtype=np.bool_)


def values(of_cell: NDArray[Any], cells: NDArray[np.int64]) -> NDArray[Any]:
    """Values of cells, given by their index in the flattened grid."""
    return np.asarray(of_cell.reshape(-1)[cells])


@njit(cache=True, nogil=True)
def _spread(mask, reach):  # type: ignore[no-untyped-def]
    """Mark all cells in squares of so many cells around the marked ones: along one axis, then the other."""
    rows, columns = mask.shape
    along, both = np.zeros_like(mask), np.zeros_like(mask)
    for i in range(rows):
        until = -1
        for j in range(columns):
            if mask[i, j]:
                for k in range(max(until + 1, j - reach), min(columns, j + reach + 1)):
                    along[i, k] = True
                until = min(columns, j + reach + 1) - 1
    for i in range(rows):
        for k in range(max(0, i - reach), min(rows, i + reach + 1)):
            for j in range(columns):
                if along[k, j]:
                    both[i, j] = True
    return both
