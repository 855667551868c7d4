"""Look-up tables of a graph."""

from __future__ import annotations

from enfilade.schema.graph import BuildingGraph
from enfilade.schema.topology import topology


def test_rooms_are_found_from_what_they_hold_and_lead_to():
    graph = BuildingGraph("b")
    for id, label in [("b/s0", "Storey"), ("b/r0", "Room"), ("b/r1", "Room"), ("b/p0", "Opening"), ("b/p1", "Opening")]:
        graph.add_node(id, label)
    graph.add_node("b/o0", "Object")
    graph.add_edge("b/s0", "HAS_ROOM", "b/r0")
    graph.add_edge("b/r1", "CONTAINS", "b/o0")
    graph.add_edge("b/r1", "OPENS", "b/p0")
    graph.add_edge("b/r0", "OPENS", "b/p0")
    found = topology(graph)
    assert found.storey_of == {"b/r0": "b/s0"}
    assert found.room_of == {"b/o0": "b/r1"}
    assert found.rooms_of == {"b/p0": ("b/r1", "b/r0"), "b/p1": ()}
