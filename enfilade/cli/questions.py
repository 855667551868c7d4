"""Commands that ask: ``query`` in Enfilade's language, ``cypher`` in Neo4j's own."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import click
import pandas as pd

from enfilade.cli.terminal import ERR, OUT, counted, open_archive, print_table
from enfilade.errors import InputError, UnsupportedError

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
@click.option(
    "--timeout", type=click.FloatRange(min=0.0, min_open=True), default=60.0, show_default=True, help="Seconds."
)
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
) -> None:
    """Ask all buildings in the store and print the ranked matches."""
    from enfilade.queries import answer

    if form == "parquet" and output is None:
        raise click.UsageError("--format parquet needs -o FILE.")
    result = answer(
        open_archive(ctx).store,
        _question_text(question, file),
        parameters={name: _value(text) for name, text in _pairs(params, "--param")},
        likenesses=dict(_pairs(likes, "--like")),
        timeout_s=timeout,
    )
    if explain:
        said = json.dumps(result.explanation.to_dict()) if form == "json" else str(result.explanation)
        click.echo(said, err=True)
    _write(result.rows, result.columns, "json" if nl else form, nl=nl, output=output)


def _question_text(question: str | None, file: Path | None) -> str:
    if (question is None) == (file is None):
        raise click.UsageError("Give the question as an argument, or in a file with -f.")
    if question is not None:
        return question
    try:
        return sys.stdin.read() if str(file) == "-" else Path(str(file)).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"The question file {file} cannot be read: {error}.") from None


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


def _write(rows: list[dict[str, Any]], columns: list[str], form: str, *, nl: bool, output: Path | None) -> None:
    if form == "parquet":
        pd.DataFrame(rows, columns=columns).to_parquet(output)
        return
    if form == "table" and output is None:
        print_table(columns, [[row[column] for column in columns] for row in rows])
        OUT.print(counted(len(rows), "row"))
        return
    if form == "csv":
        text = pd.DataFrame(rows, columns=columns).to_csv(index=False)
    elif nl:
        text = "".join(json.dumps(row, ensure_ascii=False) + "\n" for row in rows)
    elif form == "json":
        text = json.dumps(rows, ensure_ascii=False, indent=1) + "\n"
    else:
        text = pd.DataFrame(rows, columns=columns).to_string(index=False) + "\n"
    if output is None:
        click.echo(text, nl=False)
    else:
        output.write_text(text, encoding="utf-8")
        ERR.print(f"Wrote {output}", markup=False)


@click.command("cypher")
@click.argument("text")
@click.option("--param", "params", multiple=True, metavar="NAME=VALUE", help="$NAME is a value: JSON, else text.")
@click.option(
    "--timeout", type=click.FloatRange(min=0.0, min_open=True), default=60.0, show_default=True, help="Seconds."
)
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
        click.echo(json.dumps(row, ensure_ascii=False, default=str))
