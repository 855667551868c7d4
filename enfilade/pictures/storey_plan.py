"""One storey ready to be drawn: walls, openings, stairs, voids, and what must be said about them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from typing import Final

import numpy as np
from numpy.typing import NDArray
from shapely import Polygon, union_all
from shapely.geometry.base import BaseGeometry

from enfilade.clouds import LabelledCloud
from enfilade.faces import WallFaces
from enfilade.schema.graph import BuildingGraph, Node
from enfilade.schema.ids import parse
from enfilade.schema.topology import Topology, topology

from .endings import wall_cells
from .faces import wall_faces
from .flights import Flight
from .frame import PageFrame, page_frame
from .furniture import object_outlines
from .leaves import Leaf, hang_doors
from .reveals import PlanGrid, outer_thickness, plan_grid
from .scene import Bounds, PlannedOpening, PlanScene, outline_rings, plan_scene
from .steps import Stairs, all_flights, find_stairs
from .walls import USUAL_THICKNESS_M, Gap, Walls, build_walls, gap

F64 = NDArray[np.float64]

_VOID_M: Final = 1.0
"""A room whose ceiling is so far above the floor of the next storey reaches through it."""
_LEAST_VOID_M2: Final = 0.8
_LEVEL_M: Final = 0.08
"""A floor so far from the storey's elevation has its own level written."""


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What all storeys of a building share.

    Attributes
    ----------
    frame
        How the building lies on the page.
    faces
        Faces of walls by number of room.
    grid
        All points by place; None without a cloud.
    walls
        By number of a room, ``(n, 2)`` places on the page where its walls, or what hides them, were seen; None without
        a cloud.
    outlines
        Outlines of objects by number; None where their points are not known.
    furniture
        Whether objects are drawn.
    """

    graph: BuildingGraph
    topology: Topology
    frame: PageFrame
    faces: Mapping[int, WallFaces] = field(default_factory=dict)
    grid: PlanGrid | None = None
    walls: Mapping[int, F64] | None = None
    outlines: dict[int, BaseGeometry] | None = None
    furniture: bool = False


@dataclass(frozen=True, slots=True)
class Void:
    """Where a room below reaches through a storey."""

    shape: BaseGeometry
    room: str


@dataclass(frozen=True, slots=True)
class StoreyPlan:
    """A storey ready to be drawn.

    Attributes
    ----------
    node, scene
        The storey, its rooms and openings on the page.
    walls, gaps, stairs, voids
        What is drawn of them.
    leaves
        Leaves of each door, by its key.
    lines
        By key of a room what stands under its name.
    outer_m
        Thickness of outer walls, metres.
    """

    node: Node
    scene: PlanScene
    walls: Walls
    gaps: tuple[Gap, ...]
    leaves: Mapping[str, Sequence[Leaf]]
    stairs: tuple[Stairs, ...]
    voids: tuple[Void, ...]
    lines: Mapping[str, tuple[str, ...]]
    outer_m: float

    @property
    def bounds(self) -> Bounds:
        """Least and greatest x and y, metres on the page."""
        if self.walls.solid.is_empty:
            return self.scene.bounds
        (a, b, c, d), (e, f, g, h) = self.walls.solid.bounds, self.scene.bounds
        return min(a, e), min(b, f), max(c, g), max(d, h)

    @property
    def obstacles(self) -> list[BaseGeometry]:
        """What names keep clear of."""
        sectors = [leaf.sector() for leaf in chain.from_iterable(self.leaves.values())]
        return [*sectors, *(floor for stairs in self.stairs for floor in stairs.floor)]


def surroundings(graph: BuildingGraph, cloud: LabelledCloud | None, *, furniture: bool) -> Surroundings:
    """Take from graph and cloud what the plans of all storeys share."""
    rings = (ring for room in graph.of_label("Room") for ring in outline_rings(room.properties)[:1])
    frame, ends = page_frame(rings), topology(graph)
    if cloud is None or not len(cloud):
        return Surroundings(graph, ends, frame, furniture=furniture)
    frame, faces = wall_faces(cloud, frame)
    walls = wall_cells(cloud, frame, graph)
    outlines = object_outlines(cloud, frame) if furniture else None
    return Surroundings(graph, ends, frame, faces, plan_grid(cloud, frame), walls, outlines, furniture)


def plan_storeys(around: Surroundings, storeys: Sequence[Node]) -> list[StoreyPlan]:
    """Make the plans of storeys, those of which some room has a place; outer walls are equally thick on all."""
    rooms: dict[str, list[str]] = {storey.id: [] for storey in around.graph.of_label("Storey")}
    for room, storey in around.topology.storey_of.items():
        rooms[storey].append(room)
    scenes = {
        storey.id: plan_scene(
            around.graph, rooms[storey.id], ends=around.topology, frame=around.frame, faces=around.faces
        )
        for storey in around.graph.of_label("Storey")
    }
    outer_m = _outer_thickness(around, scenes.values())
    flights = all_flights(scenes.values(), around.grid)
    drawn = [storey for storey in storeys if scenes[storey.id].rooms]
    return [_plan(around, storey, scenes, outer_m, flights) for storey in drawn]


def _outer_thickness(around: Surroundings, scenes: Iterable[PlanScene]) -> float:
    if around.grid is None:
        return USUAL_THICKNESS_M
    all_gaps = (
        gap(scene, opening, USUAL_THICKNESS_M) for scene in scenes for opening in scene.openings if _in_wall(opening)
    )
    return outer_thickness(all_gaps, around.grid)


def _in_wall(opening: PlannedOpening) -> bool:
    return opening.upright and opening.kind not in ("stairs", "hatch")


def _plan(
    around: Surroundings,
    storey: Node,
    scenes: Mapping[str, PlanScene],
    outer_m: float,
    flights: Mapping[str, Sequence[Flight]],
) -> StoreyPlan:
    scene = scenes[storey.id]
    gaps = tuple(gap(scene, opening, outer_m) for opening in scene.openings if _in_wall(opening))
    hung = hang_doors(gaps, scene.rooms)
    stairs = tuple(find_stairs(scene, flights))
    walked = [Polygon(flight.corners) for way in stairs if way.upward for flight in way.flights if flight.measured]
    walls = build_walls(scene, gaps, outer_m, _wall_places(around.walls, scene), walked)
    voids = tuple(_voids(around.graph, storey, scenes))
    return StoreyPlan(storey, scene, walls, gaps, hung, stairs, voids, _lines(storey, scene), outer_m)


def _wall_places(walls: Mapping[int, F64] | None, scene: PlanScene) -> F64 | None:
    """``(n, 2)`` where the walls of a storey's rooms were seen."""
    if walls is None:
        return None
    seen = (walls.get(parse(room).numbers[0]) for room in scene.rooms)
    return np.concatenate([np.empty((0, 2)), *(places for places in seen if places is not None)])


def _voids(graph: BuildingGraph, storey: Node, scenes: Mapping[str, PlanScene]) -> list[Void]:
    """Rooms of lower storeys that reach through this one."""
    elevation, index = storey.properties.get("elevation"), storey.properties.get("index", 0)
    if elevation is None:
        return []
    here = [room.polygon for room in scenes[storey.id].rooms.values()]
    found = []
    for key, scene in scenes.items():
        if graph.nodes[key].properties.get("index", 0) >= index:
            continue
        for id, room in scene.rooms.items():
            ceiling = room.node.properties.get("ceiling_elevation")
            if room.outlined and ceiling is not None and ceiling > elevation + _VOID_M:
                left = room.polygon.difference(union_all(here)).buffer(-0.2).buffer(0.2)
                if left.area >= _LEAST_VOID_M2:
                    found.append(Void(left, id))
    return found


def _lines(storey: Node, scene: PlanScene) -> dict[str, tuple[str, ...]]:
    """Return what stands under the name of each room: function, area, level where it differs."""
    elevation = storey.properties.get("elevation")
    return {id: tuple(_said(room.node, elevation)) for id, room in scene.rooms.items()}


def _said(room: Node, elevation: float | None) -> list[str]:
    given = room.properties
    said = [" ".join(str(given["function"]).split())[:40]] if given.get("function") else []
    if given.get("area") is not None:
        said.append(f"{given['area']:.1f} m²")
    floor = given.get("floor_elevation")
    if floor is not None and elevation is not None and abs(floor - elevation) >= _LEVEL_M:
        said.append(f"level {floor - elevation:+.2f}")
    return said
