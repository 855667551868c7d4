"""Enfilade: registered indoor laser scans in, a graph of rooms out, questions over many buildings answered."""

from __future__ import annotations

from importlib.metadata import version
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from enfilade.queries import Connection

__all__ = ["__version__", "connect"]

__version__ = version("enfilade")


def connect(store: str = "sqlite:enfilade.db") -> Connection:
    """Open a store to ask questions of.

    Parameters
    ----------
    store
        ``sqlite:PATH``, a bare path, or ``neo4j://user@host:7687``; the password comes from ``ENFILADE_PASSWORD``
        or, for a server that ``enfilade server start`` started, from its own file.

    Raises
    ------
    StoreError
        If the store is not there or cannot be reached.

    Examples
    --------
    >>> import enfilade
    >>> with enfilade.connect("sqlite:enfilade.db") as buildings:  # doctest: +SKIP
    ...     buildings.query("MATCH (a:Room {area: 10..20}) RETURN a, a.area").to_pandas()
    """
    # Imported late: compiled functions and data frames take a second that `enfilade --help` need not wait for.
    from enfilade.queries import Connection
    from enfilade.stores import open_store

    return Connection(open_store(store, create=False))
