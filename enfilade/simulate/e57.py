"""Writes scans to an E57 file, one after the other."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType
from typing import Any, Self

import pye57

from .scanner import Scan


class ScanWriter:
    """An E57 file under way: each scan in its own frame, with its pose.

    The file appears under its name only when all is written.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._unfinished = path.with_name(f".{path.name}.unfinished")

    def __enter__(self) -> Self:
        """Open the file."""
        self._unfinished.unlink(missing_ok=True)
        self._file: Any = pye57.E57(str(self._unfinished), mode="w")
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the file and give it its name, or remove it after an error."""
        self._file.close()
        if kind is None:
            self._unfinished.replace(self._path)
        else:
            self._unfinished.unlink(missing_ok=True)

    def write(self, scan: Scan) -> None:
        """Add a scan."""
        points = {f"cartesian{axis}": scan.local[:, k].astype("f8") for k, axis in enumerate("XYZ")}
        self._file.write_scan_raw(
            {**points, "intensity": scan.intensity.astype("f8")},
            name=scan.name,
            rotation=scan.pose.quaternion,
            translation=scan.pose.translation,
        )
