"""What is read across buildings from the tables of SQLite."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np

from enfilade.schema.sqlite import quoted
from enfilade.stores.base import BuildingSummary, DescriptorTable
from enfilade.stores.sqlite_graph import shape_of

_SUMMARIES: Final = """
SELECT id, name,
    (SELECT count(*) FROM storey WHERE storey.building = building.id),
    (SELECT count(*) FROM room WHERE room.building = building.id),
    (SELECT count(*) FROM opening WHERE opening.building = building.id),
    (SELECT count(*) FROM object WHERE object.building = building.id AND coalesce(parts, 1) = 1),
    (SELECT sum(area) FROM room WHERE room.building = building.id),
    ingested_at
FROM building ORDER BY id
"""

_ROWS_AT_ONCE: Final = 4096


def summaries(connection: sqlite3.Connection) -> list[BuildingSummary]:
    """All buildings, by id."""
    return [BuildingSummary(*row) for row in connection.execute(_SUMMARIES)]


def plan(connection: sqlite3.Connection, text: str, parameters: Mapping[str, Any]) -> str:
    """Return the steps that SQLite would take, one a line, inner ones indented."""
    depths = {0: -1}
    lines = []
    for step, parent, _, detail in connection.execute(f"EXPLAIN QUERY PLAN {text}", parameters):
        depths[step] = depths[parent] + 1
        lines.append("  " * depths[step] + detail)
    return "\n".join(lines)


def descriptors(connection: sqlite3.Connection, property: str) -> list[DescriptorTable]:
    """All descriptors of one kind, one table a shape, objects by building and in order of writing."""
    column = quoted(property)
    counted = connection.execute(
        f"SELECT b.descriptor_shape, count(*) FROM object o JOIN building b ON b.id = o.building "
        f"WHERE o.{column} IS NOT NULL GROUP BY 1 ORDER BY 1"
    ).fetchall()
    return [_descriptor_table(connection, column, shape, size) for shape, size in counted]


def _descriptor_table(connection: sqlite3.Connection, column: str, shape: str, size: int) -> DescriptorTable:
    parsed = shape_of(shape)
    assert parsed is not None, "the checks let no descriptor in without a shape"
    counts = np.empty((size, int(np.prod(parsed))), dtype="<u2")
    floor_offsets = np.empty(size, dtype=np.float32)
    ids: list[str] = []
    for rows in _in_parts(connection, column, shape):
        here = slice(len(ids), len(ids) + len(rows))
        names, offsets, blobs = zip(*rows, strict=True)
        ids.extend(names)
        floor_offsets[here] = [np.nan if offset is None else offset for offset in offsets]
        counts[here] = np.frombuffer(b"".join(blobs), dtype="<u2").reshape(len(rows), -1)
    return DescriptorTable(parsed, ids, counts.astype(np.uint16, copy=False), floor_offsets)


def _in_parts(connection: sqlite3.Connection, column: str, shape: str) -> Iterator[list[tuple[Any, ...]]]:
    rows = connection.execute(
        f"SELECT o.id, o.floor_offset, o.{column} FROM object o JOIN building b ON b.id = o.building "
        f"WHERE o.{column} IS NOT NULL AND b.descriptor_shape = ? ORDER BY o.building, o.pk",
        (shape,),
    )
    while part := rows.fetchmany(_ROWS_AT_ONCE):
        yield part
