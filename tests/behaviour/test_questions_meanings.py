"""Meanings that the worked questions leave open, one question each, worked out by hand on the hotel."""

from __future__ import annotations

from typing import Any

import pytest

from enfilade.queries import answer
from enfilade.schema.graph import BuildingGraph
from enfilade.stores import Store


def rooms(*numbers: int) -> list[str]:
    return [f"hotel/r{number}" for number in numbers]


FIRST_COLUMN = [
    ("unknown OR true is true", "MATCH (a:Room) WHERE a.height > 9 OR a.area = 12 RETURN a", rooms(4)),
    (
        "unknown AND false is false",
        "MATCH (a:Room) WHERE NOT (a.height > 9 AND a.area > 99) RETURN a",
        rooms(*range(7)),
    ),
    ("unknown XOR true is unknown", "MATCH (a:Room) WHERE a.height > 9 XOR a.area = 12 RETURN a", []),
    ("IN a list with null is never false", "MATCH (a:Room) WHERE NOT a.area IN [4, null] RETURN a", []),
    (
        "what is missing is in no list",
        "MATCH (a:Room) WHERE a.height IN [3.0] OR a.height IS NULL RETURN a",
        rooms(0, 4),
    ),
    (
        "the empty text is in every text",
        "MATCH (a:Room) WHERE a.name STARTS WITH '' AND a.function ENDS WITH '' RETURN a",
        [],
    ),
    ("a chain of comparisons", "MATCH (a:Room) WHERE 6 <= a.area < 14 RETURN a", rooms(4, 6)),
    ("numbers multiply before they add", "MATCH (a:Room) WHERE 2 + a.area * 2 ^ 1 - 1 = 25 RETURN a", rooms(4)),
    ("whole numbers divide to whole numbers", "MATCH (s:Storey) WHERE (s.index + 3) / 2 = 2 RETURN s", ["hotel/s1"]),
    ("% has the sign of its left side", "MATCH (s:Storey {index: 1}) WHERE -s.index % 2 = -1 RETURN s", ["hotel/s1"]),
    (
        "AND binds tighter than XOR and OR",
        "MATCH (a:Room) WHERE a.area = 4 OR a.area = 6 AND a.area = 7 RETURN a",
        rooms(3),
    ),
    ("two names, one room never", "MATCH (a:Room {name: 'WC'}), (b:Room {name: 'WC'}) RETURN a", []),
    ("a smaller id is first of a pair", "MATCH (a:Room {area: 14}), (b:Room {area: 14}) RETURN a", rooms(1, 2)),
    ("of a pair that is returned whole, too", "MATCH (b:Room {area: 14}), (a:Room {area: 14}) RETURN a, b", rooms(2)),
    ("ALL keeps both", "MATCH (b:Room {area: 14}), (a:Room {area: 14}) RETURN ALL a, b", rooms(2, 1)),
    (
        "OR in another order is the same",
        "MATCH (a:Room {area: 14}), (b:Room {area: 14}) WHERE a.name = 'Office A' OR b.name = 'Office A' RETURN a, b",
        rooms(1),
    ),
    (
        "< turned round is the same",
        "MATCH (a:Room {area: 14}), (b:Room {area: 14}) WHERE a.area <= b.area AND a.area >= b.area RETURN a, b",
        rooms(1),
    ),
    (
        "a distance said the other way is not",
        "MATCH (a:Room {area: 14}), (b:Room {area: 14}) WHERE a.area <= b.area RETURN a, b",
        rooms(1, 2),
    ),
    ("no label is needed where edges tell it", "MATCH (s)-[:BELOW]->(t)-[:HAS_ROOM]->(r) RETURN r", rooms(5, 6)),
    ("an undirected pattern of a directed edge", "MATCH (s)-[:BELOW]-(t) RETURN s", ["hotel/s0", "hotel/s1"]),
    (
        "a path may pass through rooms of the match",
        "MATCH (a:Room {name: 'Office A'})-[:DOOR]-(b:Room {name: 'Lobby'}), "
        "(a)-[:DOOR*2]-(c:Room {name: 'WC'}) RETURN c",
        rooms(3),
    ),
    ("NEIGHBOUR may be a path", "MATCH (a:Room {name: 'Lobby'})-[:NEIGHBOUR*2..3]-(b:Room) RETURN b", rooms(2, 3)),
    ("a map holds on all of a path", "MATCH (a:Room {name: 'WC'})-[:DOOR*..2 {width: 0.85..}]-(b:Room) RETURN b", []),
    (
        "an inner node is none that is named inside",
        "MATCH (a:Room {name: 'Suite'})-[:DOOR]-(b:Room) "
        "WHERE EXISTS { (b)-[:DOOR]-(x:Room) WHERE x.area >= a.area } RETURN b",
        [],
    ),
    (
        "it may be one that is not",
        "MATCH (a:Room {name: 'Suite'})-[:DOOR]-(b:Room) "
        "WHERE EXISTS { (b)-[:DOOR]-(x:Room) WHERE x.area >= 22 } RETURN b",
        rooms(6),
    ),
    (
        "symmetric matches count once",
        "MATCH (a:Building) WHERE count { (:Room)-[:DOOR]-(:Room) } = 6 RETURN a",
        ["hotel"],
    ),
    (
        "a likened count lists no overlap",
        "MATCH (a:Room) WHERE count { (a)-[:CONTAINS]->(:Object LIKE object('hotel/o0')) } = 2 RETURN a",
        rooms(1, 2),
    ),
    ("PART_OF joins objects that share", "MATCH (p:Object)-[:PART_OF]->(o:Object) RETURN p", ["hotel/o0", "hotel/o1"]),
    (
        "others that share are apart",
        "MATCH (o:Object {parts: 2}), (p:Object {parts: 1})-[:NEAR]-(:Object) RETURN o",
        [],
    ),
    ("an id asks for combinations", "MATCH (o:Object) WHERE o.id CONTAINS '+' RETURN o", ["hotel/o0+o1"]),
    (
        "an option's nodes are other nodes",
        "MATCH (a:Room {name: 'Suite'})-[:DOOR]-(b:Room) OPTIONAL MATCH (b)-[:DOOR]-(c:Room) RETURN c",
        [None],
    ),
    (
        "an option of an option that is missing",
        "MATCH (a:Room {name: 'Kitchen'}) OPTIONAL MATCH (a)-[:DOOR]-(b:Room) "
        "OPTIONAL MATCH (b)-[:DOOR]-(c:Room) RETURN c",
        [None],
    ),
    ("missing values last, ascending", "MATCH (a:Room) RETURN a ORDER BY a.height, a.name LIMIT 2", rooms(3, 6)),
    (
        "a column's name in ORDER BY",
        "MATCH (a:Room) RETURN a, a.area AS size ORDER BY size DESC SKIP 1 LIMIT 2",
        rooms(5, 1),
    ),
    ("no row is no row", "MATCH (a:Room) RETURN a LIMIT 0", []),
    ("PER BUILDING counts before SKIP", "MATCH (a:Room) RETURN a SKIP 1 PER BUILDING 2", rooms(1)),
]

ROWS = [
    (
        "MATCH (a:Room {area: 99..}) RETURN count(*), sum(a.area), avg(a.area), min(a.area), collect(a), stDev(a.area)",
        [(0, 0, None, None, [], None)],
    ),
    ("MATCH (a:Room {area: 99..}) RETURN a.name, count(*)", []),
    (
        "MATCH (a:Room) RETURN count(a.height), count(DISTINCT a.height), max(a.name), percentileCont(a.area, 0.25)",
        [(6, 4, "WC", 9.0)],
    ),
    ("MATCH (a:Room)-[:DOOR]-(b:Room) RETURN count(*)", [(6,)]),
    ("MATCH (a:Room) RETURN a.area > 13 AS large, count(*) ORDER BY count(*)", [(False, 3), (True, 4)]),
    ("MATCH (a:Room)-[w:NEIGHBOUR]-(b:Room) RETURN sum(w.gap), count(w)", [(pytest.approx(0.4), 3)]),
    (
        "MATCH (a:Room {name: 'WC'}) RETURN a.area + 1, -a.area, a.name + '!', a.height IS NULL, [a.area, null]",
        [(5.0, -4.0, "WC!", False, [4.0, None])],
    ),
    ("MATCH (b:Building) RETURN b, b.building, b.scan_count, score, mean_score", [("hotel", "hotel", None, 0, 0)]),
    (
        "MATCH (o:Object {id: 'hotel/o4'}) RETURN o.descriptor, o.segments",
        [([0, 0, 0.5, 0.5, 0, 0, 0, 0], ["hotel/o4"])],
    ),
]


@pytest.mark.parametrize(("question", "column"), [c[1:] for c in FIRST_COLUMN], ids=[c[0] for c in FIRST_COLUMN])
def test_meaning(store: Store, hotel: BuildingGraph, question: str, column: list[str]) -> None:
    store.write(hotel)

    assert [next(iter(row.values())) for row in answer(store, question).rows] == column


@pytest.mark.parametrize(("question", "rows"), ROWS, ids=[case[0] for case in ROWS])
def test_values(store: Store, hotel: BuildingGraph, question: str, rows: list[tuple[Any, ...]]) -> None:
    store.write(hotel)

    assert [tuple(row.values()) for row in answer(store, question).rows] == rows
