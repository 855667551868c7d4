"""The building's graph and labelled cloud, put together from what the stages found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enfilade.clouds import LabelledCloud
from enfilade.parallel import in_slices, taken
from enfilade.schema.graph import BuildingGraph
from enfilade.schema.ids import object_id, opening_id, room_id, storey_id

from .cells import extent
from .records import (
    F32,
    F64,
    I32,
    Combination,
    Neighbour,
    Objects,
    Opening,
    Planes,
    Room,
    RoomLabels,
    Storey,
    Surfels,
    ThinnedCloud,
)


@dataclass(frozen=True, slots=True)
class Findings:
    """What the stages found in one building."""

    cloud: ThinnedCloud
    surfels: Surfels
    planes: Planes
    labels: RoomLabels
    rooms: tuple[Room, ...]
    storeys: tuple[Storey, ...]
    neighbours: tuple[Neighbour, ...]
    openings: tuple[Opening, ...]
    objects: Objects

    @property
    def room_storey(self) -> I32:
        """``(R,) int32`` storey of each room."""
        storey = np.full(self.labels.room_count, -1, np.int32)
        for level in self.storeys:
            storey[list(level.rooms)] = level.index
        return storey


def assemble_graph(
    building: str,
    name: str,
    found: Findings,
    descriptor_shape: tuple[int, int, int],
    provenance: Mapping[str, Any],
) -> BuildingGraph:
    """Put the graph of a building together; `provenance` holds further properties of the building's node."""
    graph = BuildingGraph(building, descriptor_shape=descriptor_shape if found.objects.combinations else None)
    origin = found.cloud.origin
    _add_building(graph, name, found.cloud, provenance)
    _add_storeys(graph, found.storeys, found.rooms, origin)
    _add_rooms(graph, found.rooms, found.room_storey, origin)
    _add_neighbours(graph, found.neighbours)
    _add_openings(graph, found.openings, origin)
    _add_objects(graph, found.objects, origin)
    return graph


def assemble_cloud(found: Findings) -> LabelledCloud:
    """Label every thinned point, in the scans' own coordinates."""
    room = _of_surfel(found.labels.after, found.surfels.point_surfel)
    thing = np.full(len(room), -1, np.int32)
    for segment in found.objects.segments:
        thing[segment.points] = segment.number
    return LabelledCloud(
        _moved(found.cloud.positions, found.cloud.origin),
        _of_surfel(found.room_storey, room),
        room,
        thing,
        _of_surfel(found.planes.surfel_plane, found.surfels.point_surfel),
        found.cloud.scan if found.cloud.read_as is None else taken(found.cloud.read_as, found.cloud.scan),
        intensity=found.cloud.intensity,
        colour=found.cloud.colour,
    )


def _of_surfel(values: I32, index: I32) -> I32:
    """``values[index]``, and -1 where the index is -1."""
    return taken(np.append(values, np.int32(-1)), index)


def _moved(positions: F32, by: F64) -> F64:
    """``positions + by``."""
    moved = np.empty(positions.shape, np.float64)
    in_slices(_move, len(positions), moved, positions, by)
    return moved


@njit(cache=True, nogil=True)
def _move(first: int, past: int, moved: F64, positions: F32, by: F64) -> None:
    for i in range(first, past):
        for axis in range(3):
            moved[i, axis] = positions[i, axis] + by[axis]


def _add_building(graph: BuildingGraph, name: str, cloud: ThinnedCloud, provenance: Mapping[str, Any]) -> None:
    low, high = (corner + cloud.origin for corner in extent(cloud.positions))
    graph.add_node(
        graph.building,
        "Building",
        name=name,
        scan_count=len(cloud.scan_names),
        point_count=cloud.raw_count,
        bounds=[*low.tolist(), *high.tolist()],
        origin=cloud.origin.tolist(),
        **provenance,
    )


def _add_storeys(
    graph: BuildingGraph, storeys: Sequence[Storey], rooms: Sequence[Room], origin: NDArray[np.float64]
) -> None:
    by_number = {room.number: room for room in rooms}
    for storey in storeys:
        inside = [by_number[number] for number in storey.rooms]
        ceilings = [room.ceiling_elevation for room in inside if room.ceiling_elevation is not None]
        id = storey_id(graph.building, storey.index)
        graph.add_node(
            id,
            "Storey",
            name=f"Storey {storey.index}",
            index=storey.index,
            elevation=storey.elevation + float(origin[2]),
            height=max(ceilings) - storey.elevation if ceilings else None,
            area=sum(room.area for room in inside),
        )
        graph.add_edge(graph.building, "HAS_STOREY", id)
    for lower, upper in pairwise(storeys):
        graph.add_edge(storey_id(graph.building, lower.index), "BELOW", storey_id(graph.building, upper.index))


def _add_rooms(graph: BuildingGraph, rooms: Sequence[Room], room_storey: I32, origin: NDArray[np.float64]) -> None:
    for room in rooms:
        id = room_id(graph.building, room.number)
        ceiling = room.ceiling_elevation
        graph.add_node(
            id,
            "Room",
            name=f"Room {room.number}",
            area=room.area,
            floor_elevation=room.floor_elevation + float(origin[2]),
            ceiling_elevation=None if ceiling is None else ceiling + float(origin[2]),
            height=None if ceiling is None else ceiling - room.floor_elevation,
            centroid=(room.centroid + origin).tolist(),
            bounds=(room.bounds + np.tile(origin, 2)).tolist(),
            outline=[(ring + origin[:2]).ravel().tolist() for ring in room.outline],
            point_count=room.point_count,
            scans=list(room.scans),
            scan_positions=(room.scan_positions + origin).ravel().tolist(),
            seen_from="inside" if room.scans else "outside",
            confidence=room.confidence,
        )
        graph.add_edge(storey_id(graph.building, int(room_storey[room.number])), "HAS_ROOM", id)


def _add_neighbours(graph: BuildingGraph, neighbours: Sequence[Neighbour]) -> None:
    for pair in neighbours:
        graph.add_edge(
            room_id(graph.building, pair.room_a),
            "NEIGHBOUR",
            room_id(graph.building, pair.room_b),
            gap=pair.gap,
            area=pair.area,
            planes=[plane for planes in pair.plane_pairs for plane in planes],
        )


def _add_openings(graph: BuildingGraph, openings: Sequence[Opening], origin: NDArray[np.float64]) -> None:
    for number, opening in enumerate(openings):
        id = opening_id(graph.building, number)
        graph.add_node(
            id,
            "Opening",
            name=f"{opening.kind.capitalize()} {number}",
            kind=opening.kind,
            orientation=opening.orientation,
            width=opening.width,
            height=opening.height,
            sill=opening.sill,
            lintel=opening.lintel,
            area=opening.area,
            position=(opening.position + origin).tolist(),
            normal=opening.normal.tolist(),
            ray_count=opening.ray_count,
            state=opening.state,
            confidence=opening.confidence,
        )
        for room in (opening.room_a, opening.room_b):
            if room is not None:
                graph.add_edge(room_id(graph.building, room), "OPENS", id)


def _add_objects(graph: BuildingGraph, objects: Objects, origin: NDArray[np.float64]) -> None:
    room_of = {segment.number: segment.room for segment in objects.segments}
    for combination in objects.combinations:
        id = _add_object(graph, combination, origin)
        graph.add_edge(room_id(graph.building, room_of[combination.segments[0]]), "CONTAINS", id)
    for combination in objects.combinations:
        if len(combination.segments) > 1:
            for segment in combination.segments:
                graph.add_edge(
                    object_id(graph.building, segment), "PART_OF", object_id(graph.building, *combination.segments)
                )
    for a, b, distance in objects.near:
        graph.add_edge(object_id(graph.building, a), "NEAR", object_id(graph.building, b), distance=distance)


def _add_object(graph: BuildingGraph, combination: Combination, origin: NDArray[np.float64]) -> str:
    id = object_id(graph.building, *combination.segments)
    graph.add_node(
        id,
        "Object",
        name="Object " + "+".join(str(segment) for segment in combination.segments),
        segments=[object_id(graph.building, segment) for segment in combination.segments],
        parts=len(combination.segments),
        size=combination.size.tolist(),
        position=(combination.position + origin).tolist(),
        floor_offset=combination.floor_offset,
        point_count=combination.point_count,
        descriptor=combination.descriptor,
        foot_descriptor=combination.foot_descriptor,
    )
    return id
