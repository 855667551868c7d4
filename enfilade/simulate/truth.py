"""The truth beside a simulated file: the building's graph and the labelled cloud."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import enfilade
from enfilade.clouds import LabelledCloud
from enfilade.descriptors import DEFAULT_LAYOUT, describe
from enfilade.schema.graph import BuildingGraph
from enfilade.schema.ids import object_id, opening_id, room_id, storey_id

from .adjacency import adjacent_rooms
from .casting import F32
from .locate import Locator, rooms_of_surfaces
from .scanner import Pose, Scan
from .scene import OUTSIDE, Opening, Room, Scene, places_of
from .solids import F64, I32

THINNING_M = 0.01
_MARGIN_M = 1000.0


@dataclass(frozen=True, slots=True)
class _LabelledScan:
    """Thinned points of one scan in its own frame, and ``(K, 3) int32`` room, furnishing and surface of each."""

    pose: Pose
    local: F32
    labels: I32

    def some(self, kept: NDArray[np.intp]) -> _LabelledScan:
        """Return it with some of its points."""
        return _LabelledScan(self.pose, self.local[kept], self.labels[kept])


class TruthCloud:
    """Gathers labelled points scan by scan; at most one a centimetre voxel is left in the end."""

    def __init__(self, scene: Scene, locator: Locator) -> None:
        self._scene = scene
        self._locator = locator
        self._origin: F64 = np.floor(scene.mesh.bounds[0] - _MARGIN_M)
        self._scans: list[_LabelledScan] = []

    def add(self, scan: Scan) -> None:
        """Label the points of a scan and keep the thinned ones."""
        kept = _firsts(self._voxels(scan.pose.apply(scan.local)))
        triangle, stray = scan.triangle[kept], scan.stray[kept]
        nothing = scan.mixed[kept] | stray
        room = np.full(len(kept), OUTSIDE, dtype=np.int32)
        room[~stray] = rooms_of_surfaces(self._scene, self._locator, scan.hit[kept][~stray], scan.normal[kept][~stray])
        furnishing = np.where(nothing, -1, self._scene.furnishing[triangle])
        surface = np.where(nothing, -1, self._scene.surface[triangle])
        labels = np.column_stack([room, furnishing, surface]).astype(np.int32)
        self._scans.append(_LabelledScan(scan.pose, scan.local[kept], labels))

    def finish(self) -> LabelledCloud:
        """Return all points, scan by scan; the gathered scans are given up on the way."""
        self._thin()
        counts = [len(scan.local) for scan in self._scans]
        room, furnishing, surface = np.concatenate([scan.labels for scan in self._scans]).T.copy()
        positions = np.empty((len(room), 3))
        for end, count in zip(np.cumsum(counts), counts, strict=True):
            scan = self._scans.pop(0)
            positions[end - count : end] = scan.pose.apply(scan.local)
        storeys = np.array([r.storey for r in self._scene.rooms] + [-1], dtype=np.int32)
        number = np.repeat(np.arange(len(counts), dtype=np.int32), counts)
        return LabelledCloud(positions, storeys[room], room, furnishing, surface, number)

    def _thin(self) -> None:
        """Of the points of all scans in one voxel keep the first."""
        voxels = np.concatenate([self._voxels(scan.pose.apply(scan.local)) for scan in self._scans])
        ends = np.cumsum([len(scan.local) for scan in self._scans])
        firsts = _firsts(voxels)
        kept = np.split(firsts, np.searchsorted(firsts, ends[:-1]))
        for number, (members, start) in enumerate(zip(kept, [0, *ends[:-1]], strict=True)):
            self._scans[number] = self._scans[number].some(members - start)

    def _voxels(self, positions: F64) -> NDArray[np.int64]:
        """``(K,)`` packed number of the voxel of each point, 21 bits an axis."""
        x, y, z = np.floor((positions - self._origin) / THINNING_M).astype(np.int64).T
        packed: NDArray[np.int64] = (x << 42) | (y << 21) | z
        return packed


def truth_graph(scene: Scene, building: str, cloud: LabelledCloud, scan_rooms: dict[str, int]) -> BuildingGraph:
    """Return the graph of the scene as the scans could show it at best.

    Parameters
    ----------
    scan_rooms
        Room of each scan by the scan's name, -1 for none.
    """
    graph = BuildingGraph(building)
    graph.add_node(
        building,
        "Building",
        name=scene.name,
        scan_count=len(scan_rooms),
        point_count=len(cloud.positions),
        bounds=_bounds(cloud.positions),
        origin=[0.0, 0.0, 0.0],
        software_version=enfilade.__version__,
    )
    _add_storeys(graph, scene)
    _add_rooms(graph, scene, cloud, scan_rooms)
    for pair in adjacent_rooms(scene.rooms):
        ends = (room_id(graph.building, pair.first), room_id(graph.building, pair.second))
        graph.add_edge(ends[0], "NEIGHBOUR", ends[1], gap=pair.gap, area=pair.area)
    _add_openings(graph, scene)
    _add_furnishings(graph, scene, cloud)
    return graph


def _add_storeys(graph: BuildingGraph, scene: Scene) -> None:
    for storey in scene.storeys:
        rooms = [room for room in scene.rooms if room.storey == storey.index]
        id = storey_id(graph.building, storey.index)
        graph.add_node(
            id,
            "Storey",
            name=storey.name,
            index=storey.index,
            elevation=storey.elevation,
            height=max((r.ceiling_elevation - storey.elevation for r in rooms), default=None),
            area=sum(room.area for room in rooms),
        )
        graph.add_edge(graph.building, "HAS_STOREY", id)
    for storey in scene.storeys[1:]:
        graph.add_edge(storey_id(graph.building, storey.index - 1), "BELOW", storey_id(graph.building, storey.index))


def _add_rooms(graph: BuildingGraph, scene: Scene, cloud: LabelledCloud, scan_rooms: dict[str, int]) -> None:
    counts = np.bincount(cloud.room[cloud.room >= 0], minlength=len(scene.rooms))
    for room in scene.rooms:
        id = room_id(graph.building, room.number)
        graph.add_node(
            id,
            "Room",
            name=room.name,
            area=room.area,
            floor_elevation=room.floor_elevation,
            ceiling_elevation=room.ceiling_elevation,
            height=room.ceiling_elevation - room.floor_elevation,
            centroid=_centroid(room),
            bounds=room.boundary.bounds.reshape(-1).tolist(),
            outline=[ring.reshape(-1).tolist() for ring in room.outline],
            point_count=int(counts[room.number]),
            scans=[name for name, number in scan_rooms.items() if number == room.number],
        )
        graph.add_edge(storey_id(graph.building, room.storey), "HAS_ROOM", id)


def _centroid(room: Room) -> list[float]:
    centre = room.polygon.centroid
    return [float(centre.x), float(centre.y), room.floor_elevation]


def _add_openings(graph: BuildingGraph, scene: Scene) -> None:
    for number, opening in enumerate(scene.openings):
        id = opening_id(graph.building, number)
        graph.add_node(id, "Opening", name=f"{opening.kind.capitalize()} {number}", **_opening_properties(opening))
        for room in dict.fromkeys(opening.rooms):
            if room != OUTSIDE:
                graph.add_edge(room_id(graph.building, room), "OPENS", id)


def _opening_properties(opening: Opening) -> dict[str, object]:
    return {
        "kind": opening.kind,
        "orientation": "horizontal" if opening.horizontal else "vertical",
        "width": opening.width,
        "height": opening.height,
        "sill": opening.sill,
        "area": opening.width * opening.height,
        "position": opening.position.tolist(),
        "normal": opening.normal.tolist(),
        "state": opening.state,
    }


def _add_furnishings(graph: BuildingGraph, scene: Scene, cloud: LabelledCloud) -> None:
    graph.descriptor_shape = DEFAULT_LAYOUT.shape
    bodies = places_of(scene.furnishing, len(scene.furnishings))
    seen = places_of(cloud.object, len(scene.furnishings))
    for piece in scene.furnishings:
        corners = scene.mesh.vertices[scene.mesh.triangles[bodies[piece.number]]].reshape(-1, 3)
        id = object_id(graph.building, piece.number)
        floor = None if piece.room == OUTSIDE else scene.rooms[piece.room].floor_elevation
        points = cloud.positions[seen[piece.number]]
        properties = _furnishing_properties(corners, points, floor)
        graph.add_node(id, "Object", name=piece.name, segments=[id], parts=1, **properties)
        if piece.room != OUTSIDE:
            graph.add_edge(room_id(graph.building, piece.room), "CONTAINS", id)


def _furnishing_properties(corners: F64, points: F64, floor: float | None) -> dict[str, object]:
    """Size and foot are those of the body; position and shape are of the points seen, if there are any."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    properties: dict[str, object] = {
        "size": (high - low).tolist(),
        "position": (points if len(points) else corners).mean(axis=0).tolist(),
        "floor_offset": None if floor is None else float(low[2] - floor),
        "point_count": len(points),
    }
    if len(points) and floor is not None:
        properties["descriptor"] = describe(points, floor)
        properties["foot_descriptor"] = describe(points, float(points[:, 2].min()))
    return properties


def _bounds(positions: F64) -> list[float]:
    return [*positions.min(axis=0).tolist(), *positions.max(axis=0).tolist()]


def _firsts(voxels: NDArray[np.int64]) -> NDArray[np.intp]:
    """Return indices of the first point of each voxel, in order."""
    return np.sort(np.unique(voxels, return_index=True)[1])
