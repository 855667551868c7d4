"""Commands that ask: ``query`` in Enfilade's language, ``cypher`` in Neo4j's own."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import click

from enfilade.cli.answers import json_text, write_answer
from enfilade.cli.terminal import open_archive
from enfilade.errors import InputError, UnsupportedError
from enfilade.stores import Store

FORMATS = ("table", "json", "csv", "parquet")
SECONDS = click.FloatRange(min=0.0, min_open=True)


@click.command("query")
@click.argument("question", required=False)
@click.option(
    "-f", "--file", "file", type=click.Path(path_type=Path, allow_dash=True), help="Read the question; - is stdin."
)
@click.option(
    "--like", "likes", multiple=True, metavar="NAME=FILE", help="$NAME is a mesh or cloud file, or object:ID."
)
@click.option("--param", "params", multiple=True, metavar="NAME=VALUE", help="$NAME is a value: JSON, else text.")
@click.option("--format", "form", type=click.Choice(FORMATS), default="table", show_default=True)
@click.option("--nl", is_flag=True, help="JSON with one match a line.")
@click.option("-o", "--output", type=click.Path(dir_okay=False, path_type=Path), help="Write the answer to a file.")
@click.option("--explain", is_flag=True, help="Also say how the answer was found, on standard error.")
@click.option("--timeout", type=SECONDS, default=60.0, show_default=True, help="Seconds to try.")
@click.option("--rows", type=click.IntRange(min=1), default=1_000_000, show_default=True, help="Rows to print at most.")
@click.pass_context
def query_command(
    ctx: click.Context,
    question: str | None,
    file: Path | None,
    likes: tuple[str, ...],
    params: tuple[str, ...],
    form: str,
    nl: bool,
    output: Path | None,
    explain: bool,
    timeout: float,
    rows: int,
) -> None:
    """Ask all buildings in the store and print the ranked matches.

    QUESTION may be - for standard input. Without one, on a terminal, a prompt takes one question after another.
    """
    if form == "parquet" and output is None:
        raise click.UsageError("--format parquet needs -o FILE.")
    if nl and form in ("csv", "parquet"):
        raise click.UsageError(f"--nl is JSON and does not go with --format {form}.")
    asker = Asker(
        ctx,
        parameters={name: _value(text) for name, text in _pairs(params, "--param")},
        likenesses=dict(_pairs(likes, "--like")),
        form="lines" if nl else form,
        output=output,
        explain=explain,
        timeout_s=timeout,
        most_rows=rows,
    )
    if question is None and file is None and sys.stdin.isatty():
        asker.prompt()
    else:
        asker.ask(_question_text(question, file))


@dataclass
class Asker:
    """Answers questions and prints the answers, as the options of the command say."""

    ctx: click.Context
    parameters: dict[str, object]
    likenesses: dict[str, str]
    form: str
    output: Path | None
    explain: bool
    timeout_s: float
    most_rows: int

    @cached_property
    def store(self) -> Store:
        """The store, opened when it is first asked."""
        return open_archive(self.ctx).store

    def ask(self, question: str) -> None:
        """Answer one question."""
        from enfilade.queries import answer

        result = answer(
            self.store,
            question,
            parameters=self.parameters,
            likenesses=self.likenesses,
            timeout_s=self.timeout_s,
            most_rows=self.most_rows,
        )
        if self.explain:
            as_json = self.form in ("json", "lines")
            click.echo(json.dumps(result.explanation.to_dict()) if as_json else str(result.explanation), err=True)
        write_answer(result.columns, result.rows, self.form, self.output)
        if result.left_out:
            every = len(result.rows) + result.left_out
            click.echo(
                f"Note: these are the first {len(result.rows):,} of {every:,} rows; raise --rows for more.", err=True
            )

    def prompt(self) -> None:
        """Answer questions from the terminal until Ctrl-D."""
        from enfilade.cli.prompt import prompt_for_questions

        prompt_for_questions(self.ask, self.command, lambda: [*self.parameters, *self.likenesses], self.store.url)

    def command(self, word: str, rest: str) -> None:
        """Do what a line such as ``:param x=12`` says."""
        if word == ":param":
            self.parameters |= {name: _value(text) for name, text in _pairs([rest], word)}
        elif word == ":like":
            self.likenesses |= dict(_pairs([rest], word))
        elif word == ":explain":
            self.explain = not self.explain
        else:
            raise click.UsageError(f"there is no command {word}; :help lists them.")


def _question_text(question: str | None, file: Path | None) -> str:
    if (question is None) == (file is None):
        raise click.UsageError("Give the question as an argument, or in a file with -f; - is standard input.")
    if question is not None and question != "-":
        return question
    named = "-" if question == "-" else str(file)
    try:
        content = sys.stdin.buffer.read() if named == "-" else Path(named).read_bytes()
        return content.decode("utf-8-sig")
    except OSError as error:
        raise InputError(f"The question file {file} cannot be read: {error.strerror}.") from None
    except UnicodeDecodeError as error:
        raise InputError(f"The question file {named} is not UTF-8 text (byte {error.start}).") from None


def _pairs(given: Iterable[str], option: str) -> list[tuple[str, str]]:
    pairs = [text.partition("=") for text in given]
    for name, equals, _ in pairs:
        if not name or not equals:
            raise click.UsageError(f"{option} takes NAME=VALUE, not {name!r}.")
    return [(name.removeprefix("$"), value) for name, _, value in pairs]


def _value(text: str) -> object:
    try:
        return json.loads(text)
    except ValueError:
        return text
    except RecursionError:
        raise click.UsageError("A value of --param holds lists too deep in one another.") from None


@click.command("cypher")
@click.argument("text")
@click.option("--param", "params", multiple=True, metavar="NAME=VALUE", help="$NAME is a value: JSON, else text.")
@click.option("--timeout", type=SECONDS, default=60.0, show_default=True, help="Seconds to try.")
@click.pass_context
def cypher_command(ctx: click.Context, text: str, params: tuple[str, ...], timeout: float) -> None:
    """Send raw Cypher to a Neo4j store, read-only.

    The rows are printed as JSON, one a line.
    """
    from enfilade.stores.neo4j import Neo4jStore

    store = open_archive(ctx).store
    if not isinstance(store, Neo4jStore):
        raise UnsupportedError(f"{store.url} understands no Cypher; use --store neo4j://... or `enfilade query`.")
    given = {name: _value(value) for name, value in _pairs(params, "--param")}
    for row in store.cypher(text, given, timeout_s=timeout):
        click.echo(json_text(row))
