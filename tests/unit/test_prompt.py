"""The prompt of ``enfilade query``, through a pipe in place of the keyboard."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import click
import pytest
from prompt_toolkit.application import create_app_session
from prompt_toolkit.input import PipeInput, create_pipe_input
from prompt_toolkit.output import DummyOutput

from enfilade.cli import cli
from enfilade.cli.prompt import prompt_for_questions
from enfilade.cli.questions import Asker
from enfilade.schema.exchange import read_graph
from enfilade.stores import open_store

HOTEL = Path(__file__).parents[1] / "graphs" / "hotel.graph.json"
ENTER, TAB, CTRL_C, CTRL_D, UP = "\r", "\t", "\x03", "\x04", "\x1b[A"


@pytest.fixture
def keyboard(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[PipeInput]:
    monkeypatch.setenv("ENFILADE_HISTORY", str(tmp_path / "state" / "questions"))
    with create_pipe_input() as pipe, create_app_session(input=pipe, output=DummyOutput()):
        yield pipe


@pytest.fixture
def asked(keyboard: PipeInput) -> Callable[[str], list[str]]:
    """Type something and Ctrl-D; returns the questions that were asked."""

    def type(keys: str, ask: Callable[[str], None] | None = None) -> list[str]:
        questions: list[str] = []
        keyboard.send_text(keys + CTRL_D)
        prompt_for_questions(ask or questions.append, lambda word, rest: questions.append(f"{word} {rest}"), list, "x")
        return questions

    return type


def test_enter_ends_a_whole_question_and_goes_on_with_an_unfinished_one(asked: Callable[..., list[str]]) -> None:
    assert asked(f"MATCH (a:Room){ENTER}RETURN a{ENTER}MATCH (b:Room) RETURN b;{ENTER}MATCH ({ENTER};{ENTER}") == [
        "MATCH (a:Room)\nRETURN a",
        "MATCH (b:Room) RETURN b;",
        "MATCH (\n;",
    ]


def test_tab_completes(asked: Callable[..., list[str]]) -> None:
    assert asked(f"MATCH (a:Roo{TAB}) RETURN a.floor{TAB}{ENTER}") == ["MATCH (a:Room) RETURN a.floor_elevation"]


def test_ctrl_c_takes_back_what_is_typed(asked: Callable[..., list[str]]) -> None:
    assert asked(f"MATCH (a:Nonsense{CTRL_C}MATCH (a:Room) RETURN a{ENTER}") == ["MATCH (a:Room) RETURN a"]


def test_ctrl_c_ends_a_running_question_and_errors_leave_the_prompt(
    asked: Callable[..., list[str]], capsys: pytest.CaptureFixture[str]
) -> None:
    ran: list[str] = []

    def ask(question: str) -> None:
        ran.append(question)
        raise KeyboardInterrupt if len(ran) == 1 else click.UsageError("no such thing")

    asked(f"MATCH (a:Room) RETURN a{ENTER}" * 2, ask)

    assert len(ran) == 2
    assert capsys.readouterr().err.splitlines()[1:] == ["Interrupted.", "Error: no such thing"]


def test_history_is_kept_for_the_next_time(asked: Callable[..., list[str]], tmp_path: Path) -> None:
    asked(f"MATCH (a:Room) RETURN a{ENTER}")

    assert asked(f"{UP}{ENTER}") == ["MATCH (a:Room) RETURN a"]
    assert (tmp_path / "state" / "questions").stat().st_mode & 0o077 == 0


def test_colon_commands(asked: Callable[..., list[str]], capsys: pytest.CaptureFixture[str]) -> None:
    assert asked(f":param x=12{ENTER}:help{ENTER}{ENTER}:quit{ENTER}MATCH (a:Room) RETURN a{ENTER}") == [":param x=12"]
    assert "Ctrl-C" in capsys.readouterr().out


def test_the_command_answers_and_marks_errors(
    keyboard: PipeInput, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    url = f"sqlite:{tmp_path / 'hotel.db'}"
    with open_store(url) as store:
        store.write(read_graph(HOTEL))
    keyboard.send_text(
        f":param least=21{ENTER}:like seat=object:hotel/o4{ENTER}:explain{ENTER}:explain{ENTER}:nothing{ENTER}"
        f"MATCH (a:Room {{area: $least..}}) RETURN a{ENTER}MATCH (a:Rom) RETURN a{ENTER}"
        f"MATCH (o:Object LIKE $seat WITHIN 0) RETURN o{ENTER}{CTRL_D}"
    )

    with click.Context(cli, obj={"store": url, "clouds": None}) as context:
        Asker(context, {}, {}, "lines", None, explain=False, timeout_s=60.0, most_rows=100).prompt()

    done = capsys.readouterr()
    assert done.out == '{"a": "hotel/r0"}\n{"a": "hotel/r5"}\n{"o": "hotel/o3"}\n{"o": "hotel/o4"}\n'
    assert "there is no command :nothing" in done.err
    assert 'no label "Rom": did you mean "Room"?\n  MATCH (a:Rom) RETURN a\n        ^' in done.err
