"""Point moments and the plane that fits them: small compiled arithmetic that several stages share."""

from __future__ import annotations

import math

from numba import njit

from .records import F64

MOMENTS = 10
"""Columns of a row of moments: count, sums of x y z, sums of xx xy xz yy yz zz."""


@njit(cache=True, nogil=True)
def add_point(moments: F64, x: float, y: float, z: float) -> None:
    """Add a point to a row of moments ``(10,)``."""
    moments[0] += 1.0
    moments[1] += x
    moments[2] += y
    moments[3] += z
    moments[4] += x * x
    moments[5] += x * y
    moments[6] += x * z
    moments[7] += y * y
    moments[8] += y * z
    moments[9] += z * z


@njit(cache=True, nogil=True)
def fit_plane(moments: F64, normal: F64) -> tuple[float, float, float]:
    """Fit a plane to a row of moments.

    Parameters
    ----------
    moments
        ``(10,)``.
    normal
        ``(3,)``, filled with the unit normal.

    Returns
    -------
    The three variances, least first: along the normal and the two axes in the plane.
    """
    n = moments[0]
    mx, my, mz = moments[1] / n, moments[2] / n, moments[3] / n
    xx = moments[4] / n - mx * mx
    xy = moments[5] / n - mx * my
    xz = moments[6] / n - mx * mz
    yy = moments[7] / n - my * my
    yz = moments[8] / n - my * mz
    zz = moments[9] / n - mz * mz
    least, middle, greatest = _eigenvalues(xx, xy, xz, yy, yz, zz)
    _null_vector(xx - least, xy, xz, yy - least, yz, zz - least, normal)
    return least, middle, greatest


@njit(cache=True, nogil=True)
def _eigenvalues(xx: float, xy: float, xz: float, yy: float, yz: float, zz: float) -> tuple[float, float, float]:
    """Eigenvalues of a symmetric 3x3 matrix, least first, by the trigonometric formula."""
    mean = (xx + yy + zz) / 3.0
    off = xy * xy + xz * xz + yz * yz
    spread = (xx - mean) ** 2 + (yy - mean) ** 2 + (zz - mean) ** 2 + 2.0 * off
    if spread <= 0.0:
        return mean, mean, mean
    p = math.sqrt(spread / 6.0)
    a, b, c = (xx - mean) / p, (yy - mean) / p, (zz - mean) / p
    d, e, f = xy / p, xz / p, yz / p
    half = (a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e)) / 2.0
    angle = math.acos(min(1.0, max(-1.0, half))) / 3.0
    greatest = mean + 2.0 * p * math.cos(angle)
    least = mean + 2.0 * p * math.cos(angle + 2.0 * math.pi / 3.0)
    return least, 3.0 * mean - greatest - least, greatest


@njit(cache=True, nogil=True)
def _null_vector(xx: float, xy: float, xz: float, yy: float, yz: float, zz: float, out: F64) -> None:
    """Write the unit vector that a singular symmetric matrix maps to zero: the longest cross product of its rows."""
    best = 0.0
    out[0], out[1], out[2] = 0.0, 0.0, 1.0
    rows = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
    for i, j in ((0, 1), (0, 2), (1, 2)):
        a, b = rows[i], rows[j]
        x = a[1] * b[2] - a[2] * b[1]
        y = a[2] * b[0] - a[0] * b[2]
        z = a[0] * b[1] - a[1] * b[0]
        length = math.sqrt(x * x + y * y + z * z)
        if length > best:
            best = length
            out[0], out[1], out[2] = x / length, y / length, z / length
