"""Text of the user's never becomes a statement: hostile names, values and variables on every store."""

from __future__ import annotations

import pytest

from enfilade.queries import answer
from enfilade.schema.graph import BuildingGraph
from enfilade.stores import Store

HOSTILE = [
    "'; MATCH (n) DETACH DELETE n //",
    "'; DROP TABLE room; --",
    '" OR 1 = 1 --',
    "`) DETACH DELETE n //",
    "$p0 :p0 ?",
    "a\nb\tc\\",
    "\\' OR true",
    "naïve 🏠 \u202e",
    "%_*",
]


def building_named(name: str) -> BuildingGraph:
    id = name.replace("/", "|").replace("\n", " ").replace("\t", " ")
    graph = BuildingGraph(id, descriptor_shape=(1, 1, 1))
    graph.add_node(id, "Building", name=name)
    graph.add_node(f"{id}/s0", "Storey", index=0)
    graph.add_edge(id, "HAS_STOREY", f"{id}/s0")
    for number, area in enumerate((10.0, 20.0)):
        graph.add_node(f"{id}/r{number}", "Room", name=f"{name}{number}", area=area)
        graph.add_edge(f"{id}/s0", "HAS_ROOM", f"{id}/r{number}")
    graph.add_node(f"{id}/o1", "Object", parts=1, segments=[f"{id}/o1"])
    graph.add_edge(f"{id}/r0", "CONTAINS", f"{id}/o1")
    return graph


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_values_are_only_values(store: Store, name: str) -> None:
    graph = building_named(name)
    store.write(graph)
    store.write(building_named("other"))

    by_parameter = answer(store, "MATCH (a:Room {name: $x}) RETURN a.name, a", parameters={"x": f"{name}0"})
    by_text = answer(
        store,
        "MATCH (b:Building)-[:HAS_STOREY]->()-[:HAS_ROOM]->(a) WHERE b.name = $x AND a.name STARTS WITH $x "
        "AND a.name ENDS WITH $y AND a.name CONTAINS $x AND a.name IN [$z, 'x'] RETURN a.name",
        parameters={"x": name, "y": f"{name}1"[-2:], "z": f"{name}1"},
    )
    like = answer(
        store, "MATCH (o:Object LIKE object($x) WITHIN 0.5) RETURN o", parameters={"x": f"{graph.building}/o1"}
    )

    assert by_parameter.rows == [{"a.name": f"{name}0", "a": f"{graph.building}/r0"}]
    assert by_text.rows == [{"a.name": f"{name}1"}]
    assert like.rows == []  # it has no descriptor, and nothing is like it
    assert [summary.rooms for summary in store.buildings()] == [2, 2]


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_variables_and_columns_are_only_names(store: Store, name: str) -> None:
    store.write(building_named("hotel"))
    quoted = "`" + name.replace("`", "``") + "`"

    result = answer(
        store,
        f"MATCH ({quoted}:Room {{area: 15..}}) WHERE EXISTS {{ ({quoted})<-[:HAS_ROOM]-(s) WHERE s.index = 0 }} "
        f"RETURN {quoted}.area AS {quoted}, {quoted} AS `a``b`",
    )

    assert result.rows == [{name: 20.0, "a`b": "hotel/r1"}]
    assert len(store.buildings()) == 1


def test_texts_are_compared_by_code_point(store: Store) -> None:
    names = ["Z", "a", "é", "\uff5e", "𐐷", "~", "aa", ""]
    graph = BuildingGraph("b")
    graph.add_node("b", "Building")
    for number, name in enumerate(names):
        graph.add_node(f"b/r{number}", "Room", name=name)
    store.write(graph)

    ordered = answer(store, "MATCH (a:Room) RETURN a.name ORDER BY a.name")
    pairs = answer(store, "MATCH (a:Room), (b:Room) WHERE a.name < b.name RETURN count(*)")
    above = answer(store, "MATCH (a:Room) WHERE a.name > '\uff5e' RETURN a.name")

    assert [row["a.name"] for row in ordered.rows] == sorted(names)
    assert pairs.rows == [{"count(*)": len(names) * (len(names) - 1) // 2}]
    assert above.rows == [{"a.name": "𐐷"}]
