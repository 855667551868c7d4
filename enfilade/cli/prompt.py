"""The prompt of ``enfilade query``: questions with completion, history and marked errors, one after another."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Final

import click
from platformdirs import user_state_path
from prompt_toolkit import PromptSession
from prompt_toolkit.completion import CompleteEvent, Completer, Completion
from prompt_toolkit.document import Document
from prompt_toolkit.history import FileHistory, History, InMemoryHistory
from prompt_toolkit.key_binding import KeyBindings, KeyPressEvent

from enfilade.errors import EnfiladeError
from enfilade.queries.completion import completions
from enfilade.queries.parse import is_unfinished

HISTORY_VARIABLE: Final = "ENFILADE_HISTORY"
"""Names the file of the history; an empty text keeps none."""

HELP: Final = """\
A question ends with ; or with Enter where it is whole. Tab completes, the arrows go back to earlier questions.
:param NAME=VALUE   give $NAME a value (JSON, else text)
:like NAME=FILE     give $NAME an example: a mesh or cloud file, or object:ID
:explain            say how answers are found, or no longer
:help, :quit        this text; leave, as Ctrl-D does. Ctrl-C stops a question that runs."""


class QuestionCompleter(Completer):
    """Completes questions; `names` tells the parameters that have values."""

    def __init__(self, names: Callable[[], Iterable[str]]) -> None:
        self._names = names

    def get_completions(self, document: Document, complete_event: CompleteEvent) -> Iterator[Completion]:
        """Yield the words that may stand at the cursor."""
        before, after = document.text_before_cursor, document.text_after_cursor
        for found in completions(before, after, parameters=self._names()):
            yield Completion(found.text, start_position=-found.typed, display_meta=found.kind)


def prompt_for_questions(
    ask: Callable[[str], None], command: Callable[[str, str], None], names: Callable[[], Iterable[str]], store: str
) -> None:
    """Read questions from the terminal and answer them until Ctrl-D.

    Parameters
    ----------
    ask
        Answers a question and prints the answer.
    command
        Takes a line such as ``:param x=12`` as its word and the rest.
    names
        Tells the names of the parameters that have values.
    store
        Address of the store, for the greeting.
    """
    completer = QuestionCompleter(names)
    session: PromptSession[str] = PromptSession(
        "? ",
        multiline=True,
        prompt_continuation="  ",
        completer=completer,
        complete_while_typing=False,
        history=_history(),
        key_bindings=_keys(completer),
    )
    click.echo(f"{store}. :help says what there is; Ctrl-D leaves.", err=True)
    while True:
        try:
            text = session.prompt().strip()
        except KeyboardInterrupt:  # Ctrl-C takes back what is typed
            continue
        except EOFError:
            return
        if text in (":quit", ":exit"):
            return
        _done(text, ask, command)


def _done(text: str, ask: Callable[[str], None], command: Callable[[str, str], None]) -> None:
    """Do what a text says; whatever goes wrong, the prompt comes back."""
    try:
        if text == ":help":
            click.echo(HELP)
        elif text.startswith(":"):
            word, _, rest = text.partition(" ")
            command(word, rest.strip())
        elif text.strip(";"):
            ask(text)
    except KeyboardInterrupt:
        click.echo("Interrupted.", err=True)
    except click.ClickException as error:
        click.echo(f"Error: {error.format_message()}", err=True)
    except EnfiladeError as error:
        click.echo(f"Error: {error}", err=True)


def _keys(completer: Completer) -> KeyBindings:
    """Enter ends a whole question and goes on with one that is not; Tab completes, by a menu if there is a choice."""
    keys = KeyBindings()

    @keys.add("tab")
    def tab(event: KeyPressEvent) -> None:
        buffer = event.current_buffer
        found = list(completer.get_completions(buffer.document, CompleteEvent(completion_requested=True)))
        if len(found) == 1:
            buffer.delete_before_cursor(-found[0].start_position)
            buffer.insert_text(found[0].text)
        elif buffer.complete_state is not None:
            buffer.complete_next()
        else:
            buffer.start_completion(insert_common_part=True)

    @keys.add("enter")
    def enter(event: KeyPressEvent) -> None:
        text = event.current_buffer.document.text.strip()
        if event.current_buffer.complete_state is not None:  # take the word that is chosen in the menu
            event.current_buffer.complete_state = None
        elif text and not text.startswith(":") and not text.endswith(";") and is_unfinished(text):
            event.current_buffer.insert_text("\n")
        else:
            event.current_buffer.validate_and_handle()

    return keys


def _history() -> History:
    """Return the history of the user's questions, kept in a file that nobody else can read."""
    named = os.environ.get(HISTORY_VARIABLE)
    if named == "":
        return InMemoryHistory()
    path = Path(named) if named else user_state_path("enfilade") / "questions"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch(mode=0o600)
    except OSError:  # a history is a convenience
        return InMemoryHistory()
    return FileHistory(str(path))
