"""PCD files (Point Cloud Library), a chunk at a time: text, binary and compressed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO, Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from . import read_rows
from .number_lines import NumberLines

Table = NDArray[np.void]

_TYPES: Final = {("F", 4), ("F", 8), *((kind, size) for kind in "IU" for size in (1, 2, 4, 8))}
_LONGEST_HEADER: Final = 20_000
_MOST_GROWTH: Final = 300


@dataclass(frozen=True, slots=True)
class PcdHeader:
    """What the header says.

    Attributes
    ----------
    row
        Columns; a name that comes again, as padding does, has its place behind it; a field of several numbers is one
        column of that shape.
    count
        Points.
    form
        ``ascii``, ``binary`` or ``binary_compressed``.
    viewpoint
        Where the scanner stood and how it was turned: x y z, then a quaternion, w first.
    """

    row: np.dtype[np.void]
    count: int
    form: str
    viewpoint: tuple[float, ...]


def read_pcd_header(file: BinaryIO) -> PcdHeader:
    """Read the header of an opened PCD file.

    Raises
    ------
    ValueError, LookupError
        It is no PCD header.
    """
    words: dict[str, list[str]] = {}
    for line in iter(lambda: file.readline(_LONGEST_HEADER), b""):
        name, *rest = line.decode("ascii", errors="replace").split() or [""]
        words[name] = rest
        if name == "DATA":
            return _parse(words)
        if len(words) > 50:
            break
    raise ValueError("its header has no end")


def _parse(words: dict[str, list[str]]) -> PcdHeader:
    names = words["FIELDS"]
    counts = [int(count) for count in words.get("COUNT", ["1"] * len(names))]
    types = [(kind, int(size)) for kind, size in zip(words["TYPE"], words["SIZE"], strict=True)]
    if not set(types) <= _TYPES or any(not 0 < count <= 10_000 for count in counts):
        raise ValueError("its fields have types or counts that do not exist")
    taken = [name if names.index(name) == at else f"{name} {at}" for at, name in enumerate(names)]
    row = [
        (name, f"<{kind.lower()}{size}", () if count == 1 else (count,))
        for name, (kind, size), count in zip(taken, types, counts, strict=True)
    ]
    points = words["POINTS"] if "POINTS" in words else [str(int(words["WIDTH"][0]) * int(words["HEIGHT"][0]))]
    viewpoint = tuple(float(number) for number in words.get("VIEWPOINT", [])) or (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    if int(points[0]) < 0 or len(viewpoint) != 7:
        raise ValueError("its number of points or its viewpoint makes no sense")
    return PcdHeader(np.dtype(row), int(points[0]), words["DATA"][0], viewpoint)


def read_pcd_tables(file: BinaryIO, header: PcdHeader, most: int) -> Iterator[Table]:
    """Yield the points after the header, at most `most` at once; fewer in all where the file is cut off.

    Compressed points lie column by column and are taken out of the file as a whole.

    Raises
    ------
    ValueError
        The points are damaged, or of an unknown form.
    """
    if header.form == "binary_compressed":
        whole = _decompressed(file, header)
        yield from (whole[start : start + most] for start in range(0, len(whole), most))
        return
    if header.form not in ("ascii", "binary"):
        raise ValueError(f"its data are {header.form!r}, which is unknown")
    lines = NumberLines(file) if header.form == "ascii" else None
    left = header.count
    while left > 0:
        table = (
            _from_text(lines, min(left, most), header.row) if lines else read_rows(file, header.row, min(left, most))
        )
        if not len(table):
            return
        left -= len(table)
        yield table


def _from_text(lines: NumberLines, count: int, row: np.dtype[np.void]) -> Table:
    shapes = [row[name].shape for name in row.names or ()]
    widths = [int(np.prod(shape)) for shape in shapes]
    numbers = lines.rows(count, sum(widths))
    table = np.empty(len(numbers), row)
    first = 0
    for name, shape, width in zip(row.names or (), shapes, widths, strict=True):
        values = numbers[:, first : first + width].reshape(-1, *shape)
        kind = row[name].base
        limits = np.iinfo(kind) if kind.kind in "ui" else None
        table[name] = values if limits is None else np.clip(np.nan_to_num(values), limits.min, limits.max)
        first += width
    return table


def _decompressed(file: BinaryIO, header: PcdHeader) -> Table:
    """Return all points of a compressed file (LZF, column by column)."""
    packed, unpacked = (int(size) for size in np.fromfile(file, "<u4", 2))
    if unpacked != header.count * header.row.itemsize or unpacked > _MOST_GROWTH * packed:
        raise ValueError("the sizes of its compressed points contradict its header")
    source = np.fromfile(file, np.uint8, packed)
    if len(source) < packed:
        raise ValueError("it is cut off")
    target = np.empty(unpacked, np.uint8)
    if _unpack(source, target) != unpacked:
        raise ValueError("its compressed points are damaged")
    table = np.empty(header.count, header.row)
    start = 0
    for name in header.row.names or ():
        size = header.row[name].itemsize * header.count
        table[name] = target[start : start + size].view(header.row[name].base).reshape(-1, *header.row[name].shape)
        start += size
    return table


@njit(cache=True, nogil=True)
def _unpack(source, target):  # type: ignore[no-untyped-def]
    """LZF: returns how many bytes were written, or -1 where the source makes no sense."""
    at, to = 0, 0
    while at < len(source):
        control = int(source[at])
        at += 1
        if control < 32:
            length = control + 1
            if at + length > len(source) or to + length > len(target):
                return -1
            target[to : to + length] = source[at : at + length]
            at += length
            to += length
            continue
        length = control >> 5
        if length == 7:
            if at >= len(source):
                return -1
            length += int(source[at])
            at += 1
        if at >= len(source):
            return -1
        back = to - ((control & 31) << 8) - int(source[at]) - 1
        at += 1
        length += 2
        if back < 0 or to + length > len(target):
            return -1
        for i in range(length):
            target[to + i] = target[back + i]
        to += length
    return to
