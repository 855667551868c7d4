"""Progress bars, tables and trees on a terminal, and the store that the options name."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import click
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TaskProgressColumn, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from enfilade.errors import StoreError
from enfilade.stores import open_store
from enfilade.stores.archive import Archive, default_clouds_folder

OUT = Console(highlight=False, soft_wrap=True, width=None if sys.stdout.isatty() else 160)
"""Standard output, for results."""
ERR = Console(stderr=True, highlight=False)
"""Standard error, for progress and messages."""


class Bars:
    """Shows each stage as a bar on standard error; a stage without a total pulses until the next begins."""

    def __init__(self, bars: Progress, prefix: str) -> None:
        self._bars = bars
        self._prefix = prefix
        self._task: TaskID | None = None

    def start(self, stage: str, total: float | None = None) -> None:
        """Finish the bar before and open one for a stage."""
        self.finish()
        self._task = self._bars.add_task(f"{self._prefix}{stage}", total=total)

    def advance(self, amount: float = 1.0) -> None:
        """Move the bar."""
        if self._task is not None:
            self._bars.advance(self._task, amount)

    def note(self, sentence: str) -> None:
        """Print a line above the bars."""
        self._bars.console.print(f"Note: {self._prefix}{sentence}", markup=False, soft_wrap=True)

    def finish(self) -> None:
        """Fill the bar of the stage that has ended."""
        if self._task is not None:
            task = self._bars.tasks[self._bars.task_ids.index(self._task)]
            total = task.total if task.total is not None else 1.0
            self._bars.update(self._task, total=total, completed=total)
            self._task = None


@contextmanager
def progress_bars(prefix: str = "") -> Iterator[Bars]:
    """Show bars while the block runs; where standard error is a file or pipe, as they stand at the end."""
    columns = (TextColumn("{task.description:<14}"), BarColumn(), TaskProgressColumn(), TimeElapsedColumn())
    with Progress(*columns, console=ERR, refresh_per_second=4) as bars:
        listener = Bars(bars, prefix)
        yield listener
        listener.finish()


def open_archive(ctx: click.Context, *, create: bool = False, url: str | None = None) -> Archive:
    """Open the store that the options name, together with its clouds; closed when the command ends."""
    store = open_store(url or ctx.obj["store"], create=create, ask=ask_password)
    ctx.call_on_close(store.close)
    folder = ctx.obj["clouds"]
    return Archive(store, Path(folder) if folder and url is None else default_clouds_folder(store))


def ask_password(url: str) -> str:
    """Ask for the password of a store on the terminal."""
    if not sys.stdin.isatty():
        raise StoreError(f"{url} needs a password; set ENFILADE_PASSWORD.")
    answer: str = click.prompt(f"Password of {url}", hide_input=True, err=True)
    return answer


def print_table(columns: Sequence[str], rows: Iterable[Sequence[object]], *, title: str | None = None) -> None:
    """Print a table with numbers to the right, three decimals at most."""
    rows = [list(row) for row in rows]
    table = Table(title=title, title_justify="left", title_style="bold", header_style="bold")
    for index, column in enumerate(columns):
        numeric = any(isinstance(row[index], (int, float)) for row in rows)
        table.add_column(Text(column), justify="right" if numeric else "left")
    for row in rows:
        table.add_row(*(Text(show_value(value)) for value in row))
    OUT.print(table)


def counted(count: int, what: str) -> str:
    """Return a count with its noun: ``1 room``, ``2 rooms``."""
    return f"{count:,} {what}{'' if count == 1 else 's'}"


def show_value(value: object) -> str:
    """Return a value as a person reads it; a missing one is a dash."""
    if value is None:
        return "–"
    if isinstance(value, float):
        return f"{round(value, 3) + 0.0:.3f}".rstrip("0").rstrip(".") if abs(value) < 1e6 else f"{value:g}"
    if isinstance(value, (list, tuple)):
        return ", ".join(show_value(each) for each in value)
    return str(value)
