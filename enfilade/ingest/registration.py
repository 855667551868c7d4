"""Whether the scans fit together: what two scans see of one surface must lie in one place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from enfilade.errors import InputError
from enfilade.progress import Progress, Silent

from .records import F32, F64, I32, Surfels, ThinnedCloud

I64 = NDArray[np.int64]

_SILENT: Final = Silent()
_FACE: Final = 32
"""Cells along a side of the six faces of the cube on which a scanner's ranges are kept."""
_SIDES: Final = 6
_MET: Final = 4
_UPRIGHT: Final = 0.7
_LEAST_IN_SIGHT: Final = 0.1
_FLAT: Final = 0.98
_FEWEST_FACING: Final = 20.0
_GAP_M: Final = 0.002
_ROUNDS: Final = 15


@dataclass(frozen=True, slots=True)
class RegistrationParameters:
    """When two scans do not fit together.

    Attributes
    ----------
    neighbours
        Scans near each scan that it is compared with.
    cell_m
        Cells in which two scans see the same surface.
    least_cells
        Cells that two scans must share to be compared surface by surface.
    most_shift_m
        What one of two scans may have to be moved to fit: registrations are good for some centimetres.
    sample
        Surfels of a scan that are looked up in what the other sees.
    margin_m
        An upright surfel nearer to the other scanner than what that sees, by more than this, is in its way.
    most_in_the_way
        Share of the upright surfels in sight of the other scanner that may be in its way: people walk, and doors move.
    """

    neighbours: int = 6
    cell_m: float = 0.3
    least_cells: int = 30
    most_shift_m: float = 0.05
    sample: int = 2000
    margin_m: float = 0.3
    most_in_the_way: float = 0.35


@dataclass(frozen=True, slots=True)
class _Patches:
    """Pieces of surface, one a place and scan, sorted so: mean ``(n, 3)`` metres, unit normal ``(n, 3)``."""

    place: I64
    scan: I32
    mean: F64
    normal: F64


def check_registration(
    cloud: ThinnedCloud,
    surfels: Surfels,
    parameters: RegistrationParameters = RegistrationParameters(),
    *,
    progress: Progress = _SILENT,
) -> None:
    """Say which two scans disagree most, and by how much.

    Two tests. Scans that are off by centimetres see two layers of each surface: the shift that would bring the layers
    of a pair together is fitted to all their common surfaces at once. Scans that are off by more have surfaces in what
    should be empty: surfels of one scan lie in the way of the other's rays.

    Raises
    ------
    InputError
        Most scans near each other have surfaces in each other's way: they were never registered.
    """
    pairs = _near_pairs(cloud.scanner_positions, parameters.neighbours)
    if not len(pairs):
        return
    share = _in_the_way(cloud.scanner_positions, surfels, pairs, parameters)
    is_off = _with_a_suspect(pairs, share, share > parameters.most_in_the_way)
    if is_off.any():
        _tell_unregistered(cloud, pairs, share, is_off, progress)
        return
    shift = _shifts(surfels, pairs, parameters)
    worst = int(np.argmax(shift))
    count = int(np.count_nonzero(shift > parameters.most_shift_m))
    if count:
        a, b = (cloud.scan_names[scan] for scan in pairs[worst])
        progress.note(
            f"scans {a!r} and {b!r} disagree by {1000.0 * shift[worst]:.0f} mm where both see the same surfaces"
            + (f", and {count - 1} more pairs disagree" if count > 1 else "")
            + ": is their registration right?"
        )


def _near_pairs(scanners: F32, neighbours: int) -> I64:
    """``(n, 2)`` scans near each other, the smaller number first."""
    if len(scanners) < 2:
        return np.zeros((0, 2), np.int64)
    count = min(neighbours + 1, len(scanners))
    nearest = cKDTree(scanners).query(scanners, k=count)[1]
    pairs = np.column_stack([np.repeat(np.arange(len(scanners)), count), nearest.ravel()])
    return np.unique(np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1), axis=0)


def _with_a_suspect(pairs: I64, share: F64, is_off: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Leave the pairs off of which one scan is off with most that it is compared with; glass makes single ones so."""
    count = int(pairs.max()) + 1
    compared = np.bincount(pairs[~np.isnan(share)].ravel(), minlength=count)
    is_suspect = np.bincount(pairs[is_off].ravel(), minlength=count) > 0.5 * compared
    return np.asarray(is_off & is_suspect[pairs].any(axis=1))


def _tell_unregistered(
    cloud: ThinnedCloud, pairs: I64, share: F64, is_off: NDArray[np.bool_], progress: Progress
) -> None:
    worst = int(np.argmax(np.where(is_off, share, 0.0)))
    a, b = (cloud.scan_names[scan] for scan in pairs[worst])
    said = (
        f"scans {a!r} and {b!r} do not fit together: {100.0 * share[worst]:.0f} % of what one sees stands in the way "
        "of the other's rays"
    )
    if np.count_nonzero(is_off) > 0.5 * np.count_nonzero(~np.isnan(share)):
        raise InputError(f"the scans are not registered: {said}; export them registered, with their positions")
    progress.note(f"{said}: is their registration right?")


def _in_the_way(scanners: F32, surfels: Surfels, pairs: I64, parameters: RegistrationParameters) -> F64:
    """``(n,)`` share of the surfels of one scan that are in the way of the other, the greater of both ways; or NaN."""
    (upright,) = np.nonzero(np.abs(surfels.normals[:, 2]) < _UPRIGHT)  # floors lie level however a scan is turned
    order = upright[np.argsort(surfels.scan[upright], kind="stable")]
    bounds = np.searchsorted(surfels.scan[order], np.arange(len(scanners) + 1))
    ranges = _ranges(surfels.positions, surfels.scan, scanners)
    share = np.full(len(pairs), np.nan)
    for number, (a, b) in enumerate(pairs):
        for own, other in ((a, b), (b, a)):
            members = order[bounds[own] : bounds[own + 1]]
            chosen = members[:: max(1, len(members) // parameters.sample)]
            blocked, seen = _blocked(surfels.positions[chosen], scanners[other], ranges[other], parameters.margin_m)
            if seen >= max(parameters.least_cells, _LEAST_IN_SIGHT * len(chosen)):
                share[number] = np.fmax(share[number], blocked / seen)
    return share


@njit(cache=True, nogil=True)
def _cell(dx: float, dy: float, dz: float) -> int:
    """Cell of the cube's faces that a direction meets."""
    x, y, z = abs(dx), abs(dy), abs(dz)
    if x >= y and x >= z:
        face, u, v, w = (0 if dx > 0 else 1), dy, dz, x
    elif y >= z:
        face, u, v, w = (2 if dy > 0 else 3), dx, dz, y
    else:
        face, u, v, w = (4 if dz > 0 else 5), dx, dy, z
    if w == 0.0:
        return 0
    i = min(int((u / w + 1.0) * 0.5 * _FACE), _FACE - 1)
    j = min(int((v / w + 1.0) * 0.5 * _FACE), _FACE - 1)
    return (face * _FACE + i) * _FACE + j


@njit(cache=True, nogil=True)
def _ranges(positions: F32, scan: I32, scanners: F32) -> F32:
    """``(S, 6 * face²)`` least range that each scanner measured in each direction, 0 where it measured nothing."""
    ranges = np.zeros((len(scanners), 6 * _FACE * _FACE), np.float32)
    for i in range(len(positions)):
        d = positions[i] - scanners[scan[i]]
        cell = _cell(d[0], d[1], d[2])
        distance = np.float32(np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]))
        before = ranges[scan[i], cell]
        if before == 0.0 or distance < before:
            ranges[scan[i], cell] = distance
    return ranges


@njit(cache=True, nogil=True)
def _blocked(positions: F32, scanner: F32, ranges: F32, margin: float) -> tuple[int, int]:
    """How many points stand in the way of a scanner, and how many it could see: there, or farther off."""
    blocked, seen = 0, 0
    for i in range(len(positions)):
        d = positions[i] - scanner
        distance = np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
        least = ranges[_cell(d[0], d[1], d[2])]
        if least == 0.0 or distance > least * 1.05 + margin:
            continue
        seen += 1
        blocked += distance < least * 0.95 - margin
    return blocked, seen


def _shifts(surfels: Surfels, pairs: I64, parameters: RegistrationParameters) -> F64:
    """``(n,)`` how far one scan of each pair would have to be moved to fit the other, metres; 0 where nothing tells."""
    patches = _patches(surfels, parameters.cell_m)
    first, second = _met(patches.place)
    normal = patches.normal[first] + patches.normal[second]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    gap = np.einsum("ij,ij->i", normal, patches.mean[second] - patches.mean[first])
    count = int(surfels.scan.max(initial=0)) + 1
    key = patches.scan[first].astype(np.int64) * count + patches.scan[second]
    order = np.argsort(key, kind="stable")
    wanted = pairs[:, 0] * count + pairs[:, 1]
    low, high = np.searchsorted(key[order], wanted), np.searchsorted(key[order], wanted, side="right")
    shift = np.zeros(len(pairs))
    for number, (start, stop) in enumerate(zip(low, high, strict=True)):
        members = order[start:stop]
        if len(members) >= parameters.least_cells:
            shift[number] = _shift(normal[members], gap[members])
    return shift


def _patches(surfels: Surfels, cell_m: float) -> _Patches:
    """Gather what each scan sees in each cell, by the side that it faces."""
    cell = np.floor(surfels.positions / cell_m).astype(np.int64)
    cell -= cell.min(axis=0, initial=0)
    axis = np.argmax(np.abs(surfels.normals), axis=1)
    side = 2 * axis + (np.take_along_axis(surfels.normals, axis[:, None], axis=1)[:, 0] > 0)
    extent = cell.max(axis=0, initial=0) + 1
    key = ((cell[:, 0] * extent[1] + cell[:, 1]) * extent[2] + cell[:, 2]) * _SIDES + side
    order = np.lexsort((surfels.scan, key))
    both = np.column_stack([key[order], surfels.scan[order]])
    starts = np.flatnonzero(np.any(np.diff(both, axis=0, prepend=-1) != 0, axis=1))
    count = np.diff(starts, append=len(order))[:, None]
    mean = np.add.reduceat(surfels.positions[order].astype(np.float64), starts, axis=0) / count
    normal = np.add.reduceat(surfels.normals[order].astype(np.float64), starts, axis=0)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    flat = (length / count)[:, 0] > _FLAT  # what is bent in a cell has no place along one normal
    return _Patches(key[order][starts][flat], surfels.scan[order][starts][flat], mean[flat], (normal / length)[flat])


def _met(place: I64) -> tuple[I64, I64]:
    """Pair patches of scans in one place, as two lists, the smaller scan first; of many each meets the next few."""
    first, second = [], []
    for step in range(1, _MET + 1):
        (same,) = np.nonzero(place[step:] == place[:-step])
        first.append(same)
        second.append(same + step)
    return np.concatenate(first), np.concatenate(second)


def _shift(normal: F64, gap: F64) -> float:
    """Length of the shift that leaves the least sum of gaps; along axes that no surface faces there is none.

    A sum, not one of squares: each axis goes by the middle of the surfaces that face it, be they few, and what only one
    of both scans saw counts little.
    """
    strength, axes = np.linalg.eigh(normal.T @ normal)
    axes = axes[:, strength >= _FEWEST_FACING]
    facing = normal @ axes
    shift: F64 = np.zeros(axes.shape[1])
    weight = np.ones(len(gap))
    for _ in range(_ROUNDS if len(shift) else 0):
        weighted = facing * weight[:, None]
        shift = np.asarray(np.linalg.solve(weighted.T @ facing, weighted.T @ gap), np.float64)
        weight = 1.0 / np.maximum(np.abs(gap - facing @ shift), _GAP_M)
    return float(np.linalg.norm(shift))
