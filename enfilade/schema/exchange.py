"""``graph.json``: a building's graph as a file that loses nothing and that networkx reads.

The form is node-link, as ``networkx.node_link_graph(data, edges="edges")`` takes it. A ``.json`` file holds one
building; ``.jsonl`` and ``.jsonl.gz`` hold many, one a line, read and written one at a time.
"""

from __future__ import annotations

import gzip
import json
import zlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any, Final, NoReturn

from enfilade.atomic import replacing
from enfilade.errors import GraphError, VersionError
from enfilade.schema.checks import check
from enfilade.schema.decoding import decode
from enfilade.schema.encoding import encode
from enfilade.schema.graph import BuildingGraph

_LINES: Final = (".jsonl", ".jsonl.gz")


def read_graphs(path: Path) -> Iterator[BuildingGraph]:
    """Yield the graphs in a file, each checked against the schema.

    Parameters
    ----------
    path
        A ``.json``, ``.jsonl`` or ``.jsonl.gz`` file.

    Raises
    ------
    GraphError
        If the file cannot be read or a graph breaks the schema; the sentence names the file, and the line of many.
    VersionError
        If the file was written in another version of the form.
    """
    lines = path.name.endswith(_LINES)
    try:
        with _open(path) as file:
            for number, text in enumerate(file if lines else [file.read()], start=1):
                if text.strip() or not lines:
                    yield _read_one(text, f"{path}, line {number}" if lines else str(path))
    except (OSError, EOFError, zlib.error) as error:
        raise GraphError(f"{path} cannot be read: {_reason(error)}") from error


def read_graph(path: Path) -> BuildingGraph:
    """Return the only graph in a file. Raises as `read_graphs`, and GraphError where there are none or several."""
    graphs = read_graphs(path)
    graph = next(graphs, None)
    if graph is None or next(graphs, None) is not None:
        raise GraphError(f"{path} holds {'no building' if graph is None else 'several buildings'}; one is needed here")
    return graph


def write_graph(graph: BuildingGraph, path: Path) -> None:
    """Write one graph as ``.json``, in one step: a reader sees the old file or the new one.

    Raises
    ------
    GraphError
        If the file cannot be written; it is then as it was.
    """
    with _telling(path), replacing(path) as file:
        file.writelines(encode(graph))


def write_graphs(graphs: Iterable[BuildingGraph], path: Path) -> None:
    """Write many graphs as ``.jsonl`` or ``.jsonl.gz``, one a line, in one step. Raises as `write_graph`."""
    with _telling(path), replacing(path) as file:
        if path.suffix == ".gz":
            with gzip.GzipFile(filename="", mode="wb", fileobj=file, mtime=0) as packed:
                _write_lines(graphs, packed)
        else:
            _write_lines(graphs, file)


@contextmanager
def _telling(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise GraphError(f"{path} cannot be written: {error.strerror}") from error


def _write_lines(graphs: Iterable[BuildingGraph], file: IO[bytes] | gzip.GzipFile) -> None:
    for graph in graphs:
        file.write(b"".join(encode(graph, separator=b"")) + b"\n")


def _open(path: Path) -> IO[bytes] | gzip.GzipFile:
    return gzip.open(path, "rb") if path.suffix == ".gz" else path.open("rb")


def _reason(error: Exception) -> str:
    return (error.strerror if isinstance(error, OSError) else None) or str(error)


def _read_one(text: bytes, place: str) -> BuildingGraph:
    try:
        graph = decode(_parsed(text))
        check(graph)
    except VersionError as error:
        raise VersionError(f"{place}: {error}") from error
    except GraphError as error:
        raise GraphError(f"{place}: {error}") from error
    return graph


def _parsed(text: bytes) -> Any:
    try:
        return json.loads(text.decode("utf-8-sig"), parse_constant=_refuse_constant)
    except UnicodeDecodeError as error:
        raise GraphError(f"is not UTF-8 text (byte {error.start})") from error
    except json.JSONDecodeError as error:
        raise GraphError(f"is no JSON ({error.msg}, line {error.lineno}, column {error.colno})") from error
    except RecursionError as error:
        raise GraphError("holds lists or mappings too deep in one another") from error
    except ValueError as error:  # a whole number of more digits than Python converts
        raise GraphError("holds a number with too many digits") from error


def _refuse_constant(name: str) -> NoReturn:
    raise GraphError(f"holds {name}, which is no JSON number")
