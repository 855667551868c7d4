"""Which index an engine takes, as it tells itself: EXPLAIN QUERY PLAN and PROFILE over a corpus of many buildings."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from conftest import RunningNeo4j
from neo4j import GraphDatabase

from enfilade.queries import answer
from enfilade.schema.graph import BuildingGraph
from enfilade.stores import Store
from enfilade.stores.neo4j import Neo4jStore

BUILDINGS = 60
ROOMS = 20
FUNCTIONS = ("kitchen", "bath", "bedroom", "hall", "living room")

ANCHORED = {
    "by id": "MATCH (a:Room {id: 'b7/r3'})-[:DOOR]-(b:Room)-[:DOOR]-(c:Room) RETURN b, c",
    "by building": "MATCH (b:Building {id: 'b7'})-[:HAS_STOREY]->(s)-[:HAS_ROOM]->(r)-[:CONTAINS]->(o) RETURN r, o",
    "by property": "MATCH (r:Room {building: 'b7', function: 'kitchen'})-[:DOOR]-(h:Room) RETURN r, h",
    "a path": "MATCH (a:Room {id: 'b7/r3'})-[:DOOR*1..3]-(b:Room) RETURN b",
    "from the other end": "MATCH (a:Room)-[:DOOR]-(b:Room)-[:CONTAINS]->(o:Object {id: 'b7/o3'}) RETURN a, b",
    "with a negation": "MATCH (a:Room {building: 'b7'}) WHERE NOT EXISTS { (a)-[:DOOR]-(:Room {area: 50..}) } RETURN a",
}
WHOLE = {
    "selective": "MATCH (a:Room {area: 19.5..})-[:DOOR]-(b:Room {function: 'bath'}) RETURN a, b",
    "four rooms": (
        "MATCH (a:Room {function: 'bath'})-[:DOOR]-(b:Room)-[:DOOR]-(c:Room)-[:DOOR]-(d:Room {function: 'kitchen'}) "
        "RETURN a, b, c, d"
    ),
    "a ring": "MATCH (a:Room)-[:DOOR]-(b:Room)-[:DOOR]-(c:Room)-[:DOOR]-(a) RETURN a, b, c",
}


def building(number: int) -> BuildingGraph:
    """Twenty rooms, each with doors to the next two, an object in each."""
    id = f"b{number}"
    graph = BuildingGraph(id)
    graph.add_node(id, "Building")
    graph.add_node(f"{id}/s0", "Storey", index=0)
    graph.add_edge(id, "HAS_STOREY", f"{id}/s0")
    for k in range(ROOMS):
        graph.add_node(f"{id}/r{k}", "Room", area=float(k) + number / BUILDINGS, function=FUNCTIONS[k % len(FUNCTIONS)])
        graph.add_edge(f"{id}/s0", "HAS_ROOM", f"{id}/r{k}")
        graph.add_node(f"{id}/o{k}", "Object", parts=1, segments=[f"{id}/o{k}"])
        graph.add_edge(f"{id}/r{k}", "CONTAINS", f"{id}/o{k}")
    for k in range(ROOMS - 2):
        for step in (1, 2):
            door = f"{id}/p{2 * k + step}"
            graph.add_node(door, "Opening", kind="door", width=0.9)
            graph.add_edge(f"{id}/r{k}", "OPENS", door)
            graph.add_edge(f"{id}/r{k + step}", "OPENS", door)
    return graph


@pytest.fixture
def corpus(store: Store) -> Store:
    store.write_all([building(number) for number in range(BUILDINGS)])
    return store


@pytest.mark.parametrize("name", [*ANCHORED, *WHOLE])
def test_sqlite_scans_no_table_for_an_anchor_and_one_at_most_for_all(sqlite_store: Store, name: str) -> None:
    sqlite_store.write_all([building(number) for number in range(BUILDINGS)])
    text = ANCHORED.get(name) or WHOLE[name]
    step = answer(sqlite_store, text).explanation.steps[0]

    plan = sqlite_store.plan(step.text, step.parameters).splitlines()

    scans = [line for line in plan if line.strip().startswith("SCAN")]
    assert len(scans) <= (0 if name in ANCHORED else 1), plan
    assert not any("AUTOMATIC" in line for line in plan), plan


Profiled = Callable[[str, dict[str, object]], list[tuple[str, int]]]


@pytest.fixture
def profiled(neo4j_server: RunningNeo4j) -> Iterator[Profiled]:
    """Run a statement and return its operators, each with the number of its accesses to the database."""
    address = neo4j_server.url.replace("neo4j@", "")
    with GraphDatabase.driver(address, auth=("neo4j", neo4j_server.password)) as driver:

        def run(text: str, parameters: dict[str, object]) -> list[tuple[str, int]]:
            _, summary, _ = driver.execute_query(
                text.replace("CYPHER 5 ", "CYPHER 5 PROFILE ", 1), parameters, database_="neo4j"
            )
            waiting, found = [summary.profile], []
            while waiting:
                operator = waiting.pop()
                found.append((operator["operatorType"].partition("@")[0], operator.get("dbHits", 0)))
                waiting.extend(operator.get("children", ()))
            return found

        yield run


@pytest.mark.neo4j
@pytest.mark.parametrize("name", [*ANCHORED, *WHOLE])
def test_neo4j_begins_at_an_index(neo4j_store: Neo4jStore, profiled: Profiled, name: str) -> None:
    neo4j_store.write_all([building(number) for number in range(BUILDINGS)])
    list(neo4j_store.cypher("CALL db.prepareForReplanning()", {}))
    text = ANCHORED.get(name) or WHOLE[name]
    step = answer(neo4j_store, text).explanation.steps[0]

    operators = profiled(step.text, step.parameters)

    names = [operator for operator, _ in operators]
    assert "AllNodesScan" not in names
    assert not any("CartesianProduct" in operator for operator in names if name != "a path"), operators
    if name in ANCHORED:
        assert any("IndexSeek" in operator for operator in names), operators
        assert "NodeByLabelScan" not in names, operators
        assert sum(hits for _, hits in operators) < BUILDINGS * ROOMS or name == "a path", operators
