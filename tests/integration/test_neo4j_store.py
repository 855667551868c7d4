"""What only the Neo4j store has: its version in the database, its writers' turns, raw Cypher."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator

import pytest
from conftest import RunningNeo4j
from neo4j import GraphDatabase

from enfilade.errors import StoreError, VersionError
from enfilade.schema.definition import SCHEMA_VERSION
from enfilade.schema.graph import BuildingGraph
from enfilade.stores import neo4j_turns
from enfilade.stores.neo4j import Neo4jStore

pytestmark = pytest.mark.neo4j

Run = Callable[[str], object]


@pytest.fixture
def run(neo4j_server: RunningNeo4j, neo4j_store: Neo4jStore) -> Iterator[Run]:
    """Write Cypher behind the store's back; afterwards the schema node is as it was."""
    address = neo4j_server.url.replace("neo4j@", "")
    with GraphDatabase.driver(address, auth=("neo4j", neo4j_server.password)) as driver:
        yield lambda text: driver.execute_query(text, database_="neo4j")
        driver.execute_query("MATCH (n) DETACH DELETE n", database_="neo4j")
    neo4j_server.open().close()


def test_another_schema_version_is_refused(run: Run, neo4j_server: RunningNeo4j) -> None:
    run(f"MATCH (s:EnfiladeSchema) SET s.version = {SCHEMA_VERSION + 1}")
    said = f"has schema version {SCHEMA_VERSION + 1}, this Enfilade knows {SCHEMA_VERSION}"
    with pytest.raises(VersionError, match=said):
        neo4j_server.open()


def test_a_database_without_schema_is_only_prepared_when_asked(run: Run, neo4j_server: RunningNeo4j) -> None:
    run("MATCH (n) DETACH DELETE n")
    with pytest.raises(StoreError, match="has no schema of Enfilade yet"):
        neo4j_server.open(create=False)
    neo4j_server.open().close()
    neo4j_server.open(create=False).close()


def test_a_reader_waits_for_a_commit_that_is_under_way(run: Run, neo4j_store: Neo4jStore, hotel: BuildingGraph) -> None:
    neo4j_store.write(hotel)
    run("MATCH (s:EnfiladeSchema) SET s.begun = s.ended + 1, s.begun_at = timestamp()")
    read: list[BuildingGraph] = []
    reader = threading.Thread(target=lambda: read.append(neo4j_store.read("hotel")))
    reader.start()
    time.sleep(0.5)
    assert not read
    run("MATCH (s:EnfiladeSchema) SET s.ended = s.begun")
    reader.join()
    assert read == [hotel]


def test_a_commit_that_never_said_its_end_stops_nobody(run: Run, neo4j_store: Neo4jStore, hotel: BuildingGraph) -> None:
    neo4j_store.write(hotel)
    long_ago = neo4j_turns.ABANDONED_MS + 1
    run(f"MATCH (s:EnfiladeSchema) SET s.begun = s.ended + 1, s.begun_at = timestamp() - {long_ago}")
    assert neo4j_store.read("hotel") == hotel
    neo4j_store.write(hotel)
    assert list(neo4j_store.rows("MATCH (s:EnfiladeSchema) RETURN s.begun = s.ended", {})) == [(True,)]


def test_a_reader_without_peace_takes_the_writers_turn_and_still_only_reads(
    run: Run, neo4j_store: Neo4jStore, hotel: BuildingGraph, monkeypatch: pytest.MonkeyPatch
) -> None:
    neo4j_store.write(hotel)
    monkeypatch.setattr(neo4j_turns, "QUIET_TRIES", 0)
    assert neo4j_store.read("hotel") == hotel
    assert list(neo4j_store.rows("MATCH (r:Room) SET r.area = 1 RETURN DISTINCT r.area", {})) == [(1,)]
    assert neo4j_store.read("hotel") == hotel


def test_raw_cypher_gives_plain_values(neo4j_store: Neo4jStore, hotel: BuildingGraph) -> None:
    neo4j_store.write(hotel)
    text = "MATCH way = (:Room {id: $id})-[:CONTAINS]->(o:Object) RETURN way, o.descriptor AS counts, date($day) AS day"
    (row,) = neo4j_store.cypher(text, {"id": "hotel/r6", "day": "2026-01-02"})
    room, contains, thing = row["way"]
    assert (room["label"], room["name"], contains["type"], thing["id"]) == ("Room", "Bath", "CONTAINS", "hotel/o3")
    assert "descriptor" not in thing
    assert row["counts"] == [30720, 0, 0, 30720, 0, 0, 0, 0]
    assert row["day"] == "2026-01-02"


def test_raw_cypher_only_reads(neo4j_store: Neo4jStore, hotel: BuildingGraph) -> None:
    neo4j_store.write(hotel)
    with pytest.raises(StoreError, match="is only read here"):
        list(neo4j_store.cypher("MATCH (n) DETACH DELETE n", {}))
    assert neo4j_store.read("hotel") == hotel


def test_constraints_and_indexes_come_from_the_definition(neo4j_store: Neo4jStore) -> None:
    found = {row["name"] for row in neo4j_store.cypher("SHOW INDEXES YIELD name", {})}
    expected = {"enfilade_room_id", "enfilade_room_area", "enfilade_object_parts", "enfilade_storey_building"}
    assert expected <= found
