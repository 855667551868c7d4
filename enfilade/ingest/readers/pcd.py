"""PCD (Point Cloud Library): one scan a file, its scanner in the header's viewpoint."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np

from enfilade.errors import InputError
from enfilade.formats.pcd import PcdHeader, Table, read_pcd_header, read_pcd_tables
from enfilade.ingest.records import F64, U8, Chunk, Scan

from .columns import chunk_of, named_chunk
from .faults import naming_faults
from .placing import CHUNK
from .whereabouts import Whereabouts


@naming_faults("PCD")
def read(path: Path, whereabouts: Whereabouts) -> Iterator[Scan]:
    """Read a PCD file as one scan, named as the file.

    The viewpoint is where the scanner stood, in the coordinates of the points, as the Point Cloud Library uses it. One
    at the origin, unturned, is what is written when none is known, and tells nothing.

    Raises
    ------
    InputError
        The file is damaged, cut off or empty, its points have no x, y, z or no finite ones, or nothing tells where the
        scanner stood.
    """
    with path.open("rb") as file:
        header = read_pcd_header(file)
        missing = [axis for axis in "xyz" if axis not in (header.row.names or ()) or header.row[axis].shape]
        if missing:
            raise ValueError(f"its points have no {', '.join(missing)}")
        if header.count == 0:
            raise InputError(f"{path} has no points: export it again")
        yield Scan(path.stem, path.name, _chunks(path, file, header), _scanner(path, header, whereabouts))


def _scanner(path: Path, header: PcdHeader, whereabouts: Whereabouts) -> F64:
    viewpoint = np.array(header.viewpoint)
    is_default = viewpoint.tolist() == [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
    return whereabouts.scanner(path, path.stem, None if is_default else viewpoint[:3])


@naming_faults("PCD")
def _chunks(path: Path, file: BinaryIO, header: PcdHeader) -> Iterator[Chunk]:
    left, usable = header.count, 0
    for table in read_pcd_tables(file, header, CHUNK):
        left -= len(table)
        chunk = _chunk(table)
        usable += len(chunk.positions)
        yield chunk
    if left > 0:
        raise InputError(f"{path} is cut off: {left} of its {header.count} points are missing; export it again")
    if usable == 0:
        raise InputError(f"{path} has no usable point: all {header.count} are NaN or infinite")


def _chunk(table: Table) -> Chunk:
    names = table.dtype.names or ()
    packed = next((name for name in ("rgb", "rgba") if name in names and table.dtype[name].itemsize == 4), None)
    if packed is None:
        return named_chunk(table)
    positions = np.stack([table[axis] for axis in "xyz"], axis=1).astype(np.float64)
    return chunk_of(positions, table["intensity"] if "intensity" in names else None, _unpacked(table, packed))


def _unpacked(table: Table, name: str) -> U8:
    """Colours from one number of 32 bits, which may be called a float: blue in the lowest byte."""
    number = np.ascontiguousarray(table[name]).view(np.uint32)
    return np.stack([number >> 16 & 255, number >> 8 & 255, number & 255], axis=1).astype(np.uint8)
