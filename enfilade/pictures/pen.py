"""What plans are drawn with: lines of true weights, areas and letters, in metres on a sheet of paper."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.transforms import Transform
from numpy.typing import NDArray
from shapely import Polygon, get_parts
from shapely.geometry.base import BaseGeometry

from .style import INK, words

F64 = NDArray[np.float64]

_POINTS_PER_MM: Final = 72 / 25.4

CUT_MM: Final = 0.35
"""Edge of what is cut through."""
SEEN_MM: Final = 0.25
"""What is seen below the cut: leaves, treads, panes."""
FINE_MM: Final = 0.13
"""Arcs, voids, furniture."""

DASHED: Final = (0, (6, 3))
DOTTED: Final = (0, (1, 2.5))
DASH_DOTTED: Final = (0, (9, 3, 1, 3))
SOLID: Final = "solid"
LineStyle = str | tuple[float, Sequence[float]]


@dataclass(frozen=True, slots=True)
class Pen:
    """Draws on a sheet.

    Attributes
    ----------
    axes
        The whole sheet.
    transform
        From metres of the plan to the sheet.
    mm_per_m
        Scale.
    clip
        What is outside is not drawn, metres of the plan.
    """

    axes: Axes
    transform: Transform
    mm_per_m: float
    clip: Path | None = None

    def within(self, shape: BaseGeometry) -> Pen:
        """Return a pen that draws only within polygons."""
        return replace(self, clip=_outline(shape))

    def _add(self, artist: Artist) -> None:
        self.axes.add_artist(artist)
        if self.clip is not None:
            artist.set_clip_path(self.clip, transform=self.transform)

    def points(self, millimetres: float) -> float:
        """Return a line weight in points; small scales take finer lines, as on drawings by hand."""
        return millimetres * _POINTS_PER_MM * float(np.clip((self.mm_per_m / 20) ** 0.35, 0.5, 1.0))

    def area(self, shape: BaseGeometry, *, layer: float, fill: str, edge: str = "none", **more: Any) -> None:
        """Fill polygons, holes left open."""
        if not shape.is_empty:
            self.path(_outline(shape), layer=layer, fill=fill, edge=edge, **more)

    def path(
        self,
        path: Path,
        *,
        layer: float,
        weight: float = SEEN_MM,
        fill: str = "none",
        edge: str = INK,
        style: LineStyle = SOLID,
        gid: str | None = None,
        **more: Any,
    ) -> None:
        """Draw a path; `gid` names it in an SVG."""
        patch = PathPatch(path, facecolor=fill, edgecolor=edge, transform=self.transform, zorder=layer)
        patch.set(linewidth=self.points(weight), linestyle=style, capstyle="butt", joinstyle="miter", gid=gid, **more)
        self._add(patch)

    def lines(
        self,
        lines: Iterable[F64],
        *,
        layer: float,
        weight: float = SEEN_MM,
        style: LineStyle = SOLID,
        colour: str = INK,
        gid: str | None = None,
    ) -> None:
        """Draw open lines, ``(n, 2)`` each."""
        given = list(lines)
        if given:
            drawn = LineCollection(given, colors=colour, linewidths=self.points(weight), linestyles=[style])
            drawn.set(transform=self.transform, zorder=layer, capstyle="butt", gid=gid)
            self._add(drawn)

    def write(self, place: F64, text: str, size: float, *, layer: float, gid: str | None = None, **more: Any) -> None:
        """Write a text, taken literally."""
        style = words(size, zorder=layer, gid=gid, **more)
        self.axes.text(float(place[0]), float(place[1]), text, transform=self.transform, **style)


def _outline(shape: BaseGeometry) -> Path:
    """Return all rings of polygons as one path."""
    rings = [
        np.asarray(ring.coords)[:, :2]
        for part in get_parts(shape)
        if isinstance(part, Polygon)
        for ring in (part.exterior, *part.interiors)
    ]
    return Path.make_compound_path(*(Path(ring, closed=True) for ring in rings)) if rings else Path(np.empty((0, 2)))
