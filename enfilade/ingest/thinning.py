"""Thin the scans to at most one point a voxel (§8), scan by scan."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enfilade.errors import InputError
from enfilade.progress import Progress, Silent

from .records import F32, F64, I32, Scan, ThinnedCloud

_SILENT: Final = Silent()
_BITS: Final = 21
FARTHEST_M: Final = 10_000.0
"""Coordinates up to here are used as they are; beyond, an origin is taken off first."""

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


@dataclass(frozen=True, slots=True)
class _Run:
    """Points sorted by voxel, one a voxel. `range` is the distance to the scanner, metres."""

    voxel: I64
    positions: F32
    scan: I32
    range: F32

    def __len__(self) -> int:
        return len(self.voxel)


def thin(
    scans: Iterable[Scan], parameters: ThinningParameters = ThinningParameters(), *, progress: Progress = _SILENT
) -> ThinnedCloud:
    """Merge scans into one cloud that keeps, of each voxel, the point nearest to its scanner.

    The points kept do not depend on the order of the scans. Memory follows the thinned cloud: runs of points are
    merged like the digits of a binary counter, so that n points in s scans cost n log s.

    Raises
    ------
    InputError
        There are no scans, or the scans lie farther apart than one building can.
    """
    runs: list[_Run] = []
    names: list[str] = []
    scanners: list[F64] = []
    raw_count = 0
    origin = np.zeros(3)
    for index, scan in enumerate(scans):
        if index == 0:
            origin = _origin(scan.scanner_position)
        runs.append(_run_of(scan, index, origin, parameters.voxel_size_m))
        _settle(runs)
        names.append(scan.name)
        scanners.append(scan.scanner_position - origin)
        raw_count += len(scan.positions)
        progress.advance()
    if not runs:
        raise InputError("there are no scans to ingest")
    run = _merged(runs)
    return ThinnedCloud(run.positions, run.scan, np.array(scanners, np.float32), tuple(names), origin, raw_count)


def _origin(scanner_position: F64) -> F64:
    """Zero, or whole metres near the first scanner where its coordinates are large."""
    if np.abs(scanner_position).max() <= FARTHEST_M:
        return np.zeros(3)
    return np.round(scanner_position)


def _run_of(scan: Scan, index: int, origin: F64, voxel_size_m: float) -> _Run:
    local = scan.positions - origin
    distance = np.linalg.norm(scan.positions - scan.scanner_position, axis=1).astype(np.float32)
    positions = local.astype(np.float32)
    voxel = _voxel_keys(positions, voxel_size_m, scan)
    run = _Run(voxel, positions, np.full(len(positions), index, np.int32), distance)
    return _nearest_per_voxel(run, np.argsort(voxel))


def _voxel_keys(positions: F32, voxel_size_m: float, scan: Scan) -> I64:
    """Pack the voxel indices of ``(n, 3)`` positions into 63 bits."""
    half = 1 << (_BITS - 1)
    if np.abs(positions).max() >= half * voxel_size_m:
        raise InputError(
            f"scan {scan.name!r} of {scan.source} lies more than {half * voxel_size_m / 1000:.0f} km "
            "from the first one: are the scans registered, and in metres?"
        )
    key = np.zeros(len(positions), np.int64)
    for axis in range(3):
        key <<= _BITS
        key += np.floor(positions[:, axis].astype(np.float64) / voxel_size_m).astype(np.int64) + half
    return key


def _settle(runs: list[_Run]) -> None:
    """Merge the last runs while the last is not much smaller than the one before it."""
    while len(runs) > 1 and 2 * len(runs[-1]) > len(runs[-2]):
        runs[-2:] = [_merged(runs[-2:])]


def _merged(runs: list[_Run]) -> _Run:
    if len(runs) == 1:
        return runs[0]
    joined = _Run(
        np.concatenate([run.voxel for run in runs]),
        np.concatenate([run.positions for run in runs]),
        np.concatenate([run.scan for run in runs]),
        np.concatenate([run.range for run in runs]),
    )
    return _nearest_per_voxel(joined, np.argsort(joined.voxel, kind="stable"))  # merges what is sorted in one pass


def _nearest_per_voxel(run: _Run, order: I64) -> _Run:
    kept = _best_of_each(run.voxel, order, run.range, run.positions)
    return _Run(run.voxel[kept], run.positions[kept], run.scan[kept], run.range[kept])


@njit(cache=True)
def _best_of_each(voxel: I64, order: I64, distance: F32, positions: F32) -> I64:
    """Index of the best point of each voxel: the nearest to its scanner, of equals the least by x, y, z."""
    kept = np.empty(len(order), np.int64)
    count = 0
    for at in range(len(order)):
        i = order[at]
        if at == 0 or voxel[i] != voxel[order[at - 1]]:
            kept[count] = i
            count += 1
            continue
        best = kept[count - 1]
        if distance[i] < distance[best]:
            kept[count - 1] = i
        elif distance[i] == distance[best]:
            for axis in range(3):
                if positions[i, axis] != positions[best, axis]:
                    if positions[i, axis] < positions[best, axis]:
                        kept[count - 1] = i
                    break
    return kept[:count].copy()
