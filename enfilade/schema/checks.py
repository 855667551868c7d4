"""Does a graph keep to the schema? One sentence about the first fault found."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

from enfilade.errors import GraphError
from enfilade.schema.definition import (
    EDGE_PROPERTIES,
    EDGES,
    NODE_PROPERTIES,
    NODES,
    EdgeType,
    Kind,
    NodeType,
    Property,
)
from enfilade.schema.graph import BuildingGraph, Edge, Node
from enfilade.schema.ids import check_building, parse
from enfilade.schema.names import hint
from enfilade.schema.values import fault_of, plain_fault, shown

NODE_WORDS: Final = ("id", "label")
EDGE_WORDS: Final = ("source", "target", "key", "type")
GRAPH_WORDS: Final = ("format", "version", "building", "descriptor_shape")
"""Words of the file form: no property of a node, of an edge, of a graph may be called so."""

Words = tuple[str, ...]

MAX_ROOMS_OF_OPENING: Final = 2

_PARENTAL: Final = ("HAS_STOREY", "HAS_ROOM", "CONTAINS")


def check(graph: BuildingGraph) -> None:
    """Raise GraphError where a graph breaks the schema."""
    check_building(graph.building)
    _check_shape(graph)
    _check_unknown(graph.attributes, "the graph", GRAPH_WORDS)
    _check_root(graph)
    for id, node in graph.nodes.items():
        _check_node(graph, id, node)
    families = _Families()
    for edge in graph.edges:
        _check_edge(graph, edge)
        families.admit(edge)


def described(edge: Edge) -> str:
    """Return how a sentence speaks of an edge."""
    return f"edge {edge.type} from {shown(edge.source)} to {shown(edge.target)}"


def _check_shape(graph: BuildingGraph) -> None:
    shape = graph.descriptor_shape
    if shape is None:
        return
    whole = isinstance(shape, tuple) and all(isinstance(n, int) and not isinstance(n, bool) for n in shape)
    if not whole or len(shape) != 3 or min(shape) < 1:
        raise GraphError(f'"descriptor_shape" must be three whole numbers above 0, not {shown(shape)}')


def _check_root(graph: BuildingGraph) -> None:
    root = graph.nodes.get(graph.building)
    if root is None or root.label != "Building":
        raise GraphError(f'building "{graph.building}" has no node of label Building with that id')


def _check_node(graph: BuildingGraph, id: str, node: Node) -> None:
    where = f"node {shown(node.id)}"
    node_type = _node_type(node, where)
    if node.id != id:
        raise GraphError(f"{where} is filed under {shown(id)}")
    key = parse(node.id)
    if key.label != node.label:
        raise GraphError(f"{where} is a {node.label}, whose keys look like {node_type.key}")
    if key.building != graph.building or node.properties.get("building") != graph.building:
        raise GraphError(f"{where} belongs to another building than {shown(graph.building)}")
    _check_properties(node.properties, NODE_PROPERTIES[node.label], where, NODE_WORDS)
    _check_descriptors(graph, node, where)


def _node_type(node: Node, where: str) -> NodeType:
    found = NODES.get(node.label)
    if found is None:
        raise GraphError(f"{where} has the unknown label {shown(node.label)}; {hint(str(node.label), NODES)}")
    return found


def _check_descriptors(graph: BuildingGraph, node: Node, where: str) -> None:
    for property in NODES[node.label].properties:
        if property.kind is not Kind.DESCRIPTOR or property.name not in node.properties:
            continue
        if graph.descriptor_shape is None:
            raise GraphError(f'{where} has a {property.name}, but the graph has no "descriptor_shape"')
        bins = math.prod(graph.descriptor_shape)
        if len(node.properties[property.name]) != bins:
            found = len(node.properties[property.name])
            raise GraphError(f'{where}: {property.name} has {found} bins, "descriptor_shape" says {bins}')


def _check_edge(graph: BuildingGraph, edge: Edge) -> None:
    where = described(edge)
    edge_type = EDGES.get(edge.type)
    if edge_type is None:
        raise GraphError(f"{where} has an unknown type; {hint(str(edge.type), EDGES)}")
    for end in (edge.source, edge.target):
        if end not in graph.nodes:
            raise GraphError(f"{where}: there is no node {shown(end)}")
    if edge.source == edge.target:
        raise GraphError(f"{where} joins a node with itself")
    if not isinstance(edge.key, int | str) or isinstance(edge.key, bool):
        raise GraphError(f"{where}: its key must be a whole number or a text, not {shown(edge.key)}")
    if fault := plain_fault(edge.key):
        raise GraphError(f"{where}: its key {fault}")
    _check_ends(graph, edge, edge_type, where)
    _check_properties(edge.properties, EDGE_PROPERTIES[edge.type], where, EDGE_WORDS)


def _check_ends(graph: BuildingGraph, edge: Edge, edge_type: EdgeType, where: str) -> None:
    labels = (graph.nodes[edge.source].label, graph.nodes[edge.target].label)
    if labels not in edge_type.ends:
        allowed = " or ".join(f"{source} to {target}" for source, target in edge_type.ends)
        raise GraphError(f"{where} leads from {labels[0]} to {labels[1]}; {edge.type} leads from {allowed}")


def _check_properties(given: Mapping[str, Any], known: Mapping[str, Property], where: str, words: Words) -> None:
    _check_unknown({name: value for name, value in given.items() if name not in known}, where, words)
    for name, value in given.items():
        if name in known and (fault := fault_of(value, known[name])):
            raise GraphError(f"{where}: {name} {fault}")


def _check_unknown(given: Mapping[str, Any], where: str, words: Words) -> None:
    for name, value in given.items():
        if name in words:
            raise GraphError(f'{where}: no property may be called "{name}"')
        if fault := plain_fault({name: value}):
            raise GraphError(f"{where}: {shown(name)} {fault}")


class _Families:
    """Each node has one parent, each opening two rooms at most, each two neighbours one edge."""

    def __init__(self) -> None:
        self._keys: set[tuple[str, str, str | int]] = set()
        self._parents: dict[str, str] = {}
        self._rooms: dict[str, list[str]] = {}
        self._pairs: set[tuple[str, ...]] = set()

    def admit(self, edge: Edge) -> None:
        """Take the next edge in, or raise GraphError."""
        triple = (edge.source, edge.target, edge.key)
        if triple in self._keys:
            raise GraphError(f"{described(edge)} has the key {shown(edge.key)} of another edge between the two")
        self._keys.add(triple)
        if edge.type in _PARENTAL:
            self._admit_child(edge)
        elif edge.type == "OPENS":
            self._admit_opening(edge)
        else:
            self._admit_pair(edge)

    def _admit_child(self, edge: Edge) -> None:
        if edge.target in self._parents:
            parent = self._parents[edge.target]
            raise GraphError(f"{described(edge)}: {shown(edge.target)} lies in {shown(parent)} already")
        self._parents[edge.target] = edge.source

    def _admit_opening(self, edge: Edge) -> None:
        rooms = self._rooms.setdefault(edge.target, [])
        if edge.source in rooms:
            raise GraphError(f"{described(edge)} is stated twice")
        if len(rooms) == MAX_ROOMS_OF_OPENING:
            raise GraphError(f"{described(edge)}: the opening leads to two rooms already")
        rooms.append(edge.source)

    def _admit_pair(self, edge: Edge) -> None:
        ends = (edge.source, edge.target) if EDGES[edge.type].directed else sorted((edge.source, edge.target))
        pair = (edge.type, *ends)
        if pair in self._pairs:
            raise GraphError(f"{described(edge)} is stated twice; a pair has one {edge.type} at most")
        self._pairs.add(pair)
