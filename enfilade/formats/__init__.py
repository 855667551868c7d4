"""Pieces of file formats that several parts of the package read: PLY headers, PCD, lines of numbers."""

from __future__ import annotations

import os
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray


def read_rows(file: BinaryIO, row: np.dtype[np.void], count: int) -> NDArray[np.void]:
    """Read up to `count` rows of a table; fewer where the file ends, whatever its header claims."""
    left = os.fstat(file.fileno()).st_size - file.tell()
    return np.fromfile(file, row, max(0, min(count, left // max(row.itemsize, 1))))
