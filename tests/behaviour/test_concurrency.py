"""Eight processes ask while two write: no error, no half building, on every store."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import RunningNeo4j

from enfilade.descriptors import TOTAL
from enfilade.schema.exchange import write_graphs
from enfilade.schema.graph import BuildingGraph
from enfilade.stores import Store

READERS = 8
WRITERS = 2
SIZES = (30, 31)
ROUNDS = int(os.environ.get("ENFILADE_CONCURRENT_ROUNDS", "6"))
LEAST_ANSWERS = 3

READING = f"""
import os
import sys
from pathlib import Path
from enfilade.queries import answer
from enfilade.stores import open_store

url, password, done, sizes = sys.argv[1], sys.argv[2], Path(sys.argv[3]), set(map(int, sys.argv[4:]))
seen = set()
answers = 0
with open_store(url, create=False, ask=lambda _: password) as store:
    while answers < {LEAST_ANSWERS} or not done.exists():
        rooms = "MATCH (s:Storey)-[:HAS_ROOM]->(r:Room) RETURN r.building, count(*), min(r.area), max(r.area)"
        for building, *figures in (row.values() for row in answer(store, rooms).rows):
            assert len(set(figures)) == 1 and figures[0] in sizes, (building, figures)
            seen.add((building, figures[0]))
        doors = answer(store, "MATCH (a:Room)-[:DOOR]-(b:Room) RETURN a.building, count(*), min(a.area) AS rooms").rows
        assert all(row["count(*)"] == 2 * (row["rooms"] - 1) for row in doors), doors
        like = answer(store, "MATCH (o:Object LIKE object('still/o0')) RETURN o, score LIMIT 1").rows
        assert like == [{{"o": "still/o0", "score": 0.0}}], like
        answers += 1
        Path(f"{{done}}-not-yet-{{os.getpid()}}").touch()
print(len(seen))
"""

WRITING = """
import sys
from pathlib import Path
from enfilade.schema.exchange import read_graphs
from enfilade.stores import open_store
from enfilade.stores.archive import Archive

url, password, clouds, rounds, files = sys.argv[1], sys.argv[2], Path(sys.argv[3]), int(sys.argv[4]), sys.argv[5:]
with open_store(url, ask=lambda _: password) as store:
    archive = Archive(store, clouds)
    for number in range(rounds):
        for file in files:
            if number % 3 == 2:
                list(archive.save_all((graph, None) for graph in read_graphs(Path(file))))
                continue
            for graph in read_graphs(Path(file)):
                archive.save(graph, None)
"""


def building(id: str, rooms: int) -> BuildingGraph:
    """Rooms in a row whose area is their number, and one object."""
    graph = BuildingGraph(id, descriptor_shape=(1, 1, 2))
    graph.add_node(id, "Building")
    graph.add_node(f"{id}/s0", "Storey", index=0)
    graph.add_edge(id, "HAS_STOREY", f"{id}/s0")
    for number in range(rooms):
        graph.add_node(f"{id}/r{number}", "Room", area=float(rooms))
        graph.add_edge(f"{id}/s0", "HAS_ROOM", f"{id}/r{number}")
    for number in range(rooms - 1):
        graph.add_node(f"{id}/p{number}", "Opening", kind="door")
        graph.add_edge(f"{id}/r{number}", "OPENS", f"{id}/p{number}")
        graph.add_edge(f"{id}/r{number + 1}", "OPENS", f"{id}/p{number}")
    counts = np.array([TOTAL, 0] if id == "still" else [rooms, TOTAL - rooms], dtype=np.uint16)
    graph.add_node(f"{id}/o0", "Object", parts=1, segments=[f"{id}/o0"], descriptor=counts, foot_descriptor=counts)
    graph.add_edge(f"{id}/r0", "CONTAINS", f"{id}/o0")
    return graph


@pytest.mark.slow
def test_many_processes_ask_while_others_write(
    store: Store, request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ENFILADE_CACHE", str(tmp_path / "cache"))
    password = ""
    if store.dialect == "cypher":
        server: RunningNeo4j = request.getfixturevalue("neo4j_server")
        password = server.password
    names = [f"w{number}" for number in range(WRITERS)]
    for size in SIZES:
        for name in names:
            write_graphs([building(name, size), building(f"{name}b", size)], tmp_path / f"{name}-{size}.jsonl")
    store.write_all([building("still", SIZES[0]), *(building(n, SIZES[0]) for w in names for n in (w, f"{w}b"))])
    done = tmp_path / "done"

    reading = [_start(READING, store.url, password, str(done), *map(str, SIZES)) for _ in range(READERS)]
    _wait_for(lambda: len(list(tmp_path.glob("done-not-yet-*"))) == READERS, reading)
    writing = [
        _start(
            WRITING,
            store.url,
            password,
            str(tmp_path / "clouds"),
            str(ROUNDS),
            *(str(tmp_path / f"{name}-{size}.jsonl") for size in reversed(SIZES)),
        )
        for name in names
    ]
    written = [_finished(process) for process in writing]
    done.touch()
    seen = [_finished(process) for process in reading]

    assert [status for status, _, _ in written] == [0] * WRITERS, written
    assert [status for status, _, _ in seen] == [0] * READERS, [said for _, _, said in seen]
    assert max(int(printed) for _, printed, _ in seen) > 1 + 2 * WRITERS  # a building in both sizes: it was replaced
    assert len(store.buildings()) == 1 + 2 * WRITERS


def _wait_for(ready: Callable[[], bool], processes: list[subprocess.Popen[str]]) -> None:
    """Wait until all have answered once, or one has ended, which it should not yet."""
    latest = time.monotonic() + 120.0
    while not ready() and all(process.poll() is None for process in processes) and time.monotonic() < latest:
        time.sleep(0.05)


def _start(code: str, *arguments: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", code, *arguments]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def _finished(process: subprocess.Popen[str]) -> tuple[int, str, str]:
    printed, said = process.communicate(timeout=300)
    return process.returncode, printed, said[-2000:]
