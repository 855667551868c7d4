"""Starting, finding and stopping the process of the local server."""

from __future__ import annotations

import fcntl
import os
import socket
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import psutil
from neo4j import GraphDatabase
from neo4j.exceptions import AuthError, DriverError, Neo4jError

from enfilade.cache import cache_folder
from enfilade.errors import ServerError
from enfilade.progress import Progress, Silent
from enfilade.server.home import HOST, USER, Home, Running, default_home
from enfilade.server.jars import install, neo4j_version
from enfilade.server.launch import Settings, server_command, set_first_password, write_configuration

DEFAULT_SETTINGS: Final = Settings()

_SILENT: Final = Silent()
_STOP_TIMEOUT_S: Final = 60.0
_POLL_S: Final = 0.25
_TAIL_LINES: Final = 5


@dataclass(frozen=True, slots=True)
class ServerStatus:
    """A local server that runs.

    Attributes
    ----------
    url
        Address of the store, for ``--store``.
    browser
        Address of Neo4j Browser.
    password_file
        File that holds the password.
    pid
        Number of the process.
    version
        Version of Neo4j.
    """

    url: str
    browser: str
    password_file: Path
    pid: int
    version: str


def start(
    home: Path | None = None, *, settings: Settings = DEFAULT_SETTINGS, progress: Progress = _SILENT
) -> ServerStatus:
    """Start the local server, or find it running, and wait until it answers.

    Parameters
    ----------
    home
        Folder of the server, by default one in the user's cache folder.
    settings
        Ports and memory; a server that runs already keeps its own.
    progress
        Hears of the fetching of jars and of the start.

    Raises
    ------
    ServerError
        If it cannot be fetched or started; the sentence ends with what the server said.
    """
    place = _place(home)
    place.make()
    with _alone(place):
        running = _alive(place)
        if running is None:
            try:
                running = _launch(place, _with_free_ports(settings), progress)
            except OSError as error:
                raise ServerError(f"{error.filename or place.folder} cannot be used: {error.strerror}") from error
        return _status(place, running)


def stop(home: Path | None = None) -> bool:
    """Stop the local server and wait until it is gone; returns whether it ran."""
    place = _place(home)
    if not place.folder.exists():
        return False
    with _alone(place):
        running = _alive(place)
        if running is not None:
            _end(running.pid)
        place.forget()
    return running is not None


def status(home: Path | None = None) -> ServerStatus | None:
    """Return the local server if it runs."""
    place = _place(home)
    running = _alive(place)
    return None if running is None else _status(place, running)


def local_password(host: str, port: int) -> str | None:
    """Return the password of the local server if `host` and `port` are where it listens."""
    place = default_home()
    running = place.remembered()
    if running is None or host not in (HOST, "localhost", "::1") or port != running.bolt_port:
        return None
    return place.password()


def _place(home: Path | None) -> Home:
    return default_home() if home is None else Home(home.absolute())


def _status(home: Home, running: Running) -> ServerStatus:
    return ServerStatus(
        url=f"neo4j://{USER}@{HOST}:{running.bolt_port}",
        browser=f"http://{HOST}:{running.http_port}/browser/",
        password_file=home.password_file,
        pid=running.pid,
        version=neo4j_version(),
    )


@contextmanager
def _alone(home: Home) -> Iterator[None]:
    """Keep two processes from starting or stopping the same server at once."""
    with home.lock_file.open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _alive(home: Home) -> Running | None:
    running = home.remembered()
    if running is None:
        return None
    try:
        process = psutil.Process(running.pid)
        same = process.create_time() == running.started and process.status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return None
    return running if same else None


def _with_free_ports(settings: Settings) -> Settings:
    with closing(_bound(settings.bolt_port)) as bolt, closing(_bound(settings.http_port)) as http:
        return replace(settings, bolt_port=bolt.getsockname()[1], http_port=http.getsockname()[1])


def _bound(port: int) -> socket.socket:
    listener = socket.socket()
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((HOST, port))
    except OSError as error:
        listener.close()
        raise ServerError(f"port {port} is taken by another program; choose another port") from error
    return listener


def _launch(home: Home, settings: Settings, progress: Progress) -> Running:
    jars = install(cache_folder() / "neo4j-jars" / neo4j_version(), progress=progress)
    progress.start("start Neo4j")
    write_configuration(home, settings)
    password = home.password()
    if not home.is_initialised:
        set_first_password(home, jars, password)
    pid = _spawn(server_command(home, jars, settings), home.console)
    running = Running(pid, psutil.Process(pid).create_time(), settings.bolt_port, settings.http_port)
    home.remember(running)
    try:
        _wait(home, running, password, settings.start_timeout_s)
    except BaseException:
        _end(pid)
        home.forget()
        raise
    return running


def _spawn(command: list[str], console: Path) -> int:
    """Start a process that outlives this one and writes to `console`."""
    write = os.O_WRONLY | os.O_CREAT | os.O_TRUNC
    files = [
        (os.POSIX_SPAWN_OPEN, 0, os.devnull, os.O_RDONLY, 0),
        (os.POSIX_SPAWN_OPEN, 1, str(console), write, 0o600),
        (os.POSIX_SPAWN_DUP2, 1, 2),
    ]
    return os.posix_spawn(command[0], command, os.environ, file_actions=files, setsid=True)


def _wait(home: Home, running: Running, password: str, timeout_s: float) -> None:
    end = time.monotonic() + timeout_s
    with GraphDatabase.driver(f"bolt://{HOST}:{running.bolt_port}", auth=(USER, password)) as driver:
        while time.monotonic() < end:
            if _alive(home) is None:
                raise ServerError(f"Neo4j ended while it started; it said: {_tail(home.console)}")
            try:
                with driver.session(database="neo4j") as session:
                    session.run("RETURN 1").consume()
                socket.create_connection((HOST, running.http_port), _POLL_S).close()
                return
            except AuthError as error:
                raise ServerError(
                    f"Neo4j does not take the password in {home.password_file}; put the right one there, "
                    f"or delete {home.folder} to begin with an empty database"
                ) from error
            except (DriverError, Neo4jError, OSError):
                time.sleep(_POLL_S)
    raise ServerError(f"Neo4j did not answer within {timeout_s:g} s; it said: {_tail(home.console)}")


def _tail(console: Path) -> str:
    lines = console.read_text(encoding="utf-8", errors="replace").splitlines()
    return " | ".join(line.strip() for line in lines[-_TAIL_LINES:]) or "nothing"


def _end(pid: int) -> None:
    """Ask a process to stop, and make it stop where it does not."""
    try:
        process = psutil.Process(pid)
        process.terminate()
        try:
            process.wait(_STOP_TIMEOUT_S)
        except psutil.TimeoutExpired:
            process.kill()
            process.wait(_STOP_TIMEOUT_S)
    except psutil.NoSuchProcess:
        return
