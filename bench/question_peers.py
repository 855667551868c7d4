"""Who else could answer the questions: Neo4j asked by an expert, DuckDB, Ladybug, and networkx's VF2."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any, Final

import networkx as nx
import pandas as pd
from scale_questions import Asked

from enfilade.queries import answer, parse
from enfilade.queries.checks import resolve
from enfilade.queries.expansion import Expansion, Point, combining_objects, expansions
from enfilade.queries.query_graph import Between, Constraint, Equal
from enfilade.queries.symmetry import order_of_appearance, question_symmetries, smaller_first
from enfilade.queries.syntax import Expression, Literal
from enfilade.schema.graph import BuildingGraph
from enfilade.stores import Store
from enfilade.stores.sqlite import SQLiteStore

Parameters = Mapping[str, Any]

TABLES: Final = {
    "room": "pk, id, building, area, function, floor_elevation",
    "opening": "pk, id, building, kind, width",
    "storey": 'pk, id, "index"',
    "opens": "source, target",
    "has_room": "source, target",
    "neighbour": "source, target",
    "contains": "source, target",
}
"""What DuckDB gets of the embedded store."""

NODES: Final = {
    "Building": {"id": "STRING", "building": "STRING"},
    "Storey": {"id": "STRING", "building": "STRING", "index": "INT64"},
    "Room": {"id": "STRING", "building": "STRING", "area": "DOUBLE", "function": "STRING", "floor_elevation": "DOUBLE"},
    "Opening": {"id": "STRING", "building": "STRING", "kind": "STRING", "width": "DOUBLE"},
}
EDGES: Final = {
    "HAS_STOREY": ("Building", "Storey"),
    "HAS_ROOM": ("Storey", "Room"),
    "OPENS": ("Room", "Opening"),
    "NEIGHBOUR": ("Room", "Room"),
}
"""What Ladybug gets of it: all but objects, whose parts our Cypher tells in functions that Ladybug has not."""


def expert(store: Store) -> Callable[[Asked, Parameters], int]:
    """Return what asks Neo4j in Cypher written by hand; its answer is the number of rows."""
    return lambda asked, parameters: len(list(store.rows(f"CYPHER 5 {asked.cypher}", parameters, timeout_s=60)))


def duckdb(path: Path) -> Callable[[Asked, Parameters], int]:
    """Return what asks DuckDB, with the tables of an SQLite store in memory and an index on each key."""
    import duckdb as engine

    connection = engine.connect()
    with closing(sqlite3.connect(path)) as source:
        for name, columns in TABLES.items():
            frame = pd.read_sql(f"SELECT {columns} FROM {name}", source)
            connection.register("frame", frame)
            connection.execute(f"CREATE TABLE {name} AS SELECT * FROM frame")
            connection.unregister("frame")
            keys = ("source", "target") if "source" in columns else ("pk", "id")
            for key in keys:
                connection.execute(f"CREATE INDEX {name}_{key} ON {name} ({key})")
    return lambda asked, parameters: len(connection.execute(asked.sql, dict(parameters)).fetchall())


class _InCypher(SQLiteStore):
    """Tells what would be asked of Neo4j, which is not there."""

    dialect = "cypher"


def ladybug(path: Path) -> Callable[[Asked, Parameters], int]:
    """Return what asks Ladybug, with the rooms of an SQLite store in memory, in the Cypher that we write for Neo4j."""
    import ladybug as engine

    connection = engine.Connection(engine.Database(":memory:"))
    with closing(sqlite3.connect(path)) as source:
        for label, columns in NODES.items():
            typed = ", ".join(f"`{name}` {kind}" for name, kind in columns.items())
            connection.execute(f"CREATE NODE TABLE {label} ({typed}, PRIMARY KEY (id))")
            names = ", ".join(f'"{name}"' for name in columns)
            frame = pd.read_sql(f"SELECT {names} FROM {label.lower()}", source)
            connection.execute(f"COPY {label} FROM $frame", {"frame": frame})
        for type, (start, end) in EDGES.items():
            connection.execute(f"CREATE REL TABLE {type} (FROM {start} TO {end})")
            frame = pd.read_sql(
                f"SELECT a.id, b.id AS other FROM {type.lower()} e JOIN {start.lower()} a ON a.pk = e.source "
                f"JOIN {end.lower()} b ON b.pk = e.target",
                source,
            )
            connection.execute(f"COPY {type} FROM $frame", {"frame": frame})
    teller = _InCypher(path)

    def ask(asked: Asked, parameters: Parameters) -> int:
        (step,) = answer(teller, asked.text, parameters=parameters, explain_only=True).explanation.steps
        found = connection.execute(step.text.removeprefix("CYPHER 5 "), step.parameters)
        assert isinstance(found, engine.QueryResult)
        rows = 0
        while found.has_next():
            found.get_next()
            rows += 1
        return rows

    return ask


def vf2(graphs: Sequence[BuildingGraph]) -> Callable[[Asked, Parameters], int]:
    """Return what looks for a pattern in some buildings, one by one; graphs are built before."""
    hosts = [_host(graph) for graph in graphs]

    def ask(asked: Asked, parameters: Parameters) -> int:
        query = resolve(parse(asked.text))
        (expansion,) = expansions(query.pattern, {}, combining_objects(query))
        smaller = smaller_first(order_of_appearance(query.pattern), question_symmetries(query))
        pattern = _pattern(expansion)
        return sum(_matches(host, pattern, smaller) for host in hosts)

    return ask


def _host(graph: BuildingGraph) -> nx.Graph[str]:
    host: nx.Graph[str] = nx.Graph()
    host.add_nodes_from((node.id, {"label": node.label, **node.properties}) for node in graph.nodes.values())
    host.add_edges_from((edge.source, edge.target, {"type": edge.type}) for edge in graph.edges)
    return host


def _pattern(expansion: Expansion) -> nx.Graph[str]:
    pattern: nx.Graph[str] = nx.Graph()
    for point in expansion.points:
        pattern.add_node(point.name, point=point, kinds=expansion.kinds.get(point.name))
    pattern.add_edges_from((link.source, link.target, {"type": link.type}) for link in expansion.links)
    return pattern


def _matches(host: nx.Graph[str], pattern: nx.Graph[str], smaller: Sequence[tuple[str, str]]) -> int:
    matcher = nx.algorithms.isomorphism.GraphMatcher(
        host,
        pattern,
        node_match=lambda one, asked: _fits(one, asked["point"], asked["kinds"]),
        edge_match=lambda one, asked: one["type"] == asked["type"],
    )
    count = 0
    for found in matcher.subgraph_monomorphisms_iter():
        place = {name: node for node, name in found.items()}
        count += all(place[a] < place[b] for a, b in smaller if a in place and b in place)
    return count


def _fits(properties: Mapping[str, Any], point: Point, kinds: Sequence[str] | None) -> bool:
    if properties["label"] != point.label or (kinds is not None and properties.get("kind") not in kinds):
        return False
    return all(_holds(properties.get(entry.property), entry) for entry in point.constraints)


def _holds(value: Any, constraint: Constraint) -> bool:
    if value is None:
        return False
    if isinstance(constraint, Equal):
        return bool(value == _value(constraint.value))
    assert isinstance(constraint, Between)
    low, high = constraint.low, constraint.high
    return (low is None or value >= _value(low)) and (high is None or value <= _value(high))


def _value(expression: Expression) -> Any:
    assert isinstance(expression, Literal)
    return expression.value
