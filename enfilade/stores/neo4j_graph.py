"""A building's graph into Neo4j and out of it; transactions are the caller's."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from neo4j import ManagedTransaction, Transaction

from enfilade.schema.definition import (
    EDGE_PROPERTIES,
    EDGE_TYPES,
    NODE_PROPERTIES,
    NODES,
    EdgeType,
    Kind,
    Property,
)
from enfilade.schema.encoding import as_json
from enfilade.schema.graph import BuildingGraph, Edge, Node
from enfilade.schema.neo4j import from_property, to_property
from enfilade.stores.base import new_revision

BATCH: Final = 2000
"""Rows that one statement takes; with descriptors a row has some 6 kB."""

Stored = Mapping[str, Any]

_PRESENT: Final = "MATCH (b:Building) WHERE b.id IN $buildings RETURN count(b)"
_HEADER: Final = "MATCH (b:Building {id: $building}) RETURN properties(b)"


def delete(transaction: ManagedTransaction, buildings: Sequence[str]) -> int:
    """Take buildings out; returns how many were there."""
    found = transaction.run(_PRESENT, buildings=buildings).single(strict=True)[0]
    for label in reversed(NODES) if found else ():
        text = f"UNWIND $buildings AS building MATCH (n:`{label}` {{building: building}}) DETACH DELETE n"
        transaction.run(text, buildings=buildings).consume()
    return int(found)


def insert(transaction: ManagedTransaction, graphs: Sequence[BuildingGraph]) -> None:
    """Put buildings in that are not there."""
    nodes: dict[str, list[dict[str, Any]]] = {}
    edges: dict[tuple[str, str, str], list[dict[str, Any]]] = {}
    for graph in graphs:
        for sequence, node in enumerate(graph.nodes.values()):
            nodes.setdefault(node.label, []).append(_node_row(node, sequence))
        for sequence, edge in enumerate(graph.edges):
            ends = (edge.type, graph.nodes[edge.source].label, graph.nodes[edge.target].label)
            edges.setdefault(ends, []).append(_edge_row(edge, sequence))
        nodes["Building"][-1].update(_header(graph))
    for label, rows in nodes.items():
        _run_batches(transaction, f"UNWIND $rows AS row CREATE (n:`{label}`) SET n = row", rows)
    for key, rows in edges.items():
        _run_batches(transaction, _edge_statement(*key), rows)


@dataclass(frozen=True, slots=True)
class StoredGraph:
    """A building as it lies in the database.

    Attributes
    ----------
    header
        Properties of the building's own node.
    nodes
        By label, properties of each node.
    edges
        By type, of each edge the ids of source and target, and its properties.
    """

    header: Mapping[str, Any]
    nodes: Mapping[str, list[Stored]]
    edges: Mapping[str, list[tuple[str, str, Stored]]]

    def graph(self) -> BuildingGraph:
        """Return it as it was written."""
        nodes = ((row["sequence"], _node(label, row)) for label, rows in self.nodes.items() for row in rows)
        edges = ((row[2]["sequence"], _edge(type, *row)) for type, rows in self.edges.items() for row in rows)
        return BuildingGraph(
            self.header["id"],
            {node.id: node for _, node in sorted(nodes, key=_by_sequence)},
            [edge for _, edge in sorted(edges, key=_by_sequence)],
            shape_of(self.header.get("descriptor_shape")),
            json.loads(self.header["attributes"]),
        )


def select(transaction: ManagedTransaction | Transaction, building: str) -> StoredGraph | None:
    """Fetch a building's graph; None where it is not there."""
    found = transaction.run(_HEADER, building=building).single()
    if found is None:
        return None
    nodes = {label: _fetch_nodes(transaction, building, label) for label in NODES}
    edges = {edge.type: _fetch_edges(transaction, building, edge) for edge in EDGE_TYPES}
    return StoredGraph(found[0], nodes, edges)


def select_node(transaction: ManagedTransaction | Transaction, label: str, id: str) -> dict[str, Any] | None:
    """Return the properties of one node without its descriptors, or None where it is not there."""
    text = f"MATCH (n:`{label}` {{id: $id}}) RETURN properties(n)"
    found = transaction.run(text, id=id).single()
    known = [p for p in NODE_PROPERTIES[label].values() if p.name != "id" and p.kind is not Kind.DESCRIPTOR]
    return None if found is None else _properties(found[0], known)


def shape_of(values: Sequence[int] | None) -> tuple[int, int, int] | None:
    """Return slices, shells and sectors from the property of a building."""
    if values is None:
        return None
    slices, shells, sectors = values
    return slices, shells, sectors


def _by_sequence(row: tuple[int, Any]) -> int:
    return row[0]


def _header(graph: BuildingGraph) -> dict[str, Any]:
    shape = None if graph.descriptor_shape is None else list(graph.descriptor_shape)
    return {"descriptor_shape": shape, "attributes": as_json(graph.attributes), "revision": new_revision()}


def _node_row(node: Node, sequence: int) -> dict[str, Any]:
    return {"id": node.id, "sequence": sequence, **_kept(node.properties, NODE_PROPERTIES[node.label])}


def _edge_row(edge: Edge, sequence: int) -> dict[str, Any]:
    kept = _kept(edge.properties, EDGE_PROPERTIES[edge.type])
    return {
        "source": edge.source,
        "target": edge.target,
        "properties": {"key": edge.key, "sequence": sequence, **kept},
    }


def _edge_statement(type: str, source: str, target: str) -> str:
    return (
        f"UNWIND $rows AS row MATCH (a:`{source}` {{id: row.source}}) MATCH (b:`{target}` {{id: row.target}}) "
        f"CREATE (a)-[e:`{type}`]->(b) SET e = row.properties"
    )


def _run_batches(transaction: ManagedTransaction, text: str, rows: Sequence[Mapping[str, Any]]) -> None:
    for start in range(0, len(rows), BATCH):
        transaction.run(text, rows=rows[start : start + BATCH]).consume()


def _kept(properties: Mapping[str, Any], known: Mapping[str, Property]) -> dict[str, Any]:
    kept = {name: to_property(value, known[name].kind) for name, value in properties.items() if name in known}
    unknown = {name: value for name, value in properties.items() if name not in known}
    return kept | {"extra": as_json(unknown)} if unknown else kept


def _fetch_nodes(transaction: ManagedTransaction | Transaction, building: str, label: str) -> list[Stored]:
    text = f"MATCH (n:`{label}` {{building: $building}}) RETURN properties(n)"
    return [stored for (stored,) in transaction.run(text, building=building)]


def _fetch_edges(
    transaction: ManagedTransaction | Transaction, building: str, edge_type: EdgeType
) -> list[tuple[str, str, Stored]]:
    rows: list[tuple[str, str, Stored]] = []
    for label in dict.fromkeys(source for source, _ in edge_type.ends):
        text = (
            f"MATCH (a:`{label}` {{building: $building}})-[e:`{edge_type.type}`]->(b) RETURN a.id, b.id, properties(e)"
        )
        rows.extend((source, target, stored) for source, target, stored in transaction.run(text, building=building))
    return rows


def _node(label: str, stored: Stored) -> Node:
    properties = _properties(stored, NODE_PROPERTIES[label].values())
    return Node(properties.pop("id"), label, properties)


def _edge(type: str, source: str, target: str, stored: Stored) -> Edge:
    return Edge(source, target, type, stored["key"], _properties(stored, EDGE_PROPERTIES[type].values()))


def _properties(stored: Stored, known: Iterable[Property]) -> dict[str, Any]:
    properties = {p.name: from_property(stored[p.name], p.kind) for p in known if p.name in stored}
    return properties | json.loads(stored["extra"]) if "extra" in stored else properties
