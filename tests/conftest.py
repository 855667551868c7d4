"""Settings and fixtures that all tests share."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from hypothesis import settings

from enfilade import server
from enfilade.cache import CACHE_VARIABLE, cache_folder
from enfilade.errors import ServerError
from enfilade.schema.exchange import read_graph
from enfilade.schema.graph import BuildingGraph
from enfilade.stores import Store, open_store
from enfilade.stores.neo4j import Neo4jStore

# The first call of a compiled function takes long, and a run must be repeatable.
settings.register_profile("enfilade", deadline=None, derandomize=True)
settings.load_profile("enfilade")

GRAPHS = Path(__file__).parent / "graphs"


@pytest.fixture(scope="session", autouse=True)
def _own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """A cache folder of this run's own; only the jars of Neo4j are the user's."""
    jars = cache_folder() / "neo4j-jars"
    jars.mkdir(parents=True, exist_ok=True)
    own = tmp_path_factory.mktemp("cache")
    (own / "neo4j-jars").symlink_to(jars)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(CACHE_VARIABLE, str(own))
        yield


@dataclass(frozen=True)
class RunningNeo4j:
    """The real server of this test run."""

    url: str
    browser: str
    password: str
    home: Path

    def open(self, *, create: bool = True) -> Neo4jStore:
        store = open_store(self.url, create=create, ask=lambda _: self.password)
        assert isinstance(store, Neo4jStore)
        return store


@pytest.fixture(scope="session")
def neo4j_server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningNeo4j]:
    """A real Neo4j on free ports, with a home of its own; the jars come from the user's cache."""
    home = tmp_path_factory.mktemp("neo4j")
    try:
        running = server.start(home, settings=server.Settings(bolt_port=0, http_port=0))
    except ServerError as error:
        if os.environ.get("ENFILADE_REQUIRE_NEO4J") == "1":
            raise
        pytest.skip(f"Neo4j cannot be started here: {error}")
    try:
        password = running.password_file.read_text(encoding="utf-8")
        yield RunningNeo4j(running.url, running.browser, password, home)
    finally:
        assert server.stop(home)
        assert server.status(home) is None


@pytest.fixture(scope="session")
def _neo4j_connection(neo4j_server: RunningNeo4j) -> Iterator[Neo4jStore]:
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("ENFILADE_PASSWORD", raising=False)
        store = neo4j_server.open()
    with store:
        yield store


@pytest.fixture
def neo4j_store(_neo4j_connection: Neo4jStore) -> Neo4jStore:
    """The Neo4j store, empty."""
    for summary in _neo4j_connection.buildings():
        _neo4j_connection.remove(summary.id)
    return _neo4j_connection


@pytest.fixture
def sqlite_store(tmp_path: Path) -> Iterator[Store]:
    """An empty SQLite store."""
    with open_store(f"sqlite:{tmp_path / 'enfilade.db'}") as store:
        yield store


@pytest.fixture(params=["sqlite", pytest.param("neo4j", marks=pytest.mark.neo4j)])
def store(request: pytest.FixtureRequest) -> Store:
    """An empty store, of each kind in turn."""
    opened = request.getfixturevalue(f"{request.param}_store")
    assert isinstance(opened, Store)
    return opened


@pytest.fixture
def hotel() -> BuildingGraph:
    """A small building with every label and nearly every edge type."""
    return read_graph(GRAPHS / "hotel.graph.json")


@dataclass(frozen=True)
class Demo:
    """What ``enfilade demo`` left behind: the folder it ran in, what it printed, what it reported."""

    folder: Path
    printed: str
    reported: str

    @property
    def store(self) -> str:
        return f"sqlite:{self.folder / 'enfilade.db'}"


@pytest.fixture(scope="session")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Demo:
    """The built-in building, scanned, ingested and asked by the command itself; made once a run."""
    folder = tmp_path_factory.mktemp("demo")
    done = subprocess.run(
        [sys.executable, "-m", "enfilade", "demo"], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return Demo(folder, done.stdout, done.stderr)
