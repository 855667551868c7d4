"""Stairs and hatches as they are drawn in plans."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.path import Path
from numpy.typing import NDArray
from shapely import Polygon, union_all

from .flights import Flight, find_flights, nominal_flight
from .pen import DASHED, FINE_MM, SEEN_MM, SOLID, Pen
from .reveals import PlanGrid
from .scene import PlannedOpening, PlanScene
from .style import INK, PAPER

F64 = NDArray[np.float64]

_CUT_M: Final = 1.2
"""A plan is cut so far above the floor; steps above are drawn dashed."""
_HEAD_M: Final = 0.16
_BREAK_M: Final = 0.12
_LAYER: Final = 3.0
_DOWN_LAYER: Final = 2.0
"""Stairs that lead down lie under those that lead up through the same well."""
_LABEL_PT: Final = 6.5
_USUAL_STOREY_M: Final = 2.8
_WIDEST_M: Final = 2.6
"""Two flights beside each other; a hole wider than that is more than stairs."""


@dataclass(frozen=True, slots=True)
class Stairs:
    """Stairs through one hole, as one storey shows them.

    Attributes
    ----------
    opening
        The opening in the graph.
    flights
        The lowest first.
    upward
        Whether they lead up from this storey; None where that is unknown.
    """

    opening: PlannedOpening
    flights: tuple[Flight, ...]
    upward: bool | None

    @property
    def floor(self) -> list[Polygon]:
        """What they cover of the plan."""
        return [Polygon(flight.corners) for flight in self.flights]


def find_stairs(scene: PlanScene, flights: Mapping[str, Sequence[Flight]]) -> list[Stairs]:
    """Return the stairs of a storey with their flights, given by key of the opening."""
    found = []
    for opening in scene.openings:
        if opening.kind == "stairs":
            floors = _floors(scene, opening)
            here = [_floor(scene, room) for room in opening.rooms if room in scene.rooms]
            known = [floor for floor in here if floor is not None]
            upward = None if floors is None or not known else min(known) < sum(floors) / 2
            found.append(Stairs(opening, tuple(flights[opening.node.id]), upward))
    return found


def all_flights(scenes: Iterable[PlanScene], grid: PlanGrid | None) -> dict[str, list[Flight]]:
    """Find the flights of all stairs in the cloud, else take their holes; by key of the opening."""
    found: dict[str, list[Flight]] = {}
    for scene in scenes:
        for opening in scene.openings:
            if opening.kind != "stairs" or opening.node.id in found:
                continue
            floors = _floors(scene, opening)
            seen = find_flights(grid, opening, *floors) if grid is not None and floors is not None else []
            low, high = floors or (0.0, _USUAL_STOREY_M)
            found[opening.node.id] = seen or [nominal_flight(opening, low, high, _lie(scene, opening))]
    return found


def _floor(scene: PlanScene, room: str) -> float | None:
    floor = scene.graph.nodes[room].properties.get("floor_elevation")
    return None if floor is None else float(floor)


def _floors(scene: PlanScene, opening: PlannedOpening) -> tuple[float, float] | None:
    """Elevations of the floors that stairs lead from and to, None where they are unknown or one."""
    known = sorted(floor for room in opening.rooms if (floor := _floor(scene, room)) is not None)
    return (known[0], known[-1]) if len(known) > 1 and known[-1] > known[0] else None


def _lie(scene: PlanScene, opening: PlannedOpening) -> float:
    """Angle at which a hole of known size fits best into the rooms that it belongs to: along the page or up it."""
    rooms = [scene.rooms[room].polygon for room in opening.rooms if room in scene.rooms]

    def inside(angle: float) -> float:
        shape = Polygon(nominal_flight(opening, 0.0, _USUAL_STOREY_M, angle).corners)
        return sum(float(shape.intersection(room).area) for room in rooms)

    return max((0.0, np.pi / 2), key=inside)


def draw_stairs(pen: Pen, stairs: Stairs, scene: PlanScene) -> None:
    """Draw treads, the line of walking with an arrow, and say "up" or "down".

    Of stairs that lead down, only what the rooms of the storey have over them is seen.
    """
    rooms = [scene.rooms[room].polygon for room in stairs.opening.rooms if room in scene.rooms]
    seen = pen.within(union_all(rooms)) if stairs.upward is False and rooms and stairs.flights[0].measured else pen
    layer = _DOWN_LAYER if stairs.upward is False else _LAYER
    gid: str | None = f"stairs-{stairs.opening.node.id.split('/', 1)[1]}"
    for flight in stairs.flights:
        style = SOLID if flight.measured and not stairs.opening.doubtful else DASHED
        shape = Polygon(flight.corners)
        seen.area(shape, layer=layer, fill=PAPER, edge=INK, weight=SEEN_MM, style=style, gid=gid)
        if flight.measured or min(flight.width, flight.length) <= _WIDEST_M:
            _draw_treads(seen, flight, _cut(flight, stairs), style, layer)
        else:
            a, b, c, d = flight.corners
            seen.lines([np.array([a, c]), np.array([b, d])], layer=layer + 0.1, weight=FINE_MM, style=DASHED)
        if flight.measured:
            _draw_arrow(seen, flight, layer, rising=stairs.upward is not False)
        gid = None
    _write_way(pen, stairs, layer)


def _cut(flight: Flight, stairs: Stairs) -> float:
    """Share of a flight below the cut: all of it where the stairs lead down from here."""
    if stairs.upward is not True or not flight.measured:
        return 1.0
    cut = stairs.flights[0].low + _CUT_M
    return float(np.clip((cut - flight.low) / max(flight.high - flight.low, 1e-6), 0.0, 1.0))


def _draw_treads(pen: Pen, flight: Flight, cut: float, style: object, layer: float) -> None:
    """Draw a line an edge of a tread, dashed above the cut, and the cut itself."""
    half = flight.width / 2 * np.array([-flight.up[1], flight.up[0]])
    shares = np.arange(1, flight.treads + 1) / (flight.treads + 1)
    edges = [
        np.array([middle - half, middle + half]) for middle in flight.foot + np.outer(shares * flight.length, flight.up)
    ]
    below = [edge for edge, share in zip(edges, shares, strict=True) if share <= cut]
    above = [edge for edge, share in zip(edges, shares, strict=True) if share > cut]
    pen.lines(below, layer=layer + 0.1, weight=FINE_MM, style=SOLID if style == SOLID else DASHED)
    pen.lines(above, layer=layer + 0.1, weight=FINE_MM, style=DASHED)
    if 0.0 < cut < 1.0:
        middle, slant = flight.foot + cut * flight.length * flight.up, 0.35 * flight.width * flight.up
        zigzag = _BREAK_M * flight.up
        a, b = middle - 1.15 * half - slant / 2, middle + 1.15 * half + slant / 2
        third = (b - a) / 12
        centre = (a + b) / 2
        pen.lines(
            [
                np.array(
                    [a, centre - third, centre - third / 3 + zigzag, centre + third / 3 - zigzag, centre + third, b]
                )
            ],
            layer=layer + 0.3,
        )


def _draw_arrow(pen: Pen, flight: Flight, layer: float, *, rising: bool) -> None:
    """Draw the line of walking from the first step that one treads on, with an arrow to where it leads."""
    ends = [flight.foot + 0.04 * flight.up, flight.foot + (flight.length - 0.05) * flight.up]
    (start, end), way = (ends, flight.up) if rising else (ends[::-1], -flight.up)
    side = _HEAD_M * np.array([-way[1], way[0]])
    head = [end - _HEAD_M * way + 0.45 * side, end, end - _HEAD_M * way - 0.45 * side]
    pen.lines([np.array([start, end]), np.array(head)], layer=layer + 0.2, weight=SEEN_MM)
    ring = start + 0.05 * np.array([(np.cos(t), np.sin(t)) for t in np.linspace(0, 2 * np.pi, 17)])
    pen.path(Path(ring, closed=True), layer=layer + 0.2, fill=PAPER, weight=SEEN_MM)


def _write_way(pen: Pen, stairs: Stairs, layer: float) -> None:
    """Write "up" at the foot of stairs that lead up, "down" at the head of those that lead down."""
    text = {True: "up", False: "down", None: "stairs"}[stairs.upward]
    flight = stairs.flights[-1] if stairs.upward is False else stairs.flights[0]
    middle = flight.foot + (0.5 if not flight.measured else 0.16 if stairs.upward else 0.84) * flight.length * flight.up
    paper = {"facecolor": PAPER, "edgecolor": "none", "pad": 0.6}
    pen.write(middle, text, _LABEL_PT, layer=layer + 0.9, bbox=paper)


def draw_hatch(pen: Pen, opening: PlannedOpening, name: str) -> None:
    """Draw a hatch as a crossed square, dashed: it lies above or below the cut."""
    half = opening.width / 2
    a, b, c, d = opening.position + half * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    pen.path(Path([a, b, c, d, a], closed=True), layer=_LAYER, weight=SEEN_MM, style=DASHED, gid=f"hatch-{name}")
    pen.lines([np.array([a, c]), np.array([b, d])], layer=_LAYER, weight=FINE_MM, style=DASHED)
