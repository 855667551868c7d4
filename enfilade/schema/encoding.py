"""From a graph in memory to the text of ``graph.json``."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from typing import Any, Final

import numpy as np

from enfilade.schema.counts import TOTAL
from enfilade.schema.definition import EDGE_PROPERTIES, NODE_PROPERTIES
from enfilade.schema.graph import BuildingGraph, Edge, Node

FORMAT: Final = "enfilade"
FORMAT_VERSION: Final = 1


def encode(graph: BuildingGraph, *, separator: bytes = b"\n") -> Iterator[bytes]:
    """Yield the JSON text of a graph in parts, UTF-8; one node or edge a line where the separator is a line's end.

    Properties stand in the order of the schema, unknown ones after them as they came, so that equal graphs
    give equal bytes.
    """
    yield b'{"directed": true, "multigraph": true,' + separator
    yield b'"graph": ' + _json(_header(graph)) + b"," + separator
    yield b'"nodes": [' + separator
    yield from _listed((_json(_node(node)) for node in graph.nodes.values()), separator)
    yield b'], "edges": [' + separator
    yield from _listed((_json(_edge(edge)) for edge in graph.edges), separator)
    yield b"]}" + separator


def as_json(value: Any) -> str:
    """Return the JSON text of a value, short and without infinite numbers."""
    return json.dumps(value, ensure_ascii=False, allow_nan=False)


def _json(value: Any) -> bytes:
    return as_json(value).encode()


def _listed(texts: Iterator[bytes], separator: bytes) -> Iterator[bytes]:
    before = b""
    for text in texts:
        yield before + text
        before = b"," + (separator or b" ")
    yield separator


def _header(graph: BuildingGraph) -> dict[str, Any]:
    header: dict[str, Any] = {"format": FORMAT, "version": FORMAT_VERSION, "building": graph.building}
    if graph.descriptor_shape is not None:
        header["descriptor_shape"] = list(graph.descriptor_shape)
    return header | graph.attributes


def _node(node: Node) -> dict[str, Any]:
    return {"id": node.id, "label": node.label} | _ordered(node.properties, NODE_PROPERTIES[node.label])


def _edge(edge: Edge) -> dict[str, Any]:
    ends = {"source": edge.source, "target": edge.target, "key": edge.key, "type": edge.type}
    return ends | _ordered(edge.properties, EDGE_PROPERTIES[edge.type])


def _ordered(properties: dict[str, Any], order: Iterable[str]) -> dict[str, Any]:
    known = {name: _plain(properties[name]) for name in order if name in properties}
    return known | {name: value for name, value in properties.items() if name not in known}


def _plain(value: Any) -> Any:
    return (value / TOTAL).tolist() if isinstance(value, np.ndarray) else value
