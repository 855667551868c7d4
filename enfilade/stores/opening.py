"""From the address of a store to the store."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Final
from urllib.parse import SplitResult, unquote, urlsplit

from enfilade.errors import StoreError
from enfilade.stores.base import Store
from enfilade.stores.sqlite import SQLiteStore

DEFAULT_URL: Final = "sqlite:enfilade.db"

NEO4J_SCHEMES: Final = ("neo4j", "neo4j+s", "neo4j+ssc", "bolt", "bolt+s", "bolt+ssc")
NEO4J_PORT: Final = 7687
PASSWORD_VARIABLE: Final = "ENFILADE_PASSWORD"  # noqa: S105 (the name of it, not the password)


def open_store(url: str, *, create: bool = True, ask: Callable[[str], str] | None = None) -> Store:
    """Open a store.

    Parameters
    ----------
    url
        ``sqlite:PATH``, a bare path, or ``neo4j://user@host:7687`` (also ``bolt://``, ``neo4j+s://``,
        ``neo4j+ssc://``), with ``/database`` behind it if it is not called ``neo4j``.
    create
        Whether a store that is not there yet is made.
    ask
        Asked for the password of a Neo4j with the address, where neither the environment nor the local
        server knows it.

    Raises
    ------
    StoreError
        If the address makes no sense, or the store cannot be opened or reached.
    VersionError
        If the store carries another schema version.
    """
    scheme, colon, rest = url.partition(":")
    if colon and scheme in NEO4J_SCHEMES:
        return _open_neo4j(url, create=create, ask=ask)
    if colon and rest.startswith("//"):
        known = ", ".join(["sqlite:PATH", *(f"{name}://" for name in NEO4J_SCHEMES)])
        raise StoreError(f'"{scheme}://" is no kind of store; known are {known}')
    path = rest if colon and scheme == "sqlite" else url
    if not path:
        raise StoreError('the address "sqlite:" lacks the path of a file')
    return SQLiteStore(Path(path), create=create)


def _open_neo4j(url: str, *, create: bool, ask: Callable[[str], str] | None) -> Store:
    # The driver takes a while to import, and so does what runs the local server.
    from enfilade import server
    from enfilade.stores.neo4j import DEFAULT_DATABASE, Neo4jStore

    parts = urlsplit(url)
    if parts.password is not None:
        raise StoreError(f"a password does not belong into an address; take it out and set {PASSWORD_VARIABLE}")
    host, port = _host_and_port(parts)
    user = unquote(parts.username or server.USER)
    address = f"{parts.scheme}://{f'[{host}]' if ':' in host else host}:{port}"
    database = unquote(parts.path.strip("/")) or DEFAULT_DATABASE
    password = os.environ.get(PASSWORD_VARIABLE) or server.local_password(host, port) or _asked(url, ask)
    return Neo4jStore(address, user, password, database=database, create=create)


def _host_and_port(parts: SplitResult) -> tuple[str, int]:
    try:
        host, port = parts.hostname, parts.port
    except ValueError as error:
        raise StoreError(f'"{parts.geturl()}" has no right port: {error}') from error
    if not host:
        raise StoreError(f'"{parts.geturl()}" names no host; an address looks like neo4j://neo4j@localhost:7687')
    return host, port or NEO4J_PORT


def _asked(url: str, ask: Callable[[str], str] | None) -> str:
    if ask is None:
        raise StoreError(f"{url} needs a password; set {PASSWORD_VARIABLE}")
    return ask(url)
