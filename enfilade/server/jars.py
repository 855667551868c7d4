"""The jars of Neo4j: pinned by coordinates and SHA-256 in ``jars.tsv``, fetched once, checked at every start."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from importlib.resources import files
from pathlib import Path
from typing import Final, NamedTuple, TypeVar

import requests
from jgo.constants import default_maven_repo
from jgo.maven import MavenContext

from enfilade.errors import ServerError
from enfilade.progress import Progress, Silent
from enfilade.server.mirrors import mirrors_of_central

_DOWNLOADS_AT_ONCE: Final = 8
_TIMEOUT_S: Final = 60
_SILENT: Final = Silent()

T = TypeVar("T")


class Jar(NamedTuple):
    """One pinned jar; `classifier` is empty for most."""

    group: str
    artifact: str
    version: str
    classifier: str
    sha256: str

    @property
    def file_name(self) -> str:
        """``artifact-version[-classifier].jar``."""
        return "-".join(filter(None, (self.artifact, self.version, self.classifier))) + ".jar"


def pinned() -> list[Jar]:
    """Return all jars that the server runs on."""
    text = files("enfilade.server").joinpath("jars.tsv").read_text(encoding="utf-8")
    return [Jar(*line.split("\t")) for line in text.splitlines()]


def neo4j_version() -> str:
    """Version of the pinned Neo4j."""
    return next(jar.version for jar in pinned() if (jar.group, jar.artifact) == ("org.neo4j", "neo4j"))


def sha256_of(path: Path) -> str:
    """Return a file's SHA-256 in hexadecimal digits."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def install(folder: Path, *, progress: Progress = _SILENT) -> list[Path]:
    """Fetch the jars that `folder` lacks and check all of them.

    Parameters
    ----------
    folder
        Where the jars lie; made where missing.
    progress
        Hears of each jar.

    Returns
    -------
    list of pathlib.Path
        Every pinned jar, in the order of the class path.

    Raises
    ------
    ServerError
        If a jar cannot be fetched or is not the pinned one.
    """
    jars = pinned()
    missing = [jar for jar in jars if not (folder / jar.file_name).exists()]
    if missing:
        folder.mkdir(parents=True, exist_ok=True)
        progress.start("fetch Neo4j", len(missing))
        _fetch(missing, folder, progress)
    progress.start("check Neo4j", len(jars))
    return _each(jars, lambda jar: _checked(folder / jar.file_name, jar), progress)


def _fetch(jars: Iterable[Jar], folder: Path, progress: Progress) -> None:
    """Fetch into a folder of its own, so that a jar appears in `folder` only when it is whole and right."""
    with tempfile.TemporaryDirectory(dir=folder, prefix=".part-") as part:
        context = MavenContext(
            repo_cache=Path(part),
            local_repos=[default_maven_repo()],
            remote_repos=mirrors_of_central(),
            timeout=_TIMEOUT_S,
        )
        _each(jars, lambda jar: _fetch_one(context, jar, folder), progress)


def _fetch_one(context: MavenContext, jar: Jar, folder: Path) -> None:
    component = context.project(jar.group, jar.artifact).at_version(jar.version)
    try:
        path = Path(component.artifact(classifier=jar.classifier).resolve())
    except (requests.RequestException, RuntimeError, OSError) as error:
        raise ServerError(
            f"Neo4j's {jar.file_name} cannot be fetched from Maven Central; check the network and try again"
        ) from error
    _checked(path, jar)
    # the user's own Maven repository is read only, so what was found there is copied
    (path if path.is_relative_to(context.repo_cache) else _copy(path, context.repo_cache)).replace(
        folder / jar.file_name
    )


def _copy(path: Path, folder: Path) -> Path:
    copied = folder / path.name
    copied.write_bytes(path.read_bytes())
    return copied


def _checked(path: Path, jar: Jar) -> Path:
    if sha256_of(path) != jar.sha256:
        raise ServerError(f"{path} is not the jar that is pinned (its SHA-256 differs); delete it and start again")
    return path


def _each(jars: Iterable[Jar], work: Callable[[Jar], T], progress: Progress) -> list[T]:
    results = []
    with ThreadPoolExecutor(_DOWNLOADS_AT_ONCE) as pool:
        for result in pool.map(work, jars):
            results.append(result)
            progress.advance()
    return results
