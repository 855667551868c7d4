"""The SQLite file itself: whose it is, which version, and what a killed writer leaves."""

from __future__ import annotations

import signal
import sqlite3
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path

import pytest

from enfilade.errors import StoreError, VersionError
from enfilade.schema.definition import EDGE_TYPES, NODE_TYPES, SCHEMA_VERSION
from enfilade.schema.exchange import write_graph
from enfilade.schema.graph import BuildingGraph
from enfilade.stores import open_store
from enfilade.stores.sqlite import SQLiteStore

ENDLESS_WRITER = """
import sys
from pathlib import Path
from enfilade.schema.exchange import read_graph
from enfilade.stores import open_store
graphs = [read_graph(Path(name)) for name in sys.argv[2:]]
with open_store(sys.argv[1]) as store:
    while True:
        for graph in graphs:
            store.write(graph)
            print(graph.building, flush=True)
"""


def set_pragma(path: Path, pragma: str) -> None:
    with closing(sqlite3.connect(path)) as connection:
        connection.execute(f"PRAGMA {pragma}")
        connection.commit()


def rooms(count: int) -> BuildingGraph:
    graph = BuildingGraph("a")
    graph.add_node("a", "Building")
    for number in range(count):
        graph.add_node(f"a/r{number}", "Room", area=float(count))
    return graph


def test_the_layout_is_that_of_the_definition(tmp_path: Path) -> None:
    SQLiteStore(tmp_path / "a.db").close()
    with closing(sqlite3.connect(tmp_path / "a.db")) as connection:
        for node in NODE_TYPES:
            columns = [row[1] for row in connection.execute(f"PRAGMA table_info('{node.label.lower()}')")]
            besides = ["descriptor_shape", "attributes", "revision"] if node.label == "Building" else []
            expected = ["pk", "id", "building", "name", *(p.name for p in node.properties), *besides, "extra"]
            assert columns == expected
        for edge in EDGE_TYPES:
            columns = [row[1] for row in connection.execute(f"PRAGMA table_info('{edge.type.lower()}')")]
            assert columns == ["pk", "building", "source", "target", "key", *(p.name for p in edge.properties), "extra"]
        assert connection.execute("PRAGMA journal_mode").fetchone() == ("wal",)


@pytest.mark.parametrize(
    ("version", "advice"), [(SCHEMA_VERSION + 1, "use a newer Enfilade"), (SCHEMA_VERSION - 1, "export its buildings")]
)
def test_another_schema_version_is_refused(tmp_path: Path, version: int, advice: str) -> None:
    SQLiteStore(tmp_path / "a.db").close()
    set_pragma(tmp_path / "a.db", f"user_version = {version}")
    with pytest.raises(VersionError, match=advice):
        SQLiteStore(tmp_path / "a.db")


def test_a_file_of_somebody_else_is_refused_and_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "photos.db"
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("CREATE TABLE photos (id)")
    before = path.read_bytes()
    with pytest.raises(StoreError, match="no store of Enfilade"):
        SQLiteStore(path)
    assert path.read_bytes() == before


def test_what_is_no_sqlite_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("not a database, but long enough to look at" * 50)
    with pytest.raises(StoreError, match="is no SQLite file"):
        SQLiteStore(path)


def test_a_missing_store_is_only_made_when_asked(tmp_path: Path) -> None:
    with pytest.raises(StoreError, match="there is no store"):
        SQLiteStore(tmp_path / "a.db", create=False)
    assert not (tmp_path / "a.db").exists()
    (tmp_path / "a.db").touch()
    with pytest.raises(StoreError, match="is an empty file"):
        SQLiteStore(tmp_path / "a.db", create=False)
    SQLiteStore(tmp_path / "a.db").close()
    SQLiteStore(tmp_path / "a.db", create=False).close()


def test_a_name_that_no_file_can_have_is_said(tmp_path: Path) -> None:
    for create in (True, False):
        with pytest.raises(StoreError, match="cannot be opened"):
            SQLiteStore(tmp_path / ("x" * 300), create=create)


def test_a_missing_folder_is_said(tmp_path: Path) -> None:
    with pytest.raises(StoreError, match="its folder exists"):
        SQLiteStore(tmp_path / "no" / "a.db")


def test_a_file_name_may_hold_anything(tmp_path: Path) -> None:
    path = tmp_path / "a ?#%20'ü;.db"
    with SQLiteStore(path) as store:
        store.write(rooms(2))
        assert store.read("a") == rooms(2)
    assert path.exists()


def test_many_may_make_the_same_store_at_once(tmp_path: Path) -> None:
    def make(_: int) -> None:
        with SQLiteStore(tmp_path / "a.db") as store:
            store.write(rooms(3))

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(make, range(8)))
    with SQLiteStore(tmp_path / "a.db") as store:
        assert store.read("a") == rooms(3)


def test_a_full_disk_is_said_and_changes_nothing(tmp_path: Path) -> None:
    with SQLiteStore(tmp_path / "a.db") as store:
        store.write(rooms(1))
        (pages,) = store._writer.execute("PRAGMA page_count").fetchone()
        store._writer.execute(f"PRAGMA max_page_count = {pages + 2}")
        with pytest.raises(StoreError, match="the disk is full"):
            store.write(rooms(5000))
        assert store.read("a") == rooms(1)


def test_a_damaged_file_is_said(tmp_path: Path) -> None:
    path = tmp_path / "a.db"
    with SQLiteStore(path) as store:
        store.write(rooms(500))
    content = bytearray(path.read_bytes())
    content[4096:] = b"\xa5" * (len(content) - 4096)
    path.write_bytes(content)
    with pytest.raises(StoreError, match="is damaged"), SQLiteStore(path) as store:
        store.read("a")


@pytest.mark.slow
def test_a_killed_writer_leaves_the_old_building_or_the_new_one(tmp_path: Path) -> None:
    sizes = (200, 201)
    names = []
    for size in sizes:
        names.append(str(tmp_path / f"{size}.json"))
        write_graph(rooms(size), Path(names[-1]))
    url = f"sqlite:{tmp_path / 'a.db'}"
    for wait_s in (0.0, 0.013, 0.031, 0.057, 0.1):
        with subprocess.Popen(
            [sys.executable, "-c", ENDLESS_WRITER, url, *names], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        ) as writer:
            assert writer.stdout is not None
            assert writer.stdout.readline() == b"a\n"
            time.sleep(wait_s)
            writer.send_signal(signal.SIGKILL)
        with open_store(url) as store:
            areas = [node.properties["area"] for node in store.read("a").of_label("Room")]
            assert len(areas) in sizes
            assert areas == [float(len(areas))] * len(areas)
            assert [summary.id for summary in store.buildings()] == ["a"]


@pytest.mark.parametrize("writable", [True, False])
def test_a_store_from_before_revisions_gets_them_where_it_may_be_written(tmp_path: Path, writable: bool) -> None:
    path = tmp_path / "a.db"
    with open_store(f"sqlite:{path}") as store:
        store.write(rooms(1))
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("DROP INDEX building_revision")
        connection.execute("ALTER TABLE building DROP COLUMN revision")
        connection.execute("PRAGMA journal_mode = DELETE")
        connection.commit()
    with (SQLiteStore if writable else ReadOnlyStore)(path) as store:
        assert store.revisions() == {"a": None}
        assert [found.revision for found in store.descriptors(["a"])] == [None]
        if writable:
            store.write(rooms(1))
            assert store.revisions()["a"] is not None


class ReadOnlyStore(SQLiteStore):
    """Opened as on a medium that cannot be written."""

    def _prepare(self, connection: sqlite3.Connection, *, create: bool) -> None:
        connection.execute("PRAGMA query_only = ON")
        super()._prepare(connection, create=create)
