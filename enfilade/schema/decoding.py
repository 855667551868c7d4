"""From the parsed text of ``graph.json`` to a graph in memory; what the schema then says is for `checks`."""

from __future__ import annotations

from itertools import count
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from enfilade.errors import GraphError, VersionError
from enfilade.schema.checks import EDGE_WORDS, GRAPH_WORDS, NODE_WORDS
from enfilade.schema.counts import quantise
from enfilade.schema.definition import EDGE_PROPERTIES, NODE_PROPERTIES, Kind, Property
from enfilade.schema.encoding import FORMAT, FORMAT_VERSION
from enfilade.schema.graph import BuildingGraph, Edge, Node
from enfilade.schema.ids import check_building
from enfilade.schema.values import shown

SUM_TOLERANCE: Final = 0.001
"""How far from 1 the sum of a descriptor may be."""

EXACT_INTEGER: Final = 2**53
"""Whole numbers up to this are floating point numbers too."""


def decode(document: Any) -> BuildingGraph:
    """Make a graph of a parsed ``graph.json``.

    Numbers take the schema's kind (a whole 3.0 where it says integer, 30 where it says number), descriptors
    become counts, a property that is null is absent, and a building without a node of its own gets one.

    Raises
    ------
    GraphError
        If the document has not the form of a graph.
    VersionError
        If it was written in another version of the form.
    """
    header = _header(document)
    graph = BuildingGraph(
        building=check_building(header.get("building")),
        descriptor_shape=_shape(header.get("descriptor_shape")),
        attributes={name: value for name, value in header.items() if name not in GRAPH_WORDS},
    )
    items = [_node_item(item, number) for number, item in enumerate(_items(document, "nodes"))]
    if all(item["id"] != graph.building for item in items):
        graph.add_node(graph.building, "Building")
    for item in items:
        _add_node(graph, item)
    keys = _Keys()
    for number, item in enumerate(_items(document, "edges")):
        graph.edges.append(_edge(item, number, keys))
    return graph


def _header(document: Any) -> dict[str, Any]:
    header = document.get("graph") if isinstance(document, dict) else None
    if not isinstance(header, dict) or header.get("format") != FORMAT:
        raise GraphError(f'is no graph of Enfilade, whose "graph" says "format": "{FORMAT}"')
    version = header.get("version")
    if version != FORMAT_VERSION or isinstance(version, bool):
        raise VersionError(f"has version {shown(version)}; this Enfilade reads version {FORMAT_VERSION}")
    if document.get("directed") is False:
        raise GraphError('is an undirected graph; edges of Enfilade have a direction ("directed": true)')
    return header


def _items(document: dict[str, Any], name: str) -> list[Any]:
    items = document.get(name)
    if not isinstance(items, list):
        hint = '; write it with edges="edges"' if name == "edges" and "links" in document else ""
        raise GraphError(f'has no list of "{name}"{hint}')
    return items


def _shape(value: Any) -> tuple[int, int, int] | None:
    if value is None:
        return None
    if not isinstance(value, list) or len(value) != 3:
        raise GraphError(f'"descriptor_shape" must be a list of three numbers, not {shown(value)}')
    slices, shells, sectors = value
    return slices, shells, sectors


def _node_item(item: Any, number: int) -> dict[str, Any]:
    texts = isinstance(item, dict) and all(isinstance(item.get(word), str) for word in NODE_WORDS)
    if not texts:
        raise GraphError(f'node {number}, counted from 0, must be an object with the texts "id" and "label"')
    return dict(item)


def _add_node(graph: BuildingGraph, item: dict[str, Any]) -> None:
    id, label = item["id"], item["label"]
    if id in graph.nodes:
        raise GraphError(f"two nodes have the id {shown(id)}")
    known = NODE_PROPERTIES.get(label, {})
    properties = {name: value for name, value in item.items() if name not in NODE_WORDS}
    graph.nodes[id] = Node(id, label, {"building": graph.building, **_decoded(properties, known, f"node {shown(id)}")})


def _edge(item: Any, number: int, keys: _Keys) -> Edge:
    texts = isinstance(item, dict) and all(isinstance(item.get(word), str) for word in ("source", "target", "type"))
    if not texts:
        raise GraphError(f'edge {number}, counted from 0, must be an object with the texts "source", "target", "type"')
    source, target, type = item["source"], item["target"], item["type"]
    properties = {name: value for name, value in item.items() if name not in EDGE_WORDS}
    where = f"edge {shown(type)} from {shown(source)} to {shown(target)}"
    decoded = _decoded(properties, EDGE_PROPERTIES.get(type, {}), where)
    return Edge(source, target, type, keys.given_or_free(source, target, item.get("key")), decoded)


class _Keys:
    """Numbers edges without a key, each pair of nodes for itself, as networkx does."""

    def __init__(self) -> None:
        self._taken: dict[tuple[str, str], set[int | str]] = {}

    def given_or_free(self, source: str, target: str, key: Any) -> Any:
        taken = self._taken.setdefault((source, target), set())
        if key is None:
            key = next(number for number in count(len(taken)) if number not in taken)
        if isinstance(key, int | str):
            taken.add(key)
        return key


def _decoded(properties: dict[str, Any], known: dict[str, Property], where: str) -> dict[str, Any]:
    decoded = {}
    for name, value in properties.items():
        property = known.get(name)
        if property is None:
            decoded[name] = value
        elif value is not None:
            decoded[name] = _value(value, property, where)
    return decoded


def _value(value: Any, property: Property, where: str) -> Any:
    if property.kind is Kind.DESCRIPTOR:
        return _descriptor(value, f"{where}: {property.name}")
    if property.kind in (Kind.INTEGER, Kind.REAL):
        return _number(value, property.kind)
    if property.kind in (Kind.INTEGERS, Kind.REALS) and isinstance(value, list):
        element = Kind.INTEGER if property.kind is Kind.INTEGERS else Kind.REAL
        return [_number(part, element) for part in value]
    if property.kind is Kind.RINGS and isinstance(value, list):
        return [[_number(part, Kind.REAL) for part in ring] if isinstance(ring, list) else ring for ring in value]
    return value


def _number(value: Any, kind: Kind) -> Any:
    """Give a number the schema's kind where nothing is lost; anything else is left for the checks to refuse."""
    if kind is Kind.INTEGER:
        return int(value) if isinstance(value, float) and value.is_integer() else value
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) <= EXACT_INTEGER:
        return float(value)
    return value + 0.0 if isinstance(value, float) else value  # minus zero becomes zero, as in the stores


def _descriptor(value: Any, where: str) -> NDArray[np.uint16]:
    if not isinstance(value, list) or not set(map(type, value)) <= {int, float}:
        raise GraphError(f"{where} must be a list of numbers")
    try:
        shares = np.array(value, dtype=np.float64)
    except OverflowError as error:
        raise GraphError(f"{where} must be a list of finite numbers, none below 0") from error
    if not np.isfinite(shares).all() or (shares < 0).any():
        raise GraphError(f"{where} must be a list of finite numbers, none below 0")
    total = shares.sum()
    if abs(total - 1.0) > SUM_TOLERANCE:
        raise GraphError(f"{where} must sum to 1, not to {total:.6g}")
    return quantise(shares)
