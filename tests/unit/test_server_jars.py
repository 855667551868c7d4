"""The jars of Neo4j: pinned, fetched once, and refused where they differ. Nothing here asks the network."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

import pytest

from enfilade.errors import ServerError
from enfilade.server import jars
from enfilade.server.jars import Jar, install, neo4j_version, pinned
from enfilade.server.mirrors import mirrors_of_central
from enfilade.server.pin import pin

CONTENT = b"a jar"
SUM = hashlib.sha256(CONTENT).hexdigest()
ONE = Jar("org.example", "one", "1.0", "", SUM)
OTHER = Jar("org.example", "other", "2.0", "linux", SUM)


@pytest.fixture
def repository(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """The user's own Maven repository; two jars are pinned, and there is no network."""
    folder = tmp_path / "repository"
    monkeypatch.setattr(jars, "pinned", lambda: [ONE, OTHER])
    monkeypatch.setattr(jars, "default_maven_repo", lambda: folder)
    monkeypatch.setattr(jars, "mirrors_of_central", lambda: {"central": "http://127.0.0.1:9"})
    return folder


def put(repository: Path, jar: Jar, content: bytes = CONTENT) -> Path:
    path = repository / jar.group.replace(".", "/") / jar.artifact / jar.version / jar.file_name
    path.parent.mkdir(parents=True)
    path.write_bytes(content)
    return path


def test_the_pins_are_complete() -> None:
    found = pinned()
    assert len({jar.file_name for jar in found}) == len(found) > 200
    assert all(re.fullmatch("[0-9a-f]{64}", jar.sha256) for jar in found)
    assert neo4j_version().startswith("5.26.")
    assert any(jar.artifact == "neo4j-browser" for jar in found)


def test_jars_of_the_users_own_repository_are_copied(repository: Path, tmp_path: Path) -> None:
    sources = [put(repository, ONE), put(repository, OTHER)]
    installed = install(tmp_path / "jars")
    assert [path.name for path in installed] == ["one-1.0.jar", "other-2.0-linux.jar"]
    assert all(path.read_bytes() == CONTENT for path in (*installed, *sources))
    assert sorted(path.name for path in (tmp_path / "jars").iterdir()) == [path.name for path in installed]


def test_what_is_there_is_not_fetched_again(repository: Path, tmp_path: Path) -> None:
    put(repository, ONE)
    (tmp_path / "jars").mkdir()
    (tmp_path / "jars" / OTHER.file_name).write_bytes(CONTENT)
    assert len(install(tmp_path / "jars")) == 2


def test_without_a_network_it_is_one_sentence(repository: Path, tmp_path: Path) -> None:
    put(repository, ONE)
    with pytest.raises(ServerError, match=r"other-2\.0-linux\.jar cannot be fetched .* check the network"):
        install(tmp_path / "jars")
    assert not (tmp_path / "jars" / OTHER.file_name).exists()


def test_a_fetched_jar_that_differs_is_refused(repository: Path, tmp_path: Path) -> None:
    put(repository, ONE)
    put(repository, OTHER, b"another jar")
    with pytest.raises(ServerError, match="is not the jar that is pinned"):
        install(tmp_path / "jars")
    assert not (tmp_path / "jars" / OTHER.file_name).exists()


def test_a_jar_that_was_damaged_later_is_refused(repository: Path, tmp_path: Path) -> None:
    put(repository, ONE)
    put(repository, OTHER)
    install(tmp_path / "jars")[1].write_bytes(CONTENT[:-1])
    with pytest.raises(ServerError, match=r"other-2\.0-linux\.jar is not the jar that is pinned .* delete it"):
        install(tmp_path / "jars")


def test_pins_are_made_from_a_folder(tmp_path: Path) -> None:
    put(tmp_path, OTHER)
    put(tmp_path, ONE)
    assert pin(tmp_path) == [ONE, OTHER]


@pytest.mark.parametrize(
    ("pattern", "taken"),
    [("central", True), ("*", True), ("external:*", True), ("a, central", True), ("a", False), ("*,!central", False)],
)
@pytest.mark.parametrize("namespace", ["", ' xmlns="urn:settings"'])
def test_the_users_mirror_is_asked(tmp_path: Path, namespace: str, pattern: str, taken: bool) -> None:
    settings = tmp_path / "settings.xml"
    settings.write_text(
        f"<settings{namespace}><mirrors><mirror><mirrorOf>{pattern}</mirrorOf>"
        "<url>http://mirror.example/maven/</url></mirror></mirrors></settings>"
    )
    assert mirrors_of_central(settings) == ({"central": "http://mirror.example/maven"} if taken else None)


def test_without_settings_central_is_asked_itself(tmp_path: Path) -> None:
    assert mirrors_of_central(tmp_path / "settings.xml") is None


def test_broken_settings_are_said(tmp_path: Path) -> None:
    (tmp_path / "settings.xml").write_text("<settings>")
    with pytest.raises(ServerError, match="is no XML"):
        mirrors_of_central(tmp_path / "settings.xml")
