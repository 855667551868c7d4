"""A building as a plan: spaces of any outline, holes in the walls between them, stairs, furniture.

Walls are what is left of the storey's outline between the spaces, so nothing about them has to be said, and two spaces
that leave no gap have no wall. `build` makes a scene of a plan. The built-in demo building, the generated buildings
and the small buildings of the tests are all plans.
"""

from __future__ import annotations

from dataclasses import dataclass

import shapely
from shapely import Polygon

from .roofs import Roof
from .solids import Mesh, Rectangle

Point = tuple[float, float]
AJAR_BELOW_DEG = 50.0
"""A leaf that stands open less than this is ajar."""


@dataclass(frozen=True, slots=True)
class Leaf:
    """The leaf of a door.

    Attributes
    ----------
    angle_deg
        How far it stands open; 0 is closed.
    into
        Which of the hole's two rooms it opens into, 0 or 1.
    hinge
        -1 or 1: at the low or the high end along the hole's axis.
    glass
        Whether the scanner sees through.
    """

    angle_deg: float = 0.0
    into: int = 1
    hinge: int = -1
    glass: bool = False


@dataclass(frozen=True, slots=True)
class Hole:
    """A hole through a wall.

    Attributes
    ----------
    kind
        ``door``, ``passage`` or ``window``.
    rooms
        Names of the spaces on its two sides; None is outside.
    place
        Its middle in plan, somewhere in the wall.
    width, height, sill
        Metres, clear; the sill counts from the higher floor of the two spaces.
    leaf
        Of a door or passage; None where nothing hangs in it.
    lining
        Thickness of the frame that lines a door's hole, metres; 0 for none.
    mullions
        Upright bars that part a window's pane.
    glazed
        Whether a window has panes; a gallery's open side has none.
    """

    kind: str
    rooms: tuple[str | None, str | None]
    place: Point
    width: float
    height: float
    sill: float = 0.0
    leaf: Leaf | None = None
    lining: float = 0.0
    mullions: int = 0
    glazed: bool = True

    @property
    def state(self) -> str | None:
        """``open``, ``ajar`` or ``closed``; None for a passage, where there is nothing to open."""
        if self.kind == "window":
            return "closed" if self.glazed else "open"
        if self.leaf is None:
            return None if self.kind == "passage" else "open"
        if self.leaf.angle_deg == 0:
            return "closed"
        return "ajar" if self.leaf.angle_deg < AJAR_BELOW_DEG else "open"


@dataclass(frozen=True, slots=True)
class Piece:
    """A piece of furniture: where its origin stands in plan, turned anticlockwise, `height` over its room's floor."""

    name: str
    mesh: Mesh
    place: Point
    angle_deg: float = 0.0
    height: float = 0.0


@dataclass(frozen=True, slots=True)
class Mirror:
    """A mirror on a wall: the middle of its foot in plan, the direction it faces, its size, metres over the floor."""

    place: Point
    facing_deg: float
    width: float
    height: float
    above_floor: float


@dataclass(frozen=True, slots=True)
class Space:
    """A space to be a room.

    Attributes
    ----------
    polygon
        Its plan; holes in it are columns.
    floor, roof
        Where they are not the storey's: elevation of the floor, and what is above.
    fixtures
        Solids that belong to the structure: steps, balustrades.
    scanned
        Whether a scanner may be set up in it.
    """

    name: str
    polygon: Polygon
    pieces: tuple[Piece, ...] = ()
    floor: float | None = None
    roof: Roof | None = None
    mirrors: tuple[Mirror, ...] = ()
    fixtures: tuple[Mesh, ...] = ()
    scanned: bool = True


@dataclass(frozen=True, slots=True)
class Level:
    """A storey: clear from `floor` to `ceiling`, metres; `footprint` is its outline where it is not the plan's."""

    name: str
    floor: float
    ceiling: float
    spaces: tuple[Space, ...]
    holes: tuple[Hole, ...] = ()
    footprint: Polygon | None = None


@dataclass(frozen=True, slots=True)
class Run:
    """A straight run of steps: the middle of its foot and of its head in plan, its width, elevations, risers."""

    foot: Point
    head: Point
    width: float
    bottom: float
    top: float
    step_count: int


@dataclass(frozen=True, slots=True)
class Stairs:
    """Stairs from one room up to another.

    Attributes
    ----------
    rooms
        The lower and the upper one.
    runs
        From the lowest up.
    well
        The hole in the slab above, in plan.
    landings
        Plan, lower and upper elevation of each landing between runs.
    balustrades
        Lines of the low walls around the well, on the upper floor.
    """

    rooms: tuple[str, str]
    runs: tuple[Run, ...]
    well: Polygon
    landings: tuple[tuple[Polygon, float, float], ...] = ()
    balustrades: tuple[tuple[Point, Point], ...] = ()

    @property
    def bottom(self) -> float:
        """Elevation of the foot."""
        return self.runs[0].bottom

    @property
    def top(self) -> float:
        """Elevation of the head."""
        return self.runs[-1].top


@dataclass(frozen=True, slots=True)
class Plan:
    """A whole building.

    Attributes
    ----------
    footprint
        Outline of its storeys.
    slab_thickness
        Of the lowest and the topmost slab; those between fill what the storeys leave.
    garden
        Metres of ground around the building; 0 for none.
    ground
        Elevation of the ground; 0.2 m below the lowest floor where None.
    surroundings
        Solids outside: other houses, trees, balconies.
    outdoor_stations
        ``(x, y, z)`` scanner positions outside.
    """

    name: str
    footprint: Polygon
    levels: tuple[Level, ...]
    stairs: tuple[Stairs, ...] = ()
    slab_thickness: float = 0.3
    garden: float = 5.0
    ground: float | None = None
    surroundings: tuple[Mesh, ...] = ()
    outdoor_stations: tuple[tuple[float, float, float], ...] = ()


def rectangle(x0: float, x1: float, y0: float, y1: float) -> Polygon:
    """Return a rectangle of the plan."""
    return shapely.box(x0, y0, x1, y1)


def bounds_of(polygon: Polygon) -> Rectangle:
    """Return least and greatest x, least and greatest y."""
    x0, y0, x1, y1 = polygon.bounds
    return x0, x1, y0, y1
