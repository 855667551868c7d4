"""A time limit to the moment: a server of Neo4j looks at its own only every two seconds.

Who asks gives a transaction a mark. When the time is over, transactions with that mark are ended over another
connection. The server's own limit stays, for where that one cannot be had.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from typing import Any, Final
from uuid import uuid4

from neo4j import Session
from neo4j.exceptions import DriverError, Neo4jError

_MARK: Final = "enfilade"
_AGAIN_S: Final = 0.25
_END: Final = (
    f"SHOW TRANSACTIONS YIELD transactionId AS id, metaData WHERE metaData.{_MARK} = $mark "
    "TERMINATE TRANSACTIONS id YIELD message RETURN message"
)


@contextmanager
def ended_in_time(open_session: Callable[[], Session], timeout_s: float | None) -> Iterator[dict[str, Any]]:
    """Yield metadata for the transactions of the block; they are ended when the time is over, and on Ctrl-C.

    Parameters
    ----------
    open_session
        For ending them.
    timeout_s
        Seconds from now, or None for no limit.
    """
    end = partial(_end, open_session, uuid4().hex)
    done = threading.Event()
    if timeout_s is not None:
        threading.Thread(target=_watch, args=(end, timeout_s, done), daemon=True).start()
    try:
        yield {_MARK: end.args[1]}
    except KeyboardInterrupt:
        end()  # the driver would wait for the server to finish
        raise
    finally:
        done.set()


def _watch(end: Callable[[], None], timeout_s: float, done: threading.Event) -> None:
    wait_s = timeout_s
    while not done.wait(wait_s):
        end()
        wait_s = _AGAIN_S


def _end(open_session: Callable[[], Session], mark: str) -> None:
    # Where the server cannot be reached, there is nothing to end.
    with suppress(Neo4jError, DriverError), open_session() as session:
        session.run(_END, mark=mark).consume()
