"""Scan files in: one module a format, chosen by suffix."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final

from enfilade.errors import InputError
from enfilade.ingest.records import Scan

from . import e57

Reader = Callable[[Path], Iterator[Scan]]

READERS: Final[Mapping[str, Reader]] = {".e57": e57.read}
"""Reader of each suffix, lower case."""


def scan_files(sources: Sequence[Path]) -> tuple[Path, ...]:
    """Return the scan files that `sources` name, folders replaced by the scan files in them, sorted by name.

    Raises
    ------
    InputError
        A source is missing, has a name that is no text, is of a format that no reader knows, or is a folder without
        scans.
    """
    if not sources:
        raise InputError("no scan files were given: name one or more E57 files, or folders of them")
    return tuple(_with_name(file) for source in sources for file in _files_of(Path(source)))


def read_scans(sources: Sequence[Path]) -> Iterator[Scan]:
    """Read the scans of all `sources` (files or folders), one at a time.

    Raises
    ------
    InputError
        A file or folder cannot be used; the message names it and the cause.
    """
    for file in scan_files(sources):
        yield from READERS[file.suffix.lower()](file)


def _files_of(source: Path) -> list[Path]:
    if source.is_dir():
        files = sorted(file for file in source.iterdir() if file.suffix.lower() in READERS and file.is_file())
        if not files:
            raise InputError(f"the folder {source} holds no scans (files ending in {_suffixes()})")
        return files
    if not source.exists():
        raise InputError(f"there is no file or folder {source}: check the path")
    if source.suffix.lower() not in READERS:
        raise InputError(f"{source} is of a format that cannot be read: use files ending in {_suffixes()}")
    return [source]


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
