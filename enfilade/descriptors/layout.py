"""How a descriptor divides space, and the counts that it is kept in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

TOTAL: Final = 61440
"""Sum of a descriptor's counts: 2¹²·3·5, so that halves, thirds, fifths and tenths are whole counts."""

_ROUNDING: Final = 1e-9
"""Counts closer than this to a whole one are that one: far above float64's noise, far below a count."""


@dataclass(frozen=True, slots=True)
class Layout:
    """Slices, shells and sectors around a vertical axis, and what votes for them.

    Attributes
    ----------
    slices
        Θ, horizontal slices above the base.
    slice_height_m
        Height of a slice.
    shells
        Φ, concentric shells around the axis.
    shell_width_m
        Width of a shell.
    sectors
        Ψ, sectors of equal angle.
    cell_m
        Points within one cubic cell of this side vote once, at their mean; 0 lets every point vote.
    annulus_weight
        Whether a vote in shell φ counts 1 / (2φ + 1), one over the relative area of its annulus (Eq. 8 means this).
    """

    slices: int = 12
    slice_height_m: float = 0.15
    shells: int = 8
    shell_width_m: float = 0.15
    sectors: int = 16
    cell_m: float = 0.05
    annulus_weight: bool = False

    @property
    def shape(self) -> tuple[int, int, int]:
        """Slices, shells, sectors; a flat descriptor runs through the sectors fastest."""
        return self.slices, self.shells, self.sectors

    @property
    def bins(self) -> int:
        """Length of a flat descriptor."""
        return self.slices * self.shells * self.sectors


DEFAULT_LAYOUT: Final = Layout()

PAPER_LAYOUT: Final = Layout(
    slices=8, slice_height_m=0.25, shells=6, shell_width_m=0.2, sectors=12, cell_m=0.0, annulus_weight=True
)
"""Eqs. 8-10 as printed, with the annulus weight that Eq. 8 means; for comparison."""


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
    exact = given * TOTAL / total
    counts = np.floor(exact + _ROUNDING)
    remainders = np.round(exact - counts, 9)
    missing = TOTAL - int(counts.sum())
    counts[np.argsort(-remainders, kind="stable")[:missing]] += 1
    return np.asarray(counts, dtype=np.uint16)
