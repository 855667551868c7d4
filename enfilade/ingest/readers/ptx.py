"""PTX (Leica): text, several posed scans a file, a line a point."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from enfilade.errors import InputError
from enfilade.formats.number_lines import NumberLines
from enfilade.ingest.records import F64, Chunk, Scan

from .faults import naming_faults
from .placing import CHUNK, compacted, place
from .whereabouts import Whereabouts

_HEADER_LINES: Final = (3, 3, 3, 3, 4, 4, 4, 4)
_WIDTHS: Final = (7, 6, 4, 3)
_LEAST_BYTES_A_POINT: Final = 6


@dataclass(frozen=True, slots=True)
class _Header:
    """Points of a scan, where its scanner stood, ``(3,)``, and its pose, ``(4, 4)`` by which rows are multiplied."""

    count: int
    scanner: F64
    pose: F64


@naming_faults("PTX")
def read(path: Path, whereabouts: Whereabouts) -> Iterator[Scan]:
    """Read the scans of a PTX file, one at a time, in the file's common coordinates.

    Points at 0 0 0, where nothing came back, are dropped.

    Raises
    ------
    InputError
        The file is damaged, cut off or empty, one of its scans has no usable point, or several scans have lost their
        position.
    """
    with path.open("rb") as file:
        lines = NumberLines(file)
        index = 0
        while (first := lines.text()) is not None:
            header = _header(first, lines, path)
            name = f"{path.stem} {index}"
            is_unturned = np.array_equal(header.pose, np.eye(4))
            is_lost = is_unturned and not header.scanner.any()
            scanner = header.scanner if is_unturned else header.pose[3, :3]
            position = whereabouts.scanner(path, name, scanner, is_default=is_lost)
            chunks = _chunks(path, lines, header, f"scan {name!r} of {path}")
            yield Scan(name, path.name, chunks, position)
            for _ in chunks:  # what was not asked for stands before the next scan
                pass
            index += 1


def _header(first: str, lines: NumberLines, path: Path) -> _Header:
    """Read the header whose first line, the number of columns, is read already."""
    rows = lines.text()
    if rows is None or not (first.isdecimal() and rows.isdecimal()):
        raise ValueError(f"line {lines.line - 1} should hold the number of columns or rows of a scan")
    count = int(first) * int(rows)
    if count > path.stat().st_size / _LEAST_BYTES_A_POINT:
        raise ValueError(f"line {lines.line - 1}: {first} x {rows} points are more than the file can hold")
    numbers = [lines.rows(1, width) for width in _HEADER_LINES]
    if any(len(row) != 1 for row in numbers):
        raise ValueError("it ends in the header of a scan")
    pose = np.concatenate(numbers[4:])
    scanner = numbers[0][0]
    if not (np.isfinite(pose).all() and np.isfinite(scanner).all()):
        raise ValueError(f"the pose before line {lines.line} is not of finite numbers")
    return _Header(count, scanner, pose)


@naming_faults("PTX")
def _chunks(path: Path, lines: NumberLines, header: _Header, what: str) -> Iterator[Chunk]:
    width = next((w for w in _WIDTHS if w <= lines.width()), 0)
    left, usable = header.count, 0
    while left > 0:
        table = lines.rows(min(left, CHUNK), width) if width else np.empty((0, 3))
        if not len(table):
            raise InputError(f"{what} is cut off: {left} of its {header.count} points are missing; export it again")
        left -= len(table)
        chunk = _chunk(table, header.pose)
        usable += len(chunk.positions)
        yield chunk
    if usable == 0:
        raise InputError(f"{what} has no usable point: all {header.count} are missing or no numbers")


def _chunk(table: F64, pose: F64) -> Chunk:
    x, y, z = (np.ascontiguousarray(column) for column in table[:, :3].T)
    nothing = np.asarray(~table[:, :3].any(axis=1), np.int8)
    rotation = np.ascontiguousarray(pose[:3, :3].T)
    positions, kept = place(x, y, z, nothing, False, rotation, np.ascontiguousarray(pose[3, :3]))
    width = table.shape[1]
    intensity = compacted(table[:, 3].astype(np.float32), kept) if width in (4, 7) else None
    colour = compacted(np.clip(np.nan_to_num(table[:, -3:]), 0, 255).astype(np.uint8), kept) if width >= 6 else None
    return Chunk(positions, intensity, colour)
