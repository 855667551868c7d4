"""What explodes is stopped: in time, within memory, at the server too, and said in one sentence."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from itertools import combinations, pairwise

import psutil
import pytest
from conftest import RunningNeo4j

from enfilade.errors import StoreError, UnsupportedError
from enfilade.queries import answer
from enfilade.queries.run import matching
from enfilade.schema.graph import BuildingGraph
from enfilade.stores import Store
from enfilade.stores.neo4j import Neo4jStore

LIMIT_S = 1.0
LATE_S = 3.0
"""How late an end may be: a second is asked for, and the machine that runs the tests may be busy."""

MEMORY_MB = 400


def chain(edge: str, count: int = 30) -> str:
    return f"-[:{edge}]-".join(f"(a{i}:Room)" for i in range(count))


EXPLODING = {
    "chain of neighbours": f"MATCH {chain('NEIGHBOUR')} RETURN count(*)",
    "ring of neighbours": f"MATCH {chain('NEIGHBOUR')}-[:NEIGHBOUR]-(a0) RETURN count(*)",
    "star": "MATCH " + ", ".join(f"(a)-[:NEIGHBOUR]-(b{i}:Room)" for i in range(30)) + " RETURN a",
    "loose nodes": "MATCH " + ", ".join(f"(a{i}:Room)" for i in range(30)) + " RETURN count(*)",
    "rows": "MATCH (a:Room), (b:Room), (c:Room), (d:Room), (e:Room) RETURN ALL a, b, c, d, e",
    "inside count": f"MATCH (a0:Room) WHERE count {{ {chain('NEIGHBOUR', 20)} }} < 0 RETURN a0",
    "options": (
        "MATCH (a:Room)-[:NEIGHBOUR]-(b:Room) OPTIONAL MATCH (c:Room)-[:NEIGHBOUR]-(d:Room)-[:NEIGHBOUR]-(e:Room) "
        "RETURN a, c"
    ),
}
"""Each has more matches, or partial ones, than anybody can count."""


@pytest.fixture
def crowded() -> BuildingGraph:
    """Forty rooms of which each is every other's neighbour, all with doors to the next."""
    graph = BuildingGraph("crowded")
    graph.add_node("crowded", "Building")
    rooms = [graph.add_node(f"crowded/r{number}", "Room", area=float(number)).id for number in range(40)]
    for a, b in combinations(rooms, 2):
        graph.add_edge(a, "NEIGHBOUR", b)
    for number, (a, b) in enumerate(pairwise(rooms)):
        graph.add_node(f"crowded/p{number}", "Opening", kind="door")
        graph.add_edge(a, "OPENS", f"crowded/p{number}")
        graph.add_edge(b, "OPENS", f"crowded/p{number}")
    return graph


@pytest.fixture
def running(neo4j_server: RunningNeo4j) -> Iterator[Callable[[], list[str]]]:
    """What the server is at, besides telling it."""
    with neo4j_server.open() as other:
        text = "SHOW TRANSACTIONS YIELD currentQuery AS text WHERE NOT text STARTS WITH 'SHOW' RETURN text"
        yield lambda: [row["text"] for row in other.cypher(text, {})]


@pytest.mark.parametrize("name", EXPLODING)
def test_an_exploding_question_ends_in_time_and_within_memory(store: Store, crowded: BuildingGraph, name: str) -> None:
    store.write(crowded)
    before = psutil.Process().memory_info().rss
    start = time.perf_counter()

    with pytest.raises(StoreError, match=r"took longer than 1 s.*make it narrower or raise --timeout"):
        answer(store, EXPLODING[name], timeout_s=LIMIT_S)

    assert time.perf_counter() - start < LIMIT_S + LATE_S
    assert psutil.Process().memory_info().rss - before < MEMORY_MB * 1e6
    assert answer(store, "MATCH (a:Room) RETURN count(*)").rows == [{"count(*)": 40}]


def test_how_far_it_got_is_said(store: Store, crowded: BuildingGraph) -> None:
    store.write(crowded)
    text = "MATCH (a:Room) OPTIONAL MATCH (b:Room)-[:NEIGHBOUR]-(c:Room)-[:NEIGHBOUR]-(d:Room) RETURN a, b"
    with pytest.raises(StoreError, match=r"took longer than 1.5 s \([0-9,]+ rows were found so far\)"):
        answer(store, text, timeout_s=1.5)


def test_what_does_not_fit_memory_is_refused(
    store: Store, crowded: BuildingGraph, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(matching, "MOST_VALUES", 4000)
    store.write(crowded)
    assert len(answer(store, "MATCH (a:Room)-[:NEIGHBOUR]-(b:Room) RETURN a, b").rows) == 780
    with pytest.raises(UnsupportedError, match="more than 1,333 matches"):
        answer(store, "MATCH (a:Room)-[:NEIGHBOUR]-(b:Room) RETURN ALL a, b")
    with pytest.raises(UnsupportedError, match="too many matches"):
        answer(store, "MATCH (a:Room) OPTIONAL MATCH (b:Room)-[:DOOR]-(c:Room) RETURN a, b")


@pytest.mark.neo4j
def test_the_server_stops_working_at_the_limit(
    neo4j_store: Neo4jStore, crowded: BuildingGraph, running: Callable[[], list[str]]
) -> None:
    neo4j_store.write(crowded)
    endless = "UNWIND range(1, 1000000000) AS x WITH x WHERE x % 7 = 8 RETURN count(x)"
    for ask in (
        lambda: answer(neo4j_store, EXPLODING["chain of neighbours"], timeout_s=0.5),
        lambda: list(neo4j_store.cypher(endless, {}, timeout_s=0.5)),
    ):
        start = time.perf_counter()
        with pytest.raises(StoreError, match="longer than"):
            ask()
        assert time.perf_counter() - start < 0.5 + LATE_S
        assert running() == []


ASKING = """
import sys
from enfilade.queries import answer
from enfilade.stores import open_store
with open_store(sys.argv[1], ask=lambda _: sys.argv[2]) as store:
    print("asking", flush=True)
    answer(store, sys.argv[3], timeout_s=None)
"""


@pytest.mark.neo4j
def test_ctrl_c_stops_the_server_too(
    neo4j_server: RunningNeo4j, neo4j_store: Neo4jStore, crowded: BuildingGraph, running: Callable[[], list[str]]
) -> None:
    neo4j_store.write(crowded)
    question = EXPLODING["chain of neighbours"]
    command = [sys.executable, "-c", ASKING, neo4j_server.url, neo4j_server.password, question]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as asking:
        assert asking.stdout is not None
        assert asking.stdout.readline() == b"asking\n"
        _wait_until(lambda: any("NEIGHBOUR" in text for text in running()))
        asking.send_signal(signal.SIGINT)
        assert asking.wait(timeout=10) == -signal.SIGINT
    _wait_until(lambda: running() == [])


def _wait_until(holds: Callable[[], bool]) -> None:
    for _ in range(200):
        if holds():
            return
        time.sleep(0.05)
    raise AssertionError("waited ten seconds in vain")
