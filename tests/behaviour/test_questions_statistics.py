"""Statistics are Cypher's: the same question in Cypher, asked of Neo4j itself, has the same rows."""

from __future__ import annotations

import math
import random
from typing import Any

import pytest

from enfilade.queries import answer
from enfilade.schema.graph import BuildingGraph
from enfilade.stores import Store
from enfilade.stores.neo4j import Neo4jStore

PATTERN = "MATCH (s:Storey)-[:HAS_ROOM]->(a:Room)"
NUMBERS = ("a.area", "a.point_count", "a.height")
COLUMNS = [
    "count(*)",
    "count(DISTINCT s.name)",
    *(
        text.format(x)
        for x in NUMBERS
        for text in (
            *("count({})", "count(DISTINCT {})", "avg({})", "min({})", "max({})", "sum({})", "sum(DISTINCT {})"),
            *("stDev({})", "stDevP({})", "collect({})", "collect(DISTINCT {})"),
            *(f"{f}({{}}, {share})" for f in ("percentileCont", "percentileDisc") for share in (0, 0.25, 0.5, 0.9, 1)),
        )
    ),
    *("min(a.name)", "max(a.name)", "collect(a.name)", "avg(a.area + 1) * 2", "max(a.area) - min(a.area)"),
]


def offices(seed: int) -> list[BuildingGraph]:
    """Buildings whose storeys have no, one, two and many rooms, with missing values."""
    rng = random.Random(seed)
    graphs = []
    for name in ("b", "c"):
        graph = BuildingGraph(name)
        graph.add_node(name, "Building")
        for storey, count in enumerate((0, 1, 2, rng.randint(5, 9))):
            graph.add_node(f"{name}/s{storey}", "Storey", index=storey, name=rng.choice(("low", "high", None)))
            for number in range(count):
                room = f"{name}/r{10 * storey + number}"
                graph.add_node(
                    room,
                    "Room",
                    name=rng.choice(("Hall", "hall", "Bad", "\uff5e", "𐐷", None)),
                    area=rng.choice((4.0, 9.5, 12.25, None)),
                    point_count=rng.choice((1, 2, 7, 100, None)),
                    height=rng.choice((2.5, None)) if storey > 1 else None,
                )
                graph.add_edge(f"{name}/s{storey}", "HAS_ROOM", room)
        graphs.append(graph)
    return graphs


@pytest.mark.neo4j
@pytest.mark.parametrize("keys", ["", "s.id", "s.name", "a.point_count, s.name"])
def test_aggregates_are_those_of_neo4j(neo4j_store: Neo4jStore, keys: str) -> None:
    for graph in offices(7):
        neo4j_store.write(graph)
    # On both sides a column at a time, as Cypher allows no mixture of what is grouped and what is not.
    for column in COLUMNS:
        returned = ", ".join(part for part in (keys, f"{column} AS x") if part)

        ours = answer(neo4j_store, f"{PATTERN} RETURN {returned}").rows
        theirs = list(neo4j_store.cypher(f"{PATTERN} RETURN {returned}", {}))

        assert len(ours) == len(theirs)
        pairs = list(zip(*(sorted(rows, key=by_key) for rows in (ours, theirs)), strict=True))
        assert [pair for pair in pairs if not same(*pair)] == [], column


def test_aggregates_of_both_stores_are_alike(store: Store) -> None:
    for graph in offices(8):
        store.write(graph)

    rows = answer(store, f"{PATTERN} RETURN s.name, {', '.join(COLUMNS)}").rows

    assert [row["s.name"] for row in rows] == ["high", "low", None]
    assert sum(row["count(*)"] for row in rows) == sum(1 for graph in offices(8) for _ in graph.of_label("Room"))
    assert all(row["percentileDisc(a.area, 0)"] == row["min(a.area)"] for row in rows)


def by_key(row: dict[str, Any]) -> str:
    return str([value for name, value in row.items() if name != "x"])


def same(ours: dict[str, Any], theirs: dict[str, Any]) -> bool:
    return all(alike(ours[name], theirs[name]) for name in theirs)


def alike(a: Any, b: Any) -> bool:
    if isinstance(a, list):
        return sorted(map(str, a)) == sorted(map(str, b))
    if isinstance(a, float) and isinstance(b, int | float):  # Neo4j returns 3, not 3.0, where it need not interpolate
        return math.isclose(a, b, rel_tol=1e-9, abs_tol=1e-12)
    return type(a) is type(b) and bool(a == b)
