"""Writes scans to an E57 file, one after the other."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pye57
from pye57.libe57 import E57Exception

from enfilade.errors import InputError

from .scanner import Scan


@contextmanager
def scan_file(path: Path) -> Iterator[Callable[[Scan], None]]:
    """Open an E57 file and give what adds a scan to it: in the scanner's own frame, with its pose.

    The file appears under its name when all is written; after an error it does not.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    unfinished = path.with_name(f".{path.name}.unfinished")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        file = pye57.E57(str(unfinished), mode="w")
        try:
            yield partial(_write, file)
        finally:
            file.close()
        unfinished.replace(path)
    except (OSError, E57Exception) as error:
        raise InputError(f"{path} cannot be written; choose a folder that can, with enough space") from error
    finally:
        if unfinished.exists():
            unfinished.unlink()


def _write(file: Any, scan: Scan) -> None:
    points = {f"cartesian{axis}": scan.local[:, k].astype("f8") for k, axis in enumerate("XYZ")}
    file.write_scan_raw(
        {**points, "intensity": scan.intensity.astype("f8")},
        name=scan.name,
        rotation=scan.pose.quaternion,
        translation=scan.pose.translation,
    )
