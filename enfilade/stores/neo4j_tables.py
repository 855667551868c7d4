"""What is read across buildings from Neo4j, and Neo4j's values as plain ones."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Final

import numpy as np
from neo4j import ManagedTransaction, Transaction
from neo4j.graph import Node, Path, Relationship

from enfilade.stores.base import BuildingDescriptors, BuildingSummary
from enfilade.stores.neo4j_graph import shape_of

Reader = ManagedTransaction | Transaction

_SUMMARIES: Final = """
MATCH (b:Building)
CALL (b) { MATCH (r:Room {building: b.id}) RETURN count(r) AS rooms, count(r.area) AS measured, sum(r.area) AS area }
RETURN b.id, b.name,
    COUNT { MATCH (s:Storey {building: b.id}) },
    rooms,
    COUNT { MATCH (p:Opening {building: b.id}) },
    COUNT { MATCH (o:Object {building: b.id}) WHERE coalesce(o.parts, 1) = 1 },
    CASE WHEN measured > 0 THEN area END,
    b.ingested_at
"""

_HEADERS: Final = (
    "UNWIND $buildings AS building MATCH (b:Building {id: building}) RETURN b.id, b.revision, b.descriptor_shape"
)
_DESCRIPTORS: Final = (
    "UNWIND $buildings AS building MATCH (o:Object {building: building}) "
    "WHERE o.descriptor IS NOT NULL OR o.foot_descriptor IS NOT NULL "
    "RETURN building, o.sequence, o.id, o.descriptor, o.foot_descriptor"
)


def summaries(transaction: Reader) -> list[list[Any]]:
    """Fetch what `building_summaries` takes."""
    return transaction.run(_SUMMARIES).values()


def building_summaries(rows: Iterable[Iterable[Any]]) -> list[BuildingSummary]:
    """Return one summary a building, by id."""
    return sorted((BuildingSummary(*row) for row in rows), key=lambda summary: summary.id)


def plan_lines(plan: Mapping[str, Any], depth: int = 0) -> Iterator[str]:
    """Yield the operators of a plan, one a line, inner ones indented."""
    details = plan.get("args", {}).get("Details", "")
    yield f"{'  ' * depth}{plan.get('operatorType', '').partition('@')[0]} {details}".rstrip()
    for child in plan.get("children", ()):
        yield from plan_lines(child, depth + 1)


def revisions(transaction: Reader) -> list[tuple[str, str | None]]:
    """Fetch id and revision of each building."""
    found = transaction.run("MATCH (b:Building) RETURN b.id, b.revision")
    return [(building, revision) for building, revision in found]


def descriptors(transaction: Reader, buildings: Sequence[str]) -> list[tuple[Any, ...]]:
    """Fetch the descriptors of some buildings, as `building_descriptors` takes them."""
    headers = transaction.run(_HEADERS, buildings=list(buildings)).values()
    rows = transaction.run(_DESCRIPTORS, buildings=list(buildings)).values()
    found: dict[str, list[Any]] = {building: [] for building, _, _ in headers}
    for building, *row in rows:
        found[building].append(row)
    return [(*header, found[header[0]]) for header in headers]


def building_descriptors(
    building: str, revision: str | None, shape: Sequence[int] | None, rows: list[Any]
) -> BuildingDescriptors:
    """Return one building's descriptors, objects as written."""
    ordered = [(id, floor, foot) for _, id, floor, foot in sorted(rows, key=lambda row: row[0])]
    return BuildingDescriptors.from_rows(building, revision, shape_of(shape), ordered)


def plain(value: Any) -> Any:
    """Return a value of Neo4j as one that JSON has: nodes and edges as their properties, without descriptors."""
    if isinstance(value, Node):
        return {"label": "|".join(sorted(value.labels)), **_plain_properties(value)}
    if isinstance(value, Relationship):
        return {"type": value.type, **_plain_properties(value)}
    if isinstance(value, Path):
        parts = [part for pair in zip(value.nodes, value.relationships, strict=False) for part in pair]
        return [plain(part) for part in (*parts, value.end_node)]
    if isinstance(value, dict):
        return {name: plain(part) for name, part in value.items()}
    if isinstance(value, list):
        return [plain(part) for part in value]
    if isinstance(value, bytes):
        return np.frombuffer(value, dtype="<u2").tolist() if len(value) % 2 == 0 else list(value)
    return value if value is None or isinstance(value, bool | int | float | str) else str(value)


def _plain_properties(entity: Node | Relationship) -> dict[str, Any]:
    return {name: plain(value) for name, value in entity.items() if not isinstance(value, bytes)}
