"""What holds what and what leads where in a building's graph, looked up by key."""

from __future__ import annotations

from dataclasses import dataclass

from .graph import BuildingGraph


@dataclass(frozen=True, slots=True)
class Topology:
    """Ends of the edges that tell the building's order.

    Attributes
    ----------
    storey_of
        Storey of each room.
    room_of
        Room of each object.
    rooms_of
        Rooms of each opening, in order of writing; one for an opening to the outside, none for a loose one.
    """

    storey_of: dict[str, str]
    room_of: dict[str, str]
    rooms_of: dict[str, tuple[str, ...]]


def topology(graph: BuildingGraph) -> Topology:
    """Return the look-up tables of a graph, made in one pass over its edges."""
    rooms_of: dict[str, tuple[str, ...]] = {node.id: () for node in graph.of_label("Opening")}
    for edge in graph.of_type("OPENS"):
        rooms_of[edge.target] = (*rooms_of[edge.target], edge.source)
    return Topology(
        {edge.target: edge.source for edge in graph.of_type("HAS_ROOM")},
        {edge.target: edge.source for edge in graph.of_type("CONTAINS")},
        rooms_of,
    )
