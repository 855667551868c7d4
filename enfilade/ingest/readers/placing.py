"""Points of a scanner in the coordinates that all scans share, a chunk at a time."""

from __future__ import annotations

from typing import Any, Final, TypeVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enfilade.ingest.records import F64, Bool

CHUNK: Final = 1 << 18
"""Points that a reader hands on at once, at most."""

T = TypeVar("T", bound=np.generic)


def place(
    first: F64, second: F64, third: F64, state: NDArray[np.int8], spherical: bool, rotation: F64, translation: F64
) -> tuple[F64, Bool]:
    """Bring coordinates of a scanner into the common frame; what is invalid or no finite number is left out.

    Parameters
    ----------
    first, second, third
        ``(n,)``: x, y, z; or range, azimuth, elevation where `spherical`; metres, radians.
    state
        ``(n,)``, 0 where the coordinates are valid (1 is a direction only, 2 is nothing); empty if all are.
    rotation, translation
        ``(3, 3)`` and ``(3,)``, the scanner's pose.

    Returns
    -------
    tuple
        ``(m, 3)`` positions and ``(n,)`` which of the points they are.
    """
    positions, kept, count = _place(first, second, third, state, spherical, rotation, translation)
    return positions[:count], kept


def compacted(values: NDArray[T], kept: Bool) -> NDArray[T]:
    """Return a copy of the values of the points that were kept."""
    return values.copy() if kept.all() else values[kept]


def usable(positions: F64) -> Bool:
    """``(n,)``, where all three coordinates are finite numbers."""
    return np.asarray(np.isfinite(positions).all(axis=1))


@njit(cache=True, nogil=True)
def _place(
    first: F64, second: F64, third: F64, state: NDArray[np.int8], spherical: bool, rotation: F64, translation: F64
) -> tuple[Any, Any, int]:
    n = len(first)
    positions = np.empty((n, 3))
    kept = np.zeros(n, np.bool_)
    count = 0
    for i in range(n):
        if len(state) > 0 and state[i] != 0:
            continue
        x, y, z = first[i], second[i], third[i]
        if spherical:
            level = x * np.cos(z)
            x, y, z = level * np.cos(y), level * np.sin(y), x * np.sin(z)
        if not (np.isfinite(x) and np.isfinite(y) and np.isfinite(z)):
            continue
        for axis in range(3):
            positions[count, axis] = (
                rotation[axis, 0] * x + rotation[axis, 1] * y + rotation[axis, 2] * z + translation[axis]
            )
        kept[i] = True
        count += 1
    return positions, kept, count
