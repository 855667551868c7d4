"""Truth and prediction as evaluation sees them: rooms by number, what they are called, and which are asked for."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

from enfilade.schema.graph import BuildingGraph, Node
from enfilade.schema.ids import parse
from enfilade.schema.topology import Topology, topology

STAIR_WELL_SHARE: Final = 0.5
"""A room is a stair well from this share of its area on that the holes of its stairs take."""
ROOF_HEIGHT_M: Final = 1.8
"""A room lower than this is a roof space or a crawl space."""


@dataclass(frozen=True)
class Side:
    """One of the two graphs that are compared.

    Attributes
    ----------
    rooms
        Room nodes by number.
    storeys
        Number of the storey of each room.
    """

    graph: BuildingGraph
    topology: Topology
    rooms: dict[int, Node]
    storeys: dict[int, int]

    @cached_property
    def scanned(self) -> frozenset[int]:
        """Rooms that a scan stands in; all, where no room says which scans it has."""
        told = [number for number, node in self.rooms.items() if node.properties.get("scans")]
        return frozenset(told or self.rooms)

    @cached_property
    def stair_wells(self) -> frozenset[int]:
        """Rooms of which the holes of stairs take half or more."""
        holes: dict[int, float] = {}
        for opening in self.graph.of_label("Opening"):
            if opening.properties.get("kind") == "stairs":
                for room in self.rooms_of(opening.id):
                    holes[room] = max(holes.get(room, 0.0), _area(opening))
        return frozenset(
            room for room, area in holes.items() if area > 0 and area >= STAIR_WELL_SHARE * self._area_of(room)
        )

    @cached_property
    def roof_spaces(self) -> frozenset[int]:
        """Rooms too low to stand in."""
        heights = ((number, self.value(number, "height")) for number in self.rooms)
        return frozenset(number for number, height in heights if height is not None and height < ROOF_HEIGHT_M)

    @cached_property
    def segments(self) -> frozenset[int]:
        """Numbers of the segments that object nodes have."""
        return frozenset(n for node in self.graph.of_label("Object") for n in parse(node.id).numbers)

    def name(self, room: int) -> str:
        """Key after the slash and name, for people: ``r3 Kitchen``."""
        return label(self.rooms[room])

    def names(self, rooms: list[int] | tuple[int, ...]) -> str:
        """Names of rooms in a row: ``r3 Kitchen + r4 Hall``."""
        return " + ".join(self.name(room) for room in rooms)

    def id(self, room: int) -> str:
        """Key of a room."""
        return self.rooms[room].id

    def ids(self, rooms: list[int] | tuple[int, ...]) -> tuple[str, ...]:
        """Keys of rooms."""
        return tuple(self.id(room) for room in rooms)

    def value(self, room: int, property: str) -> Any:
        """Return a property of a room, or None."""
        return self.rooms[room].properties.get(property)

    def rooms_of(self, opening: str) -> tuple[int, ...]:
        """Numbers of the rooms that an opening leads to."""
        return tuple(number_of(room) for room in self.topology.rooms_of[opening])

    def _area_of(self, room: int) -> float:
        area = self.value(room, "area")
        return float("inf") if area is None else float(area)


def side(graph: BuildingGraph) -> Side:
    """Make a graph ready to be compared."""
    ends = topology(graph)
    storeys = {number_of(room): number_of(storey) for room, storey in ends.storey_of.items()}
    return Side(graph, ends, {number_of(node.id): node for node in graph.of_label("Room")}, storeys)


def number_of(id: str) -> int:
    """Return the number in a key with one."""
    return parse(id).numbers[0]


def label(node: Node) -> str:
    """Key after the slash and name of a node: ``r3 Kitchen``."""
    local = node.id.split("/", 1)[1]
    name = node.properties.get("name")
    return f"{local} {name}" if name else local


def _area(opening: Node) -> float:
    """Area of the hole, of its width and height where it is not said."""
    area = opening.properties.get("area")
    if area is None:
        area = opening.properties.get("width", 0.0) * opening.properties.get("height", 0.0)
    return float(area)
