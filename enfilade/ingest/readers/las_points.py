"""The points of LAS and LAZ files as arrays; also a program of its own, which writes them to standard output.

The library that unpacks LAZ ends the whole process at some damaged files (it asks for more memory than there is), so
compressed files are unpacked by a child. To start quickly it imports nothing of this package.
"""

from __future__ import annotations

import json
import math
import resource
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any, BinaryIO, Final

import laspy
import numpy as np
from numpy.typing import NDArray

Columns = dict[str, NDArray[Any]]

_MOST_MEMORY: Final = 4 << 30
_MOST_SAID: Final = 200


def read_columns(path: Path, most: int) -> Iterator[Columns]:
    """Yield ``xyz`` (n, 3), ``intensity`` and where there are any ``rgb`` (n, 3) and ``time``, at most `most` at once.

    Withheld points are there, with coordinates that are no numbers.
    """
    with path.open("rb") as stream, laspy.open(stream, closefd=False) as file:
        names = set(file.header.point_format.dimension_names)
        for points in file.chunk_iterator(most):
            xyz = np.column_stack([np.asarray(points.x), np.asarray(points.y), np.asarray(points.z)])
            if "withheld" in names:
                xyz[np.asarray(points.withheld) != 0] = np.nan
            columns = {"xyz": xyz, "intensity": np.asarray(points.intensity)}
            if "red" in names:
                columns["rgb"] = np.column_stack([points.red, points.green, points.blue])
            if "gps_time" in names:
                columns["time"] = np.asarray(points.gps_time, np.float64)
            yield columns


def receive_columns(stream: IO[bytes]) -> Iterator[Columns]:
    """Yield what `send_columns` wrote.

    Raises
    ------
    ValueError
        The writer met a fault, or ended without a word.
    """
    for line in stream:
        said = json.loads(line)
        if "fault" in said:
            raise ValueError(said["fault"])
        if not said["columns"]:
            return
        yield {name: _receive(stream, *form) for name, form in said["columns"].items()}
    raise ValueError("its compressed points are damaged")


def _receive(stream: IO[bytes], type: str, shape: list[int]) -> NDArray[Any]:
    kind = np.dtype(type)
    size = kind.itemsize * math.prod(shape)
    content = stream.read(size)
    if len(content) < size:
        raise ValueError("its compressed points are damaged")
    return np.frombuffer(content, kind).reshape(shape)


def send_columns(path: Path, most: int, stream: BinaryIO) -> None:
    """Write the points of a file to a stream, and at the end that it was the end, or what went wrong."""
    try:
        for columns in read_columns(path, most):
            forms = {name: (column.dtype.str, column.shape) for name, column in columns.items()}
            stream.write(json.dumps({"columns": forms}).encode() + b"\n")
            for column in columns.values():
                stream.write(np.ascontiguousarray(column).data)
        last: dict[str, Any] = {"columns": {}}
    except BaseException as error:  # panics of the native library are no ordinary exceptions
        said = (str(error).strip().splitlines() or [""])[0][:_MOST_SAID]
        last = {"fault": said or "its compressed points are damaged"}
    stream.write(json.dumps(last).encode() + b"\n")
    stream.flush()


if __name__ == "__main__":
    resource.setrlimit(resource.RLIMIT_AS, (_MOST_MEMORY, _MOST_MEMORY))
    send_columns(Path(sys.argv[1]), int(sys.argv[2]), sys.stdout.buffer)
