"""What a plan shows of a graph: rooms as polygons with a place for their names, openings with their ends."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from shapely import Point, Polygon, STRtree
from shapely.errors import GEOSException
from shapely.ops import polylabel

from enfilade.faces import WallFaces, true_polygon, whole
from enfilade.schema.graph import BuildingGraph, Node
from enfilade.schema.ids import parse
from enfilade.schema.topology import Topology, topology

from .frame import AS_SCANNED, PageFrame
from .style import ROOM_TINTS

F64 = NDArray[np.float64]
Bounds = tuple[float, float, float, float]
"""xmin, ymin, xmax, ymax, metres."""

_NEXT_DOOR_M = 0.6


@dataclass(frozen=True, slots=True)
class PlannedRoom:
    """A room on the plan.

    Attributes
    ----------
    rings
        Outline, ``(K, 2)`` arrays in metres, the outer one first; its bounds or a dot where none is known.
    outlined
        Whether its outline is known.
    place
        ``(2,)`` where its node and name go: well inside.
    tint
        Colour.
    """

    node: Node
    rings: tuple[F64, ...]
    polygon: Polygon
    place: F64
    tint: str
    outlined: bool = True

    @property
    def name(self) -> str:
        """Name, or the key after the slash."""
        return str(self.node.properties.get("name") or self.local)

    @property
    def local(self) -> str:
        """The key after the slash, ``r12``."""
        return self.node.id.split("/", 1)[1]


@dataclass(frozen=True, slots=True)
class PlannedOpening:
    """An opening on the plan.

    Attributes
    ----------
    position
        ``(2,)`` centre, metres.
    along
        ``(2,)`` unit vector along its width.
    upright
        Whether it stands in a wall, so that the plan shows its width; False for a hole in a slab.
    rooms
        Keys of all its rooms, on other storeys too.
    """

    node: Node
    position: F64
    along: F64
    upright: bool
    rooms: tuple[str, ...]

    @property
    def kind(self) -> str:
        """Kind, ``door`` where unknown."""
        return str(self.node.properties.get("kind", "door"))

    @property
    def closed(self) -> bool:
        """Whether its leaf was closed."""
        return self.node.properties.get("state") == "closed"

    @property
    def across(self) -> F64:
        """``(2,)`` unit vector across it."""
        return np.array([-self.along[1], self.along[0]])

    @property
    def ends(self) -> F64:
        """``(2, 2)`` its jambs, metres."""
        half = self.along * self.width / 2
        return np.array([self.position - half, self.position + half])

    @property
    def width(self) -> float:
        """Width, metres; 0.9 where unknown."""
        return float(self.node.properties.get("width", 0.9))

    @property
    def height(self) -> float:
        """Height, metres; 2 where unknown. Of a hole in a slab its longer side."""
        return float(self.node.properties.get("height", 2.0))

    @property
    def middle(self) -> float:
        """Elevation of its centre, metres; 0 where unknown."""
        position = self.node.properties["position"]
        return float(position[2]) if len(position) > 2 else 0.0

    @property
    def doubtful(self) -> bool:
        """Whether it is as likely not there."""
        return float(self.node.properties.get("confidence", 1.0)) < 0.5


@dataclass(frozen=True, slots=True)
class PlanScene:
    """Everything of one storey that has a place on the plan."""

    graph: BuildingGraph
    topology: Topology
    rooms: dict[str, PlannedRoom]
    openings: tuple[PlannedOpening, ...]
    neighbours: tuple[tuple[str, str], ...]
    frame: PageFrame = AS_SCANNED

    @property
    def bounds(self) -> Bounds:
        """Least and greatest x and y of rooms and openings."""
        corners = [ring for room in self.rooms.values() for ring in room.rings]
        corners += [opening.position[None] for opening in self.openings]
        points = np.concatenate(corners)
        low, high = points.min(axis=0), points.max(axis=0)
        return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def plan_scene(
    graph: BuildingGraph,
    rooms: Iterable[str],
    *,
    ends: Topology | None = None,
    frame: PageFrame = AS_SCANNED,
    faces: Mapping[int, WallFaces] = MappingProxyType({}),
) -> PlanScene:
    """Take what the plan of some rooms needs from a graph; rooms without any place in it are left out.

    Parameters
    ----------
    graph
        The building.
    rooms
        Keys of the rooms to show.
    ends
        The graph's topology, where it is at hand.
    frame
        How the building lies on the page.
    faces
        Faces of walls on the page by number of room; outlines are drawn true to them.
    """
    ends = ends or topology(graph)
    shapes = {room: _polygon(graph.nodes[room], frame, faces) for room in rooms}
    known = {room: shape for room, shape in shapes.items() if shape is not None}
    neighbours = {
        (edge.source, edge.target): None
        for edge in graph.of_type("NEIGHBOUR")
        if edge.source in known and edge.target in known
    }
    openings = [
        opening
        for node in graph.of_label("Opening")
        if any(room in known for room in ends.rooms_of[node.id])
        and (opening := _opening(node, ends.rooms_of[node.id], frame)) is not None
    ]
    tints = _tints(known, [*neighbours, *(o.rooms for o in openings if len(o.rooms) == 2)])
    planned = {room: _room(graph.nodes[room], shape, tints[room]) for room, shape in known.items()}
    return PlanScene(graph, ends, planned, tuple(openings), tuple(neighbours), frame)


def outline_rings(properties: Mapping[str, Any]) -> list[F64]:
    """Return the rings of a room's outline, ``(K, 2)`` each; none where it is unknown."""
    rings = [np.asarray(ring, dtype=np.float64) for ring in properties.get("outline", ())]
    if any(len(ring) < 6 or len(ring) % 2 or not np.isfinite(ring).all() for ring in rings):
        return []
    return [ring.reshape(-1, 2) for ring in rings]


def _polygon(node: Node, frame: PageFrame, faces: Mapping[int, WallFaces]) -> Polygon | None:
    """Return the outline, else the bounds, else a dot at the centroid; None where the room has no place."""
    properties = node.properties
    rings = outline_rings(properties)
    if rings:
        polygon = whole(Polygon(frame.points(rings[0]), [frame.points(ring) for ring in rings[1:]]))
        around = faces.get(parse(node.id).numbers[0])
        if polygon is not None:
            return polygon if around is None else true_polygon(polygon, around)
    if "bounds" in properties:
        x0, y0, _, x1, y1, _ = properties["bounds"]
        return Polygon(frame.points(np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])))
    if "centroid" in properties:
        x, y = frame.points(np.asarray(properties["centroid"][:2], dtype=np.float64))
        return Polygon([(x - 0.1, y - 0.1), (x + 0.1, y - 0.1), (x, y + 0.1)])
    return None


def _room(node: Node, polygon: Polygon, tint: str) -> PlannedRoom:
    place = _place(polygon)
    rings = tuple(np.asarray(ring.coords, dtype=np.float64)[:, :2] for ring in (polygon.exterior, *polygon.interiors))
    outlined = bool(outline_rings(node.properties))
    return PlannedRoom(node, rings, polygon, np.array([place.x, place.y]), tint, outlined)


def _place(polygon: Polygon) -> Point:
    """Return the centre of a room where it lies well inside, else the point farthest from the walls."""
    centre = polygon.centroid
    try:
        inmost = polylabel(polygon, tolerance=0.05)
    except GEOSException:
        return polygon.representative_point()
    boundary = polygon.boundary
    inside = polygon.contains(centre) and centre.distance(boundary) > 0.6 * inmost.distance(boundary)
    return centre if inside else inmost


def _opening(node: Node, rooms: tuple[str, ...], frame: PageFrame) -> PlannedOpening | None:
    if "position" not in node.properties:
        return None
    position = frame.points(np.asarray(node.properties["position"][:2], dtype=np.float64))
    normal = frame.directions(np.asarray(node.properties.get("normal", (0.0, 0.0, 1.0))[:2], dtype=np.float64))
    length = float(np.hypot(*normal))
    upright = length > 0.5
    along = np.array([-normal[1], normal[0]]) / length if upright else np.array([1.0, 0.0])
    return PlannedOpening(node, position, along, upright, rooms)


def _tints(shapes: Mapping[str, Polygon], touching: Iterable[tuple[str, ...]]) -> dict[str, str]:
    """Colour rooms so that those next to one another differ: greedily, the tint used least so far first."""
    beside: dict[str, set[str]] = {room: set() for room in shapes}
    rooms = list(shapes)
    outlines = np.array(list(shapes.values()), dtype=object)
    near = STRtree(outlines).query(outlines, predicate="dwithin", distance=_NEXT_DOOR_M).T
    for a, b in [*((rooms[i], rooms[j]) for i, j in near), *touching]:
        if a != b and a in beside and b in beside:
            beside[a].add(b)
            beside[b].add(a)
    tints: dict[str, str] = {}
    used = dict.fromkeys(ROOM_TINTS, 0)
    for room in rooms:
        taken = {tints[other] for other in beside[room] if other in tints}
        free = [tint for tint in ROOM_TINTS if tint not in taken] or list(ROOM_TINTS)
        tints[room] = min(free, key=lambda tint: used[tint])
        used[tints[room]] += 1
    return tints
