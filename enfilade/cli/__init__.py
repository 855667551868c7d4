"""The command line: a thin skin over the library.

Results go to standard output, progress and messages to standard error. An error is one sentence; the exit
status is 2 for usage and questions that cannot be understood, 1 for every other failure.
"""

from __future__ import annotations

import importlib
import os
import sys
from pathlib import Path
from typing import Final

import click

from enfilade import __version__
from enfilade.errors import EnfiladeError, QuestionError

COMMANDS: Final = {
    "ingest": "scans",
    "simulate": "scans",
    "evaluate": "scans",
    "query": "questions",
    "cypher": "questions",
    "buildings": "buildings",
    "show": "buildings",
    "remove": "buildings",
    "export": "buildings",
    "import": "buildings",
    "copy": "buildings",
    "extract": "points",
    "measure": "points",
    "server": "server",
    "demo": "demo",
}
"""Module below `enfilade.cli` that holds each command; imported only when the command is called."""


class LazyGroup(click.Group):
    """Imports a command's module when the command is asked for, so that ``--help`` and errors are quick."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the commands in the order of the table."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        """Import and return a command."""
        if name not in COMMANDS:
            return None
        module = importlib.import_module(f"enfilade.cli.{COMMANDS[name]}")
        command: click.Command = getattr(module, f"{name}_command")
        return command


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.option(
    "--store",
    envvar="ENFILADE_STORE",
    default="sqlite:enfilade.db",
    show_default=True,
    help="sqlite:PATH or neo4j://user@host:7687; the password comes from ENFILADE_PASSWORD or a prompt.",
)
@click.option("--clouds", type=click.Path(file_okay=False), help="Folder of the labelled clouds.")
@click.option("--debug", is_flag=True, help="Show the traceback of an error.")
@click.version_option(__version__, prog_name="enfilade")
@click.pass_context
def cli(ctx: click.Context, store: str, clouds: str | None, debug: bool) -> None:
    """Turn registered indoor laser scans into graphs, and ask questions of many buildings."""
    ctx.obj = {"store": store, "clouds": clouds, "debug": debug}


def main() -> None:
    """Run the command line and end the process with its exit status."""
    debug = "--debug" in sys.argv
    _open_closed_streams()
    try:
        status = cli.main(prog_name="enfilade", standalone_mode=False)
        sys.stdout.flush()
    except click.exceptions.Abort:
        click.echo("Interrupted.", err=True)
        sys.exit(130)
    except click.ClickException as error:
        error.show()
        sys.exit(error.exit_code)
    except EnfiladeError as error:
        if debug:
            raise
        click.echo(f"Error: {error}", err=True)
        sys.exit(2 if isinstance(error, QuestionError) else 1)
    except BrokenPipeError:
        # The reader of a pipe has seen enough; keep Python from complaining again at exit.
        _discard_output()
        sys.exit(0)
    except OSError as error:
        if debug:
            raise
        # What no part of the library could foresee: a full disk, a folder taken away, output that cannot be written.
        if error.filename is None:
            _discard_output()
        where = "" if error.filename is None else f"{error.filename}: "
        click.echo(f"Error: {where}{error.strerror or error}.", err=True)
        sys.exit(1)
    sys.exit(status if isinstance(status, int) else 0)


def _open_closed_streams() -> None:
    """Let what a closed standard stream would get disappear; Python sets such a stream to None."""
    if sys.stdout is None:
        sys.stdout = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115 (open until the process ends)
    if sys.stderr is None:
        sys.stderr = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115 (open until the process ends)


def _discard_output() -> None:
    """Keep Python from failing again at exit, when it flushes what standard output did not take."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
