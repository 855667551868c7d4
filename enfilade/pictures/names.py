"""Names of rooms, as large as the rooms allow."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from shapely import LineString, Point, Polygon

from .scene import PlannedRoom
from .style import FAINT_INK, halo, shortened, words

_LETTER: Final = 0.64
"""Mean width of a bold letter in font sizes."""
_LINE: Final = 1.22
"""Height of a line in font sizes."""
_AREA_SIZE: Final = 0.85
_SMALLEST_PT: Final = 4.6
_NODE_PT: Final = 4.0
"""From the centre of a room's node to the first line."""


def write_names(
    axes: Axes,
    rooms: Iterable[PlannedRoom],
    points_per_metre: float,
    *,
    largest_pt: float,
    prefixes: Mapping[str, str] = MappingProxyType({}),
) -> None:
    """Write name and area under each room's node; in the smallest rooms just the number.

    `prefixes` by room id are written before the name.
    """
    for room in rooms:
        prefix = prefixes.get(room.node.id)
        name = f"{prefix} · {shortened(room.name)}" if prefix else shortened(room.name)
        area = room.node.properties.get("area")
        lines, size = _fitted(name, room, points_per_metre, largest_pt, lines_more=int(area is not None))
        if size < _SMALLEST_PT:
            lines, size, area = [room.node.id.rsplit("/r", 1)[-1]], _SMALLEST_PT, None
        x, y = room.place
        top = y - _NODE_PT / points_per_metre
        style = words(size, weight="bold", va="top", zorder=8, path_effects=halo(), linespacing=_LINE)
        axes.text(x, top, "\n".join(lines), **style)
        if area is not None:
            style = words(_AREA_SIZE * size, color=FAINT_INK, va="top", zorder=8, path_effects=halo())
            axes.text(x, top - (len(lines) * _LINE + 0.1) * size / points_per_metre, f"{area:.1f} m²", **style)


def _fitted(
    name: str, room: PlannedRoom, points_per_metre: float, largest_pt: float, *, lines_more: int
) -> tuple[list[str], float]:
    """Break a name into one or two lines, whichever may be larger, and return them with their size in points."""
    best: tuple[list[str], float] = ([name], 0.0)
    for lines in _breaks(name):
        count = len(lines) + _AREA_SIZE * lines_more
        size = largest_pt
        for _ in range(3):
            # How wide the room is depends on how far down the text reaches, and that on its size.
            wide, high = _space(room, (_NODE_PT + count * _LINE * size) / points_per_metre)
            longest = max(4, *(len(line) for line in lines))
            size = min(size, wide * points_per_metre / (_LETTER * longest))
            size = min(size, (high * points_per_metre - _NODE_PT) / (count * _LINE))
        if size > 1.1 * best[1]:
            best = (lines, size)
    return best


def _breaks(name: str) -> list[list[str]]:
    """Return the name in one line and, where it has words, in two of similar length."""
    spaces = [place for place, letter in enumerate(name) if letter == " "]
    if not spaces:
        return [[name]]
    middle = min(spaces, key=lambda place: abs(2 * place - len(name)))
    return [[name], [name[:middle], name[middle + 1 :]]]


def _space(room: PlannedRoom, depth: float) -> tuple[float, float]:
    """Width, centred on the node, that is free down to a depth under it, and the free height under it. Metres."""
    x, y = room.place
    low, _, high, _ = room.polygon.bounds
    bottom = room.polygon.bounds[1]
    levels = np.linspace(y - depth, y, 3)
    half = min(_reach(room.polygon, LineString([(low, level), (high, level)]), Point(x, level)) for level in levels)
    return 2 * half, _reach(room.polygon, LineString([(x, bottom), (x, y)]), Point(x, y))


def _reach(polygon: Polygon, line: LineString, centre: Point) -> float:
    """Distance from a point along a line to where the line leaves the room; 0 where the point is not in it."""
    if not polygon.covers(centre):
        return 0.0
    leaving = line.intersection(polygon.boundary)
    return float(centre.distance(leaving)) if not leaving.is_empty else 0.0
