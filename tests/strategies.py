"""Random graphs that the schema allows, hostile texts included."""

from __future__ import annotations

import itertools
import math
from typing import Any

from hypothesis import strategies as st

from enfilade.descriptors import quantise
from enfilade.schema.definition import EDGE_PROPERTIES, NODE_PROPERTIES, Kind, Property
from enfilade.schema.graph import BuildingGraph
from enfilade.schema.ids import object_id, opening_id, room_id, storey_id

texts = st.text(st.characters(exclude_categories=["Cs"]), max_size=20)
building_ids = st.text(st.characters(exclude_categories=["Cs", "Cc"], exclude_characters="/"), min_size=1, max_size=40)
reals = st.floats(allow_nan=False, allow_infinity=False).map(lambda value: value + 0.0)
integers = st.integers(-(2**63), 2**63 - 1)
plain = st.recursive(
    st.none() | st.booleans() | st.integers() | reals | texts,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(texts, inner, max_size=3),
    max_leaves=6,
)
shapes = st.tuples(st.integers(1, 3), st.integers(1, 3), st.integers(1, 4))


def values(property: Property, shape: tuple[int, int, int]) -> st.SearchStrategy[Any]:
    """Values that a property may hold."""
    if property.values:
        return st.sampled_from(property.values)
    bins = math.prod(shape)
    size = {"min_size": property.length, "max_size": property.length or 4}
    return {
        Kind.TEXT: texts,
        Kind.INTEGER: integers,
        Kind.REAL: reals,
        Kind.TEXTS: st.lists(texts, max_size=3),
        Kind.INTEGERS: st.lists(integers, max_size=3),
        Kind.REALS: st.lists(reals, **size),
        Kind.RINGS: st.lists(
            st.lists(st.tuples(reals, reals), max_size=4).map(lambda ring: [*sum(ring, ())]), max_size=2
        ),
        Kind.MAPPING: st.dictionaries(texts, plain, max_size=3),
        Kind.DESCRIPTOR: st.lists(st.integers(1, 1000), min_size=bins, max_size=bins).map(quantise),
    }[property.kind]


@st.composite
def graphs(draw: st.DrawFn) -> BuildingGraph:
    """Graphs of a few rooms, openings and objects, each with some of its properties and some unknown ones."""
    building = draw(building_ids)
    shape = draw(shapes)
    graph = BuildingGraph(
        building, descriptor_shape=shape, attributes=draw(_unknown(("format", "version", "building")))
    )

    def some(known: dict[str, Property], words: tuple[str, ...]) -> dict[str, Any]:
        names = draw(st.sets(st.sampled_from(sorted(set(known) - {"id", "building"} | {""})), max_size=5)) - {""}
        given = {name: draw(values(known[name], shape)) for name in sorted(names)}
        return draw(_unknown((*words, *known))) | given

    def add(id: str, label: str) -> str:
        graph.add_node(id, label).properties.update(some(NODE_PROPERTIES[label], ("id", "label")))
        return id

    def join(source: str, type: str, target: str) -> None:
        key = draw(st.just(0) | texts | integers)
        edge = graph.add_edge(source, type, target, key)
        edge.properties.update(some(EDGE_PROPERTIES[type], ("source", "target", "key", "type")))

    rooms = [room_id(building, n) for n in range(draw(st.integers(0, 3)))]
    ids = [(building, "Building"), (storey_id(building, 0), "Storey"), *((room, "Room") for room in rooms)]
    ids += [
        (opening_id(building, 7), "Opening"),
        (object_id(building, 1), "Object"),
        (object_id(building, 1, 2), "Object"),
    ]
    for id, label in draw(st.permutations(ids)):
        add(id, label)
    edges = [(building, "HAS_STOREY", storey_id(building, 0))]
    edges += [(storey_id(building, 0), "HAS_ROOM", room) for room in rooms]
    edges += [(room, "OPENS", opening_id(building, 7)) for room in rooms[:2]]
    edges += [(one, "NEIGHBOUR", other) for one, other in itertools.pairwise(rooms)]
    edges += [(object_id(building, 1), "PART_OF", object_id(building, 1, 2))]
    for edge in draw(st.permutations(edges)):
        join(*edge)
    return graph


def _unknown(words: tuple[str, ...]) -> st.SearchStrategy[dict[str, Any]]:
    names = texts.filter(lambda name: name not in {*words, "descriptor_shape"})
    return st.dictionaries(names, plain, max_size=2)
