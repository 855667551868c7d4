"""The counts that a descriptor is kept in: what stores hold, graph files carry and distances are taken of."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

TOTAL: Final = 61440
"""Sum of a descriptor's counts: 2¹²·3·5, so that halves, thirds, fifths and tenths are whole counts."""

_ROUNDING: Final = 1e-9
"""Counts closer than this to a whole one are that one: far above float64's noise, far below a count."""


def quantise(values: ArrayLike) -> NDArray[np.uint16]:
    """Turn the values of a histogram into counts that sum to `TOTAL`, by largest remainder.

    Equal remainders are served in order of bins. What `TOTAL` divides comes back exactly:
    ``quantise(counts / TOTAL)`` is ``counts``.

    Parameters
    ----------
    values
        ``(bins,)``, finite, none negative, not all zero; any scale.

    Returns
    -------
    numpy.ndarray
        ``(bins,) uint16``.

    Raises
    ------
    ValueError
        If the values are no histogram.
    """
    given = np.asarray(values, dtype=np.float64)
    total = given.sum()
    if given.ndim != 1 or not np.isfinite(total) or total <= 0 or given.min() < 0:
        raise ValueError("a histogram has one dimension, finite values, none negative, and not only zeros")
    filled = np.flatnonzero(given)
    exact = given[filled] * TOTAL / total
    shares = np.floor(exact + _ROUNDING)
    remainders = np.round(exact - shares, 9)
    missing = TOTAL - int(shares.sum())
    shares[np.argsort(-remainders, kind="stable")[:missing]] += 1
    counts = np.zeros(len(given), dtype=np.uint16)
    counts[filled] = shares
    return counts
