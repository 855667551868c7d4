"""LAS and LAZ: points of a moving scanner with its trajectory, or of one that stood still at a given position."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import laspy
import lazrs
import numpy as np

from enfilade.errors import InputError
from enfilade.ingest.records import I32, U8, Chunk, Scan

from .columns import chunk_of
from .faults import naming_faults
from .placing import CHUNK
from .trajectory import Trajectory
from .whereabouts import Whereabouts

_NATIVE = (laspy.LaspyException, lazrs.LazrsError)
_WIDE_COLOUR = 255


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
    with path.open("rb") as stream, laspy.open(stream, closefd=False) as file:
        if file.header.point_count == 0:
            raise InputError(f"{path} has no points: export it again")
        chunks = _chunks(path, file)
        trajectory = whereabouts.trajectory
        if trajectory is None:
            position = whereabouts.scanner(path, path.stem, None)
            yield Scan(path.stem, path.name, (chunk for chunk, _ in chunks), position)
        else:
            yield from _stations(path, chunks, trajectory, whereabouts)


@naming_faults("LAS", native=_NATIVE)
def _chunks(path: Path, file: Any) -> Iterator[tuple[Chunk, Any]]:
    """Chunks, and the points' times, ``(n,) float64``, or None where they have none."""
    left, names = file.header.point_count, set(file.header.point_format.dimension_names)
    is_wide: bool | None = None
    for points in file.chunk_iterator(CHUNK):
        left -= len(points)
        if "withheld" in names:
            points = points[np.asarray(points.withheld) == 0]
        positions = np.column_stack([np.asarray(points.x), np.asarray(points.y), np.asarray(points.z)])
        colour = None
        if "red" in names:
            channels = np.column_stack([points.red, points.green, points.blue])
            is_wide = bool(channels.max(initial=0) > _WIDE_COLOUR) if is_wide is None else is_wide
            colour = _bytes(channels, is_wide)
        finite = np.isfinite(positions).all(axis=1)
        time = np.asarray(points.gps_time, np.float64)[finite] if "gps_time" in names else None
        yield chunk_of(positions, np.asarray(points.intensity), colour), time
    if left > 0:
        raise InputError(f"{path} is cut off: {left} of its {file.header.point_count} points are missing; export it again")


def _bytes(channels: Any, is_wide: bool) -> U8:
    """Colours of 16 bits as they should be, or of 8 as many programs write them."""
    return np.asarray(np.minimum(channels >> 8 if is_wide else channels, 255), np.uint8)


def _stations(
    path: Path, chunks: Iterator[tuple[Chunk, Any]], trajectory: Trajectory, whereabouts: Whereabouts
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
    for number, members in zip(numbers.tolist(), np.split(order, starts[1:]), strict=True):
        intensity = None if chunk.intensity is None else chunk.intensity[members]
        colour = None if chunk.colour is None else chunk.colour[members]
        yield number, Chunk(chunk.positions[members], intensity, colour)
