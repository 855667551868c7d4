"""A building's graph into Neo4j and out of it; transactions are the caller's.

Neo4j promises to read what is committed, not to read one moment. So each node and edge carries, in the upper
half of ``sequence``, the number of the writing that it came from, and the building says how many of each there
are: what is read is whole when all of them agree.
"""

from __future__ import annotations

import json
import secrets
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Final

from neo4j import ManagedTransaction

from enfilade.errors import StoreError
from enfilade.schema.definition import EDGE_PROPERTIES, EDGE_TYPES, EDGES, NODE_PROPERTIES, NODES, Kind, Property
from enfilade.schema.encoding import as_json
from enfilade.schema.graph import BuildingGraph, Edge, Node
from enfilade.schema.neo4j import from_property, to_property

BATCH: Final = 2000
"""Rows that one statement takes; with descriptors a row has some 6 kB."""

_PLACE_BITS: Final = 30
_WRITING_BITS: Final = 22  # together below 2⁵³, which JavaScript's numbers, and so graph browsers, show exactly

_HEADER: Final = "MATCH (b:Building {id: $building}) RETURN properties(b)"


class TornReadError(StoreError):
    """A building was replaced while it was read."""


def delete(transaction: ManagedTransaction, building: str) -> bool:
    """Take a building out; returns whether it was there."""
    found = transaction.run(_HEADER, building=building).single() is not None
    for label in reversed(NODES):
        text = f"MATCH (n:`{label}` {{building: $building}}) DETACH DELETE n"
        transaction.run(text, building=building).consume()
    return found


def insert(transaction: ManagedTransaction, graph: BuildingGraph) -> None:
    """Put a building in that is not there."""
    first = secrets.randbits(_WRITING_BITS) << _PLACE_BITS
    nodes = list(enumerate(graph.nodes.values(), start=first))
    edges = list(enumerate(graph.edges, start=first))
    for label in NODES:
        rows = [_node_row(node, sequence) for sequence, node in nodes if node.label == label]
        _run_batches(transaction, f"UNWIND $rows AS row CREATE (n:`{label}`) SET n = row", rows)
    for edge_type in EDGE_TYPES:
        for ends in edge_type.ends:
            here = ((n, edge) for n, edge in edges if edge.type == edge_type.type and _ends(graph, edge) == ends)
            _run_batches(transaction, _edge_statement(edge_type.type, *ends), [_edge_row(edge, n) for n, edge in here])
    text = "MATCH (b:Building {id: $building}) SET b += $header"
    transaction.run(text, building=graph.building, header=_header(graph)).consume()


def select(transaction: ManagedTransaction, building: str) -> BuildingGraph | None:
    """Return a building's graph, or None where it is not there. Raises TornReadError."""
    found = transaction.run(_HEADER, building=building).single()
    if found is None:
        return None
    header = found[0]
    nodes = sorted((row for label in NODES for row in _nodes(transaction, building, label)), key=_by_sequence)
    edges = sorted((row for type in EDGES for row in _edges(transaction, building, type)), key=_by_sequence)
    if not (_whole(nodes, header, "node_count") and _whole(edges, header, "edge_count")):
        raise TornReadError(f'building "{building}" was replaced each time while it was read; try again')
    return BuildingGraph(
        building,
        {node.id: node for _, node in nodes},
        [edge for _, edge in edges],
        shape_of(header.get("descriptor_shape")),
        json.loads(header["attributes"]),
    )


def select_node(transaction: ManagedTransaction, label: str, id: str) -> dict[str, Any] | None:
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


def _whole(rows: Sequence[tuple[int, Any]], header: Mapping[str, Any], count: str) -> bool:
    writing = header["sequence"] >> _PLACE_BITS
    return len(rows) == header[count] and all(sequence >> _PLACE_BITS == writing for sequence, _ in rows)


def _ends(graph: BuildingGraph, edge: Edge) -> tuple[str, str]:
    return graph.nodes[edge.source].label, graph.nodes[edge.target].label


def _header(graph: BuildingGraph) -> dict[str, Any]:
    return {
        "node_count": len(graph.nodes),
        "edge_count": len(graph.edges),
        "descriptor_shape": None if graph.descriptor_shape is None else list(graph.descriptor_shape),
        "attributes": as_json(graph.attributes),
    }


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


def _nodes(transaction: ManagedTransaction, building: str, label: str) -> Iterator[tuple[int, Node]]:
    text = f"MATCH (n:`{label}` {{building: $building}}) RETURN properties(n)"
    for (stored,) in transaction.run(text, building=building):
        properties = _properties(stored, NODE_PROPERTIES[label].values())
        yield stored["sequence"], Node(properties.pop("id"), label, properties)


def _edges(transaction: ManagedTransaction, building: str, type: str) -> Iterator[tuple[int, Edge]]:
    known = EDGE_PROPERTIES[type].values()
    for source_label, _ in EDGES[type].ends:
        text = f"MATCH (a:`{source_label}` {{building: $building}})-[e:`{type}`]->(b) RETURN a.id, b.id, properties(e)"
        for source, target, stored in transaction.run(text, building=building):
            yield stored["sequence"], Edge(source, target, type, stored["key"], _properties(stored, known))


def _properties(stored: Mapping[str, Any], known: Iterable[Property]) -> dict[str, Any]:
    properties = {p.name: from_property(stored[p.name], p.kind) for p in known if p.name in stored}
    return properties | json.loads(stored["extra"]) if "extra" in stored else properties
