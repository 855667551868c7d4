"""The reference page of the graph, made from the definition.

``python -m enfilade.schema.reference PAGE`` writes it; with ``--check`` before PAGE it says whether the page that
is there is current.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

from enfilade.atomic import replacing
from enfilade.schema.definition import COMMON, EDGE_TYPES, NODE_TYPES, SCHEMA_VERSION, EdgeType, NodeType, Property

_HEAD = f"""\
# The graph

Made from `enfilade/schema/definition.py` by `make docs`; do not edit it here. Schema version {SCHEMA_VERSION}.

All lengths are metres, areas square metres, in the scans' own coordinates. Any property may be missing; what is
missing is unknown, never zero. Properties that are not listed here are kept with a node or an edge and exported
again, but cannot be asked.

```
(Building)-[:HAS_STOREY]->(Storey)-[:HAS_ROOM]->(Room)-[:CONTAINS]->(Object)
(Storey)-[:BELOW]->(Storey)     (Room)-[:NEIGHBOUR]-(Room)     (Room)-[:OPENS]->(Opening)<-[:OPENS]-(Room)
(Object)-[:NEAR]-(Object)       (Object)-[:PART_OF]->(Object)
```

In a question `-[:DOOR]-`, `-[:PASSAGE]-`, `-[:STAIRS]-`, `-[:HATCH]-`, `-[:WINDOW]-` and `-[:OPENING]-` between two
rooms stand for `-[:OPENS]->(:Opening)<-[:OPENS]-`.
"""

_STORED = """\
## In the stores

What is here beside the above is for keeping, not for asking.

| | SQLite | Neo4j |
| --- | --- | --- |
| node | a row of the table of its label (`room`) | a node with one label (`Room`) |
| edge | a row of the table of its type (`opens`), `source` and `target` are the `pk` of its ends | a relationship |
| order in the graph | `pk` | `sequence` |
| tells parallel edges apart | `key` | `key` |
| list of numbers or texts | JSON text | list |
| rings, mapping | JSON text | JSON text |
| descriptor | bytes: counts as little-endian uint16 | the same, as a byte array |
| properties not listed here | `extra`, a JSON object | `extra`, a JSON object |
| of the graph as a whole | `descriptor_shape`, `attributes`, `revision` of `building` | the same, of `Building` |
| schema version | `PRAGMA user_version` | `(:EnfiladeSchema {version})` |
| writers take turns | by SQLite's lock | on `(:EnfiladeWriter)` |
"""


def reference() -> str:
    """Return the page, in Markdown."""
    parts = [_HEAD, "## Nodes\n", "Every node carries these.\n", _table(COMMON)]
    parts += [_node(node) for node in NODE_TYPES]
    parts += ["## Edges\n", _edge_table(EDGE_TYPES)]
    parts += [_edge(edge) for edge in EDGE_TYPES if edge.properties]
    return "\n".join([*parts, _STORED])


def _node(node: NodeType) -> str:
    return f"### {node.label}\n\n{_sentence(node.text)} Key: `{node.key}`.\n\n{_table(node.properties)}"


def _edge(edge: EdgeType) -> str:
    return f"### {edge.type}\n\n{_table(edge.properties)}"


def _table(properties: Iterable[Property]) -> str:
    return _rows(("property", "kind", "unit", "meaning"), (_property_row(p) for p in properties))


def _property_row(property: Property) -> tuple[str, ...]:
    values = f": {', '.join(f'`{value}`' for value in property.values)}" if property.values else ""
    length = f" ({property.length})" if property.length else ""
    return f"`{property.name}`", property.kind.value + length, property.unit, property.text + values


def _edge_table(edges: Iterable[EdgeType]) -> str:
    return _rows(("type", "from", "to", "meaning"), (row for edge in edges for row in _edge_rows(edge)))


def _edge_rows(edge: EdgeType) -> Iterator[tuple[str, ...]]:
    direction = "" if edge.directed else " (no direction; stored once)"
    for source, target in edge.ends:
        yield f"`{edge.type}`", source, target, edge.text + direction


def _rows(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    lines = [head, ("---",) * len(head), *rows]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)


def _sentence(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}."


def main(arguments: list[str]) -> int:
    """Write or check the page; returns the exit status."""
    page = Path(arguments[-1])
    if arguments[0] != "--check":
        with replacing(page) as file:
            file.write(reference().encode())
        return 0
    current = page.exists() and page.read_text(encoding="utf-8") == reference()
    if not current:
        sys.stderr.write(f"{page} is not current; make docs writes it anew\n")
    return 0 if current else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
