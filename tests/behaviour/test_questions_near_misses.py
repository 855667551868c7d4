"""RELAX: near misses by hand on the hotel; the oracle looks at them in quantity."""

from __future__ import annotations

from typing import Any

import pytest

from enfilade.errors import EnfiladeError, QuestionError, UnsupportedError
from enfilade.queries import answer, parse
from enfilade.queries.relaxation import condition_texts
from enfilade.schema.graph import BuildingGraph
from enfilade.stores import Store

DOOR = "(a)-[d:DOOR]-(b)"

CASES = [
    (
        "a value that is a little off comes before one that is far off",
        "MATCH (a:Room {area: 13..}) RETURN a.name LIMIT 6 RELAX 1",
        [
            ("Lobby",),
            ("Office A",),
            ("Office B",),
            ("Suite",),
            ("Kitchen", "(a:Room {area: 13..})"),
            ("Bath", "(a:Room {area: 13..})"),
        ],
    ),
    (
        "without an edge its name stands for nothing, and what is said of it is unmet too",
        "MATCH (a:Room)-[d:HATCH]-(b:Room) WHERE d.width > 0.6 RETURN a.name, d LIMIT 1 RELAX 2",
        [("Lobby", None, "(a)-[d:HATCH]-(b)", "d.width > 0.6")],
    ),
    (
        "an edge is not left out where it is there with as few unmet",
        "MATCH (a:Room {name: 'Lobby'})-[d:DOOR {width: 5..}]-(b:Room {name: 'Office A'}) RETURN d RELAX 1",
        [("hotel/p0", "(a)-[d:DOOR {width: 5..}]-(b)")],
    ),
    (
        "it is left out where that leaves fewer unmet",
        "MATCH (a:Room {name: 'Lobby'})-[d:DOOR {width: 5.., height: 5..}]-(b {name: 'Office A'}) RETURN d RELAX 1",
        [(None, DOOR)],
    ),
    (
        "a negation",
        "MATCH (a:Room) WHERE a.name = 'Suite' AND NOT EXISTS { (a)-[:DOOR]-() } RETURN a.name RELAX 1",
        [("Kitchen", "a.name = 'Suite'"), ("Suite", "NOT EXISTS { (a)-[:DOOR]-() }")],
    ),
    (
        "symmetric ones are listed once",
        "MATCH (a:Room {area: 14})-[:STAIRS]-(b:Room {area: 14}) RETURN a, b RELAX 1",
        [("hotel/r1", "hotel/r2", "(a)-[:STAIRS]-(b)")],
    ),
    (
        "a path counts as one condition, its map with it",
        "MATCH (a:Room {name: 'WC'})-[:DOOR*1..2 {width: 2..}]-(b:Room {name: 'Suite'}) RETURN b RELAX 1",
        [("hotel/r5", "(a)-[:DOOR*1..2 {width: 2..}]-(b)")],
    ),
    (
        "the better of two likened objects that overlap stays, here o0 of o0 and o0+o1",
        "MATCH (o:Object LIKE object('hotel/o0') WITHIN 0.1) RETURN o LIMIT 3 RELAX 1",
        [("hotel/o0",), ("hotel/o6",), ("hotel/o3", "(o:Object LIKE object('hotel/o0') WITHIN 0.1)")],
    ),
    (
        "counts are compared as numbers",
        "MATCH (a:Room) WHERE count { (a)-[:DOOR]-() } >= 5 RETURN a.name LIMIT 2 RELAX 1",
        [
            ("Lobby", "count { (a)-[:DOOR]-() } >= 5"),
            ("Office A", "count { (a)-[:DOOR]-() } >= 5"),
        ],
    ),
    (
        "what a broken guard let through is only unmet",
        "MATCH (s:Storey) WHERE s.index > 0 AND 4 / s.index > 3 RETURN s RELAX 2",
        [("hotel/s1",), ("hotel/s0", "s.index > 0", "4 / s.index > 3")],
    ),
    (
        "DISTINCT folds by what is returned, the best one stays",
        "MATCH (a:Room {area: 14})-[:DOOR]-(b:Room) RETURN DISTINCT a.area LIMIT 1 RELAX 1",
        [(14.0,)],
    ),
    (
        "PER BUILDING counts near misses too",
        "MATCH (a:Room {area: 100..}) RETURN a PER BUILDING 1 RELAX 1",
        [("hotel/r0", "(a:Room {area: 100..})")],
    ),
]


@pytest.mark.parametrize(("question", "rows"), [case[1:] for case in CASES], ids=[case[0] for case in CASES])
def test_near_misses(store: Store, hotel: BuildingGraph, question: str, rows: list[tuple[Any, ...]]) -> None:
    store.write(hotel)

    found = answer(store, question).rows

    assert [(*(v for name, v in row.items() if name != "unmet"), *row["unmet"]) for row in found] == rows


def test_how_far_off_is_told_from_python(sqlite_store: Store, hotel: BuildingGraph) -> None:
    sqlite_store.write(hotel)

    result = answer(
        sqlite_store,
        "MATCH (a:Room {area: $least..})-[:DOOR]-(b:Room {name: 'WC'}) WHERE a.name <> 'Lobby' RETURN a RELAX 2",
        parameters={"least": 28},
    )

    assert result.columns == ["a", "unmet"]
    assert result.rows[0] == {"a": "hotel/r0", "unmet": ["a.name <> 'Lobby'"]}
    assert [[(miss.condition, miss.excess) for miss in unmet] for unmet in result.unmet[:3]] == [
        [("a.name <> 'Lobby'", 1.0)],
        [("a.name <> 'Lobby'", 1.0)],  # it has two doors to the WC
        [("(a:Room {area: $least..})", pytest.approx((28 - 22) / 28)), ("(a)-[:DOOR]-(b)", 1.0)],
    ]


def test_no_more_is_asked_than_the_limit_needs(sqlite_store: Store, hotel: BuildingGraph) -> None:
    sqlite_store.write(hotel)
    question = "MATCH (a:Room {{area: 10..}})-[:DOOR]-(b:Room) RETURN a, b {} RELAX 3"

    enough = answer(sqlite_store, question.format("LIMIT 2"))
    all_rows = answer(sqlite_store, question.format("SKIP 0"))

    assert len(enough.explanation.steps) == 1
    assert len(all_rows.explanation.steps) > 3
    assert all_rows.rows[:2] == enough.rows


@pytest.mark.parametrize(
    ("tail", "error", "sentence"),
    [
        ("RETURN a RELAX 0", QuestionError, "RELAX takes a whole number from 1 to 3, not 0"),
        ("RETURN a RELAX 4", QuestionError, "RELAX takes a whole number from 1 to 3"),
        ("RETURN a RELAX 1 RELAX 1", QuestionError, "RELAX stands twice"),
        ("RETURN count(*) RELAX 1", UnsupportedError, "RELAX does not go with aggregates"),
        ("OPTIONAL MATCH (b:Room) RETURN a RELAX 1", UnsupportedError, "RELAX does not go with OPTIONAL MATCH"),
        ("RETURN a.area AS unmet RELAX 1", QuestionError, 'RELAX adds a column named "unmet"'),
        ("RETURN a RELAKS 1", QuestionError, "did you mean RELAX?"),
    ],
)
def test_what_cannot_be_relaxed(sqlite_store: Store, tail: str, error: type[EnfiladeError], sentence: str) -> None:
    with pytest.raises(error) as caught:
        answer(sqlite_store, f"MATCH (a:Room) {tail}")

    assert sentence in str(caught.value)


def test_conditions_are_named_as_they_are_written() -> None:
    query = parse(
        "MATCH (a:Room {area:10..20, name: $n})-[:DOOR|PASSAGE {width: 0.9..}]-(:Room), (a)-[:DOOR*2]-(c:Room)\n"
        "WHERE a.area+1>2 // no comment\n AND (c.name = 'x'  OR NOT c.area>3) AND 1 < c.area < 2 RETURN a"
    )

    assert condition_texts(query.pattern, query.text) == [
        "(a:Room {area: 10..20})",
        "(a:Room {name: $n})",
        "(a)-[:DOOR|PASSAGE]-(:Room)",
        "(a)-[:DOOR|PASSAGE {width: 0.9..}]-(:Room)",
        "(a)-[:DOOR*2]-(c)",
        "a.area+1>2",
        "c.name = 'x' OR NOT c.area>3",
        "1 < c.area",
        "c.area < 2",
    ]
    assert condition_texts(query.pattern, None)[-3] == "(c.name = 'x') OR (NOT (c.area > 3))"
