"""What is read across buildings from the tables of SQLite."""

from __future__ import annotations

import sqlite3
from collections.abc import Mapping
from typing import Any, Final

from enfilade.stores.base import BuildingDescriptors, BuildingSummary
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

_DESCRIPTORS: Final = """
SELECT id, descriptor, foot_descriptor FROM object
WHERE building = ? AND (descriptor IS NOT NULL OR foot_descriptor IS NOT NULL)
ORDER BY pk
"""


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


def building_columns(connection: sqlite3.Connection) -> set[str]:
    """Names of the columns of the table ``building``."""
    return {name for _, name, *_ in connection.execute("PRAGMA table_info(building)")}


def revisions(connection: sqlite3.Connection) -> dict[str, str | None]:
    """Revision of each building; a store of old that may not be written has none."""
    revision = "revision" if "revision" in building_columns(connection) else "NULL"
    return dict(connection.execute(f"SELECT id, {revision} FROM building"))


def descriptors(connection: sqlite3.Connection, building: str) -> BuildingDescriptors | None:
    """Descriptors of one building, or None where it is not there."""
    revision = "revision" if "revision" in building_columns(connection) else "NULL"
    header = connection.execute(f"SELECT {revision}, descriptor_shape FROM building WHERE id = ?", (building,))
    found = header.fetchone()
    if found is None:
        return None
    return BuildingDescriptors.from_rows(
        building, found[0], shape_of(found[1]), connection.execute(_DESCRIPTORS, (building,)).fetchall()
    )
