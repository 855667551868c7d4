"""Thin the scans to at most one point a voxel (§8), scan by scan."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import chain
from typing import Final

import numpy as np
from numpy.typing import NDArray

from enfilade.errors import InputError
from enfilade.parallel import taken
from enfilade.progress import Progress, Silent

from .records import F64, I32, Chunk, Scan, ThinnedCloud
from .voxels import VoxelSet

_SILENT: Final = Silent()
_ORIGIN_GRID_M: Final = 1000.0
_COPIED: Final = 0.5
_FEWEST_POINTS: Final = 100

I64 = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class ThinningParameters:
    """How far the scans are thinned.

    Attributes
    ----------
    voxel_size_m
        Side of the voxels that keep one point each.
    """

    voxel_size_m: float = 0.01


@dataclass(slots=True)
class _Register:
    """The scans so far: who they are, and how many points each has in the set or has a copy of.

    `before` is what each had when the scan that is read began; None where that goes on with an earlier one.
    """

    keys: dict[tuple[str, str], int]
    scanners: F64
    raw: list[int]
    held: I64
    copies: I64
    original: list[int]
    before: I64 | None = None

    @classmethod
    def empty(cls) -> _Register:
        return cls({}, np.zeros((0, 3)), [], np.zeros(0, np.int64), np.zeros(0, np.int64), [])

    def begin(self, scan: Scan, origin: F64) -> int:
        """Return the scan's number, a new one where it is met for the first time."""
        number = self.keys.setdefault((scan.source, scan.name), len(self.keys))
        if number == len(self.raw):
            self.raw.append(0)
            self.original.append(number)
            self.scanners = np.concatenate([self.scanners, (scan.scanner_position - origin)[None]])
            self.held, self.copies = np.append(self.held, 0), np.append(self.copies, 0)
        self.before = self.held.copy() if self.raw[number] == 0 else None
        self.copies[:] = 0
        return number

    def end(self, number: int) -> None:
        """See whether a scan that has been read copies another one."""
        if self.before is not None:
            self.original[number] = _original(number, self.before, self.copies, self.original)


def thin(
    scans: Iterable[Scan], parameters: ThinningParameters = ThinningParameters(), *, progress: Progress = _SILENT
) -> ThinnedCloud:
    """Merge scans into one cloud that keeps, of each voxel, the point nearest to its scanner.

    The points kept do not depend on the order of the scans, nor of the points in them. Memory follows the thinned
    cloud: chunks are put into one set of voxels while the next is read. A scan that is the copy of another is said
    to be one, and is not there. Scans are numbered by their names: what is found does not depend on their order.

    Raises
    ------
    InputError
        There are no scans, or the scans lie farther apart than one building can.
    """
    register, origin, points = _Register.empty(), np.zeros(3), None
    number = -1
    for scan, chunk in _read_ahead(scans):
        if points is None:
            origin = np.round(scan.scanner_position / _ORIGIN_GRID_M) * _ORIGIN_GRID_M
            points = VoxelSet(parameters.voxel_size_m, origin)
        if number < 0:
            number = register.begin(scan, origin)
        if chunk is not None:
            _add(points, chunk, number, register, scan)
        else:
            register.end(number)
            number = -1
            progress.advance()
    if points is None:
        raise InputError("there are no scans to ingest")
    kept = points.finish()
    _say_copies(register, progress)
    numbers, is_kept = _renumbered(register.original)
    names = _names([key for key, keeps in zip(register.keys, is_kept, strict=True) if keeps])
    by_name = np.array(sorted(range(len(names)), key=lambda scan: _natural(names[scan])), np.int32)
    return ThinnedCloud(
        kept.positions,
        taken(np.argsort(by_name).astype(np.int32)[numbers], kept.scan),
        register.scanners[is_kept][by_name].astype(np.float32),
        tuple(names[scan] for scan in by_name),
        origin,
        sum(count for count, keeps in zip(register.raw, is_kept, strict=True) if keeps),
        kept.intensity,
        kept.colour,
        by_name,
    )


def _read_ahead(scans: Iterable[Scan]) -> Iterator[tuple[Scan, Chunk | None]]:
    """Yield the chunks of all scans, None after the last of each; while one is used, the next is read."""
    parts = ((scan, chunk) for scan in scans for chunk in chain(scan.chunks, (None,)))
    with ThreadPoolExecutor(1) as worker:
        coming = worker.submit(next, parts, None)
        while (part := coming.result()) is not None:
            coming = worker.submit(next, parts, None)
            yield part


def _add(points: VoxelSet, chunk: Chunk, number: int, register: _Register, scan: Scan) -> None:
    """Put a chunk of a scan in."""
    if not points.add(chunk, number, register.scanners, register.held, register.copies):
        raise InputError(
            f"scan {scan.name!r} of {scan.source} lies more than {points.reach_m / 1000:.0f} km "
            "from the first one: are the scans registered, and in metres?"
        )
    register.raw[number] += len(chunk.positions)


def _original(number: int, held: I64, copies: I64, original: list[int]) -> int:
    """Return which scan this one is a copy of: the one that it repeats most points of, if most; else itself."""
    share = copies / np.maximum(held, 1)
    share[held < _FEWEST_POINTS] = 0.0
    most = int(np.argmax(share))
    return original[most] if share[most] >= _COPIED else number


def _say_copies(register: _Register, progress: Progress) -> None:
    keys = list(register.keys)
    for number, original in enumerate(register.original):
        if original != number:
            (source, name), (its_source, its_name) = keys[number], keys[original]
            progress.note(f"scan {name!r} of {source} repeats scan {its_name!r} of {its_source}: it was used once")


def _renumbered(original: list[int]) -> tuple[I32, list[bool]]:
    """Return the new number of each scan when copies are left out, and which scans are no copies."""
    is_kept = [number == its for number, its in enumerate(original)]
    new = np.cumsum(is_kept).astype(np.int32) - 1
    return np.asarray(new[original], np.int32), is_kept


def _names(keys: list[tuple[str, str]]) -> tuple[str, ...]:
    """Names of scans, with that of the file before it where several files have scans that are named alike."""
    count = Counter(name for _, name in keys)
    return tuple(name if count[name] == 1 else f"{source}/{name}" for source, name in keys)


def _natural(name: str) -> list[str | int]:
    """Key by which names are sorted as people do: Scan 9 before Scan 10."""
    return [int(part) if part.isdecimal() else part for part in re.split(r"(\d+)", name)]
