"""Scans made anew for ``bench/ingest.py``: with fewer points, scanned again, the building several times."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Final

import numpy as np
import pye57
from numpy.typing import NDArray

from enfilade.ingest.readers import read_scans
from enfilade.ingest.records import Chunk, Scan
from enfilade.ingest.thinning import ThinningParameters

F64 = NDArray[np.float64]
VOXEL_M: Final = ThinningParameters().voxel_size_m
NOISE_M: Final = 0.002
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
    noise_m: float = NOISE_M


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


def scanned_again(scans: Iterable[Scan], time: int, noise_m: float = NOISE_M) -> Iterator[Scan]:
    """Yield scans as if the scanner had stood there once more, with new noise, chunk by chunk and without a file.

    Every point stays in its voxel, so that there are more points but no more to keep of them.
    """
    for number, scan in enumerate(scans):
        chance = np.random.default_rng([time, number])
        chunks = (_with_noise(chunk, scan.scanner_position, noise_m, chance) for chunk in scan.chunks)
        yield Scan(f"{scan.name}, {time}", scan.source, chunks, scan.scanner_position)


def _with_noise(chunk: Chunk, scanner: F64, noise_m: float, chance: np.random.Generator) -> Chunk:
    ray = chunk.positions - scanner
    length = np.maximum(np.linalg.norm(ray, axis=1, keepdims=True), 1e-6)
    positions = chunk.positions + ray / length * chance.normal(0.0, noise_m, (len(ray), 1))
    voxel = np.floor(chunk.positions / VOXEL_M)
    return Chunk(np.clip(positions, (voxel + 0.02) * VOXEL_M, (voxel + 0.98) * VOXEL_M), chunk.intensity, chunk.colour)


def points_of(scan: Scan) -> F64:
    """``(n, 3) float64`` all points of a scan."""
    return np.concatenate([chunk.positions for chunk in scan.chunks])


def _width(scans: list[Path]) -> float:
    """Extent of a building along x, metres."""
    columns = [points_of(scan)[:, 0] for scan in read_scans(scans)]
    return float(max(x.max() for x in columns) - min(x.min() for x in columns))
