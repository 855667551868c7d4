"""Points thinned to one a cell."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

F64 = NDArray[np.float64]

_BITS: Final = 21


def thinned(points: F64, cell_m: float) -> F64:
    """Return the corners of the cells that points lie in, each once: ``(M, d)`` of ``(N, d)``, d 2 or 3.

    A cell is packed into one number of 63 bits, which sorts far faster than rows do; so all points must lie within
    2 million cells along each axis.
    """
    if not len(points):
        return points
    cells = np.round(points / cell_m).astype(np.int64)
    low = cells.min(axis=0)
    key = np.zeros(len(cells), np.int64)
    for axis in range(points.shape[1]):
        key = key << _BITS | (cells[:, axis] - low[axis])
    key = np.unique(key)
    columns = [key >> _BITS * place & (1 << _BITS) - 1 for place in reversed(range(points.shape[1]))]
    return np.asarray((np.column_stack(columns) + low) * cell_m)
