"""Truth and prediction as evaluation sees them: rooms by number, what they are called, and who was scanned."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from enfilade.schema.graph import BuildingGraph, Node
from enfilade.schema.ids import parse
from enfilade.schema.topology import Topology, topology


@dataclass(frozen=True, slots=True)
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

    def scanned(self) -> frozenset[int]:
        """Rooms that a scan stands in; all, where no room says which scans it has."""
        told = [number for number, node in self.rooms.items() if node.properties.get("scans")]
        return frozenset(told or self.rooms)

    def name(self, room: int) -> str:
        """Key after the slash and name, for people: ``r3 Kitchen``."""
        return label(self.rooms[room])

    def value(self, room: int, property: str) -> Any:
        """Return a property of a room, or None."""
        return self.rooms[room].properties.get(property)

    def rooms_of(self, opening: str) -> tuple[int, ...]:
        """Numbers of the rooms that an opening leads to."""
        return tuple(number_of(room) for room in self.topology.rooms_of[opening])


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
