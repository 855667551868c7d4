"""Which scans share a room: seen from under the ceiling, where a lintel closes every door (§4, first phase).

The paper merges the scan positions of a room by hand. Here each scanner is lifted to just below its ceiling, and
free places around it at that height are sampled. Two scans share a room where most of their places see each other:
in one room they do, through a door the wall above it is in the way, and through a passage without lintel only the
few do that are in line with it.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import cKDTree

from enfilade.errors import InputError
from .records import F32, F64, I32, Planes
from .structure import Structure

I64 = NDArray[np.int64]
HEADER: Final = ("scan", "room")


@dataclass(frozen=True, slots=True)
class GroupParameters:
    """When two scans share a room.

    Attributes
    ----------
    below_ceiling_m
        How far under the ceiling scanners are lifted to look around.
    headroom_m
        How far a scanner is lifted where no ceiling is seen.
    azimuths
        Directions in which free places around a lifted scanner are sampled.
    reach_m
        Scans farther apart than this are not compared.
    sight_pairs
        Pairs of places that are tested for each pair of scans.
    least_sight
        Share of those pairs that must see each other.
    storey_gap_m
        Scanners more than this apart in height, with none between, are numbered as different storeys.
    """

    below_ceiling_m: float = 0.15
    headroom_m: float = 0.7
    azimuths: int = 48
    reach_m: float = 20.0
    sight_pairs: int = 288
    least_sight: float = 0.4
    storey_gap_m: float = 1.2


def group_scans(
    planes: Planes,
    scanner_positions: F32,
    scan_names: tuple[str, ...],
    rooms_csv: Path | None = None,
    parameters: GroupParameters = GroupParameters(),
) -> I32:
    """Return the room of each scan, ``(S,) int32``, numbered from below, then along x and y.

    `rooms_csv` (header ``scan,room``; a scan by name or index) overrides the automatic groups: scans it lists are in
    the rooms it says, and a scan it does not list follows the nearest listed scan of its automatic group, if any.

    Raises
    ------
    InputError
        `rooms_csv` cannot be read, or a line of it names a scan that there is not.
    """
    group = _automatic_groups(Structure(planes), scanner_positions, parameters)
    if rooms_csv is not None:
        group = _overridden(group, read_rooms(rooms_csv, scan_names), scanner_positions)
    return _numbered(group, scanner_positions.astype(np.float64), parameters.storey_gap_m)


def read_rooms(path: Path, scan_names: tuple[str, ...]) -> dict[int, str]:
    """Read a grouping table: the room that it gives to each scan (by index).

    Raises
    ------
    InputError
        The file is missing or no CSV with header ``scan,room``, or a line is wrong; the message has its number.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = list(csv.reader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"the grouping {path} cannot be read: {error}") from error
    if not rows or tuple(cell.strip() for cell in rows[0]) != HEADER:
        raise InputError(f"{path}, line 1: the header must be 'scan,room'")
    rooms: dict[int, str] = {}
    for line, row in enumerate(rows[1:], start=2):
        if not any(cell.strip() for cell in row):
            continue
        scan, room = _read_row(row, f"{path}, line {line}", scan_names)
        if rooms.setdefault(scan, room) != room:
            raise InputError(f"{path}, line {line}: scan {row[0].strip()!r} is already in room {rooms[scan]!r}")
    return rooms


def _read_row(row: list[str], where: str, scan_names: tuple[str, ...]) -> tuple[int, str]:
    if len(row) != len(HEADER):
        raise InputError(f"{where}: {len(row)} columns where 2 are needed: scan,room")
    scan, room = (cell.strip() for cell in row)
    if not room:
        raise InputError(f"{where}: the room of scan {scan!r} is empty")
    named = [index for index, name in enumerate(scan_names) if name == scan]
    if len(named) > 1:
        raise InputError(f"{where}: {len(named)} scans are called {scan!r}: name it by its index, counted from 0")
    if named:
        return named[0], room
    if scan.isdecimal() and int(scan) < len(scan_names):
        return int(scan), room
    raise InputError(f"{where}: there is no scan {scan!r}; the scans are {_some(scan_names)}")


def _some(names: tuple[str, ...], most: int = 5) -> str:
    shown = ", ".join(repr(name) for name in names[:most])
    return shown if len(names) <= most else f"{shown} and {len(names) - most} more"


# --- automatic -------------------------------------------------------------------------------------------------


def _automatic_groups(structure: Structure, scanners: F32, parameters: GroupParameters) -> I64:
    pairs = cKDTree(scanners).query_pairs(parameters.reach_m, output_type="ndarray")
    pairs = pairs[np.lexsort(pairs.T[::-1])]
    places = _free_places(structure, scanners, parameters)
    joined = pairs[_sight(structure, places, pairs, parameters.sight_pairs) >= parameters.least_sight]
    links = sparse.coo_array((np.ones(len(joined), np.int8), tuple(joined.T)), shape=(len(scanners),) * 2)
    return np.asarray(sparse.csgraph.connected_components(links, directed=False)[1], np.int64)


def _free_places(structure: Structure, scanners: F32, parameters: GroupParameters) -> F32:
    """``(S, K, 3)``: places around each scanner that it reaches freely, just below its ceiling."""
    lifted = scanners.copy()
    lifted[:, 2] += _headroom(structure, scanners, parameters)
    azimuth = 2.0 * np.pi * np.arange(parameters.azimuths) / parameters.azimuths
    rays = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros_like(azimuth)], axis=1).astype(np.float32)
    starts = np.repeat(lifted, len(rays), axis=0)
    directions = np.tile(rays, (len(lifted), 1))
    free = np.minimum(structure.cast(starts, directions).distance, parameters.reach_m / 2.0)
    shares = np.tile(np.array([0.3, 0.6, 0.9], np.float32), (len(starts) + 2) // 3)[: len(starts)]
    return (starts + directions * (free * shares)[:, None]).reshape(len(lifted), len(rays), 3)


def _headroom(structure: Structure, scanners: F32, parameters: GroupParameters) -> F32:
    """``(S,)``: how far each scanner can be lifted, from the median ceiling that a steep cone of rays meets."""
    azimuth = 2.0 * np.pi * np.arange(16) / 16.0
    tilt = np.tile([0.1, 0.35], 8)
    cone = np.stack([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)], axis=1)
    directions = np.tile(cone.astype(np.float32), (len(scanners), 1))
    hits = structure.cast(np.repeat(scanners, len(cone), axis=0), directions)
    rise = np.where(hits.front, hits.distance * directions[:, 2], np.nan).reshape(len(scanners), -1)
    seen = np.isfinite(rise).any(axis=1)
    headroom = np.full(len(scanners), parameters.headroom_m, np.float32)
    headroom[seen] = np.maximum(np.nanmedian(rise[seen], axis=1) - parameters.below_ceiling_m, 0.0)
    return headroom


def _sight(structure: Structure, places: F32, pairs: I64, count: int) -> F64:
    """Share of `count` pairs of places, one around each scan of a pair, that see each other."""
    around = places.shape[1]
    a = np.arange(count) % around
    b = (np.arange(count) * 29 + np.arange(count) // around * 7) % around
    share = np.zeros(len(pairs))
    for first in range(0, len(pairs), 4096):
        some = pairs[first : first + 4096]
        starts = places[some[:, 0]][:, a].reshape(-1, 3)
        ends = places[some[:, 1]][:, b].reshape(-1, 3)
        share[first : first + 4096] = 1.0 - structure.blocked(starts, ends).reshape(len(some), count).mean(axis=1)
    return share


# --- by hand, and numbers --------------------------------------------------------------------------------------


def _overridden(group: I64, rooms: dict[int, str], scanners: F32) -> I64:
    """Groups with the listed scans where the table says, and the others after the nearest listed of their group."""
    if not rooms:
        return group
    listed = np.array(sorted(rooms))
    names = {name: number for number, name in enumerate(dict.fromkeys(rooms.values()))}
    beyond = int(group.max()) + 1
    result = group.copy()
    for scan in range(len(group)):
        mates = listed[group[listed] == group[scan]]
        if scan in rooms:
            result[scan] = beyond + names[rooms[scan]]
        elif len(mates):
            nearest = mates[np.argmin(np.linalg.norm(scanners[mates] - scanners[scan], axis=1))]
            result[scan] = beyond + names[rooms[int(nearest)]]
    return result


def _numbered(group: I64, scanners: F64, storey_gap_m: float) -> I32:
    """Number groups by level, then x, then y of their scanners' mean, whatever the order of the scans."""
    _, group = np.unique(group, return_inverse=True)
    size = np.bincount(group)
    mean = np.stack([np.bincount(group, scanners[:, axis]) / size for axis in range(3)], axis=1)
    by_height = np.argsort(mean[:, 2], kind="stable")
    level = np.empty(len(size), np.int64)
    level[by_height] = np.cumsum(np.diff(mean[by_height, 2], prepend=mean[by_height[:1], 2]) > storey_gap_m)
    rank = np.empty(len(size), np.int32)
    rank[np.lexsort((mean[:, 1], mean[:, 0], level))] = np.arange(len(size), dtype=np.int32)
    return rank[group]
