"""The labelled cloud: a building's thinned points with storey, room, object, plane and scan.

Written as binary little endian PLY, ``x y z`` double in the scans' own coordinates, then int32 ``storey room
object plane scan``: the numbers of the ids (``r12`` is 12), -1 for none. Sorted by room, then object, so that
one room or object is one contiguous read.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final, cast

import numpy as np
from numpy.typing import NDArray

from enfilade.atomic import replacing
from enfilade.errors import InputError, StoreError

LABELS: Final = ("storey", "room", "object", "plane", "scan")

_VERTEX: Final = np.dtype([*((axis, "<f8") for axis in "xyz"), *((label, "<i4") for label in LABELS)])
_SORTED: Final = "comment enfilade cloud, sorted by room, object"
_CHUNK: Final = 1_000_000
_LONGEST_HEADER: Final = 200
_LONGEST_LINE: Final = 500
_PLY_TYPES: Final = {
    "char": "<i1",
    "uchar": "<u1",
    "short": "<i2",
    "ushort": "<u2",
    "int": "<i4",
    "uint": "<u4",
    "int8": "<i1",
    "uint8": "<u1",
    "int16": "<i2",
    "uint16": "<u2",
    "int32": "<i4",
    "uint32": "<u4",
    "float": "<f4",
    "double": "<f8",
    "float32": "<f4",
    "float64": "<f8",
}


@dataclass(frozen=True, slots=True)
class LabelledCloud:
    """Points and what each belongs to.

    Attributes
    ----------
    positions
        ``(N, 3) float64``, metres, in the scans' own coordinates.
    storey, room, object, plane, scan
        ``(N,) int32``, numbers of the ids, -1 for none.
    """

    positions: NDArray[np.float64]
    storey: NDArray[np.int32]
    room: NDArray[np.int32]
    object: NDArray[np.int32]
    plane: NDArray[np.int32]
    scan: NDArray[np.int32]

    def __len__(self) -> int:
        return len(self.positions)

    def take(self, chosen: NDArray[np.bool_] | slice) -> LabelledCloud:
        """Return the points that a mask or a slice chooses."""
        return LabelledCloud(self.positions[chosen], *(getattr(self, label)[chosen] for label in LABELS))


def write_cloud(path: Path, cloud: LabelledCloud) -> None:
    """Write a labelled cloud, sorted by room, then object; the file appears whole or not at all.

    Raises
    ------
    StoreError
        If the file cannot be written.
    """
    order = np.lexsort((cloud.object, cloud.room))
    try:
        with replacing(path) as file:
            file.write(_header(len(cloud)))
            for start in range(0, len(order), _CHUNK):
                _vertices(cloud, order[start : start + _CHUNK]).tofile(file)
    except OSError as error:
        raise StoreError(f"{path} cannot be written: {error.strerror or error}.") from error


def read_cloud(path: Path) -> LabelledCloud:
    """Read a whole labelled cloud.

    Raises
    ------
    InputError
        If the file is missing, truncated, or no labelled cloud.
    """
    return _cloud(_open(path)[0])


def read_room(path: Path, room: int) -> LabelledCloud:
    """Read the points of one room (-1: of none); of a file that `write_cloud` wrote it touches nothing else.

    Raises
    ------
    InputError
        As `read_cloud`.
    """
    vertices, is_sorted = _open(path)
    return _cloud(_equal(vertices, "room", room, is_sorted))


def read_object(path: Path, room: int, object: int) -> LabelledCloud:
    """Read the points of one segment in a room; with -1 the room's points that belong to no object.

    Raises
    ------
    InputError
        As `read_cloud`.
    """
    vertices, is_sorted = _open(path)
    return _cloud(_equal(_equal(vertices, "room", room, is_sorted), "object", object, is_sorted))


def _header(count: int) -> bytes:
    """Return the PLY header of `count` vertices."""
    positions = [f"property double {axis}" for axis in "xyz"]
    labels = [f"property int {label}" for label in LABELS]
    vertices = f"element vertex {count}"
    lines = ["ply", "format binary_little_endian 1.0", _SORTED, vertices, *positions, *labels, "end_header"]
    return ("\n".join(lines) + "\n").encode("ascii")


def _vertices(cloud: LabelledCloud, chosen: NDArray[np.intp]) -> NDArray[np.void]:
    """Return the chosen points as PLY vertices."""
    vertices = np.empty(len(chosen), dtype=_VERTEX)
    for axis, name in enumerate("xyz"):
        vertices[name] = cloud.positions[chosen, axis]
    for label in LABELS:
        vertices[label] = getattr(cloud, label)[chosen]
    return vertices


def _cloud(vertices: NDArray[np.void]) -> LabelledCloud:
    """Copy vertices, which may lie on disk, into the arrays of a cloud."""
    positions = np.column_stack([vertices[name] for name in "xyz"]).astype(np.float64, copy=False)
    return LabelledCloud(positions, *(vertices[label].astype(np.int32) for label in LABELS))


def _equal(vertices: NDArray[np.void], label: str, number: int, is_sorted: bool) -> NDArray[np.void]:
    """Return the vertices with that number; bisection reads a few pages, not the file."""
    column = vertices[label]
    if not is_sorted:
        return np.asarray(vertices[column == number])
    # The type says that only lists can be bisected, but any sequence can.
    ordered = cast(Sequence[int], column)
    return vertices[bisect_left(ordered, number) : bisect_right(ordered, number)]


def _open(path: Path) -> tuple[NDArray[np.void], bool]:
    """Map a cloud file into memory: its vertices, and whether they are sorted."""
    try:
        with path.open("rb") as file:
            lines, start = _read_header(file, path)
        size = path.stat().st_size
    except FileNotFoundError as error:
        raise InputError(f"There is no labelled cloud {path}; ingest the building again to make it.") from error
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror or error}.") from error
    count, vertex = _parse_header(lines, path)
    if size < start + count * vertex.itemsize:
        raise InputError(f"{path} is truncated: it should hold {count} points; ingest the building again.")
    if count == 0:
        return np.empty(0, dtype=vertex), True
    return np.memmap(path, dtype=vertex, mode="r", offset=start, shape=(count,)), _SORTED in lines


def _read_header(file: BinaryIO, path: Path) -> tuple[list[str], int]:
    """Return the header's lines and where the vertices begin."""
    if file.read(4).rstrip() != b"ply":
        raise InputError(f"{path} is no labelled cloud: it does not begin as a PLY file does.")
    lines: list[str] = []
    while len(lines) < _LONGEST_HEADER:
        line = file.readline(_LONGEST_LINE)
        lines.append(line.decode("ascii", errors="replace").strip())
        if lines[-1] == "end_header":
            return lines, file.tell()
        if not line:
            break
    raise InputError(f"{path} is truncated or damaged: its header has no end; ingest the building again.")


def _parse_header(lines: list[str], path: Path) -> tuple[int, np.dtype[np.void]]:
    """Return the number of vertices and their layout; the order of properties is free, more may be there."""
    if "format binary_little_endian 1.0" not in lines:
        raise InputError(f"{path} is no labelled cloud: that is a binary little endian PLY file.")
    elements = [i for i, line in enumerate(lines) if line.startswith("element ")]
    words = lines[elements[0]].split() if elements else []
    if len(words) != 3 or words[1] != "vertex" or not words[2].isdecimal():
        raise InputError(f"{path} is no labelled cloud: its first element is no list of vertices.")
    last = elements[1] if len(elements) > 1 else len(lines)
    properties = [line.split() for line in lines[elements[0] : last] if line.startswith("property ")]
    fields = [(prop[-1], _PLY_TYPES[prop[1]]) for prop in properties if len(prop) == 3 and prop[1] in _PLY_TYPES]
    names = [name for name, _ in fields]
    if len(fields) != len(properties) or len(set(names)) != len(names):
        raise InputError(f"{path} is no labelled cloud: its vertices have properties that are not plain numbers.")
    missing = [name for name in ("x", "y", "z", *LABELS) if name not in names]
    if missing:
        raise InputError(f"{path} is no labelled cloud: its points have no {', '.join(missing)}.")
    return int(words[2]), np.dtype(fields)
