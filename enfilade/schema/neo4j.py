"""The graph in Neo4j: constraints and indexes made from the definition, and how values are kept.

One label a node, properties by their own names. Rings and mappings are JSON text, a descriptor is its counts as
little-endian uint16 in a byte array. Properties that the schema does not know lie together in ``extra``, a JSON
object. ``sequence`` on nodes and edges keeps their order.
"""

from __future__ import annotations

import json
from typing import Any, Final

import numpy as np

from enfilade.schema.definition import COMMON, NODE_TYPES, Kind, NodeType
from enfilade.schema.encoding import as_json

SCHEMA_LABEL: Final = "EnfiladeSchema"
"""Label of the one node that says, as ``version``, which schema a database follows."""

WRITER_LABEL: Final = "EnfiladeWriter"
"""Label of the one node that whoever writes holds, so that writers take turns."""


def statements() -> list[str]:
    """All statements that make constraints and indexes; each may be run again."""
    return [
        _constraint(SCHEMA_LABEL, "version"),
        _constraint(WRITER_LABEL, "id"),
        *(text for node in NODE_TYPES for text in _node_statements(node)),
    ]


def to_property(value: Any, kind: Kind) -> Any:
    """Return a property's value as the database holds it."""
    if kind is Kind.REAL:
        return float(value)
    if kind is Kind.REALS:
        return [float(part) for part in value]
    if kind is Kind.DESCRIPTOR:
        return value.astype("<u2").tobytes()
    return as_json(value) if kind in (Kind.RINGS, Kind.MAPPING) else value


def from_property(value: Any, kind: Kind) -> Any:
    """Return a property's value from what the database holds."""
    if kind is Kind.DESCRIPTOR:
        return np.frombuffer(value, dtype="<u2").astype(np.uint16)
    return json.loads(value) if kind in (Kind.RINGS, Kind.MAPPING) else value


def _node_statements(node: NodeType) -> list[str]:
    indexed = [p.name for p in (*COMMON, *node.properties) if p.indexed and p.name != "id"]
    return [_constraint(node.label, "id"), *(_index(node.label, name) for name in indexed)]


def _constraint(label: str, name: str) -> str:
    return f"CREATE CONSTRAINT {_named(label, name)} IF NOT EXISTS FOR (n:`{label}`) REQUIRE n.`{name}` IS UNIQUE"


def _index(label: str, name: str) -> str:
    return f"CREATE INDEX {_named(label, name)} IF NOT EXISTS FOR (n:`{label}`) ON (n.`{name}`)"


def _named(label: str, name: str) -> str:
    return f"enfilade_{label.lower()}_{name}"
