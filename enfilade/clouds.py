"""The labelled cloud: a building's thinned points with storey, room, object, plane and scan.

Written as binary little endian PLY, ``x y z`` double in the scans' own coordinates, then int32 ``storey room
object plane scan``: the numbers of the ids (``r12`` is 12), -1 for none. Sorted by room, then object, so that
one room or object is one contiguous read.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, cast

import numpy as np
from numpy.typing import NDArray

from enfilade.atomic import replacing
from enfilade.errors import InputError, StoreError
from enfilade.formats.ply_header import PlyHeader, read_ply_header

LABELS: Final = ("storey", "room", "object", "plane", "scan")

_POSITION: Final = tuple((axis, "<f8") for axis in "xyz")
_LABEL: Final = tuple((label, "<i4") for label in LABELS)
_INTENSITY: Final = (("intensity", "<f4"),)
_COLOUR: Final = tuple((channel, "u1") for channel in ("red", "green", "blue"))
_PLY_NAMES: Final = {"<f8": "double", "<f4": "float", "<i4": "int", "u1": "uchar"}
_SORTED: Final = "enfilade cloud, sorted by room, object"
_CHUNK: Final = 1_000_000
_AHEAD: Final = 2


@dataclass(frozen=True, slots=True)
class LabelledCloud:
    """Points and what each belongs to.

    Attributes
    ----------
    positions
        ``(N, 3) float64``, metres, in the scans' own coordinates.
    storey, room, object, plane, scan
        ``(N,) int32``, numbers of the ids, -1 for none.
    intensity
        ``(N,) float32`` as the scans' files have it, NaN where a scan had none; None where no scan had.
    colour
        ``(N, 3) uint8`` red, green, blue, black where a scan had none; None where no scan had.
    """

    positions: NDArray[np.float64]
    storey: NDArray[np.int32]
    room: NDArray[np.int32]
    object: NDArray[np.int32]
    plane: NDArray[np.int32]
    scan: NDArray[np.int32]
    intensity: NDArray[np.float32] | None = field(default=None, kw_only=True)
    colour: NDArray[np.uint8] | None = field(default=None, kw_only=True)

    def __len__(self) -> int:
        return len(self.positions)

    def take(self, chosen: NDArray[np.bool_] | slice) -> LabelledCloud:
        """Return the points that a mask or a slice chooses."""
        return LabelledCloud(
            self.positions[chosen],
            *(getattr(self, label)[chosen] for label in LABELS),
            intensity=None if self.intensity is None else self.intensity[chosen],
            colour=None if self.colour is None else self.colour[chosen],
        )


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
            file.write(_header(cloud))
            for vertices in _in_chunks(cloud, order):
                vertices.tofile(file)
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


def _fields(cloud: LabelledCloud) -> list[tuple[str, str]]:
    """Name and type of each property of a vertex."""
    intensity = () if cloud.intensity is None else _INTENSITY
    return [*_POSITION, *_LABEL, *intensity, *(() if cloud.colour is None else _COLOUR)]


def _header(cloud: LabelledCloud) -> bytes:
    """Return the PLY header of a cloud."""
    properties = [f"property {_PLY_NAMES[type]} {name}" for name, type in _fields(cloud)]
    vertices = f"element vertex {len(cloud)}"
    lines = ["ply", "format binary_little_endian 1.0", f"comment {_SORTED}", vertices, *properties, "end_header"]
    return ("\n".join(lines) + "\n").encode("ascii")


def _in_chunks(cloud: LabelledCloud, order: NDArray[np.intp]) -> Iterator[NDArray[np.void]]:
    """Yield the points as PLY vertices; while one chunk is used, the next ones are made."""
    with ThreadPoolExecutor(_AHEAD) as workers:
        waiting: deque[Future[NDArray[np.void]]] = deque()
        for start in range(0, len(order), _CHUNK):
            waiting.append(workers.submit(_vertices, cloud, order[start : start + _CHUNK]))
            if len(waiting) > _AHEAD:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()


def _vertices(cloud: LabelledCloud, chosen: NDArray[np.intp]) -> NDArray[np.void]:
    """Return the chosen points as PLY vertices."""
    vertices = np.empty(len(chosen), dtype=_fields(cloud))
    for axis, (name, _) in enumerate(_POSITION):
        vertices[name] = cloud.positions[chosen, axis]
    for label in LABELS:
        vertices[label] = getattr(cloud, label)[chosen]
    if cloud.intensity is not None:
        vertices["intensity"] = cloud.intensity[chosen]
    if cloud.colour is not None:
        for channel, (name, _) in enumerate(_COLOUR):
            vertices[name] = cloud.colour[chosen, channel]
    return vertices


def _cloud(vertices: NDArray[np.void]) -> LabelledCloud:
    """Copy vertices, which may lie on disk, into the arrays of a cloud."""
    names = vertices.dtype.names or ()
    channels = [name for name, _ in _COLOUR]
    is_coloured = all(name in names and vertices.dtype[name] == np.uint8 for name in channels)
    return LabelledCloud(
        np.column_stack([vertices[name] for name in "xyz"]).astype(np.float64, copy=False),
        *(vertices[label].astype(np.int32) for label in LABELS),
        intensity=vertices["intensity"].astype(np.float32) if "intensity" in names else None,
        colour=np.column_stack([vertices[name] for name in channels]) if is_coloured else None,
    )


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
            header = read_ply_header(file, path)
        size = path.stat().st_size
    except FileNotFoundError as error:
        raise InputError(f"There is no labelled cloud {path}; ingest the building again to make it.") from error
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror or error}.") from error
    count, vertex = _vertex_of(header, path)
    if size < header.start + count * vertex.itemsize:
        raise InputError(f"{path} is truncated: it should hold {count} points; ingest the building again.")
    if count == 0:
        return np.empty(0, dtype=vertex), True
    vertices = np.memmap(path, dtype=vertex, mode="r", offset=header.start, shape=(count,))
    return vertices, _SORTED in header.comments


def _vertex_of(header: PlyHeader, path: Path) -> tuple[int, np.dtype[np.void]]:
    """Return the number of vertices and their layout; the order of properties is free, more may be there."""
    if header.form != "binary_little_endian":
        raise InputError(f"{path} is no labelled cloud: that is a binary little endian PLY file.")
    if not header.elements or header.elements[0].name != "vertex" or header.elements[0].count < 0:
        raise InputError(f"{path} is no labelled cloud: its first element is no list of vertices.")
    vertex = header.elements[0]
    if not vertex.is_plain:
        raise InputError(f"{path} is no labelled cloud: its vertices have properties that are not plain numbers.")
    names = [name for name, _ in vertex.properties]
    missing = [name for name in ("x", "y", "z", *LABELS) if name not in names]
    if missing:
        raise InputError(f"{path} is no labelled cloud: its points have no {', '.join(missing)}.")
    return vertex.count, np.dtype([(name, f"<{type}") for name, type in vertex.properties])
