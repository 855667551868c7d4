"""Scanner positions from a table of the user (``scan,x,y,z`` or ``file,x,y,z``)."""

from __future__ import annotations

import csv
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np

from enfilade.errors import InputError
from enfilade.ingest.records import F64

HEADERS: Final = (("scan", "x", "y", "z"), ("file", "x", "y", "z"))


@dataclass(slots=True)
class PositionTable:
    """Positions by scan or by file.

    Attributes
    ----------
    path
        The table's file.
    by
        ``scan`` or ``file``, what the first column names.
    rows
        Line and position ``(3,)``, in the unit of the scans, by name.
    """

    path: Path
    by: str
    rows: dict[str, tuple[int, F64]]
    _found: set[str] = field(default_factory=set)

    def find(self, path: Path, scan: str) -> F64 | None:
        """Return the position of a scan, or None; a file may be named with or without its suffix."""
        names = (scan,) if self.by == "scan" else (path.name, path.stem, str(path))
        for name in names:
            if name in self.rows:
                self._found.add(name)
                return self.rows[name][1]
        return None

    def refuse_unused(self) -> None:
        """Raise InputError where a row names what was not among the scans."""
        for name, (line, _) in self.rows.items():
            if name not in self._found:
                raise InputError(f"{self.path}, line {line}: there is no {self.by} {name!r} among what was ingested")


def read_positions(path: Path) -> PositionTable:
    """Read a table of scanner positions.

    Raises
    ------
    InputError
        The file is missing or no CSV with one of the two headers, or a line is wrong; the message has its number.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            lines = list(csv.reader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"the positions {path} cannot be read: {error}") from error
    header = tuple(cell.strip().lower() for cell in lines[0]) if lines else ()
    if header not in HEADERS:
        raise InputError(f"{path}, line 1: the header must be 'scan,x,y,z' or 'file,x,y,z'")
    table = PositionTable(path, header[0], {})
    for line, row in enumerate(lines[1:], start=2):
        if any(cell.strip() for cell in row):
            name, position = _read_row(row, f"{path}, line {line}")
            if name in table.rows:
                raise InputError(f"{path}, line {line}: {header[0]} {name!r} was in line {table.rows[name][0]} already")
            table.rows[name] = (line, position)
    return table


def _read_row(row: list[str], where: str) -> tuple[str, F64]:
    name = row[0].strip()
    if len(row) != 4 or not name:
        raise InputError(f"{where}: a name and three coordinates are needed, as in 'hall,1.5,2.0,1.6'")
    try:
        position = np.array([float(cell) for cell in row[1:]])
    except ValueError as error:
        raise InputError(f"{where}: the coordinates {', '.join(row[1:])} are not three numbers") from error
    if not np.isfinite(position).all():
        raise InputError(f"{where}: the coordinates are not finite numbers")
    return name, position
