"""Scan files in: one module a format, chosen by suffix."""

from __future__ import annotations

import glob
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from enfilade.errors import InputError
from enfilade.ingest.records import Scan
from enfilade.progress import Progress, Silent

from . import e57, pcd, ply, ptx
from .frame import AUTO, UNITS, in_metres
from .positions import read_positions
from .trajectory import read_trajectory
from .whereabouts import Whereabouts

Reader = Callable[[Path, Whereabouts], Iterator[Scan]]


def _read_las(path: Path, whereabouts: Whereabouts) -> Iterator[Scan]:
    """LAS and LAZ; loaded when there are some, for laspy brings an HTTP client that takes as long as NumPy to load."""
    from . import las

    return las.read(path, whereabouts)


READERS: Final[Mapping[str, Reader]] = {
    ".e57": e57.read,
    ".ptx": ptx.read,
    ".ply": ply.read,
    ".pcd": pcd.read,
    ".las": _read_las,
    ".laz": _read_las,
}
"""Reader of each suffix, lower case."""

_SILENT: Final = Silent()


@dataclass(frozen=True, slots=True)
class ReadingParameters:
    """How the coordinates of the files are understood.

    Attributes
    ----------
    units
        Unit of the scans: ``m``, ``mm``, ``cm``, ``ft``, ``in``, or ``auto`` to find it.
    up
        Axis that points up: ``z``, ``y``, or ``auto`` to find it.
    place_spacing_m
        A moving scanner is at a new place, which is one scan, where it is this far from all places before.
    """

    units: str = AUTO
    up: str = AUTO
    place_spacing_m: float = 1.5


def scan_files(sources: Sequence[Path]) -> tuple[Path, ...]:
    """Return the scan files that `sources` name: folders and patterns replaced by their scan files, sorted by name.

    Raises
    ------
    InputError
        A source is missing, has a name that is no text, is of a format that no reader knows, or is a folder without
        scans.
    """
    if not sources:
        raise InputError("no scan files were given: name one or more scan files, or folders of them")
    files = [_with_name(file) for source in sources for file in _files_of(Path(source))]
    return tuple(dict.fromkeys(files))


def read_scans(
    sources: Sequence[Path],
    parameters: ReadingParameters = ReadingParameters(),
    *,
    positions: Path | None = None,
    trajectory: Sequence[Path] = (),
    progress: Progress = _SILENT,
) -> Iterator[Scan]:
    """Read the scans of all `sources` (files, folders or patterns), one at a time, in metres with z up.

    Parameters
    ----------
    sources
        Where the scans are.
    parameters
        Unit, vertical axis and places of a moving scanner.
    positions
        Table of scanner positions (``scan,x,y,z`` or ``file,x,y,z``), which go before those in the files.
    trajectory
        Files of the way of a moving scanner, for LAS and LAZ.
    progress
        Hears what the user should know.

    Raises
    ------
    InputError
        A file, a folder or a table cannot be used; the message names it and the cause.
    """
    table = read_positions(positions) if positions is not None else None
    spacing = parameters.place_spacing_m / UNITS.get(parameters.units, 1.0)
    way = read_trajectory(trajectory, spacing) if trajectory else None
    scans = _read(scan_files(sources), Whereabouts(table, way, progress.note))
    return in_metres(scans, parameters.units, parameters.up, progress.note)


def _read(files: Sequence[Path], whereabouts: Whereabouts) -> Iterator[Scan]:
    for file in files:
        yield from READERS[file.suffix.lower()](file, whereabouts)
    if whereabouts.table is not None:
        whereabouts.table.refuse_unused()


def _files_of(source: Path) -> list[Path]:
    if source.is_dir():
        files = sorted(file for file in source.iterdir() if _is_scan(file))
        if not files:
            raise InputError(f"the folder {source} holds no scans (files ending in {_suffixes()})")
        return files
    if not source.exists():
        return _matching(source)
    if source.suffix.lower() not in READERS:
        raise InputError(f"{source} is of a format that cannot be read: use files ending in {_suffixes()}")
    return [source]


def _matching(pattern: Path) -> list[Path]:
    """Return the scan files that a pattern matches, which the shell did not replace."""
    names = glob.glob(str(pattern), recursive=True) if glob.has_magic(str(pattern)) else []  # noqa: PTH207 (any pattern)
    files = sorted(path for path in map(Path, names) if _is_scan(path))
    if not files:
        raise InputError(f"there is no file or folder {pattern}: check the path")
    return files


def _is_scan(file: Path) -> bool:
    return file.suffix.lower() in READERS and file.is_file()


def _suffixes() -> str:
    return ", ".join(READERS)


def _with_name(file: Path) -> Path:
    """Refuse a path that is no Unicode text: readers cannot open it, and the graph could not name it."""
    try:
        str(file).encode()
    except UnicodeEncodeError as error:
        shown = ascii(str(file))
        raise InputError(f"the path {shown} is not UTF-8 text: rename what it names and try again") from error
    return file
