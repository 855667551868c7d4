"""The real Neo4j on this machine: who may reach it, and what it survives."""

from __future__ import annotations

import os
import signal
import socket
import threading
import urllib.request
from contextlib import closing
from pathlib import Path
from urllib.parse import urlsplit

import psutil
import pytest
from conftest import RunningNeo4j

from enfilade import server
from enfilade.errors import ServerError, StoreError
from enfilade.schema.graph import BuildingGraph
from enfilade.stores import open_store


def rooms(count: int) -> BuildingGraph:
    graph = BuildingGraph("a")
    graph.add_node("a", "Building")
    for number in range(count):
        graph.add_node(f"a/r{number}", "Room", area=float(count))
    return graph


def test_a_taken_port_is_said(tmp_path: Path) -> None:
    with closing(socket.socket()) as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(ServerError, match=f"port {port} is taken by another program"):
            server.start(tmp_path, settings=server.Settings(bolt_port=port, http_port=0))
    assert server.status(tmp_path) is None


def test_without_a_server_there_is_nothing_to_stop(tmp_path: Path) -> None:
    assert not server.stop(tmp_path / "nowhere")
    assert server.status(tmp_path / "nowhere") is None


def test_a_damaged_note_of_the_server_is_said(tmp_path: Path) -> None:
    (tmp_path / "running.json").write_text("{}")
    with pytest.raises(ServerError, match="is damaged; delete it"):
        server.status(tmp_path)


def test_a_folder_that_cannot_be_made_is_said(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(ServerError, match="cannot be made"):
        server.start(tmp_path / "file" / "home")


@pytest.mark.neo4j
def test_it_listens_on_this_machine_only(neo4j_server: RunningNeo4j) -> None:
    running = server.status(neo4j_server.home)
    assert running is not None
    listening = [c for c in psutil.Process(running.pid).net_connections("inet") if c.status == psutil.CONN_LISTEN]
    addresses = {connection.laddr.ip.removeprefix("::ffff:") for connection in listening}
    assert addresses == {"127.0.0.1"}


@pytest.mark.neo4j
def test_the_password_is_the_owners_and_needed(neo4j_server: RunningNeo4j) -> None:
    password_file = neo4j_server.home / "password"
    assert password_file.stat().st_mode & 0o777 == 0o600
    assert len(neo4j_server.password) >= 24
    running = server.status(neo4j_server.home)
    assert running is not None
    assert neo4j_server.password not in " ".join(psutil.Process(running.pid).cmdline())
    with pytest.raises(StoreError, match='refuses the password of user "neo4j"'):
        open_store(neo4j_server.url, ask=lambda _: "something else")


@pytest.mark.neo4j
def test_the_browser_is_served(neo4j_server: RunningNeo4j) -> None:
    with urllib.request.urlopen(neo4j_server.browser) as answer:
        assert answer.status == 200
        assert b"<title>Neo4j Browser</title>" in answer.read()


@pytest.mark.neo4j
def test_a_second_start_finds_it_running(neo4j_server: RunningNeo4j) -> None:
    running = server.status(neo4j_server.home)
    assert server.start(neo4j_server.home) == running


@pytest.mark.neo4j
def test_the_store_of_the_local_server_needs_no_password(
    neo4j_server: RunningNeo4j, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delenv("ENFILADE_PASSWORD", raising=False)
    (tmp_path / "neo4j").symlink_to(neo4j_server.home)
    monkeypatch.setenv("ENFILADE_CACHE", str(tmp_path))
    with open_store(neo4j_server.url) as store:
        assert store.dialect == "cypher"


@pytest.mark.neo4j
def test_a_database_that_does_not_exist_is_said(neo4j_server: RunningNeo4j) -> None:
    with pytest.raises(StoreError, match='has no database "hotels"'):
        open_store(f"{neo4j_server.url}/hotels", ask=lambda _: neo4j_server.password)


@pytest.mark.neo4j
@pytest.mark.slow
def test_killed_while_it_writes_it_starts_again_with_a_whole_building(
    neo4j_server: RunningNeo4j, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("enfilade.stores.neo4j.RETRY_TIME_S", 1.0)
    first = server.status(neo4j_server.home)
    assert first is not None
    _kill_while_writing(first, neo4j_server.password)
    assert server.status(neo4j_server.home) is None
    bolt, http = (urlsplit(address).port for address in (first.url, first.browser))
    second = server.start(neo4j_server.home, settings=server.Settings(bolt_port=bolt or 0, http_port=http or 0))
    assert (second.url, second.browser) == (first.url, first.browser)
    assert second.pid != first.pid
    with neo4j_server.open() as store:
        areas = [node.properties["area"] for node in store.read("a").of_label("Room")]
        assert len(areas) in (300, 301)
        assert areas == [float(len(areas))] * len(areas)
        store.write(rooms(2))
        assert store.read("a") == rooms(2)


def _kill_while_writing(running: server.ServerStatus, password: str) -> None:
    written = threading.Semaphore(0)
    failed: list[StoreError] = []

    def write() -> None:
        with open_store(running.url, ask=lambda _: password) as store:
            try:
                for size in range(1000):
                    store.write(rooms(300 + size % 2))
                    written.release()
            except StoreError as error:
                failed.append(error)

    writer = threading.Thread(target=write)
    writer.start()
    for _ in range(3):
        assert written.acquire(timeout=120)
    os.kill(running.pid, signal.SIGKILL)
    writer.join()
    assert failed
