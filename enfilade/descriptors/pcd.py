"""Positions in PCD files."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from enfilade.errors import InputError
from enfilade.formats.pcd import read_pcd_header, read_pcd_tables

_AT_ONCE: Final = 1 << 18


def read_pcd(path: Path) -> NDArray[np.float64]:
    """Read positions.

    Returns
    -------
    numpy.ndarray
        ``(n, 3) float64``; points with a coordinate that is not a number, which PCD uses for "nothing seen", left out.

    Raises
    ------
    InputError
        If the file is damaged, cut off or has no positions.
    """
    try:
        with path.open("rb") as file:
            header = read_pcd_header(file)
            tables = list(read_pcd_tables(file, header, _AT_ONCE))
            points = [np.column_stack([table[axis] for axis in "xyz"]).astype(np.float64) for table in tables]
    except (LookupError, ValueError, TypeError, OverflowError, MemoryError) as error:
        raise InputError(f"{path} cannot be read: it is damaged, or no PCD file with x, y and z.") from error
    if sum(len(table) for table in tables) < header.count:
        raise InputError(f"{path} is cut off: it should hold {header.count} points.")
    positions = np.concatenate(points) if points else np.empty((0, 3))
    return positions[np.isfinite(positions).all(axis=1)]
