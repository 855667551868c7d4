"""The command lines and the settings that a Neo4j is started with."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from enfilade.atomic import replacing
from enfilade.errors import ServerError
from enfilade.server.home import HOST, Home, java

_OPENED: Final = ("java.base/java.nio", "java.base/java.io", "java.base/sun.nio.ch", "java.base/java.util.concurrent")
_FLAGS: Final = (
    "-XX:+UseG1GC",
    "-XX:+ExitOnOutOfMemoryError",
    "-XX:-UsePerfData",
    "--enable-native-access=ALL-UNNAMED",
    "-Dio.netty.tryReflectionSetAccessible=true",
    "-Dlog4j2.disable.jmx=true",
    "-Dfile.encoding=UTF-8",
)


@dataclass(frozen=True, slots=True)
class Settings:
    """How the local server runs.

    Attributes
    ----------
    bolt_port
        Port that drivers speak to; 0 takes a free one.
    http_port
        Port of the Browser; 0 takes a free one.
    heap_mb
        Memory for Java's objects: the data of one transaction must fit.
    page_cache_mb
        Memory for pages of the database.
    start_timeout_s
        How long the server may take until it answers.
    """

    bolt_port: int = 7687
    http_port: int = 7474
    heap_mb: int = 512
    page_cache_mb: int = 128
    start_timeout_s: float = 240.0


def write_configuration(home: Home, settings: Settings) -> None:
    """Write ``neo4j.conf``; Neo4j refuses keys that it does not know."""
    lines = {
        "server.default_listen_address": HOST,
        "server.bolt.listen_address": f"{HOST}:{settings.bolt_port}",
        "server.bolt.advertised_address": f"{HOST}:{settings.bolt_port}",
        "server.http.listen_address": f"{HOST}:{settings.http_port}",
        "server.https.enabled": "false",
        "server.memory.pagecache.size": f"{settings.page_cache_mb}m",
        "dbms.security.auth_enabled": "true",
        "dbms.usage_report.enabled": "false",
        "client.allow_telemetry": "false",
        "db.tx_log.rotation.retention_policy": "1 files",
    }
    with replacing(home.configuration / "neo4j.conf") as file:
        file.write("".join(f"{key}={value}\n" for key, value in lines.items()).encode())


def server_command(home: Home, jars: Sequence[Path], settings: Settings) -> list[str]:
    """Return the command that runs the server in the foreground."""
    arguments = [
        f"-Xms{settings.heap_mb}m",
        f"-Xmx{settings.heap_mb}m",
        *_FLAGS,
        *(f"--add-opens={package}=ALL-UNNAMED" for package in _OPENED),
        *("-cp", _class_path(home, jars)),
        "org.neo4j.server.CommunityEntryPoint",
        f"--home-dir={home.folder}",
        f"--config-dir={home.configuration}",
        "--console-mode",
    ]
    return [java(), _argument_file(home, "server", arguments)]


def set_first_password(home: Home, jars: Sequence[Path], password: str) -> None:
    """Tell a database that was never started its password, without showing it in the list of processes."""
    arguments = ["-Xmx256m", "-cp", _class_path(home, jars), "org.neo4j.cli.AdminTool"]
    given = home.folder / "run" / "first-password"
    with replacing(given, mode=0o600) as file:
        file.write(password.encode())
    try:
        done = subprocess.run(
            [java(), _argument_file(home, "admin", arguments), "dbms", "set-initial-password", f"@{given}"],
            env=os.environ | {"NEO4J_HOME": str(home.folder), "NEO4J_CONF": str(home.configuration)},
            capture_output=True,
            text=True,
            check=False,
        )
    finally:
        given.unlink()
    if done.returncode or not home.is_initialised:
        said = (done.stderr or done.stdout).strip().partition("\n")[0]
        raise ServerError(f"the password of the server cannot be set; Neo4j said: {said}")


def _class_path(home: Home, jars: Sequence[Path]) -> str:
    return os.pathsep.join([str(home.configuration), *map(str, jars)])


def _argument_file(home: Home, name: str, arguments: Sequence[str]) -> str:
    """Write arguments to a file that Java reads, as the class path is longer than some systems take."""
    path = home.folder / "run" / f"{name}.args"
    with replacing(path) as file:
        file.write("".join(f'"{_escaped(argument)}"\n' for argument in arguments).encode())
    return f"@{path}"


def _escaped(argument: str) -> str:
    return argument.replace("\\", "\\\\").replace('"', '\\"')
