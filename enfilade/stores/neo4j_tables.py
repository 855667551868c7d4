"""What is read across buildings from Neo4j, and Neo4j's values as plain ones."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Final

import numpy as np
from neo4j import ManagedTransaction, Transaction
from neo4j.graph import Node, Path, Relationship

from enfilade.stores.base import BuildingSummary, DescriptorTable

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


def descriptors(transaction: Reader, property: str) -> list[tuple[Any, ...]]:
    """Fetch all descriptors of one kind, as `descriptor_tables` takes them."""
    text = (
        f"MATCH (o:Object) WHERE o.`{property}` IS NOT NULL MATCH (b:Building {{id: o.building}}) "
        f"RETURN b.descriptor_shape, b.id, o.sequence, o.id, o.floor_offset, o.`{property}`"
    )
    return [tuple(row) for row in transaction.run(text)]


def descriptor_tables(rows: Iterable[tuple[Any, ...]]) -> list[DescriptorTable]:
    """Return descriptors as one table a shape, objects by building, as written."""
    found: dict[tuple[int, ...], list[tuple[Any, ...]]] = {}
    for shape, *row in rows:
        found.setdefault(tuple(shape), []).append(tuple(row))
    return [_descriptor_table(shape, sorted(found[shape])) for shape in sorted(found)]


def _descriptor_table(shape: tuple[int, ...], rows: list[tuple[Any, ...]]) -> DescriptorTable:
    _, _, ids, offsets, blobs = zip(*rows, strict=True)
    counts = np.frombuffer(b"".join(blobs), dtype="<u2").reshape(len(ids), -1).astype(np.uint16, copy=False)
    floor_offsets = np.array([np.nan if offset is None else offset for offset in offsets], dtype=np.float32)
    slices, shells, sectors = shape
    return DescriptorTable((slices, shells, sectors), ids, counts, floor_offsets)


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
