"""LAS and LAZ: points of a moving scanner with its trajectory, or of one that stood still at a given position."""

from __future__ import annotations

import struct
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import laspy
import numpy as np

from enfilade.errors import InputError
from enfilade.ingest.records import F64, I32, U8, Chunk, Scan

from . import las_points
from .columns import chunk_of
from .faults import naming_faults
from .las_points import Columns, read_columns, receive_columns
from .placing import CHUNK, usable
from .trajectory import Trajectory
from .whereabouts import Whereabouts

_NATIVE: Final = (laspy.LaspyException,)
_WIDE_COLOUR: Final = 255
_HEADER: Final = struct.Struct("<25xB70xII B H I 124x Q I Q")
"""Minor version, start of points, records, point format, length of a point, points; start and number of the records
after the points, points (these three since version 1.4)."""
_RECORD, _MORE_RECORD = 54, 60
_PACKED: Final = 0x80
_LEAST_PACKED: Final = 0.05


@naming_faults("LAS", native=_NATIVE)
def read(path: Path, whereabouts: Whereabouts) -> Iterator[Scan]:
    """Read a LAS or LAZ file.

    With a trajectory each point belongs to the place of it where the scanner was at the point's time; the places are
    the scans, met again and again as the points come. Without, the file is one scan, and the user has to tell its
    scanner's position.

    Raises
    ------
    InputError
        The file is damaged, cut off or empty, its points have no time that the trajectory covers, or nothing tells
        where the scanner was.
    """
    count, is_packed = _checked_header(path)
    if count == 0:
        raise InputError(f"{path} has no points: export it again")
    chunks = _chunks(path, count, is_packed)
    trajectory = whereabouts.trajectory
    if trajectory is None:
        position = whereabouts.scanner(path, path.stem, None)
        yield Scan(path.stem, path.name, (chunk for chunk, _ in chunks), position)
    else:
        yield from _stations(path, chunks, trajectory, whereabouts)


def _checked_header(path: Path) -> tuple[int, bool]:
    """Return how many points there are and whether they are compressed.

    Raises ValueError where a header claims more than the file can hold: the library would count it all.
    """
    size = path.stat().st_size
    with path.open("rb") as stream:
        head = stream.read(_HEADER.size).ljust(_HEADER.size, b"\0")
    minor, start, records, form, length, old_count, more_start, more_records, count = _HEADER.unpack(head)
    is_new, is_packed = minor >= 4, bool(form & _PACKED)
    points = count if is_new else old_count
    least = _LEAST_PACKED if is_packed else length
    if start > size or records * _RECORD > start or points * least > size - start:
        raise ValueError("it is cut off, or its header claims more points or records than there are")
    if is_new and more_records and (more_start > size or more_records * _MORE_RECORD > size - more_start):
        raise ValueError("it is cut off, or its header claims more records at its end than there are")
    return points, is_packed


@naming_faults("LAS", native=_NATIVE)
def _chunks(path: Path, count: int, is_packed: bool) -> Iterator[tuple[Chunk, F64 | None]]:
    """Chunks, and the points' times, ``(n,) float64``, or None where they have none."""
    left, is_wide = count, False
    for columns in _unpacked(path) if is_packed else read_columns(path, CHUNK):
        colour = columns.get("rgb")
        if colour is not None and left == count:
            is_wide = bool(colour.max(initial=0) > _WIDE_COLOUR)
        left -= len(columns["xyz"])
        chunk = chunk_of(columns["xyz"], columns["intensity"], None if colour is None else _bytes(colour, is_wide))
        yield chunk, columns["time"][usable(columns["xyz"])] if "time" in columns else None
    if left > 0:
        raise InputError(f"{path} is cut off: {left} of its {count} points are missing; export it again")


def _unpacked(path: Path) -> Iterator[Columns]:
    """Let a child unpack the points, which a damaged file may end."""
    command = [sys.executable, "-P", las_points.__file__, str(path), str(CHUNK)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as child:
        try:
            assert child.stdout is not None
            yield from receive_columns(child.stdout)
        finally:
            child.kill()


def _bytes(channels: Any, is_wide: bool) -> U8:
    """Colours of 16 bits as they should be, or of 8 as many programs write them."""
    return np.asarray(np.minimum(channels >> 8 if is_wide else channels, 255), np.uint8)


def _stations(
    path: Path, chunks: Iterator[tuple[Chunk, F64 | None]], trajectory: Trajectory, whereabouts: Whereabouts
) -> Iterator[Scan]:
    inside, total = 0, 0
    for chunk, time in chunks:
        if time is None:
            raise InputError(f"the points of {path} have no GPS time to find them on the trajectory {trajectory.name}")
        station = trajectory.stations(time)
        total += len(station)
        inside += int(np.count_nonzero(station >= 0))
        for number, part in _parts(chunk, station):
            yield Scan(trajectory.station_name(number), trajectory.name, (part,), trajectory.positions[number])
    if inside == 0:
        raise InputError(
            f"no point of {path} was measured while the trajectory {trajectory.name} was recorded ({trajectory.span}): "
            "give that of this file, with the same clock"
        )
    if inside < total:
        whereabouts.say(
            f"{total - inside} of the {total} points of {path} were left out: the trajectory {trajectory.name} does "
            "not cover their times"
        )


def _parts(chunk: Chunk, station: I32) -> Iterator[tuple[int, Chunk]]:
    """Cut a chunk by station; points of none are left out."""
    order = np.argsort(station, kind="stable")
    order = order[np.searchsorted(station[order], 0) :]
    numbers, starts = np.unique(station[order], return_index=True)
    for number, start, stop in zip(numbers.tolist(), starts, [*starts[1:], len(order)], strict=False):
        members = order[start:stop]
        intensity = None if chunk.intensity is None else chunk.intensity[members]
        colour = None if chunk.colour is None else chunk.colour[members]
        yield number, Chunk(chunk.positions[members], intensity, colour)
