"""Doors, passages and windows as they are drawn in plans."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.path import Path
from numpy.typing import NDArray
from shapely import LineString, Polygon, get_coordinates, union_all
from shapely.geometry.base import BaseGeometry

from .pen import DASHED, DOTTED, FINE_MM, SEEN_MM, SOLID, Pen
from .scene import PlannedRoom
from .style import INK, PAPER
from .walls import Gap

F64 = NDArray[np.float64]

SWING_NOTE: Final = (
    "Swing of doors not measured: drawn into the room with fewer doors, hung at the jamb nearer to a corner."
)

_WIDEST_LEAF_M: Final = 1.30
WIDEST_DOOR_M: Final = 2.20
"""Wider openings have no leaves, only a lintel."""
_LEAF_M: Final = 0.04
_AJAR_DEG: Final = 30.0
_OPEN_DEG: Final = {"open": 90.0, "ajar": _AJAR_DEG, "closed": 0.0}
_CUT_HEIGHT_M: Final = 1.2
_PANE_M: Final = 0.05
_LOOK_M: Final = 0.15
_AS_NEAR_M: Final = 0.05
_NEARBY_M: Final = 2.0
_ENTRY_M: Final = 0.30

LAYER: Final = 4.0


@dataclass(frozen=True, slots=True)
class Leaf:
    """One leaf of a door: where it hangs, where it shuts, where it swings to.

    Attributes
    ----------
    hinge
        ``(2,)`` on the face that it swings from.
    shut
        ``(2,)`` unit direction of the shut leaf from its hinge.
    swing
        ``(2,)`` unit direction into the room.
    length
        Metres.
    """

    hinge: F64
    shut: F64
    swing: F64
    length: float

    def at(self, degrees: float) -> F64:
        """Return the unit direction of the leaf, opened so far."""
        angle = np.radians(degrees)
        return np.asarray(np.cos(angle) * self.shut + np.sin(angle) * self.swing)

    def sector(self) -> Polygon:
        """Floor that the leaf sweeps."""
        angle = np.radians(np.arange(0, 91, 15))[:, None]
        arc = self.hinge + self.length * (np.cos(angle) * self.shut + np.sin(angle) * self.swing)
        return Polygon(np.vstack([self.hinge, arc]))


def leaved(one: Gap) -> bool:
    """Whether an opening is drawn with leaves."""
    return one.opening.kind == "door" and one.opening.width <= WIDEST_DOOR_M


def hang_doors(gaps: Sequence[Gap], rooms: Mapping[str, PlannedRoom]) -> dict[str, list[Leaf]]:
    """Hang all doors by the convention of `SWING_NOTE`, as far as their leaves do not meet; by key."""
    doors = Counter(room for one in gaps if one.opening.kind != "window" for room in one.opening.rooms)
    swept: dict[tuple[str, int, int], list[BaseGeometry]] = {}
    hung: dict[str, list[Leaf]] = {}
    for one in gaps:
        if not leaved(one):
            continue
        ways = list(_ways(one, rooms, doors))
        room, leaves = min(ways, key=lambda way: _trouble(way, rooms, swept))
        hung[one.opening.node.id] = leaves
        for cell in _cells(leaves):
            swept.setdefault((room, *cell), []).extend(leaf.sector() for leaf in leaves)
    return hung


def _ways(one: Gap, rooms: Mapping[str, PlannedRoom], doors: Mapping[str, int]) -> Iterator[tuple[str, list[Leaf]]]:
    """Yield the room that a door may swing into and its leaves, the usual way first."""
    inside = [key for key in one.inward if key in rooms]
    inside.sort(key=lambda key: (doors.get(key, 0), rooms[key].polygon.area, key))
    for room in inside or [""]:
        side = one.inward.get(room, 1)
        opening, swing, face = one.opening, side * one.opening.across, one.face(side) * one.opening.across
        (a, b), along, width = (end + face for end in opening.ends), opening.along, opening.width
        if width > _WIDEST_LEAF_M:
            yield room, [Leaf(a, along, swing, width / 2), Leaf(b, -along, swing, width / 2)]
            continue
        clear = _to_corners(one, rooms[room].polygon, side) if room else [0.0, 0.0]
        hinges = [Leaf(a, along, swing, width), Leaf(b, -along, swing, width)]
        for leaf in hinges if clear[0] <= clear[1] + _AS_NEAR_M else hinges[::-1]:
            yield room, [leaf]


def _trouble(
    way: tuple[str, list[Leaf]],
    rooms: Mapping[str, PlannedRoom],
    swept: Mapping[tuple[str, int, int], Sequence[BaseGeometry]],
) -> float:
    """Floor that leaves would sweep and another leaf does too, or that is none of the room's; m² to a tenth."""
    room, leaves = way
    if not room:
        return 0.0
    sweep = union_all([leaf.sector() for leaf in leaves])
    others = {id(shape): shape for cell in _cells(leaves) for shape in swept.get((room, *cell), ())}
    shared = sum(float(sweep.intersection(other).area) for other in others.values())
    return round(shared + float(sweep.difference(rooms[room].polygon).area), 1)


def _cells(leaves: Sequence[Leaf]) -> set[tuple[int, int]]:
    """Squares of the plan that leaves touch, by which those close by are found."""
    x0, y0, x1, y1 = (int(value // _NEARBY_M) for value in union_all([leaf.sector() for leaf in leaves]).bounds)
    return {(x, y) for x in range(x0, x1 + 1) for y in range(y0, y1 + 1)}


def _to_corners(one: Gap, room: Polygon, side: int) -> list[float]:
    """Distance from an opening to the next corner of its room along the wall, backwards and forwards."""
    opening = one.opening
    centre = opening.position + (one.face(side) + side * _LOOK_M) * opening.across
    reach = np.hypot(room.bounds[2] - room.bounds[0], room.bounds[3] - room.bounds[1])
    found = []
    for way in (-opening.along, opening.along):
        hit = LineString([centre, centre + reach * way]).intersection(room.boundary)
        places = (get_coordinates(hit) - centre) @ way
        found.append(float(places.min()) if len(places) else np.inf)
    return found


def draw_door(pen: Pen, one: Gap, hung: Sequence[Leaf]) -> None:
    """Draw the leaves as they were seen, with the arcs of their swing; dashed where the door is doubtful."""
    opening = one.opening
    degrees = _OPEN_DEG.get(str(opening.node.properties.get("state")), 90.0)
    style = DASHED if opening.doubtful else SOLID
    boards, arcs = [], []
    for leaf in hung:
        way, across = leaf.at(degrees), leaf.at(degrees - 90)
        # A shut leaf lies within the wall, an open one beside the jamb that it hangs on.
        thick = across * _LEAF_M
        tip = leaf.hinge + leaf.length * way
        boards.append(Path([leaf.hinge, tip, tip + thick, leaf.hinge + thick, leaf.hinge], closed=True))
        arcs.append(Path([leaf.hinge + leaf.length * leaf.at(step) for step in np.linspace(0, 90, 25)]))
    name = f"door-{opening.node.id.split('/', 1)[1]}"
    pen.path(Path.make_compound_path(*boards), layer=LAYER, fill=PAPER, weight=SEEN_MM, style=style, gid=name)
    pen.path(Path.make_compound_path(*arcs), layer=LAYER - 0.1, weight=FINE_MM, style=style)
    if len(opening.rooms) == 1 and one.inward:
        _draw_entry(pen, one)


def _draw_entry(pen: Pen, one: Gap) -> None:
    """Point from outside to a door of the house."""
    side = next(iter(one.inward.values()))
    opening, inwards = one.opening, side * one.opening.across
    tip = opening.position + one.face(-side) * opening.across - 0.12 * inwards
    base = tip - _ENTRY_M * inwards
    corners = [tip, base + 0.6 * _ENTRY_M * opening.along, base - 0.6 * _ENTRY_M * opening.along, tip]
    pen.path(Path(corners, closed=True), layer=LAYER, fill=INK, weight=FINE_MM)


def draw_lintel(pen: Pen, one: Gap) -> None:
    """Draw the lintel over a wide opening, dashed on both faces: it lies above the cut."""
    name = f"door-{one.opening.node.id.split('/', 1)[1]}"
    edges = [one.opening.ends + offset * one.opening.across for offset in (one.near, one.far)]
    pen.lines(edges, layer=LAYER, weight=FINE_MM, style=DASHED, gid=name)


def draw_passage(pen: Pen, one: Gap) -> None:
    """Leave the break in the wall open; dots say that two rooms meet here."""
    name = f"passage-{one.opening.node.id.split('/', 1)[1]}"
    # Outlines of both rooms may reach into it; the hole itself was measured.
    middle = one.opening.ends + float(np.clip(0.0, one.near, one.far)) * one.opening.across
    pen.lines([middle], layer=LAYER, weight=FINE_MM, style=DASHED if one.opening.doubtful else DOTTED, gid=name)


def draw_window(pen: Pen, one: Gap) -> None:
    """Draw both faces of the wall and a double pane; dashed where the cut passes under the sill, or in doubt."""
    opening = one.opening
    sill = float(opening.node.properties.get("sill", 0.0))
    style = DASHED if opening.doubtful or sill >= _CUT_HEIGHT_M else SOLID
    middle = (one.near + one.far) / 2
    pane = min(_PANE_M / 2, (one.far - one.near) / 6)
    frame = one.corners(one.near, one.far)
    inner = one.corners(middle - pane, middle + pane)
    name = f"window-{opening.node.id.split('/', 1)[1]}"
    outline = Path([*frame, frame[0]], closed=True)
    pen.path(outline, layer=LAYER - 0.2, fill=PAPER, weight=SEEN_MM, style=style, gid=name)
    pen.lines([inner[:2], inner[2:]], layer=LAYER, weight=FINE_MM, style=style)
