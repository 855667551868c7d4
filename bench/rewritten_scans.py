"""Scans written anew for ``bench/ingest.py``: with fewer points, scanned again, the building several times."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Final

import numpy as np
import pye57
from numpy.typing import NDArray

from enfilade.ingest.readers import read_scans
from enfilade.ingest.records import Scan

F64 = NDArray[np.float64]
GAP_M: Final = 30.0
"""Free ground between copies of a building, beyond the reach of what is compared within one."""


@dataclass(frozen=True, slots=True)
class Rewriting:
    """What becomes of scans.

    Attributes
    ----------
    share
        Of their points that are kept, at random.
    again
        How often each position is scanned, with new noise each time but the first.
    copies
        How often the building stands side by side.
    noise_m
        Standard deviation of the new noise along the ray.
    """

    share: float = 1.0
    again: int = 1
    copies: int = 1
    noise_m: float = 0.002


def rewrite(scans: list[Path], to: Path, how: Rewriting) -> None:
    """Write an E57 file, a scan at a time; one that is there already is used again."""
    if to.exists():
        return
    step = np.array([_width(scans) + GAP_M, 0.0, 0.0]) if how.copies > 1 else np.zeros(3)
    unfinished = to.with_suffix(".unfinished")
    unfinished.unlink(missing_ok=True)
    with pye57.E57(str(unfinished), mode="w") as file:
        for copy, time in product(range(how.copies), range(how.again)):
            for number, scan in enumerate(read_scans(scans)):
                chance = np.random.default_rng([copy, time, number])
                local = _measured(points_of(scan) - scan.scanner_position, how, time > 0, chance)
                points = {f"cartesian{axis}": local[:, k] for k, axis in enumerate("XYZ")}
                name, place = f"{scan.name}, {copy}.{time}", scan.scanner_position + copy * step
                file.write_scan_raw(points, name=name, translation=place)
    unfinished.replace(to)


def _measured(local: F64, how: Rewriting, anew: bool, chance: np.random.Generator) -> F64:
    """Return the points that are kept, if `anew` with new noise."""
    if how.share < 1.0:
        local = local[chance.random(len(local)) < how.share]
    if anew:
        local *= 1.0 + chance.normal(0.0, how.noise_m, (len(local), 1)) / np.linalg.norm(local, axis=1, keepdims=True)
    return local


def points_of(scan: Scan) -> F64:
    """``(n, 3) float64`` all points of a scan."""
    return np.concatenate([chunk.positions for chunk in scan.chunks])


def _width(scans: list[Path]) -> float:
    """Extent of a building along x, metres."""
    columns = [points_of(scan)[:, 0] for scan in read_scans(scans)]
    return float(max(x.max() for x in columns) - min(x.min() for x in columns))
