"""The graph as SQLite tables: one table a node label, one an edge type, made from the definition.

A value that SQL has no type for (a list, rings, a mapping) is JSON text; a descriptor is its counts as
little-endian uint16. Properties that the schema does not know lie together in ``extra``, a JSON object.
Primary keys count through all nodes of a store (and through all edges), so that they keep the order of a graph.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any, Final

import numpy as np

from enfilade.schema.definition import COMMON, EDGE_TYPES, NODE_TYPES, EdgeType, Kind, NodeType, Property
from enfilade.schema.encoding import as_json

APPLICATION_ID: Final = 0x454E464C
"""``ENFL``, in the header of every SQLite file of ours."""

BUILDING_COLUMNS: Final = ("descriptor_shape", "attributes", "revision")
"""What the table ``building`` has besides: about the graph as a whole, as JSON text; a word new at each writing."""

REVISION_INDEX: Final = 'CREATE INDEX IF NOT EXISTS "building_revision" ON "building" ("id", "revision")'
"""Reads all revisions without reading the buildings."""

_TYPES: Final = {Kind.INTEGER: "INTEGER", Kind.REAL: "REAL", Kind.DESCRIPTOR: "BLOB"}


def table(name: str) -> str:
    """Name of the table of a node label or an edge type, ready to stand in SQL."""
    return quoted(name.lower())


def quoted(name: str) -> str:
    """Return a name of the schema as SQL writes it."""
    return f'"{name}"'


def statements() -> list[str]:
    """All statements that make the tables and indexes of an empty store."""
    nodes = [text for node in NODE_TYPES for text in _node_statements(node)]
    edges = [text for edge in EDGE_TYPES for text in _edge_statements(edge)]
    return [*nodes, *edges, REVISION_INDEX]


def missing_columns(present: Iterable[str]) -> list[str]:
    """All statements that bring the table ``building`` of an older store up to date."""
    missing = [name for name in BUILDING_COLUMNS if name not in set(present)]
    added = [f"ALTER TABLE {table('Building')} ADD COLUMN {quoted(name)} TEXT" for name in missing]
    return [*added, REVISION_INDEX] if added else []


def to_column(value: Any, kind: Kind) -> Any:
    """Return a property's value as its column holds it; None stays None."""
    if value is None or kind in (Kind.TEXT, Kind.INTEGER):
        return value
    if kind is Kind.REAL:
        return float(value)
    if kind is Kind.DESCRIPTOR:
        return value.astype("<u2").tobytes()
    return as_json([float(part) for part in value] if kind is Kind.REALS else value)


def from_column(value: Any, kind: Kind) -> Any:
    """Return a property's value from what its column holds."""
    if kind in (Kind.TEXT, Kind.INTEGER, Kind.REAL):
        return value
    return counts_of(value) if kind is Kind.DESCRIPTOR else json.loads(value)


def counts_of(blob: bytes) -> np.ndarray[tuple[int], np.dtype[np.uint16]]:
    """Return a descriptor's counts from its bytes, as an array of its own."""
    return np.frombuffer(blob, dtype="<u2").astype(np.uint16)


def _node_statements(node: NodeType) -> list[str]:
    besides = [f"{quoted(name)} TEXT" for name in BUILDING_COLUMNS] if node.label == "Building" else []
    columns = ['"id" TEXT NOT NULL UNIQUE', '"building" TEXT NOT NULL', '"name" TEXT', *_columns(node.properties)]
    indexed = [p.name for p in (*COMMON, *node.properties) if p.indexed and p.name != "id"]
    return [_create(node.label, [*columns, *besides]), *(_index(node.label, [name]) for name in indexed)]


def _edge_statements(edge: EdgeType) -> list[str]:
    columns = ['"building" TEXT NOT NULL', '"source" INTEGER NOT NULL', '"target" INTEGER NOT NULL', '"key"']
    indexes = (["building"], ["source", "target"], ["target", "source"])
    return [
        _create(edge.type, [*columns, *_columns(edge.properties)]),
        *(_index(edge.type, names) for names in indexes),
    ]


def _columns(properties: Iterable[Property]) -> list[str]:
    return [f"{quoted(p.name)} {_TYPES.get(p.kind, 'TEXT')}" for p in properties]


def _create(name: str, columns: list[str]) -> str:
    lines = ",\n    ".join(['"pk" INTEGER PRIMARY KEY', *columns, '"extra" TEXT'])
    return f"CREATE TABLE {table(name)} (\n    {lines}\n)"


def _index(name: str, columns: list[str]) -> str:
    index = quoted("_".join([name.lower(), *columns]))
    return f"CREATE INDEX {index} ON {table(name)} ({', '.join(map(quoted, columns))})"
