"""Nobody writes through a question, and a server that is in trouble is told of in one sentence."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import RunningNeo4j
from neo4j import READ_ACCESS, Driver, Session

from enfilade import server
from enfilade.errors import StoreError
from enfilade.queries import answer
from enfilade.schema.graph import BuildingGraph
from enfilade.stores.neo4j import Neo4jStore

pytestmark = pytest.mark.neo4j

WRITING = [
    "CREATE (n:Room {id: 'x'})",
    "MATCH (r:Room) CREATE (r)-[:NEIGHBOUR]->(r)",
    "MERGE (n:Room {id: 'x'}) RETURN n",
    "MATCH (r:Room) SET r.area = 1",
    "MATCH (r:Room) SET r += {area: 1} RETURN r",
    "MATCH (r:Room) SET r:Other",
    "MATCH (r:Room) REMOVE r.area",
    "MATCH (r:Room) REMOVE r:Room",
    "MATCH (n) DETACH DELETE n",
    "MATCH ()-[e]->() DELETE e",
    "MATCH (n:Object) NODETACH DELETE n",
    "FOREACH (x IN [1] | CREATE (:Room))",
    "UNWIND [1, 2] AS x CREATE (:Room {id: toString(x)}) RETURN x",
    "CALL { CREATE (:Room) }",
    "MATCH (r:Room) CALL (r) { SET r.area = 1 } IN TRANSACTIONS OF 10 ROWS",
    "LOAD CSV FROM 'file:///x.csv' AS line CREATE (:Room)",
    "CREATE INDEX mine FOR (n:Room) ON (n.height)",
    "DROP INDEX enfilade_room_area",
    "CREATE CONSTRAINT mine FOR (n:Room) REQUIRE n.name IS UNIQUE",
    "DROP CONSTRAINT enfilade_room_id",
    "CALL db.createLabel('Mine')",
    "CALL db.createProperty('mine')",
    "CALL db.createRelationshipType('MINE')",
    "CALL db.index.fulltext.awaitEventuallyConsistentIndexRefresh() CREATE (:Room)",
    "MATCH (r:Room) CALL db.create.setNodeVectorProperty(r, 'v', [1.0]) RETURN r",
    "EXPLAIN CREATE (:Room) CREATE (:Room)",
    "PROFILE CREATE (:Room)",
    "CYPHER 5 CREATE (:Room)",
    "/* only a look */ CREATE (:Room)",
    "MATCH (r:Room) RETURN r; CREATE (:Room)",
    "CREATE USER mallory SET PASSWORD 'password123'",
    "ALTER CURRENT USER SET PASSWORD FROM 'a' TO 'b'",
    "DROP DATABASE neo4j",
]


def labels(store: Neo4jStore) -> list[str]:
    return sorted(row["label"] for row in store.cypher("CALL db.labels()", {}))


def schema(store: Neo4jStore) -> list[str]:
    return sorted(row["name"] for row in store.cypher("SHOW INDEXES YIELD name", {}))


@pytest.mark.parametrize("text", WRITING)
def test_raw_cypher_cannot_write(neo4j_store: Neo4jStore, hotel: BuildingGraph, text: str) -> None:
    neo4j_store.write(hotel)
    before = labels(neo4j_store), schema(neo4j_store)

    if text.startswith("EXPLAIN"):  # it is not run
        list(neo4j_store.cypher(text, {}))
    else:
        with pytest.raises(StoreError, match=r"^[^\n]+$"):
            list(neo4j_store.cypher(text, {}))

    assert neo4j_store.read("hotel") == hotel
    assert (labels(neo4j_store), schema(neo4j_store)) == before
    assert [row["user"] for row in neo4j_store.cypher("SHOW USERS YIELD user", {})] == ["neo4j"]


def test_questions_are_for_readers(
    neo4j_server: RunningNeo4j, neo4j_store: Neo4jStore, hotel: BuildingGraph, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a cluster the driver sends what only reads to a replica."""
    neo4j_store.write(hotel)
    asked: list[str] = []
    unchanged = Driver.session

    def session(driver: Driver, **settings: object) -> Session:
        asked.append(str(settings["default_access_mode"]))
        assert settings["database"] == "neo4j"
        return unchanged(driver, **settings)  # type: ignore[arg-type]

    monkeypatch.setattr(Driver, "session", session)
    with neo4j_server.open(create=False) as store:
        answer(store, "MATCH (a:Room)-[:DOOR]-(b:Room) RETURN a, b", timeout_s=None)
        answer(store, "MATCH (o:Object LIKE object('hotel/o4') WITHIN 0.5) RETURN o, score")
        list(store.cypher("MATCH (a:Room) RETURN a", {}))
        store.plan("MATCH (a:Room) RETURN a", {})
        store.read("hotel")
        store.buildings()

    assert set(asked) == {READ_ACCESS}


@pytest.fixture(scope="module")
def shaky(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Home of a server that a test may stop."""
    home = tmp_path_factory.mktemp("shaky")
    server.start(home, settings=server.Settings(bolt_port=0, http_port=0, heap_mb=256))
    yield home
    server.stop(home)


@pytest.mark.slow
def test_a_server_that_restarts(shaky: Path, hotel: BuildingGraph, monkeypatch: pytest.MonkeyPatch) -> None:
    """While it is away one sentence says so; a question that is asked meanwhile waits; then all is as before."""
    running = server.status(shaky)
    assert running is not None
    port = int(running.url.rpartition(":")[2])
    password = running.password_file.read_text(encoding="utf-8")
    monkeypatch.setattr("enfilade.stores.neo4j.RETRY_TIME_S", 2.0)
    impatient = Neo4jStore(f"neo4j://127.0.0.1:{port}", "neo4j", password)
    monkeypatch.setattr("enfilade.stores.neo4j.RETRY_TIME_S", 120.0)
    patient = Neo4jStore(f"neo4j://127.0.0.1:{port}", "neo4j", password)
    with impatient, patient:
        patient.write(hotel)
        assert server.stop(shaky)
        for ask in (lambda: answer(impatient, "MATCH (a:Room) RETURN a"), lambda: impatient.write(hotel)):
            with pytest.raises(StoreError, match=r"cannot be reached; check the address and that the server runs"):
                ask()
        found: list[int] = []
        waiting = threading.Thread(target=lambda: found.append(len(answer(patient, "MATCH (a:Room) RETURN a").rows)))
        waiting.start()
        time.sleep(1)
        server.start(shaky, settings=server.Settings(bolt_port=port, http_port=0, heap_mb=256))
        waiting.join(timeout=120)
        assert found == [7]
        assert len(answer(impatient, "MATCH (a:Room) RETURN a").rows) == 7
        assert impatient.read("hotel") == hotel
