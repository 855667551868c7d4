"""Divides a building's outline into cells: with a corridor, around a hall, as a flat, as rooms behind one another.

Cells are rectangles between the centre lines of walls; what becomes of them is for `drafting` to say.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
import shapely
from shapely import Polygon

from .polygons import polygon_of
from .solids import Rectangle

Generator = np.random.Generator
HUB = "hub"
STAIRWELL = "stairwell"
ROOM = "room"
_STAIRWELL_M = (2.75, 5.3)
"""Width and depth that stairs of two runs want, walls included."""


@dataclass(frozen=True, slots=True)
class Cell:
    """A rectangle x0, x1, y0, y1 between wall lines, and what it is for: `HUB`, `STAIRWELL` or `ROOM`."""

    use: str
    rectangle: Rectangle

    @property
    def size(self) -> tuple[float, float]:
        """Extent along x and y."""
        x0, x1, y0, y1 = self.rectangle
        return x1 - x0, y1 - y0


@dataclass(frozen=True, slots=True)
class Layout:
    """The cells of a storey, groups of cells (by place) with no wall between them, and the outline."""

    cells: tuple[Cell, ...]
    joined: tuple[tuple[int, ...], ...]
    outline: Polygon


@dataclass(frozen=True, slots=True)
class Frame:
    """What all storeys have in common.

    Attributes
    ----------
    width, depth
        Of the outline, metres.
    wing
        Length of a wing towards +y, 0 for none.
    line
        Elevation in plan (y) of the corridor's lower side.
    corridor
        Its width.
    stairs
        Whether there is a stairwell.
    room_width
        Least and greatest width of rooms in a row.
    """

    width: float
    depth: float
    wing: float
    line: float
    corridor: float
    stairs: bool
    room_width: tuple[float, float]


def corridor_layout(frame: Frame, random: Generator) -> Layout:
    """Rooms on both sides of a corridor, which goes round the corner where there is a wing."""
    width, top = frame.width, frame.line + frame.corridor
    cells = [Cell(HUB, (0.0, width, frame.line, top))]
    joined: list[tuple[int, ...]] = []
    end = width
    if frame.wing > 0:
        end = width - 4.6 - frame.corridor
        cells.append(Cell(HUB, (end, end + frame.corridor, top, frame.depth + frame.wing)))
        joined.append((0, 1))
        lines = _split(top, frame.depth + frame.wing, frame.room_width, random)
        cells += [Cell(ROOM, (end + frame.corridor, width, a, b)) for a, b in pairwise(lines)]
    start = 0.0
    if frame.stairs:
        start = _STAIRWELL_M[0]
        cells.append(Cell(STAIRWELL, (0.0, start, top, frame.depth)))
    cells += [Cell(ROOM, (a, b, top, frame.depth)) for a, b in pairwise(_split(start, end, frame.room_width, random))]
    cells += [Cell(ROOM, (a, b, 0.0, frame.line)) for a, b in pairwise(_split(0.0, width, frame.room_width, random))]
    return Layout(tuple(cells), tuple(joined), _outline(frame, end))


def hall_layout(frame: Frame, random: Generator) -> Layout:
    """Rooms around a hall, which has the stairs in it."""
    width, top = frame.width, frame.line + frame.corridor
    west = 0.0 if random.random() < 0.5 else 2.6
    hall = min(west + max(6.4, 0.55 * width), width - 2.6)
    cells = [Cell(HUB, (west, hall, frame.line, top))]
    if west > 0:
        cells.append(Cell(ROOM, (0.0, west, frame.line, top)))
    cells.append(Cell(ROOM, (hall, width, frame.line, top)))
    for low, high in ((0.0, frame.line), (top, frame.depth)):
        cells += [Cell(ROOM, (a, b, low, high)) for a, b in pairwise(_split(0.0, width, frame.room_width, random))]
    joined: list[tuple[int, ...]] = []
    east = next(k for k, cell in enumerate(cells) if cell.rectangle[0] == hall)
    corner = next(k for k, cell in enumerate(cells) if cell.rectangle[1] == width and cell.rectangle[2] == top)
    if cells[corner].rectangle[0] >= hall - 0.5 or random.random() < 0.6:
        joined.append((east, corner))
    return Layout(tuple(cells), tuple(joined), _outline(frame, width))


def flat_layout(frame: Frame, random: Generator) -> Layout:
    """Put a short corridor between rooms, and a large room across its end."""
    width, top = frame.width, frame.line + frame.corridor
    end = width * float(random.uniform(0.5, 0.62))
    cells = [Cell(HUB, (0.0, end, frame.line, top))]
    start = 0.0
    if frame.stairs:
        start = _STAIRWELL_M[0]
        cells.append(Cell(STAIRWELL, (0.0, start, top, frame.depth)))
    cells += [Cell(ROOM, (a, b, top, frame.depth)) for a, b in pairwise(_split(start, end, frame.room_width, random))]
    cells += [Cell(ROOM, (a, b, 0.0, frame.line)) for a, b in pairwise(_split(0.0, end, frame.room_width, random))]
    kitchen = frame.line if random.random() < 0.5 else 0.0
    first = len(cells)
    if kitchen > 0:
        cells += [Cell(ROOM, (end, width, 0.0, kitchen)), Cell(ROOM, (end, width, kitchen, frame.depth))]
        joined = ((first, first + 1),) if random.random() < 0.5 else ()
        return Layout(tuple(cells), joined, _outline(frame, width))
    cells.append(Cell(ROOM, (end, width, 0.0, frame.depth)))
    return Layout(tuple(cells), (), _outline(frame, width))


def suite_layout(frame: Frame, random: Generator) -> Layout:
    """Rooms of many sizes that open into one another, halved again and again."""
    cells: list[Cell] = []
    start = 0.0
    if frame.stairs:
        start, deep = _STAIRWELL_M
        cells += [Cell(STAIRWELL, (0.0, start, 0.0, deep)), Cell(ROOM, (0.0, start, deep, frame.depth))]
    rooms = _halved((start, frame.width, 0.0, frame.depth), random)
    middle = np.array([frame.width / 2, frame.depth / 2])
    centres = [np.array([(r[0] + r[1]) / 2, (r[2] + r[3]) / 2]) for r in rooms]
    central = int(np.argmin([np.linalg.norm(centre - middle) for centre in centres]))
    cells += [Cell(HUB if k == central else ROOM, rectangle) for k, rectangle in enumerate(rooms)]
    return Layout(tuple(cells), (), _outline(frame, frame.width))


LAYOUTS: Final[dict[str, Callable[[Frame, Generator], Layout]]] = {
    "corridor": corridor_layout,
    "hall": hall_layout,
    "flat": flat_layout,
    "suite": suite_layout,
}


def _split(low: float, high: float, width: tuple[float, float], random: Generator) -> list[float]:
    """Lines from low to high, so far apart as rooms are wide."""
    lines = [low]
    while high - lines[-1] > 1.9 * width[0]:
        step = float(random.uniform(*width))
        if high - lines[-1] - step < 0.9 * width[0]:
            break
        lines.append(round(lines[-1] + step, 2))
    return [*lines, high]


def _halved(rectangle: Rectangle, random: Generator) -> list[Rectangle]:
    x0, x1, y0, y1 = rectangle
    wide = x1 - x0 >= y1 - y0
    long = max(x1 - x0, y1 - y0)
    if long < 5.2 or (x1 - x0) * (y1 - y0) < random.uniform(10.0, 26.0):
        return [rectangle]
    cut = round(float(random.uniform(0.4, 0.6)) * long + (x0 if wide else y0), 2)
    halves = ((x0, cut, y0, y1), (cut, x1, y0, y1)) if wide else ((x0, x1, y0, cut), (x0, x1, cut, y1))
    return [cell for half in halves for cell in _halved(half, random)]


def _outline(frame: Frame, wing_from: float) -> Polygon:
    main = shapely.box(0.0, 0.0, frame.width, frame.depth)
    if frame.wing <= 0:
        return main
    return polygon_of(shapely.union(main, shapely.box(wing_from, 0.0, frame.width, frame.depth + frame.wing)))
