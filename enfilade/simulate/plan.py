"""A building as a plan: rectangular rooms, straight walls with doors and windows, slabs, stairs, furniture.

`build` turns the plan into a scene. The built-in demo building is such a plan, and so are small test buildings.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from . import scene
from .solids import F64, Mesh, Rectangle, box, hexahedron, merge, slab, upright, wall

LEAF_THICKNESS_M = 0.04
LEAF_INSET_M = 0.03
FRAME_M = 0.06
BALUSTRADE_M = (0.08, 0.9)
"""Thickness and height."""


@dataclass(frozen=True, slots=True)
class Hole:
    """A hole in a wall.

    Attributes
    ----------
    kind
        ``door``, ``passage`` or ``window``.
    along
        Metres from the start of the wall to the centre of the hole.
    width, height, sill
        Metres; the sill counts from the floor of the wall's storey.
    rooms
        Names of the rooms on the right and on the left of the wall, seen from start to end; None is outside.
    closed
        Whether a leaf hangs in it.
    """

    kind: str
    along: float
    width: float
    height: float
    rooms: tuple[str | None, str | None]
    sill: float = 0.0
    closed: bool = False


@dataclass(frozen=True, slots=True)
class Wall:
    """A straight wall by its centre line in plan, metres."""

    start: tuple[float, float]
    end: tuple[float, float]
    thickness: float
    holes: tuple[Hole, ...] = ()


@dataclass(frozen=True, slots=True)
class Piece:
    """A piece of furniture: where its origin stands in plan, turned anticlockwise."""

    name: str
    mesh: Mesh
    place: tuple[float, float]
    angle_deg: float = 0.0


@dataclass(frozen=True, slots=True)
class Space:
    """A rectangular room, x0, x1, y0, y1, and what stands in it."""

    name: str
    rectangle: Rectangle
    pieces: tuple[Piece, ...] = ()


@dataclass(frozen=True, slots=True)
class Level:
    """A storey: clear from `floor` to `ceiling`, metres."""

    name: str
    floor: float
    ceiling: float
    spaces: tuple[Space, ...]
    walls: tuple[Wall, ...]


@dataclass(frozen=True, slots=True)
class Flight:
    """A straight flight of stairs that rises along +x from one room to another, with its well in the slab.

    `rectangle` is the flight in plan, `well` the hole above it, `balustrades` are the lines of the low walls
    around it; `step_count` risers.
    """

    rooms: tuple[str, str]
    rectangle: Rectangle
    well: Rectangle
    bottom: float
    top: float
    balustrades: tuple[tuple[tuple[float, float], tuple[float, float]], ...] = ()
    step_count: int = 15


@dataclass(frozen=True, slots=True)
class Plan:
    """A whole building; `footprint` is x0, x1, y0, y1 of its slabs, `garden` the metres of ground around it."""

    name: str
    footprint: Rectangle
    levels: tuple[Level, ...]
    flights: tuple[Flight, ...] = ()
    slab_thickness: float = 0.3
    garden: float = 5.0


def build(plan: Plan) -> scene.Scene:
    """Make the scene of a plan."""
    parts = scene.SceneParts()
    rooms = _rooms(plan)
    numbers = {room.name: room.number for room in rooms}
    furnishings: list[scene.Furnishing] = []
    openings: list[scene.Opening] = []
    _add_slabs(parts, plan)
    for level in plan.levels:
        for line in level.walls:
            openings += _add_wall(parts, level, line, numbers)
        for space in level.spaces:
            furnishings += _add_pieces(parts, level, space, numbers, len(furnishings))
    openings += [_add_flight(parts, flight, plan, numbers) for flight in plan.flights]
    mesh, furnishing, surface, glass = parts.arrays()
    storeys = tuple(scene.Storey(i, level.floor, level.name) for i, level in enumerate(plan.levels))
    return scene.Scene(plan.name, mesh, furnishing, surface, glass, storeys, rooms, tuple(openings), tuple(furnishings))


def _rooms(plan: Plan) -> tuple[scene.Room, ...]:
    rooms: list[scene.Room] = []
    for storey, level in enumerate(plan.levels):
        for space in level.spaces:
            x0, x1, y0, y1 = space.rectangle
            outline = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
            boundary = box([x0, y0, level.floor], [x1, y1, level.ceiling])
            rooms.append(scene.Room(len(rooms), storey, space.name, (outline,), boundary, level.floor, level.ceiling))
    return tuple(rooms)


def _add_slabs(parts: scene.SceneParts, plan: Plan) -> None:
    x0, x1, y0, y1 = plan.footprint
    tops = [plan.levels[0].floor, *(level.floor for level in plan.levels[1:])]
    tops.append(plan.levels[-1].ceiling + plan.slab_thickness)
    bottoms = [tops[0] - plan.slab_thickness, *(level.ceiling for level in plan.levels)]
    for bottom, top in zip(bottoms, tops, strict=True):
        wells = [flight.well for flight in plan.flights if flight.bottom < bottom < flight.top]
        parts.add_structure(slab(plan.footprint, bottom, top, wells))
    if plan.garden > 0:
        ground = (x0 - plan.garden, x1 + plan.garden, y0 - plan.garden, y1 + plan.garden)
        parts.add_structure(slab(ground, tops[0] - 0.4, tops[0] - 0.2, [plan.footprint]))


def _add_wall(parts: scene.SceneParts, level: Level, line: Wall, numbers: dict[str, int]) -> list[scene.Opening]:
    gaps = [
        (
            hole.along - hole.width / 2,
            hole.along + hole.width / 2,
            level.floor + hole.sill,
            level.floor + hole.sill + hole.height,
        )
        for hole in line.holes
    ]
    parts.add_structure(wall(line.start, line.end, line.thickness, (level.floor, level.ceiling), gaps))
    for hole, gap in zip(line.holes, gaps, strict=True):
        if hole.kind == "window":
            _add_window(parts, line, gap)
        elif hole.closed:
            parts.add_structure(_leaf(line, gap))
    return [_opening(level, line, hole, numbers) for hole in line.holes]


def _add_window(parts: scene.SceneParts, line: Wall, gap: Rectangle) -> None:
    u0, u1, z0, z1 = gap
    pane = (u0 + FRAME_M, u1 - FRAME_M, z0 + FRAME_M, z1 - FRAME_M)
    parts.add_structure(_pieces_on_line(line, [*_frame(gap, pane)], FRAME_M))
    parts.add_glass(upright(line.start, line.end, 0.006, pane))


def _frame(outer: Rectangle, inner: Rectangle) -> list[Rectangle]:
    u0, u1, z0, z1 = outer
    return [
        (u0, inner[0], z0, z1),
        (inner[1], u1, z0, z1),
        (inner[0], inner[1], z0, inner[2]),
        (inner[0], inner[1], inner[3], z1),
    ]


def _pieces_on_line(line: Wall, rectangles: Sequence[Rectangle], thickness: float) -> Mesh:
    """Return upright boxes on the centre line of a wall."""
    return merge(upright(line.start, line.end, thickness, rectangle) for rectangle in rectangles)


def _leaf(line: Wall, gap: Rectangle) -> Mesh:
    """Make a closed leaf near the left face of its wall, inset a little."""
    left = _directions(line)[1]
    shift = left * (line.thickness / 2 - LEAF_INSET_M - LEAF_THICKNESS_M / 2)
    return _pieces_on_line(line, [gap], LEAF_THICKNESS_M).moved(shift)


def _directions(line: Wall) -> tuple[F64, F64]:
    """Return unit vectors along a wall and to its left."""
    direction = np.array([*np.subtract(line.end, line.start), 0.0])
    direction /= np.linalg.norm(direction)
    return direction, np.array([-direction[1], direction[0], 0.0])


def _opening(level: Level, line: Wall, hole: Hole, numbers: dict[str, int]) -> scene.Opening:
    direction, left = _directions(line)
    foot = np.array([*line.start, level.floor + hole.sill + hole.height / 2])
    right_room, left_room = (scene.OUTSIDE if name is None else numbers[name] for name in hole.rooms)
    state = None if hole.kind == "passage" else "closed" if hole.closed or hole.kind == "window" else "open"
    return scene.Opening(
        hole.kind,
        state,
        foot + direction * hole.along,
        direction,
        left,
        hole.width,
        hole.height,
        line.thickness,
        hole.sill,
        (right_room, left_room),
    )


def _add_pieces(
    parts: scene.SceneParts, level: Level, space: Space, numbers: dict[str, int], first: int
) -> list[scene.Furnishing]:
    for number, piece in enumerate(space.pieces, start=first):
        parts.add_furnishing(piece.mesh.turned(piece.angle_deg).moved([*piece.place, level.floor]), number)
    return [scene.Furnishing(first + k, numbers[space.name], p.name) for k, p in enumerate(space.pieces)]


def _add_flight(parts: scene.SceneParts, flight: Flight, plan: Plan, numbers: dict[str, int]) -> scene.Opening:
    parts.add_structure(_steps(flight))
    for start, end in flight.balustrades:
        parts.add_structure(wall(start, end, BALUSTRADE_M[0], (flight.top, flight.top + BALUSTRADE_M[1])))
    x0, x1, y0, y1 = flight.well
    middle = (flight.rectangle[2] + flight.rectangle[3]) / 2
    ends = np.array([[flight.rectangle[0], middle, flight.bottom], [flight.rectangle[1], middle, flight.top]])
    return scene.Opening(
        "stairs",
        None,
        np.array([(x0 + x1) / 2, (y0 + y1) / 2, flight.top - plan.slab_thickness / 2]),
        np.array([0.0, 1.0, 0.0]),
        np.array([0.0, 0.0, 1.0]),
        y1 - y0,
        x1 - x0,
        plan.slab_thickness,
        None,
        (numbers[flight.rooms[0]], numbers[flight.rooms[1]]),
        ends,
    )


def _steps(flight: Flight, waist: float = 0.16) -> Mesh:
    """Make steps with a sloped underside, each a solid of its own."""
    x0, x1, y0, y1 = flight.rectangle
    xs = np.linspace(x0, x1, flight.step_count + 1)
    rise = (flight.top - flight.bottom) / flight.step_count
    treads = flight.bottom + rise * np.arange(1, flight.step_count + 1)
    soffit = np.maximum(flight.bottom + rise * np.arange(flight.step_count + 1) - waist, flight.bottom)
    return merge(
        hexahedron([[xs[k + i], y, z] for i in (0, 1) for y in (y0, y1) for z in (soffit[k + i], treads[k])])
        for k in range(flight.step_count)
    )
