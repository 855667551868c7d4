"""What the command line says and returns where it cannot do what is asked."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from enfilade.cli import COMMANDS, cli


def enfilade(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "enfilade", *arguments]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL)


def assert_one_sentence(done: subprocess.CompletedProcess[str], *, status: int, about: str) -> None:
    assert done.returncode == status, done.stderr
    assert "Traceback" not in done.stderr
    assert about in done.stderr
    assert done.stdout == ""


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself(command: str) -> None:
    result = CliRunner().invoke(cli, [command, "--help"])
    assert result.exit_code == 0, result.output
    assert "Usage:" in result.output


def test_help_lists_every_command() -> None:
    output = CliRunner().invoke(cli, ["--help"]).output
    assert all(f"\n  {command} " in output for command in COMMANDS)


def test_missing_scan_file(tmp_path: Path) -> None:
    assert_one_sentence(enfilade("ingest", "nowhere.e57", cwd=tmp_path), status=1, about="nowhere.e57")


def test_folder_without_scans(tmp_path: Path) -> None:
    (tmp_path / "scans").mkdir()
    assert_one_sentence(enfilade("ingest", "scans", cwd=tmp_path), status=1, about="scans")


def test_unknown_building(tmp_path: Path) -> None:
    enfilade("import", str(_hotel()), cwd=tmp_path)
    assert_one_sentence(enfilade("show", "motel", cwd=tmp_path), status=1, about="motel")


def test_missing_store(tmp_path: Path) -> None:
    assert_one_sentence(enfilade("buildings", cwd=tmp_path), status=1, about="enfilade.db")
    assert not (tmp_path / "enfilade.db").exists()


@pytest.mark.parametrize(
    ("question", "about"),
    [
        ("MATCH (a:Rom) RETURN a", "Room"),
        ("MATCH (a:Room)-[:DOR]-(b:Room) RETURN a", "DOOR"),
        ("MATCH (a:Room {area: 20..10}) RETURN a", "20..10"),
        ("MATCH (a:Room) WHERE a.hight > 2 RETURN a", "height"),
        ("MATCH (a:Room) WHERE a.area > $least RETURN a", "least"),
        ("MATCH (a:Room", "line 1"),
    ],
)
def test_bad_question_shows_place_and_suggestion(tmp_path: Path, question: str, about: str) -> None:
    enfilade("import", str(_hotel()), cwd=tmp_path)
    done = enfilade("query", question, cwd=tmp_path)
    assert_one_sentence(done, status=2, about=about)


def test_missing_mesh(tmp_path: Path) -> None:
    enfilade("import", str(_hotel()), cwd=tmp_path)
    question = "MATCH (o:Object LIKE 'nowhere.obj') RETURN o"
    done = enfilade("query", question, cwd=tmp_path)
    assert done.returncode in (1, 2)
    assert "nowhere.obj" in done.stderr
    assert "Traceback" not in done.stderr


def test_answers_can_be_piped(tmp_path: Path) -> None:
    enfilade("import", str(_hotel()), cwd=tmp_path)
    done = enfilade("query", "MATCH (a:Room {area: 12..14}) RETURN a, a.name", "--nl", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[0] == '{"a": "hotel/r1", "a.name": "Office A"}'


def _hotel() -> Path:
    return Path(__file__).parents[1] / "graphs" / "hotel.graph.json"
