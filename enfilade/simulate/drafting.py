"""From cells to spaces: walls of several thicknesses, open plans, closets, round rooms, columns, raised floors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
import shapely
from shapely import Polygon

from .layouts import ROOM, STAIRWELL, Generator, Layout
from .polygons import polygon_of
from .roofs import Roof
from .solids import Rectangle, cylinder

CLOSET = "closet"
TALL = "tall"
_CLOSET_WALL_M = 0.1
RISER_M = 0.18


@dataclass(frozen=True, slots=True)
class Draft:
    """A space that is being made.

    Attributes
    ----------
    use
        `HUB`, `STAIRWELL`, `ROOM`, `CLOSET`, or `TALL` for a room over two storeys.
    polygon
        Its plan so far.
    owner
        Of a closet the place, among the drafts, of the room that it opens to; otherwise -1.
    raised
        How much its floor lies above the storey's, metres.
    round
        Whether its sides are curved.
    """

    use: str
    polygon: Polygon
    roof: Roof
    owner: int = -1
    raised: float = 0.0
    round: bool = False

    @property
    def area(self) -> float:
        """Of its plan, m²."""
        return float(self.polygon.area)


@dataclass(slots=True)
class Walls:
    """Thickness of the outer walls, and of the inner ones by their line."""

    outer: float
    inner: tuple[float, float]
    random: Generator
    _known: dict[tuple[str, float], float] = field(default_factory=dict)

    def half(self, axis: str, line: float) -> float:
        """Half the thickness of the wall on a line, metres."""
        key = (axis, round(line, 3))
        if key not in self._known:
            self._known[key] = round(float(self.random.uniform(*self.inner)), 2) / 2
        return self._known[key]


def drafts_of(layout: Layout, walls: Walls, roof: Roof) -> list[Draft]:
    """Hollow the cells out, cells without a wall between them together."""
    inside = layout.outline.buffer(-walls.outer, join_style="mitre")
    boxes = [polygon_of(_shrunk(cell.rectangle, walls).intersection(inside)) for cell in layout.cells]
    group = {k: k for k in range(len(boxes))}
    for joined in layout.joined:
        group.update(dict.fromkeys(joined, min(joined)))
    found = []
    for first in sorted(set(group.values())):
        members = [k for k in group if group[k] == first]
        strips = [_strip(boxes[a], boxes[b]) for a in members for b in members if a < b]
        polygon = shapely.union_all([*(boxes[k] for k in members), *strips], grid_size=1e-4)
        if isinstance(polygon, Polygon):
            found.append(Draft(layout.cells[first].use, polygon, roof))
        else:
            found += [Draft(layout.cells[k].use, boxes[k], roof) for k in members]
    return found


def _shrunk(rectangle: Rectangle, walls: Walls) -> Polygon:
    x0, x1, y0, y1 = rectangle
    return shapely.box(
        x0 + walls.half("x", x0), y0 + walls.half("y", y0), x1 - walls.half("x", x1), y1 - walls.half("y", y1)
    )


def _strip(a: Polygon, b: Polygon) -> Polygon:
    """Return what lies between two boxes side by side."""
    (ax0, ay0, ax1, ay1), (bx0, by0, bx1, by1) = a.bounds, b.bounds
    x = (max(ax0, bx0), min(ax1, bx1))
    y = (max(ay0, by0), min(ay1, by1))
    if x[1] - x[0] > 0.5 and 0 <= y[0] - y[1] < 1.0:
        return shapely.box(x[0], y[1] - 1e-4, x[1], y[0] + 1e-4)
    if y[1] - y[0] > 0.5 and 0 <= x[0] - x[1] < 1.0:
        return shapely.box(x[1] - 1e-4, y[0], x[0] + 1e-4, y[1])
    return Polygon()


def with_open_plan(layout: Layout, random: Generator, least: int = 2) -> Layout:
    """Join a few rooms in a row that have the same depth."""
    taken = {k for members in layout.joined for k in members}
    rooms = [k for k, cell in enumerate(layout.cells) if cell.use == ROOM and k not in taken]
    runs = [(a, b) for a, b in pairwise(rooms) if _abut(layout.cells[a].rectangle, layout.cells[b].rectangle)]
    if not runs:
        return layout
    first = int(random.integers(len(runs)))
    members = [*runs[first]]
    while len(members) < least and first + 1 < len(runs) and runs[first + 1][0] == members[-1]:
        first += 1
        members.append(runs[first][1])
    return replace(layout, joined=(*layout.joined, tuple(members)))


def _abut(a: Rectangle, b: Rectangle) -> bool:
    return a[1] == b[0] and a[2:] == b[2:]


def with_closets(drafts: Sequence[Draft], count: int, random: Generator) -> list[Draft]:
    """Carve closets back to back out of rooms that lie side by side, which makes these L-shaped.

    Where no two rooms are large enough, one closet is carved out of the largest.
    """
    found = list(drafts)
    pairs = [(a, b) for a, b in pairwise(range(len(drafts))) if _pairable(drafts[a], drafts[b])]
    random.shuffle(pairs)
    used: set[int] = set()
    for a, b in pairs:
        if count <= 0 or used & {a, b}:
            continue
        count -= 1
        used |= {a, b}
        _carve(found, {a: 1, b: -1}, random)
    whole = [k for k, d in enumerate(drafts) if d.use == ROOM and _rectangular(d) and min(_extent(d)) > 2.2]
    if not used and whole:
        _carve(found, {max(whole, key=lambda k: drafts[k].area): 1}, random)
    return found


def _rectangular(draft: Draft) -> bool:
    return len(draft.polygon.exterior.coords) == 5 and not draft.polygon.interiors


def _extent(draft: Draft) -> tuple[float, float]:
    x0, y0, x1, y1 = draft.polygon.bounds
    return x1 - x0, y1 - y0


def _pairable(a: Draft, b: Draft) -> bool:
    """Whether two rooms lie side by side along x, are rectangles, and large enough to give a closet away."""
    (_, ay0, ax1, ay1), (bx0, by0, _, by1) = a.polygon.bounds, b.polygon.bounds
    whole = all(d.use == ROOM and d.area > 9.0 and _rectangular(d) for d in (a, b))
    wide = all(_extent(d)[0] > 2.6 for d in (a, b))
    return whole and wide and 0 < bx0 - ax1 < 0.6 and ay0 == by0 and ay1 == by1


def _carve(found: list[Draft], sides: dict[int, int], random: Generator) -> None:
    """Carve a closet out of each room at its high (1) or low (-1) end along x, all in the corners on one side."""
    y0, y1 = found[min(sides)].polygon.bounds[1::2]
    length = round(float(random.uniform(1.15, 1.7)), 2)
    span = (y0, y0 + length) if random.random() < 0.5 else (y1 - length, y1)
    for place, side in sides.items():
        deep = round(float(random.uniform(0.65, 0.95)), 2)
        x0, _, x1, _ = found[place].polygon.bounds
        closet = (
            shapely.box(x1 - deep, span[0], x1, span[1]) if side > 0 else shapely.box(x0, span[0], x0 + deep, span[1])
        )
        rest = polygon_of(found[place].polygon.difference(closet.buffer(_CLOSET_WALL_M, join_style="mitre")))
        found.append(Draft(CLOSET, closet, found[place].roof, owner=place))
        found[place] = replace(found[place], polygon=rest)


def with_round_room(drafts: Sequence[Draft], sides: int) -> list[Draft]:
    """Make the squarest room of at least 9 m² round, or with a few sides."""
    fit = [k for k, d in enumerate(drafts) if d.use == ROOM and d.area > 9.0 and len(d.polygon.exterior.coords) == 5]
    if not fit:
        return list(drafts)
    best = min(fit, key=lambda k: _oblong(drafts[k].polygon))
    x0, y0, x1, y1 = drafts[best].polygon.bounds
    angles = 2 * np.pi * (np.arange(sides) + 0.5) / sides
    ring = np.column_stack([np.cos(angles), np.sin(angles)]) / np.cos(np.pi / sides)
    polygon = Polygon(np.array([(x0 + x1) / 2, (y0 + y1) / 2]) + ring * [(x1 - x0) / 2, (y1 - y0) / 2])
    found = list(drafts)
    found[best] = replace(found[best], polygon=polygon, round=True)
    return found


def _oblong(polygon: Polygon) -> float:
    x0, y0, x1, y1 = polygon.bounds
    return abs(float(np.log((x1 - x0) / (y1 - y0))))


def with_columns(drafts: Sequence[Draft], random: Generator) -> list[Draft]:
    """Stand columns in the largest room, square or round."""
    best = max(range(len(drafts)), key=lambda k: drafts[k].area if drafts[k].use == ROOM else 0.0)
    polygon, size = drafts[best].polygon, float(random.uniform(0.3, 0.5))
    x0, y0, x1, y1 = polygon.bounds
    xs = np.linspace(x0, x1, max(2, round((x1 - x0) / 3.6)) + 1)[1:-1]
    ys = np.linspace(y0, y1, max(2, round((y1 - y0) / 4.5)) + 1)[1:-1]
    around = random.random() < 0.4
    for x in xs:
        for y in ys:
            column = shapely.box(x - size / 2, y - size / 2, x + size / 2, y + size / 2)
            if around:
                column = Polygon(cylinder((float(x), float(y)), size / 2, 0, 1, 16).vertices[16:32, :2])
            if polygon.buffer(-1.0).contains(column):
                polygon = polygon.difference(column)
    found = list(drafts)
    found[best] = replace(found[best], polygon=polygon)
    return found


def with_raised_floors(drafts: Sequence[Draft], risers: int, random: Generator) -> list[Draft]:
    """Raise the floor of about a third of the rooms by a few steps."""
    found = list(drafts)
    for k, draft in enumerate(drafts):
        if draft.use == ROOM and draft.area > 6.0 and not draft.round and random.random() < 0.4:
            found[k] = replace(draft, raised=risers * RISER_M)
    for k, draft in enumerate(found):
        if draft.owner >= 0:
            found[k] = replace(draft, raised=found[draft.owner].raised)
    return found


def with_low_ceilings(drafts: Sequence[Draft], random: Generator) -> list[Draft]:
    """Lower the ceilings of small rooms and corridors."""
    lower = round(float(random.uniform(0.15, 0.35)), 2)
    return [
        replace(d, roof=replace(d.roof, ceiling=d.roof.ceiling - lower)) if d.area < 9.0 and d.use != STAIRWELL else d
        for d in drafts
    ]


def with_tall_room(drafts: Sequence[Draft], roof: Roof | None) -> tuple[list[Draft], Polygon]:
    """Take the largest room out, or give it the roof of the storey above; returns its plan, too."""
    best = max(range(len(drafts)), key=lambda k: drafts[k].area if drafts[k].use == ROOM else 0.0)
    found = list(drafts)
    if roof is None:
        return found[:best] + found[best + 1 :], drafts[best].polygon
    found[best] = replace(found[best], use=TALL, roof=roof)
    return found, drafts[best].polygon
