"""The grouping table of the user: which room a scan stands in (``scan,room``)."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from enfilade.errors import InputError
from enfilade.ingest.records import I32

HEADER: Final = ("scan", "room")


def read_grouping(
    path: Path, scan_names: tuple[str, ...], read_as: Sequence[int] | I32 | None = None
) -> dict[int, str]:
    """Read a grouping table: the room that it gives to each scan; a scan is named by name or index.

    Parameters
    ----------
    path
        The table.
    scan_names
        Of all scans.
    read_as
        The index by which the table may name each scan, from 0 in the order of the files; None for their own order.

    Returns
    -------
    Names of rooms by the places of scans in `scan_names`.

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
    indices = [*range(len(scan_names))] if read_as is None else [int(index) for index in read_as]
    for line, row in enumerate(rows[1:], start=2):
        if not any(cell.strip() for cell in row):
            continue
        scan, room = _read_row(row, f"{path}, line {line}", scan_names, indices)
        if rooms.setdefault(scan, room) != room:
            raise InputError(f"{path}, line {line}: scan {row[0].strip()!r} is already in room {rooms[scan]!r}")
    return rooms


def _read_row(row: list[str], where: str, scan_names: tuple[str, ...], indices: list[int]) -> tuple[int, str]:
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
    if scan.isdecimal() and int(scan) in indices:
        return indices.index(int(scan)), room
    raise InputError(f"{where}: there is no scan {scan!r}; the scans are {_some(scan_names)}")


def _some(names: tuple[str, ...], most: int = 5) -> str:
    shown = ", ".join(repr(name) for name in names[:most])
    return shown if len(names) <= most else f"{shown} and {len(names) - most} more"
