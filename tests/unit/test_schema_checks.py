"""A graph that breaks the schema is refused, in one sentence."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from strategies import graphs

from enfilade.errors import GraphError
from enfilade.schema.checks import check
from enfilade.schema.graph import BuildingGraph, Node


@settings(max_examples=30)
@given(graph=graphs())
def test_graphs_that_keep_to_the_schema_pass(graph: BuildingGraph) -> None:
    check(graph)


def _relabel(graph: BuildingGraph, id: str, label: str) -> None:
    graph.nodes[id].label = label


def _put(node: str, **properties: Any) -> Callable[[BuildingGraph], None]:
    return lambda graph: graph.nodes[node].properties.update(properties)


def _join(source: str, type: str, target: str, key: Any = 0, **properties: Any) -> Callable[[BuildingGraph], Any]:
    return lambda graph: graph.add_edge(source, type, target, key, **properties)


FAULTS: dict[str, tuple[Callable[[BuildingGraph], Any], str]] = {
    "label": (lambda g: _relabel(g, "hotel/r1", "Romm"), "unknown label 'Romm'; did you mean \"Room\"?"),
    "label of another kind": (lambda g: _relabel(g, "hotel/r1", "Object"), "whose keys look like ID/o31"),
    "edge type": (_join("hotel/r0", "NEIGHBOR", "hotel/r4"), 'did you mean "NEIGHBOUR"?'),
    "edge type like nothing": (_join("hotel/r0", "qqqq", "hotel/r4"), "known are HAS_STOREY"),
    "missing end": (_join("hotel/r0", "OPENS", "hotel/p99"), "there is no node 'hotel/p99'"),
    "ends": (_join("hotel/r0", "OPENS", "hotel/r1"), "OPENS leads from Room to Opening"),
    "loop": (_join("hotel/r0", "NEIGHBOUR", "hotel/r0"), "joins a node with itself"),
    "second neighbour": (_join("hotel/r1", "NEIGHBOUR", "hotel/r0"), "a pair has one NEIGHBOUR at most"),
    "second near": (_join("hotel/o1", "NEAR", "hotel/o0", 1), "a pair has one NEAR at most"),
    "two parents": (_join("hotel/s1", "HAS_ROOM", "hotel/r0"), "lies in 'hotel/s0' already"),
    "parent twice": (_join("hotel/s0", "HAS_ROOM", "hotel/r0", 1), "lies in 'hotel/s0' already"),
    "three rooms": (_join("hotel/r2", "OPENS", "hotel/p0"), "leads to two rooms already"),
    "room twice": (_join("hotel/r0", "OPENS", "hotel/p0", 1), "is stated twice"),
    "key twice": (_join("hotel/r1", "NEIGHBOUR", "hotel/r0"), "stated twice"),
    "key is true": (_join("hotel/r0", "NEIGHBOUR", "hotel/r4", True), "its key must be a whole number or a text"),
    "bad id": (lambda g: g.add_node("hotel/room1", "Room"), "is no key of a node"),
    "id of another building": (lambda g: g.add_node("motel/r9", "Room"), "belongs to another building"),
    "building property": (_put("hotel/r0", building="motel"), "belongs to another building"),
    "filed wrongly": (lambda g: g.nodes.update({"x": g.nodes["hotel/r0"]}), "is filed under 'x'"),
    "no building node": (lambda g: g.nodes.pop("hotel"), "has no node of label Building"),
    "area is text": (_put("hotel/r0", area="big"), "area must be a number, not 'big'"),
    "area is true": (_put("hotel/r0", area=True), "area must be a number, not True"),
    "area is nan": (_put("hotel/r0", area=float("nan")), "must be a finite number"),
    "area is infinite": (_put("hotel/r0", area=float("inf")), "must be a finite number"),
    "area is None": (_put("hotel/r0", area=None), "area must be a number"),
    "count is real": (_put("hotel/r0", point_count=1.5), "must be a whole number"),
    "count beyond 64 bits": (_put("hotel/r0", point_count=2**63), "at most 64 bits"),
    "name is a number": (_put("hotel/r0", name=3), "name must be a text"),
    "name is half a character": (_put("hotel/r0", name="\ud800"), "lone surrogate"),
    "name is too long": (_put("hotel/r0", name="x" * 1001), "at most 1000 characters"),
    "kind": (_put("hotel/p0", kind="gate"), "must be one of door, passage, stairs, hatch, window"),
    "centroid of two": (_put("hotel/r0", centroid=[1.0, 2.0]), "must have 3 numbers, not 2"),
    "centroid of texts": (_put("hotel/r0", centroid=["1", "2", "3"]), "has an element that must be a number"),
    "centroid is a tuple": (_put("hotel/r0", centroid=(1.0, 2.0, 3.0)), "must be a list"),
    "odd ring": (_put("hotel/r0", outline=[[0.0, 1.0, 2.0]]), "rings of x y pairs"),
    "flat ring": (_put("hotel/r0", outline=[0.0, 1.0]), "must be a list"),
    "mapping": (_put("hotel", parameters=[1]), "must be a mapping"),
    "mapping of numbers": (_put("hotel", parameters={1: 2}), "key that is no text"),
    "descriptor is a list": (_put("hotel/o0", descriptor=[1.0] * 8), "flat array of uint16"),
    "descriptor sum": (_put("hotel/o0", descriptor=np.ones(8, np.uint16)), "must have counts that sum to 61440"),
    "descriptor bins": (_put("hotel/o0", descriptor=np.array([61440], np.uint16)), "has 1 bins"),
    "no shape": (lambda g: setattr(g, "descriptor_shape", None), 'has no "descriptor_shape"'),
    "shape of zero": (lambda g: setattr(g, "descriptor_shape", (0, 2, 4)), "three whole numbers above 0"),
    "unknown is a set": (_put("hotel/r0", colours={"red"}), "holds a set"),
    "unknown is nan": (_put("hotel/r0", ratio=[float("nan")]), "must be a finite number"),
    "reserved word": (_put("hotel/r0", label="x"), 'no property may be called "label"'),
    "reserved word of the graph": (lambda g: g.attributes.update(version=3), '"version"'),
    "edge property": (_join("hotel/r0", "NEIGHBOUR", "hotel/r4", gap="wide"), "gap must be a number"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_one_sentence(fault: str, hotel: BuildingGraph) -> None:
    spoil, said = FAULTS[fault]
    spoil(hotel)
    with pytest.raises(GraphError) as caught:
        check(hotel)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_no_property_of_an_edge_takes_a_word_of_the_form(hotel: BuildingGraph) -> None:
    hotel.edges[0].properties["target"] = "x"
    with pytest.raises(GraphError, match='no property may be called "target"'):
        check(hotel)


def test_nodes_are_equal_by_value() -> None:
    one = Node("a/o1", "Object", {"descriptor": np.array([1, 2], np.uint16)})
    assert one == Node("a/o1", "Object", {"descriptor": np.array([1, 2], np.uint16)})
    assert one != Node("a/o1", "Object", {"descriptor": np.array([2, 1], np.uint16)})
    assert one != Node("a/o1", "Object", {})
    assert one != "a/o1"
