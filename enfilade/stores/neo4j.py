"""The graph database: Neo4j 5.26 or later, on this machine, in a cluster or in Aura."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from functools import partial
from itertools import islice
from typing import Any, Final, TypeVar

from neo4j import READ_ACCESS, WRITE_ACCESS, Driver, GraphDatabase, ManagedTransaction, Query, Session
from neo4j.exceptions import ConfigurationError, DriverError, Neo4jError, ServiceUnavailable

from enfilade.errors import NotFoundError, StoreError, VersionError
from enfilade.schema.checks import check
from enfilade.schema.definition import SCHEMA_VERSION
from enfilade.schema.graph import BuildingGraph
from enfilade.schema.ids import parse
from enfilade.schema.neo4j import SCHEMA_LABEL, statements
from enfilade.stores import neo4j_graph, neo4j_tables, neo4j_turns
from enfilade.stores.base import BuildingDescriptors, BuildingSummary, Store
from enfilade.stores.neo4j_watch import ended_in_time

DEFAULT_DATABASE: Final = "neo4j"
CONNECTION_TIMEOUT_S: Final = 15.0
RETRY_TIME_S: Final = 30.0
"""How long the driver tries a transaction again that failed for a passing reason."""

FETCH_SIZE: Final = 2000

BUILDINGS_AT_ONCE: Final = 8
"""Buildings whose descriptors one transaction reads; a large one has some tens of megabytes of them."""

T = TypeVar("T")

logging.getLogger("neo4j").addHandler(logging.NullHandler())  # what matters is raised; the driver need not print too


class Neo4jStore(Store):
    """Buildings in a Neo4j database.

    Parameters
    ----------
    address
        ``neo4j://host:7687``, ``bolt://...``, ``neo4j+s://...``; without user and password.
    user, password
        Who asks.
    database
        Name of the database; the Community edition has one, called ``neo4j``.
    create
        Whether a database without our schema gets it; otherwise that is an error.

    Raises
    ------
    StoreError
        If the server cannot be reached, refuses the password or has no such database.
    VersionError
        If the database carries another schema version.
    """

    dialect = "cypher"

    def __init__(
        self, address: str, user: str, password: str, *, database: str = DEFAULT_DATABASE, create: bool = True
    ) -> None:
        self._address = address
        self._user = user
        self._database = database
        with self._telling():
            self._driver = self._connect(password)
            try:
                self._prepare(create=create)
            except BaseException:
                self._driver.close()
                raise

    @property
    def url(self) -> str:
        """Address with the user and, if it is not the usual one, the database."""
        scheme, _, host = self._address.partition("://")
        path = "" if self._database == DEFAULT_DATABASE else f"/{self._database}"
        return f"{scheme}://{self._user}@{host}{path}"

    def write_all(self, graphs: Sequence[BuildingGraph]) -> None:
        """Put buildings in, all or none, in one transaction; older versions disappear in the same moment."""
        for graph in graphs:
            check(graph)
        last = {graph.building: graph for graph in graphs}

        def replace(transaction: ManagedTransaction) -> None:
            neo4j_graph.delete(transaction, list(last))
            neo4j_graph.insert(transaction, list(last.values()))

        self._write(replace)

    def read(self, building: str) -> BuildingGraph:
        """Return a building's whole graph, as it was written. Raises NotFoundError."""
        stored = self._read(lambda transaction: neo4j_graph.select(transaction, building))
        if stored is None:
            raise self._not_found(building)
        return stored.graph()

    def properties(self, node: str) -> dict[str, Any]:
        """Return the properties of one node by its key, without its descriptors. Raises NotFoundError."""
        label = parse(node).label
        found = self._read(lambda transaction: neo4j_graph.select_node(transaction, label, node))
        if found is None:
            raise NotFoundError(f'there is no node "{node}" in {self.url}')
        return found

    def remove(self, building: str) -> None:
        """Take a building out, in one transaction. Raises NotFoundError."""
        if not self._write(lambda transaction: neo4j_graph.delete(transaction, [building])):
            raise self._not_found(building)

    def buildings(self) -> list[BuildingSummary]:
        """All buildings, by id."""
        return neo4j_tables.building_summaries(self._read(neo4j_tables.summaries))

    def rows(
        self, text: str, parameters: Mapping[str, Any], *, timeout_s: float | None = None, most: int | None = None
    ) -> Iterator[tuple[Any, ...]]:
        """Run a compiled question, read-only; yields its rows, all read before the first: see `neo4j_turns`."""
        given = dict(parameters)
        yield from self._read(
            lambda transaction: [tuple(row) for row in islice(transaction.run(text, given), most)], timeout_s=timeout_s
        )

    def cypher(
        self, text: str, parameters: Mapping[str, Any], *, timeout_s: float | None = None
    ) -> Iterator[dict[str, Any]]:
        """Run Cypher as it stands, read-only; yields rows of plain values, as ``enfilade cypher`` shows them."""
        with self._session(READ_ACCESS) as session, self._ended_in_time(timeout_s) as metadata:
            found = session.run(Query(text, timeout=timeout_s, metadata=metadata), dict(parameters))
            names = found.keys()
            for record in found:
                yield {name: neo4j_tables.plain(value) for name, value in zip(names, record, strict=True)}

    def plan(self, text: str, parameters: Mapping[str, Any]) -> str:
        """Return Neo4j's own plan for a compiled question, one operator a line, indented."""
        with self._session(READ_ACCESS) as session:
            summary = session.run(f"EXPLAIN {text}", dict(parameters)).consume()
        return "\n".join(neo4j_tables.plan_lines(summary.plan or {}))

    def revisions(self) -> dict[str, str | None]:
        """Of each building what tells its version from all others, None where that is not known."""
        return dict(self._read(neo4j_tables.revisions))

    def descriptors(self, buildings: Sequence[str]) -> Iterator[BuildingDescriptors]:
        """Yield the descriptors of buildings, each as it stood at one moment; one that is gone is left out."""
        for first in range(0, len(buildings), BUILDINGS_AT_ONCE):
            some = buildings[first : first + BUILDINGS_AT_ONCE]
            for found in self._read(partial(neo4j_tables.descriptors, buildings=some)):
                yield neo4j_tables.building_descriptors(*found)

    def close(self) -> None:
        """Let go of the connections."""
        self._driver.close()

    def _connect(self, password: str) -> Driver:
        return GraphDatabase.driver(
            self._address,
            auth=(self._user, password),
            notifications_min_severity="OFF",
            connection_timeout=CONNECTION_TIMEOUT_S,
            connection_acquisition_timeout=CONNECTION_TIMEOUT_S * 2,
            max_transaction_retry_time=RETRY_TIME_S,
        )

    def _prepare(self, *, create: bool) -> None:
        with self._session(WRITE_ACCESS if create else READ_ACCESS) as session:
            versions = _versions(session)  # not retried: a server that cannot be reached is told at once
            if not versions and not create:
                raise StoreError(f"{self.url} has no schema of Enfilade yet; ingest or import a building first")
            if not versions:
                for statement in statements():
                    session.run(statement).consume()
                session.run("CALL db.awaitIndexes(60)").consume()
                neo4j_turns.prepare(session)
                versions = [SCHEMA_VERSION]
        if versions != [SCHEMA_VERSION]:
            found = ", ".join(map(str, versions))
            raise VersionError(
                f"{self.url} has schema version {found}, this Enfilade knows {SCHEMA_VERSION}; "
                "open it with the Enfilade that wrote it"
            )

    def _write(self, work: neo4j_turns.Writing[T]) -> T:
        with self._session(WRITE_ACCESS) as session, self._session(WRITE_ACCESS) as announcing:
            return neo4j_turns.write(session, announcing, work)

    def _read(self, work: neo4j_turns.Reading[T], *, timeout_s: float | None = None) -> T:
        with self._session(READ_ACCESS) as session, self._ended_in_time(timeout_s) as metadata:
            locking = partial(self._open_session, WRITE_ACCESS)
            return neo4j_turns.read(session, locking, work, timeout_s=timeout_s, metadata=metadata)

    def _ended_in_time(self, timeout_s: float | None) -> AbstractContextManager[dict[str, Any]]:
        return ended_in_time(partial(self._open_session, READ_ACCESS), timeout_s)

    def _open_session(self, access: str) -> Session:
        return self._driver.session(database=self._database, default_access_mode=access, fetch_size=FETCH_SIZE)

    @contextmanager
    def _session(self, access: str) -> Iterator[Session]:
        with self._telling(), self._open_session(access) as session:
            yield session

    @contextmanager
    def _telling(self) -> Iterator[None]:
        """Turn the driver's errors into a sentence."""
        try:
            yield
        except (Neo4jError, DriverError, ConfigurationError) as error:
            if _was_interrupted(error):
                raise KeyboardInterrupt from error
            raise StoreError(self._cause(error)) from error

    def _cause(self, error: Exception) -> str:
        if isinstance(error, ServiceUnavailable):
            return (
                f"{self.url} cannot be reached; check the address and that the server runs "
                '("enfilade server start" starts one on this machine)'
            )
        if not isinstance(error, Neo4jError):
            return f"{self.url} refuses: {error}"
        known = next((text for part, text in _CAUSES.items() if error.code and error.code.endswith(part)), None)
        if known:
            return f"{self.url} {known.format(user=self._user, database=self._database)}"
        return f"{self.url} refuses: {(error.message or '').partition(chr(10))[0]}"

    def _not_found(self, building: str) -> NotFoundError:
        return NotFoundError(f'there is no building "{building}" in {self.url}; "enfilade buildings" lists them')


_CAUSES: Final = {
    "Security.Unauthorized": 'refuses the password of user "{user}"; set ENFILADE_PASSWORD to the right one',
    "Security.AuthenticationRateLimit": "has refused too many passwords; wait a few seconds and try again",
    "Database.DatabaseNotFound": 'has no database "{database}"; the one of the Community edition is called neo4j',
    "Transaction.TransactionTimedOut": "took longer than the time limit; make the question narrower or raise --timeout",
    "Transaction.TransactionTimedOutClientConfiguration": (
        "took longer than the time limit; make the question narrower or raise --timeout"
    ),
    "Transaction.Terminated": "took longer than the time limit, or somebody ended it",
    "Statement.AccessMode": "is only read here, nothing may be written",
    "General.MemoryPoolOutOfMemoryError": (
        "has too little memory for so large a transaction; give it more heap "
        '("enfilade server start --heap-mb 2048" after a stop)'
    ),
}


def _was_interrupted(error: BaseException | None) -> bool:
    """Whether an error came of leaving a transaction after Ctrl-C."""
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return True
        error = error.__context__
    return False


def _versions(session: Session) -> list[int]:
    text = f"MATCH (s:{SCHEMA_LABEL}) RETURN s.version ORDER BY s.version"
    return [version for (version,) in session.run(text)]
