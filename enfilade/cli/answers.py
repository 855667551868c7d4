"""The rows of an answer as text or file: table, JSON, CSV, Parquet."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from enfilade.atomic import replacing
from enfilade.cli.terminal import ERR, OUT, counted, print_table
from enfilade.errors import StoreError, UnsupportedError


def write_answer(columns: Sequence[str], rows: Sequence[dict[str, Any]], form: str, output: Path | None) -> None:
    """Print an answer, or write it to a file that is there whole or not at all.

    Parameters
    ----------
    columns, rows
        What was answered.
    form
        ``table``, ``json``, ``lines`` (a JSON object a line), ``csv`` or ``parquet``, which needs `output`.
    output
        The file; standard output if None.

    Raises
    ------
    StoreError
        If the file cannot be written.
    UnsupportedError
        If Parquet cannot hold the values.
    """
    if output is not None:
        content = _parquet(columns, rows) if form == "parquet" else _text(columns, rows, form).encode("utf-8")
        _write(output, content)
        ERR.print(f"Wrote {output}", markup=False)
    elif form == "table":
        print_table(columns, [[_cell(row[column], column) for column in columns] for row in rows])
        OUT.print(counted(len(rows), "row"))
    else:
        # Bytes, because standard output may speak another encoding than UTF-8, which JSON always is.
        click.echo(_text(columns, rows, form).encode("utf-8"), nl=False)


def _cell(value: Any, column: str) -> Any:
    """Return a value as a table shows it: unmet conditions, which have commas, a line each."""
    from enfilade.queries.result import UNMET

    return "\n".join(map(str, value)) if column == UNMET and isinstance(value, list) else value


def json_text(value: Any, *, indent: int | None = None) -> str:
    """Return a value as JSON; an infinite number, which JSON lacks, as the text ``Infinity`` or ``-Infinity``."""
    return json.dumps(_sayable(value), ensure_ascii=False, indent=indent, allow_nan=False, default=str)


def _sayable(value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        return json.dumps(value)
    if isinstance(value, dict):
        return {name: _sayable(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [_sayable(each) for each in value]
    return value


def _text(columns: Sequence[str], rows: Sequence[dict[str, Any]], form: str) -> str:
    if form == "json":
        return json_text(list(rows), indent=1) + "\n"
    if form == "lines":
        return "".join(json_text(row) + "\n" for row in rows)
    if form == "csv":
        return _csv(columns, rows)
    import pandas as pd

    return pd.DataFrame(list(rows), columns=list(columns)).to_string(index=False) + "\n"


def _csv(columns: Sequence[str], rows: Sequence[dict[str, Any]]) -> str:
    """Return CSV: a missing value is empty, a list or truth value is written as in JSON."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    for row in rows:
        writer.writerow(
            json_text(row[column]) if isinstance(row[column], bool | list | dict) else row[column] for column in columns
        )
    return text.getvalue()


def _parquet(columns: Sequence[str], rows: Sequence[dict[str, Any]]) -> bytes:
    """Return a Parquet file; whole numbers stay whole where some are missing."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    from enfilade.queries.result import UNMET

    types = {UNMET: pa.list_(pa.string())}
    file = pa.BufferOutputStream()
    try:
        arrays = [pa.array([row[column] for row in rows], types.get(column)) for column in columns]
        pq.write_table(pa.table(arrays, names=list(columns)), file)
    except (ValueError, TypeError, NotImplementedError) as error:  # bases of what Arrow raises
        reason = str(error).splitlines()[0].rstrip(".")
        raise UnsupportedError(f"Parquet cannot hold this answer ({reason}); use --format json.") from error
    return bytes(file.getvalue())


def _write(path: Path, content: bytes) -> None:
    try:
        with replacing(path) as file:
            file.write(content)
    except OSError as error:
        raise StoreError(f"{path} cannot be written: {error.strerror}.") from error
