"""The way of a moving scanner, cut into places: each place is one scan, however often the scanner came by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enfilade.errors import InputError
from enfilade.formats.number_lines import NumberLines
from enfilade.ingest.records import F64, I32

_NAMES: Final = {
    "time": ("time", "t", "gps_time", "gpstime", "gps time", "timestamp", "sec", "seconds", "time[s]", "gps_seconds"),
    "x": ("x", "px", "pos_x", "x[m]", "east", "easting", "e"),
    "y": ("y", "py", "pos_y", "y[m]", "north", "northing", "n"),
    "z": ("z", "pz", "pos_z", "z[m]", "height", "altitude", "elevation", "h", "up"),
}
_WEEK_S: Final = 604_800.0
_ADJUSTED_S: Final = 1e9
_GAP_S: Final = 1.0
_MOST_STATIONS: Final = 20_000
_ROWS: Final = 1 << 16
_STEP: Final = 0.05


@dataclass(frozen=True, slots=True)
class Trajectory:
    """Where a scanner was at which time.

    Attributes
    ----------
    name
        Name of its file, or of the first of them.
    time
        ``(T,) float64``, seconds, ascending.
    station
        ``(T,) int32``, the place at each time.
    positions
        ``(S, 3) float64``, the mean position at each place.
    """

    name: str
    time: F64
    station: I32
    positions: F64

    @property
    def span(self) -> str:
        """From when to when, for messages."""
        return f"{self.time[0]:.1f} to {self.time[-1]:.1f} s"

    def station_name(self, number: int) -> str:
        """Name of the scan at a place."""
        return f"place {number}"

    def stations(self, time: F64) -> I32:
        """``(n,) int32``, the place of the scanner at each time, -1 for a time that is not covered.

        Times of LAS are seconds of the GPS week or "adjusted" seconds since the GPS began, less 10⁹; those of a
        trajectory may be of the other kind.
        """
        best = self._stations(time)
        for shifted in (time + _ADJUSTED_S, (time + _ADJUSTED_S) % _WEEK_S, time - _ADJUSTED_S):
            if np.any(best >= 0):
                return best
            best = self._stations(shifted)
        return best

    def _stations(self, time: F64) -> I32:
        after = np.clip(np.searchsorted(self.time, time), 1, len(self.time) - 1)
        is_later = np.asarray(time - self.time[after - 1] > self.time[after] - time)
        nearest = np.where(is_later, after, after - 1)
        covered = np.abs(self.time[nearest] - time) <= _GAP_S
        return np.where(covered, self.station[nearest], -1).astype(np.int32)


def read_trajectory(paths: Sequence[Path], spacing: float) -> Trajectory:
    """Read a trajectory from text files with a row a moment: time, x, y, z, by the header's names or in this order.

    Parameters
    ----------
    paths
        Its files, in any order.
    spacing
        The scanner is at a new place where it is this far from all places before, in the unit of the file.

    Raises
    ------
    InputError
        A file is missing or is no such table, or the way is too long for one building.
    """
    rows = np.concatenate([_rows(path) for path in paths])
    rows = rows[np.isfinite(rows).all(axis=1)]
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    if len(rows) < 2:
        raise InputError(f"the trajectory {paths[0]} has fewer than two moments: export it again")
    station, count = _places(rows[:, 1:], spacing, _MOST_STATIONS)
    if count > _MOST_STATIONS:
        raise InputError(
            f"the trajectory {paths[0]} goes past more than {_MOST_STATIONS} places {spacing:g} apart: is it in "
            "metres, and of one building? Its unit can be set with --units"
        )
    size = np.bincount(station)
    mean = np.stack([np.bincount(station, rows[:, 1 + axis]) / size for axis in range(3)], axis=1)
    return Trajectory(paths[0].name, rows[:, 0], station, mean)


def _rows(path: Path) -> F64:
    """``(n, 4)``: time, x, y, z."""
    try:
        with path.open("rb") as file:
            head = file.readline(1 << 16)
            columns = _columns(head, path)
            is_header = columns is not None
            file.seek(len(head) if is_header else 0)
            columns = columns if columns is not None else [0, 1, 2, 3]
            lines = NumberLines(file, 2 if is_header else 1)
            parts = []
            while len(part := lines.rows(_ROWS, max(columns) + 1)):
                parts.append(part[:, columns])
    except OSError as error:
        raise InputError(f"the trajectory {path} cannot be read: {error.strerror or error}") from error
    except ValueError as error:
        raise InputError(
            f"the trajectory {path} cannot be read: {error}; it should be text, time,x,y,z a row"
        ) from error
    return np.concatenate(parts) if parts else np.empty((0, 4))


def _columns(head: bytes, path: Path) -> list[int] | None:
    """Columns of time, x, y, z by the names in the first line; None if that is no header."""
    text = head.decode("utf-8-sig", errors="replace").strip().lstrip("#%/ ").lower()
    separator = next((mark for mark in (",", ";", "\t") if mark in text), None)
    words = [word.strip().strip('"') for word in text.split(separator)]
    if not any(word[:1].isalpha() for word in words):
        return None
    found = [next((at for at, word in enumerate(words) if word in names), None) for names in _NAMES.values()]
    missing = [name for name, at in zip(_NAMES, found, strict=True) if at is None]
    if missing:
        raise InputError(
            f"the trajectory {path} has no column for {', '.join(missing)}: it needs time, x, y and z in the "
            "coordinates of the points"
        )
    return [at for at in found if at is not None]


@njit(cache=True, nogil=True)
def _places(way: NDArray[np.float64], spacing: float, most: int) -> tuple[I32, int]:
    """Return the number of the place at each moment, and how many there are (`most` + 1 if more than that).

    There is a place wherever the scanner was far from all places before; each moment belongs to the nearest.
    """
    place = np.zeros(len(way), np.int32)
    centres = np.empty((most, 3))
    count, here = 0, 0
    for i in range(len(way)):
        if count > 0 and _apart(way[i], centres[here]) <= spacing:
            continue
        here = _nearest(way[i], centres, count)
        if count == 0 or _apart(way[i], centres[here]) > spacing:
            if count == most:
                return place, most + 1
            centres[count] = way[i]
            here = count
            count += 1
    looked = 0
    for i in range(len(way)):
        if i == 0 or _apart(way[i], way[looked]) > _STEP * spacing:
            here = _nearest(way[i], centres, count)
            looked = i
        place[i] = here
    return place, count


@njit(cache=True, nogil=True)
def _nearest(point: NDArray[np.float64], centres: NDArray[np.float64], count: int) -> int:
    best, least = 0, np.inf
    for other in range(count):
        distance = _apart(point, centres[other])
        if distance < least:
            best, least = other, distance
    return best


@njit(cache=True, nogil=True)
def _apart(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    return float(np.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2))
