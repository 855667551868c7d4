"""Sheets of paper and true scales."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from matplotlib.figure import Figure
from matplotlib.transforms import Affine2D

from .canvas import sheet
from .pen import Pen
from .scene import Bounds

MM_PER_IN: Final = 25.4
MARGIN_MM: Final = 8.0
"""From the edge of the paper to the frame."""
_AIR_MM: Final = 7.0
"""From the frame to the building."""
_SIZES: Final = (("A4", 297.0, 210.0), ("A3", 420.0, 297.0))
_LARGE: Final = (("A2", 594.0, 420.0), ("A1", 841.0, 594.0), ("A0", 1189.0, 841.0))
_SCALES: Final = (50, 100, 200)
_LEAST_SCALE: Final = 500


@dataclass(frozen=True, slots=True)
class Sheet:
    """A sheet of paper.

    Attributes
    ----------
    name
        ``A3``.
    width_mm, height_mm
        Of the paper.
    scale
        100 means 1:100.
    band_mm
        Height of the band under the plan.
    """

    name: str
    width_mm: float
    height_mm: float
    scale: int
    band_mm: float

    @property
    def mm_per_m(self) -> float:
        """Millimetres on paper of a metre."""
        return 1000.0 / self.scale

    @property
    def room_mm(self) -> tuple[float, float]:
        """Width and height left for the plan."""
        less = 2 * (MARGIN_MM + _AIR_MM)
        return self.width_mm - less, self.height_mm - less - self.band_mm


def choose_sheet(bounds: Bounds, band_mm: float) -> Sheet:
    """Return the sheet with the largest usual scale that a plan fits on: 1:50 on A4, 1:50 on A3, 1:100 on A4, ..."""
    wide, high = bounds[2] - bounds[0], bounds[3] - bounds[1]
    for candidate in _candidates(band_mm, upright=high > wide):
        across, up = candidate.room_mm
        if wide * candidate.mm_per_m <= across and high * candidate.mm_per_m <= up:
            return candidate
    raise AssertionError  # the candidates do not end


def _candidates(band_mm: float, *, upright: bool) -> Iterator[Sheet]:
    """Yield sheets from the largest scale on; beyond 1:200 on A3 larger papers come before smaller scales."""
    for scale in _SCALES:
        yield from _at(scale, _SIZES, band_mm, upright=upright)
    yield from _at(_SCALES[-1], _LARGE, band_mm, upright=upright)
    scale = _LEAST_SCALE
    while True:
        yield from _at(scale, (*_SIZES, *_LARGE), band_mm, upright=upright)
        scale *= 2


def _at(scale: int, sizes: tuple[tuple[str, float, float], ...], band_mm: float, *, upright: bool) -> Iterator[Sheet]:
    for name, long, short in sizes:
        ways = ((short, long), (long, short)) if upright else ((long, short), (short, long))
        for width, height in ways:
            yield Sheet(name, width, height, scale, band_mm)


def lay_out(paper: Sheet, bounds: Bounds) -> tuple[Figure, Pen, Pen]:
    """Return an empty sheet, a pen that draws metres in the middle of it, and one that draws millimetres."""
    figure = sheet(paper.width_mm / MM_PER_IN, paper.height_mm / MM_PER_IN)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0.0, paper.width_mm), ylim=(0.0, paper.height_mm), autoscale_on=False)
    axes.axis("off")
    left = paper.width_mm / 2 - (bounds[0] + bounds[2]) / 2 * paper.mm_per_m
    middle = (paper.height_mm + paper.band_mm) / 2
    low = middle - (bounds[1] + bounds[3]) / 2 * paper.mm_per_m
    placed = Affine2D().scale(paper.mm_per_m).translate(left, low) + axes.transData
    return figure, Pen(axes, placed, paper.mm_per_m), Pen(axes, axes.transData, 20.0)
