"""A building's graph into the tables of SQLite and out of them; transactions are the caller's."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Final

from enfilade.schema.definition import EDGE_PROPERTIES, EDGES, NODE_PROPERTIES, NODES, Kind, Property
from enfilade.schema.encoding import as_json
from enfilade.schema.graph import BuildingGraph, Edge, Node
from enfilade.schema.sqlite import from_column, quoted, table, to_column
from enfilade.stores.base import new_revision

_EDGE_COLUMNS: Final = ("pk", "building", "source", "target", "key")


def delete(connection: sqlite3.Connection, building: str) -> bool:
    """Take a building out; returns whether it was there."""
    found = connection.execute("SELECT 1 FROM building WHERE id = ?", (building,)).fetchone() is not None
    for name in (*EDGES, *NODES):
        connection.execute(f"DELETE FROM {table(name)} WHERE building = ?", (building,))
    return found


def insert(connection: sqlite3.Connection, graph: BuildingGraph) -> None:
    """Put a building in that is not there."""
    first = _next_pk(connection, NODES)
    pks = {id: pk for pk, id in enumerate(graph.nodes, start=first)}
    for label, known in NODE_PROPERTIES.items():
        columns = ["pk", "id", *(name for name in known if name != "id"), "extra"]
        _insert_rows(connection, label, columns, (_node_row(n, pks[n.id], known) for n in graph.of_label(label)))
    _insert_header(connection, graph)
    numbered = list(enumerate(graph.edges, start=_next_pk(connection, EDGES)))
    for type, known in EDGE_PROPERTIES.items():
        columns = [*_EDGE_COLUMNS, *known, "extra"]
        ends = ((pk, graph.building, pks[e.source], pks[e.target], e.key) for pk, e in numbered if e.type == type)
        values = (_values(edge.properties, known) for _, edge in numbered if edge.type == type)
        _insert_rows(connection, type, columns, ((*a, *b) for a, b in zip(ends, values, strict=True)))


def select(connection: sqlite3.Connection, building: str) -> BuildingGraph | None:
    """Return a building's graph, or None where it is not there."""
    header = connection.execute(
        "SELECT descriptor_shape, attributes FROM building WHERE id = ?", (building,)
    ).fetchone()
    if header is None:
        return None
    shape, attributes = header
    graph = BuildingGraph(building, descriptor_shape=shape_of(shape), attributes=json.loads(attributes))
    nodes = sorted((row for label in NODES for row in _nodes(connection, building, label)), key=_by_pk)
    graph.nodes = {node.id: node for _, node in nodes}
    ids = {pk: node.id for pk, node in nodes}
    edges = sorted((row for type in EDGES for row in _edges(connection, building, type, ids)), key=_by_pk)
    graph.edges = [edge for _, edge in edges]
    return graph


def select_node(connection: sqlite3.Connection, label: str, id: str) -> dict[str, Any] | None:
    """Return the properties of one node without its descriptors, or None where it is not there."""
    known = [p for p in NODE_PROPERTIES[label].values() if p.name != "id" and p.kind is not Kind.DESCRIPTOR]
    names = ", ".join(quoted(property.name) for property in known)
    row = connection.execute(f"SELECT extra, {names} FROM {table(label)} WHERE id = ?", (id,)).fetchone()
    return None if row is None else _properties(known, row[1:], row[0])


def shape_of(text: str | None) -> tuple[int, int, int] | None:
    """Return slices, shells and sectors from the column of a building."""
    if text is None:
        return None
    slices, shells, sectors = json.loads(text)
    return slices, shells, sectors


def _by_pk(row: tuple[int, Any]) -> int:
    return row[0]


def _next_pk(connection: sqlite3.Connection, names: Iterable[str]) -> int:
    largest = " UNION ALL ".join(f"SELECT max(pk) AS largest FROM {table(name)}" for name in names)
    (found,) = connection.execute(f"SELECT max(largest) FROM ({largest})").fetchone()
    return (found or 0) + 1


def _insert_rows(
    connection: sqlite3.Connection, name: str, columns: list[str], rows: Iterator[tuple[Any, ...]]
) -> None:
    names = ", ".join(map(quoted, columns))
    marks = ", ".join("?" * len(columns))
    connection.executemany(f"INSERT INTO {table(name)} ({names}) VALUES ({marks})", rows)


def _insert_header(connection: sqlite3.Connection, graph: BuildingGraph) -> None:
    shape = None if graph.descriptor_shape is None else as_json(list(graph.descriptor_shape))
    connection.execute(
        "UPDATE building SET descriptor_shape = ?, attributes = ?, revision = ? WHERE id = ?",
        (shape, as_json(graph.attributes), new_revision(), graph.building),
    )


def _node_row(node: Node, pk: int, known: Mapping[str, Property]) -> tuple[Any, ...]:
    return (pk, node.id, *_values(node.properties, {name: p for name, p in known.items() if name != "id"}))


def _values(properties: Mapping[str, Any], known: Mapping[str, Property]) -> Iterator[Any]:
    for name, property in known.items():
        yield to_column(properties.get(name), property.kind)
    unknown = {name: value for name, value in properties.items() if name not in known}
    yield as_json(unknown) if unknown else None


def _nodes(connection: sqlite3.Connection, building: str, label: str) -> Iterator[tuple[int, Node]]:
    known = list(NODE_PROPERTIES[label].values())
    names = ", ".join(quoted(property.name) for property in known)
    rows = connection.execute(f"SELECT pk, extra, {names} FROM {table(label)} WHERE building = ?", (building,))
    for pk, extra, id, *values in rows:
        yield pk, Node(id, label, _properties(known[1:], values, extra))


def _edges(
    connection: sqlite3.Connection, building: str, type: str, ids: Mapping[int, str]
) -> Iterator[tuple[int, Edge]]:
    known = list(EDGE_PROPERTIES[type].values())
    names = ", ".join(quoted(name) for name in ("extra", *_EDGE_COLUMNS, *EDGE_PROPERTIES[type]))
    rows = connection.execute(f"SELECT {names} FROM {table(type)} WHERE building = ?", (building,))
    for extra, pk, _, source, target, key, *values in rows:
        yield pk, Edge(ids[source], ids[target], type, key, _properties(known, values, extra))


def _properties(known: list[Property], values: Sequence[Any], extra: str | None) -> dict[str, Any]:
    properties = {p.name: from_column(v, p.kind) for p, v in zip(known, values, strict=True) if v is not None}
    return properties | json.loads(extra) if extra else properties
