"""Where the names of rooms go: well inside, clear of walls, doors and stairs, as large as the room allows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
import shapely
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextToPath
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon, STRtree
from shapely.errors import GEOSException
from shapely.geometry.base import BaseGeometry
from shapely.ops import polylabel

from .scene import PlannedRoom
from .style import shortened

F64 = NDArray[np.float64]

SIZES_PT: Final = (9.0, 8.0, 7.0, 6.0, 5.2)
"""Sizes of names, the best first; smaller is not read."""
SMALLER: Final = 0.86
"""Size of the lines under the name."""
LINE: Final = 1.25
"""Height of a line in font sizes."""
MM_PER_PT: Final = 25.4 / 72
_CLEAR_MM: Final = 0.7
_TAG_PT: Final = (6.0, 5.0, 4.0)
_GRID: Final = 7
_CJK_EM: Final = 1.0
_MEASURED_PT: Final = 100.0
_DOT_M2: Final = 0.03
"""A room this small is a mere place."""


@dataclass(frozen=True, slots=True)
class Label:
    """What is written in a room.

    Attributes
    ----------
    room
        The room.
    place
        ``(2,)`` centre of the text on the page, metres.
    names, more
        Lines of the name, and lines under it.
    size_pt
        Of the name.
    number
        What stands in the room in place of the text, which goes to a list; None where the text itself does.
    box
        ``(4,)`` xmin, ymin, xmax, ymax of what is written in the room, metres.
    """

    room: PlannedRoom
    place: F64
    names: tuple[str, ...]
    more: tuple[str, ...]
    size_pt: float
    number: int | None
    box: F64


@lru_cache(maxsize=20_000)
def text_width_mm(text: str, size_pt: float, *, bold: bool = False) -> float:
    """Return how wide a text is on paper."""
    if size_pt != _MEASURED_PT:
        return text_width_mm(text, _MEASURED_PT, bold=bold) * size_pt / _MEASURED_PT
    font = FontProperties(size=_MEASURED_PT, weight="bold" if bold else "normal")
    if not text.isascii():
        # What the font lacks is set from another one, at most a square a letter.
        letters = sum(_CJK_EM if ord(letter) > 0x2E80 else 0.68 for letter in text)
        return letters * _MEASURED_PT * MM_PER_PT
    width, _, _ = TextToPath().get_text_width_height_descent(text, font, ismath=False)
    return float(width) * MM_PER_PT


def place_labels(
    rooms: Sequence[PlannedRoom],
    lines: Mapping[str, Sequence[str]],
    obstacles: Sequence[BaseGeometry],
    mm_per_m: float,
    marks: Sequence[BaseGeometry] = (),
) -> list[Label]:
    """Place the names of rooms.

    Parameters
    ----------
    rooms
        The rooms.
    lines
        By key of the room what stands under its name.
    obstacles
        What is to be kept clear beside the walls: swings of doors, stairs.
    mm_per_m
        Scale.
    marks
        What is better kept clear, where the room has the space.

    Returns
    -------
    list of Label
        One a room. Where not even the smallest letters fit, a number takes their place.
    """
    free = _free_floors(rooms, obstacles, mm_per_m)
    tree = STRtree(marks)
    labels: list[Label] = []
    numbers = 0
    for room, floor in zip(rooms, free, strict=True):
        more = tuple(lines.get(room.node.id, ()))
        beside = [marks[number] for number in tree.query(room.polygon)]
        label = _written(room, floor.difference(shapely.union_all(beside)), more, mm_per_m) if beside else None
        label = label or _written(room, floor, more, mm_per_m)
        labels.append(label or _numbered(room, floor, more, 1 + numbers, mm_per_m))
        numbers += label is None
    return labels


def _free_floors(
    rooms: Sequence[PlannedRoom], obstacles: Sequence[BaseGeometry], mm_per_m: float
) -> list[BaseGeometry]:
    """Return each room's floor without what stands on it and a little way from its walls."""
    clear = _CLEAR_MM / mm_per_m
    floors = np.array([room.polygon for room in rooms], dtype=object)
    shrunk = shapely.buffer(floors, -clear)
    # Where rooms lie over one another, as landings over halls do, the smaller one has the place to itself.
    others = [*obstacles, *floors]
    tree = STRtree(others)
    room_index, other = tree.query(floors, predicate="intersects")
    taken: dict[int, list[BaseGeometry]] = {}
    for place, number in zip(room_index.tolist(), other.tolist(), strict=True):
        if number < len(obstacles):
            taken.setdefault(place, []).append(obstacles[number].buffer(clear / 2))
        elif number - len(obstacles) != place and _over(floors, place, number - len(obstacles)):
            taken.setdefault(place, []).append(floors[number - len(obstacles)])
    for place, shapes in taken.items():
        shrunk[place] = shrunk[place].difference(shapely.union_all(shapes))
    return list(shrunk)


def _over(floors: NDArray[np.object_], place: int, other: int) -> bool:
    """Whether another room takes floor of a larger one."""
    sizes = (floors[other].area, other), (floors[place].area, place)
    return bool(sizes[0] < sizes[1] and floors[place].intersection(floors[other]).area > 0.05)


def _written(room: PlannedRoom, floor: BaseGeometry, more: tuple[str, ...], mm_per_m: float) -> Label | None:
    """Return the label with the largest letters that fit, or None."""
    if room.polygon.area < _DOT_M2:
        return _beside(room, more, mm_per_m)
    if floor.is_empty:
        return None
    shapely.prepare(floor)
    wide, high = floor.bounds[2] - floor.bounds[0], floor.bounds[3] - floor.bounds[1]
    places: F64 | None = None
    for size in SIZES_PT:
        for names in breaks(shortened(room.name, 40)):
            across, up = (length / mm_per_m for length in block_mm(names, more, size))
            if across > wide or up > high or across * up > floor.area:
                continue
            places = _places(room, floor) if places is None else places
            half = np.array([across / 2, up / 2])
            fits = shapely.contains(floor, shapely.box(*(places - half).T, *(places + half).T))
            if fits.any():
                return _label(room, places[np.argmax(fits)], names, more, size, across, up)
    return None


def _label(
    room: PlannedRoom, place: F64, names: tuple[str, ...], more: tuple[str, ...], size: float, across: float, up: float
) -> Label:
    half = np.array([across / 2, up / 2])
    return Label(room, place, names, more, size, None, np.concatenate([place - half, place + half]))


def _beside(room: PlannedRoom, more: tuple[str, ...], mm_per_m: float) -> Label:
    """Write the name where a room without outline has its centre."""
    names, size = (shortened(room.name, 40),), SIZES_PT[2]
    across, up = (length / mm_per_m for length in block_mm(names, more, size))
    return _label(room, room.place, names, more, size, across, up)


def _numbered(room: PlannedRoom, floor: BaseGeometry, more: tuple[str, ...], number: int, mm_per_m: float) -> Label:
    """Return a number in place of the name, at the point farthest from walls and doors."""
    sizes = [(size, text_width_mm(str(number), size) / mm_per_m, size * MM_PER_PT / mm_per_m) for size in _TAG_PT]
    parts = [part for part in shapely.get_parts(floor) if isinstance(part, Polygon) and not part.is_empty]
    free = max(parts, key=lambda part: float(part.area), default=room.polygon)
    centre, reach = inmost(free)
    if np.hypot(*sizes[-1][1:]) / 2 > reach:
        centre, reach = inmost(room.polygon)
    size, across, up = next((one for one in sizes if np.hypot(one[1], one[2]) / 2 <= reach), sizes[-1])
    half = np.array([across / 2, up / 2])
    box = np.concatenate([centre - half, centre + half])
    return Label(room, centre, (shortened(room.name, 40),), more, size, number, box)


def inmost(polygon: Polygon) -> tuple[F64, float]:
    """Return the pole of inaccessibility, and its distance from the walls."""
    try:
        pole = polylabel(polygon, tolerance=0.05)
    except GEOSException:
        pole = polygon.representative_point()
    return np.array([pole.x, pole.y]), float(pole.distance(polygon.boundary))


def _places(room: PlannedRoom, floor: BaseGeometry) -> F64:
    """``(k, 2)`` places to try: the middle, the inmost point of what is free, then a grid, the nearest first."""
    largest = max(shapely.get_parts(floor), key=lambda part: float(part.area))
    middle = np.array(largest.centroid.coords[0]) if isinstance(floor, MultiPolygon) else room.place
    pole, _ = inmost(largest)
    x0, y0, x1, y1 = floor.bounds
    steps = (np.arange(_GRID) + 0.5) / _GRID
    grid = np.array([(x0 + a * (x1 - x0), y0 + b * (y1 - y0)) for b in steps for a in steps])
    grid = grid[shapely.contains_xy(floor, grid)]
    order = np.argsort(np.hypot(*(grid - middle).T), kind="stable")
    return np.vstack([middle, pole, grid[order]])


def breaks(name: str) -> list[tuple[str, ...]]:
    """Return a name in one line, in two and in three, as far as it has words."""
    words = name.split(" ")
    return [_balanced(words, count) for count in (1, 2, 3) if len(words) >= count]


def _balanced(words: Sequence[str], count: int) -> tuple[str, ...]:
    """Break words into so many lines, none longer than need be."""
    if count == 1:
        return (" ".join(words),)
    ways = ((" ".join(words[:cut]), *_balanced(words[cut:], count - 1)) for cut in range(1, len(words) - count + 2))
    return min(ways, key=lambda lines: max(len(line) for line in lines))


def block_mm(names: Sequence[str], more: Sequence[str], size_pt: float) -> tuple[float, float]:
    """Width and height of a label on paper."""
    widths = [text_width_mm(line, size_pt, bold=True) for line in names]
    widths += [text_width_mm(line, SMALLER * size_pt) for line in more]
    return max(widths, default=0.0), (len(names) + SMALLER * len(more)) * LINE * size_pt * MM_PER_PT
