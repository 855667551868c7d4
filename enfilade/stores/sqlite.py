"""The embedded store: one SQLite file, read and written by many processes at once (WAL)."""

from __future__ import annotations

import sqlite3
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from itertools import islice
from pathlib import Path
from typing import Any, Final

from enfilade.errors import NotFoundError, StoreError, VersionError
from enfilade.schema.checks import check
from enfilade.schema.definition import SCHEMA_VERSION
from enfilade.schema.graph import BuildingGraph
from enfilade.schema.ids import parse
from enfilade.schema.sqlite import APPLICATION_ID, missing_columns, statements
from enfilade.stores import sqlite_graph, sqlite_tables
from enfilade.stores.base import BuildingDescriptors, BuildingSummary, Store
from enfilade.stores.deadline import Deadline

BUSY_TIMEOUT_S: Final = 60.0
"""How long a writer waits for another process that writes."""

CACHE_KIB: Final = 64 * 1024
"""Most memory that one connection keeps pages in."""

STEPS_BETWEEN_LOOKS: Final = 20_000
"""Steps of SQLite's machine, about a millisecond, after which the clock is looked at."""

ANALYSIS_LIMIT: Final = 1000
"""Rows of an index that are looked at for the statistics that the planner goes by."""


class SQLiteStore(Store):
    """Buildings in one SQLite file.

    Parameters
    ----------
    path
        The file.
    create
        Whether a missing or empty file becomes a new store; otherwise it is an error.

    Raises
    ------
    StoreError
        If the file cannot be opened or is no store of Enfilade.
    VersionError
        If it carries another schema version.
    """

    dialect = "sql"

    def __init__(self, path: Path, *, create: bool = True) -> None:
        self._path = path
        self._readers: list[sqlite3.Connection] = []
        self._lock = threading.Lock()
        if not create and not _exists(path):
            raise StoreError(f"there is no store {path}; ingest or import a building first")
        self._writer = self._open(create=create)

    @property
    def url(self) -> str:
        """``sqlite:PATH``."""
        return f"sqlite:{self._path}"

    @property
    def identity(self) -> str:
        """``sqlite:`` and the whole path."""
        return f"sqlite:{self._path.resolve()}"

    def write_all(self, graphs: Sequence[BuildingGraph]) -> None:
        """Put buildings in, all or none, in one transaction; older versions disappear in the same moment."""
        for graph in graphs:
            check(graph)
        with self._writing() as connection:
            for graph in graphs:
                sqlite_graph.delete(connection, graph.building)
                sqlite_graph.insert(connection, graph)
            connection.execute("ANALYZE")

    def read(self, building: str) -> BuildingGraph:
        """Return a building's whole graph, as it was written. Raises NotFoundError."""
        with self._reading() as connection:
            graph = sqlite_graph.select(connection, building)
        if graph is None:
            raise self._not_found(building)
        return graph

    def properties(self, node: str) -> dict[str, Any]:
        """Return the properties of one node by its key, without its descriptors. Raises NotFoundError."""
        with self._reading() as connection:
            found = sqlite_graph.select_node(connection, parse(node).label, node)
        if found is None:
            raise NotFoundError(f'there is no node "{node}" in {self.url}')
        return found

    def remove(self, building: str) -> None:
        """Take a building out, in one transaction. Raises NotFoundError."""
        with self._writing() as connection:
            if not sqlite_graph.delete(connection, building):
                raise self._not_found(building)

    def buildings(self) -> list[BuildingSummary]:
        """All buildings, by id."""
        with self._reading() as connection:
            return sqlite_tables.summaries(connection)

    def rows(
        self, text: str, parameters: Mapping[str, Any], *, timeout_s: float | None = None, most: int | None = None
    ) -> Iterator[tuple[Any, ...]]:
        """Run a compiled question, read-only; yields `most` rows at most. Raises StoreError past the time limit."""
        deadline = Deadline(timeout_s)
        with self._reading() as connection:
            connection.set_progress_handler(deadline.passed, STEPS_BETWEEN_LOOKS)
            try:
                yield from islice(connection.execute(text, parameters), most)
            except sqlite3.OperationalError as error:
                if error.sqlite_errorcode == sqlite3.SQLITE_INTERRUPT:
                    raise deadline.reason() from error
                raise
            finally:
                connection.set_progress_handler(None, 0)

    def plan(self, text: str, parameters: Mapping[str, Any]) -> str:
        """Return SQLite's own plan for a compiled question, one step a line, indented."""
        with self._reading() as connection:
            return sqlite_tables.plan(connection, text, parameters)

    def revisions(self) -> dict[str, str | None]:
        """Of each building what tells its version from all others, None where that is not known."""
        with self._reading() as connection:
            return sqlite_tables.revisions(connection)

    def descriptors(self, buildings: Sequence[str]) -> Iterator[BuildingDescriptors]:
        """Yield the descriptors of buildings, each as it stood at one moment; one that is gone is left out."""
        for building in buildings:
            with self._reading() as connection:
                found = sqlite_tables.descriptors(connection, building)
            if found is not None:
                yield found

    def close(self) -> None:
        """Let go of the file."""
        while self._readers:
            self._readers.pop().close()
        self._writer.close()

    def _not_found(self, building: str) -> NotFoundError:
        return NotFoundError(f'there is no building "{building}" in {self.url}; "enfilade buildings" lists them')

    def _open(self, *, create: bool) -> sqlite3.Connection:
        with self._telling():
            connection = self._connect(str(self._path))
            try:
                self._prepare(connection, create=create)
            except BaseException:
                connection.close()
                raise
        return connection

    def _connect(self, address: str, *, uri: bool = False) -> sqlite3.Connection:
        connection = sqlite3.connect(
            address, timeout=BUSY_TIMEOUT_S, isolation_level=None, check_same_thread=False, uri=uri
        )
        connection.execute(f"PRAGMA cache_size = -{CACHE_KIB}")
        connection.execute("PRAGMA temp_store = MEMORY")
        connection.execute(f"PRAGMA analysis_limit = {ANALYSIS_LIMIT}")
        return connection

    def _prepare(self, connection: sqlite3.Connection, *, create: bool) -> None:
        if self._is_empty(connection):
            if not create:
                raise StoreError(f"{self._path} is an empty file, not a store; ingest or import a building first")
            connection.execute("PRAGMA journal_mode = WAL")
            with _transaction(connection):
                if self._is_empty(connection):  # another process may have been faster
                    _make_tables(connection)
        self._check_version(connection)
        self._add_columns(connection)

    def _add_columns(self, connection: sqlite3.Connection) -> None:
        """Give a store of the same version what has come since; one that may not be written does without."""
        if not missing_columns(sqlite_tables.building_columns(connection)):
            return
        try:
            with _transaction(connection):  # another process may have been faster
                for statement in missing_columns(sqlite_tables.building_columns(connection)):
                    connection.execute(statement)
        except sqlite3.OperationalError as error:
            if error.sqlite_errorname != "SQLITE_READONLY":
                raise

    def _is_empty(self, connection: sqlite3.Connection) -> bool:
        (tables,) = connection.execute("SELECT count(*) FROM sqlite_master").fetchone()
        return tables == 0 and _pragma(connection, "application_id") == 0

    def _check_version(self, connection: sqlite3.Connection) -> None:
        if _pragma(connection, "application_id") != APPLICATION_ID:
            raise StoreError(f"{self._path} is a SQLite file, but no store of Enfilade; choose another file")
        version = _pragma(connection, "user_version")
        if version > SCHEMA_VERSION:
            raise VersionError(
                f"{self._path} has schema version {version}, this Enfilade knows {SCHEMA_VERSION}; use a newer Enfilade"
            )
        if version < SCHEMA_VERSION:
            raise VersionError(
                f"{self._path} has schema version {version}, this Enfilade needs {SCHEMA_VERSION}; "
                "export its buildings with the Enfilade that wrote it and import them into a new store"
            )

    @contextmanager
    def _writing(self) -> Iterator[sqlite3.Connection]:
        """Lend the one connection that writes, in a transaction that ends with the block."""
        with self._lock, self._telling(), _transaction(self._writer):
            yield self._writer

    @contextmanager
    def _reading(self) -> Iterator[sqlite3.Connection]:
        """Lend a connection that cannot write, in a transaction that sees one moment of the store."""
        with self._telling():
            try:
                connection = self._readers.pop()
            except IndexError:
                connection = self._connect(f"{self._path.absolute().as_uri()}?mode=ro", uri=True)
            try:
                connection.execute("BEGIN")
                yield connection
            except BaseException:
                connection.close()
                raise
            connection.execute("COMMIT")
            self._readers.append(connection)

    @contextmanager
    def _telling(self) -> Iterator[None]:
        """Turn SQLite's errors into a sentence."""
        try:
            yield
        except sqlite3.Error as error:
            raise StoreError(f"{self._path} {_cause(error)}") from error


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except OSError as error:
        raise StoreError(f"{path} cannot be opened: {error.strerror}") from error


@contextmanager
def _transaction(connection: sqlite3.Connection) -> Iterator[None]:
    connection.execute("BEGIN IMMEDIATE")
    try:
        yield
        connection.execute("COMMIT")
    except BaseException:
        if connection.in_transaction:
            connection.execute("ROLLBACK")
        raise


def _make_tables(connection: sqlite3.Connection) -> None:
    for statement in statements():
        connection.execute(statement)
    connection.execute(f"PRAGMA application_id = {APPLICATION_ID}")
    connection.execute(f"PRAGMA user_version = {SCHEMA_VERSION}")


def _pragma(connection: sqlite3.Connection, name: str) -> int:
    with closing(connection.execute(f"PRAGMA {name}")) as cursor:
        return int(cursor.fetchone()[0])


_CAUSES: Final = {
    "SQLITE_NOTADB": "is no SQLite file; choose another file",
    "SQLITE_CORRUPT": "is damaged; put a copy of it back or import its buildings into a new store",
    "SQLITE_FULL": "cannot be written, the disk is full; make room and try again",
    "SQLITE_READONLY": "cannot be written; check the permissions of the file and its folder",
    "SQLITE_CANTOPEN": "cannot be opened; check that it is no folder, that its folder exists and it may be read",
    "SQLITE_BUSY": f"is being written by another process for more than {BUSY_TIMEOUT_S:g} s; try again later",
    "SQLITE_IOERR": "cannot be read or written; check the disk",
}


def _cause(error: sqlite3.Error) -> str:
    name = getattr(error, "sqlite_errorname", "")
    known = next((text for start, text in _CAUSES.items() if name.startswith(start)), None)
    return known or f"refuses: {error}"
