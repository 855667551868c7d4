"""One building's graph in memory: what ingest makes, stores keep and files carry."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np


@dataclass(slots=True)
class Node:  # noqa: PLW1641 (it changes, so it has no hash)
    """A node: its key, its label and its properties (``id`` and ``label`` not among them).

    Property values are plain Python values of the kind that the schema gives; a descriptor is a flat
    ``(bins,) uint16`` array of counts that sum to `enfilade.descriptors.TOTAL`.
    """

    id: str
    label: str
    properties: dict[str, Any] = field(default_factory=dict)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Node):
            return NotImplemented
        return (self.id, self.label) == (other.id, other.label) and _equal(self.properties, other.properties)


@dataclass(slots=True)
class Edge:
    """An edge between two node keys; `key` tells parallel edges of one type apart."""

    source: str
    target: str
    type: str
    key: int | str = 0
    properties: dict[str, Any] = field(default_factory=dict)


@dataclass(slots=True)
class BuildingGraph:
    """The graph of one building.

    Attributes
    ----------
    building
        The building's id.
    nodes
        By key, in order of writing.
    edges
        In order of writing.
    descriptor_shape
        Slices, shells and sectors of every descriptor in the graph, or None where it has none.
    attributes
        What a graph file says beside that, kept and written out again.
    """

    building: str
    nodes: dict[str, Node] = field(default_factory=dict)
    edges: list[Edge] = field(default_factory=list)
    descriptor_shape: tuple[int, int, int] | None = None
    attributes: dict[str, Any] = field(default_factory=dict)

    def add_node(self, id: str, label: str, **properties: Any) -> Node:
        """Add a node; properties that are None are left out, ``building`` is filled in."""
        given = {name: value for name, value in properties.items() if value is not None}
        node = Node(id, label, {"building": self.building, **given})
        self.nodes[id] = node
        return node

    def add_edge(self, source: str, type: str, target: str, key: int | str = 0, **properties: Any) -> Edge:
        """Add an edge; properties that are None are left out."""
        edge = Edge(source, target, type, key, {k: v for k, v in properties.items() if v is not None})
        self.edges.append(edge)
        return edge

    def of_label(self, label: str) -> Iterator[Node]:
        """Nodes of one label, in order."""
        return (node for node in self.nodes.values() if node.label == label)

    def of_type(self, type: str) -> Iterator[Edge]:
        """Edges of one type, in order."""
        return (edge for edge in self.edges if edge.type == type)

    def targets(self, source: str, type: str) -> list[Node]:
        """Nodes that edges of a type lead to from a node."""
        return [self.nodes[e.target] for e in self.edges if e.type == type and e.source == source]


def _equal(one: dict[str, Any], other: dict[str, Any]) -> bool:
    """Whether properties agree, arrays among them (which ``==`` does not answer with one truth)."""
    return one.keys() == other.keys() and all(_equal_values(value, other[name]) for name, value in one.items())


def _equal_values(one: Any, other: Any) -> bool:
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(one, other)
    return bool(one == other)
