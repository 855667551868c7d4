"""Writers take turns, and readers see whole buildings.

Neo4j applies a commit bit by bit, and a reader may see it half applied: nodes without their edges, even nodes
without their properties. So a writer says on the schema node when its commit begins and when it has ended, and a
reader waits for a quiet moment, reads, and reads again where a commit began meanwhile. A reader that is never left
in peace waits for the writers' turn itself.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import closing
from typing import Any, Final, TypeVar

from neo4j import ManagedTransaction, Session, Transaction, unit_of_work
from neo4j.exceptions import Neo4jError

from enfilade.schema.definition import SCHEMA_VERSION
from enfilade.schema.neo4j import SCHEMA_LABEL, WRITER_LABEL

QUIET_TRIES: Final = 8
"""How often a reader tries to read between two commits."""

ABANDONED_MS: Final = 10_000
"""A commit that began so long ago has ended, well or badly, even where its writer did not come to say so."""

_POLL_S: Final = 0.01
_VANISHED: Final = "Neo.ClientError.Statement.EntityNotFound"

_PREPARE: Final = (
    f"MERGE (s:{SCHEMA_LABEL} {{version: $version}}) ON CREATE SET s.begun = 0, s.ended = 0, s.begun_at = 0 "
    f"MERGE (w:{WRITER_LABEL} {{id: 'writer'}}) ON CREATE SET w.turn = 0"
)
_TAKE_TURN: Final = f"MATCH (w:{WRITER_LABEL}) SET w.turn = w.turn + 1"
_BEGIN: Final = f"MATCH (s:{SCHEMA_LABEL}) SET s.begun = s.begun + 1, s.begun_at = timestamp() RETURN s.begun"
_END: Final = f"MATCH (s:{SCHEMA_LABEL}) WHERE s.ended < $number SET s.ended = $number"
_STATE: Final = (
    f"MATCH (s:{SCHEMA_LABEL}) RETURN s.begun, s.begun = s.ended OR timestamp() - s.begun_at > {ABANDONED_MS}"
)

T = TypeVar("T")
Reading = Callable[[ManagedTransaction | Transaction], T]
Writing = Callable[[ManagedTransaction], T]


def prepare(session: Session) -> None:
    """Make the node that says the schema's version and when commits begin and end."""
    session.execute_write(lambda transaction: transaction.run(_PREPARE, version=SCHEMA_VERSION).consume())


def write(session: Session, announcing: Session, work: Writing[T]) -> T:
    """Do what writes, in one transaction that is tried again where it failed for a passing reason.

    Parameters
    ----------
    session
        For the transaction itself.
    announcing
        For saying that its commit begins and has ended.
    work
        Writes; may be called several times.
    """
    numbers: list[int] = []

    def in_turn(transaction: ManagedTransaction) -> T:
        transaction.run(_TAKE_TURN).consume()
        result = work(transaction)
        numbers.append(announcing.execute_write(lambda other: other.run(_BEGIN).single(strict=True)[0]))
        return result

    try:
        return session.execute_write(in_turn)
    finally:
        if numbers:  # not tried again: where it fails, the store is gone or the commit counts as abandoned soon
            announcing.run(_END, number=numbers[-1]).consume()


def read(
    session: Session,
    locking: Callable[[], Session],
    work: Reading[T],
    *,
    timeout_s: float | None = None,
    metadata: dict[str, Any] | None = None,
) -> T:
    """Do what reads at one moment of the store.

    Parameters
    ----------
    session
        Reads only.
    locking
        Opens a session that may write, for the turn of a reader that found no quiet moment; what it does is
        rolled back.
    work
        Reads, and only fetches: what it fetched may be thrown away.
    timeout_s
        Limit for each try.
    metadata
        What the server notes of each transaction.
    """

    @unit_of_work(metadata=metadata, timeout=timeout_s)
    def quietly(transaction: ManagedTransaction) -> tuple[bool, T]:
        before = _quiet_state(transaction)
        result = work(transaction)
        return before == transaction.run(_STATE).single(strict=True)[0], result

    for _ in range(QUIET_TRIES):
        try:
            undisturbed, result = session.execute_read(quietly)
        except Neo4jError as error:
            if error.code != _VANISHED:
                raise
            continue
        if undisturbed:
            return result
    with locking() as other, closing(other.begin_transaction(metadata, timeout_s)) as transaction:
        transaction.run(_TAKE_TURN).consume()
        return work(transaction)  # closed without commit, it is rolled back


def _quiet_state(transaction: ManagedTransaction) -> int:
    """Wait until no commit is under way; returns the number of the last one."""
    while True:
        number, quiet = transaction.run(_STATE).single(strict=True)
        if quiet:
            return int(number)
        time.sleep(_POLL_S)
