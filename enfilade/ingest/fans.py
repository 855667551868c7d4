"""Fans of rays: spread evenly over the hemisphere in front of a surface, turned differently from place to place."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .records import F32, F64

I64 = NDArray[np.int64]

_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


def fans(first: int, past: int, count: int, members: I64, bounds: I64, starts: F32, normals: F32) -> F32:
    """Return ``((past - first) count, 6) float32`` origins and unit directions of rays, `count` for each place.

    Parameters
    ----------
    first, past
        The places.
    count
        Rays from each.
    members, bounds
        Place p has the surfels ``members[bounds[p]:bounds[p + 1]]``; its rays start at them in turn.
    starts, normals
        ``(M, 3)`` where the rays of each surfel start, and around which unit normal.
    """
    rays = np.empty(((past - first) * count, 6), np.float32)
    _fill(rays, first, past, count, members, bounds, starts, normals)
    return rays


@njit(cache=True, nogil=True)
def _fill(rays: F32, first: int, past: int, count: int, members: I64, bounds: I64, starts: F32, normals: F32) -> None:
    """Fill in a Fibonacci lattice a place, turned and shifted in height by low-discrepancy amounts."""
    direction = np.empty(3)
    at = 0
    for place in range(first, past):
        size = bounds[place + 1] - bounds[place]
        turn = _GOLDEN * place % 1.0
        shift = (place * math.sqrt(2.0)) % 1.0 - 0.5
        for k in range(count):
            member = members[bounds[place] + k * size // count]
            azimuth = 2.0 * math.pi * (_GOLDEN * k + turn)
            height = min(1.0, max(1e-3, (k + 0.5 + shift) / count))
            flat = math.sqrt(1.0 - height * height)
            _turn(flat * math.cos(azimuth), flat * math.sin(azimuth), height, normals[member], direction)
            for axis in range(3):
                rays[at, axis] = starts[member, axis]
                rays[at, 3 + axis] = direction[axis]
            at += 1


@njit(cache=True, nogil=True)
def _turn(x: float, y: float, z: float, normal: F32, turned: F64) -> None:
    """Turn a direction given around +z to be around a unit normal (the frame of Duff et al. 2017)."""
    nx, ny, nz = np.float64(normal[0]), np.float64(normal[1]), np.float64(normal[2])
    sign = 1.0 if nz >= 0.0 else -1.0
    a = -1.0 / (sign + nz)
    b = nx * ny * a
    turned[0] = x * (1.0 + sign * nx * nx * a) + y * b + z * nx
    turned[1] = x * sign * b + y * (sign + ny * ny * a) + z * ny
    turned[2] = -x * sign * nx - y * ny + z * nz
