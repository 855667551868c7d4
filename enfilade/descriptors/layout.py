"""How a descriptor divides space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Layout:
    """Slices, shells and sectors around a vertical axis, what votes for them, and how.

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
    interpolate
        Whether a vote is shared by the bins around it, by how near their middles are; otherwise its own bin gets it
        and the box filter of Eq. 9 spreads it.
    exponent
        A bin's votes are raised to this power: a large flat side fills few bins with many votes, and would outweigh all
        that tells an object from others. 1 for none.
    annulus_weight
        Whether a vote in shell φ counts 1 / (2φ + 1), one over the relative area of its annulus (Eq. 8 means this).
    """

    slices: int = 12
    slice_height_m: float = 0.15
    shells: int = 8
    shell_width_m: float = 0.1
    sectors: int = 16
    cell_m: float = 0.05
    interpolate: bool = True
    exponent: float = 0.35
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
    slices=8,
    slice_height_m=0.25,
    shells=6,
    shell_width_m=0.2,
    sectors=12,
    cell_m=0.0,
    interpolate=False,
    exponent=1.0,
    annulus_weight=True,
)
"""Eqs. 8-10 as printed, with the annulus weight that Eq. 8 means; for comparison."""
