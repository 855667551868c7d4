"""PLY: one scan a file, text or binary, without a scanner position."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from enfilade.errors import InputError
from enfilade.formats import read_rows
from enfilade.formats.number_lines import NumberLines
from enfilade.formats.ply_header import Element, PlyHeader, read_ply_header
from enfilade.ingest.records import Chunk, Scan

from .columns import named_chunk
from .faults import naming_faults
from .placing import CHUNK
from .whereabouts import Whereabouts

_ORDER: Final = {"ascii": "<", "binary_little_endian": "<", "binary_big_endian": ">"}


@naming_faults("PLY")
def read(path: Path, whereabouts: Whereabouts) -> Iterator[Scan]:
    """Read the vertices of a PLY file as one scan, named as the file; the user has to tell its scanner's position.

    Raises
    ------
    InputError
        The file is damaged, cut off or empty, its vertices have no x, y, z or no finite ones, or nothing tells where
        the scanner stood.
    """
    with path.open("rb") as file:
        header = read_ply_header(file, path)
        vertex = _vertex(header, path)
        position = whereabouts.scanner(path, path.stem, None)
        _skip_before(file, header)
        yield Scan(path.stem, path.name, _chunks(path, file, header.form, vertex), position)


def _vertex(header: PlyHeader, path: Path) -> Element:
    if header.form not in _ORDER:
        raise InputError(f"{path} is of the PLY form {header.form!r}, which is unknown: export it as binary PLY")
    vertex = next((element for element in header.elements if element.name == "vertex"), None)
    if vertex is None or vertex.count <= 0:
        raise InputError(f"{path} has no points: export it again")
    if not vertex.is_plain or any(axis not in dict(vertex.properties) for axis in "xyz"):
        raise InputError(f"{path} cannot be read as PLY: its vertices are not x, y, z and other plain numbers")
    return vertex


def _skip_before(file: BinaryIO, header: PlyHeader) -> None:
    """Pass by what stands before the vertices."""
    for element in header.elements:
        if element.name == "vertex":
            return
        if not element.is_plain or element.count < 0:
            raise ValueError(f"lists of {element.name!r} stand before the vertices")
        if header.form == "ascii":
            for _ in range(element.count):
                if not file.readline():
                    return
        else:
            file.seek(element.count * _row(element, header.form).itemsize, 1)


def _row(element: Element, form: str) -> np.dtype[np.void]:
    return np.dtype([(name, _ORDER[form] + type) for name, type in element.properties])


@naming_faults("PLY")
def _chunks(path: Path, file: BinaryIO, form: str, vertex: Element) -> Iterator[Chunk]:
    row = _row(vertex, form)
    lines = NumberLines(file) if form == "ascii" else None
    left, usable = vertex.count, 0
    while left > 0:
        table = _read_text(lines, left, row) if lines is not None else read_rows(file, row, min(left, CHUNK))
        if not len(table):
            raise InputError(f"{path} is cut off: {left} of its {vertex.count} points are missing; export it again")
        left -= len(table)
        chunk = named_chunk(table)
        usable += len(chunk.positions)
        yield chunk
    if usable == 0:
        raise InputError(f"{path} has no usable point: all {vertex.count} are NaN or infinite")


def _read_text(lines: NumberLines, left: int, row: np.dtype[np.void]) -> NDArray[np.void]:
    numbers = lines.rows(min(left, CHUNK), len(row.names or ()))
    table = np.empty(len(numbers), row)
    for column, name in enumerate(row.names or ()):
        kind = row[name]
        limits = np.iinfo(kind) if kind.kind in "ui" else None
        values = numbers[:, column]
        table[name] = values if limits is None else np.clip(np.nan_to_num(values), limits.min, limits.max)
    return table
