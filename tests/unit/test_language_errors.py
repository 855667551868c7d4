"""A question that cannot be understood gets one sentence, its place, and the nearest name."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from enfilade.errors import EnfiladeError, NotFoundError, QuestionError, UnsupportedError
from enfilade.queries import answer
from enfilade.queries.query_graph import QueryGraph
from enfilade.schema.exchange import read_graph
from enfilade.stores import Store, open_store

GRAPH = Path(__file__).parents[1] / "graphs" / "hotel.graph.json"

PLACED = [
    ("MATCH (a:Rom) RETURN a", 7, 'no label "Rom": did you mean "Room"?'),
    ("MATCH (a:ROOM) RETURN a", 7, 'did you mean "Room"?'),
    ("MATCH (a:Room {aera: 3..}) RETURN a", 16, 'A Room has no property "aera": did you mean "area"?'),
    ("MATCH (a:Room)-[:DOR]-(b) RETURN a", 16, 'no edge type "DOR": did you mean "DOOR"?'),
    ("MATCH (a:Room)-[:door]-(b) RETURN a", 16, 'did you mean "DOOR"?'),
    ("MATCH (a:Room) WHERE a.hight > 2 RETURN a", 22, 'did you mean "height"?'),
    ("MATCH (a:Room) RETURN b", 23, 'no variable "b"'),
    ("MATCH (a:Room) RETURN averge(a.area)", 23, 'no function "averge"'),
    ("MATCH (a:Room {area: 20..10}) RETURN a", 16, "range 20..10 is reversed; write 10..20"),
    ("MATCH (a:Room {area: $low..10}) RETURN a", 16, "range 11..10 is reversed"),
    ("MATCH (a:Room {area: $hgh}) RETURN a", 22, "parameter $hgh has no value: did you mean"),
    ("MATCH (a:Room {name: 'x'..}) RETURN a", 16, "name is text"),
    ("MATCH (a:Room {area: 'big'}) RETURN a", 16, "a number is compared with a text"),
    ("MATCH (a:Room) WHERE a.name > 3 RETURN a", 22, "a text is compared with a number"),
    ("MATCH (a:Room) WHERE a.name IN ['x', 3] RETURN a", 22, "a text is compared with a number"),
    ("MATCH (a:Room) WHERE a.area RETURN a", 22, "a condition is true or false"),
    ("MATCH (a:Room) WHERE NOT a.area RETURN a", 26, "a condition is true or false"),
    ("MATCH (a:Room)-[:DOOR]->(b:Room) RETURN a", 16, "DOOR has no direction"),
    ("MATCH (a:Room)-[:NEIGHBOUR]->(b:Room) RETURN a", 16, "NEIGHBOUR has no direction"),
    ("MATCH (a:Room)-[:STAIRS*1..2]->(b:Room) RETURN a", 16, "a path has no direction"),
    ("MATCH (a:Room)-[d:DOOR*1..2]-(b:Room) RETURN a", 16, "a path cannot have a name"),
    ("MATCH (a:Room)-[:DOOR*]-(b:Room) RETURN a", 22, "a path needs a greatest length"),
    ("MATCH (a:Room)-[:DOOR*3..1]-(b:Room) RETURN a", 22, "a path of 3 to 1"),
    ("MATCH (a:Room)-[:HAS_ROOM]->(b) RETURN a", 16, "HAS_ROOM leads from Storey to Room"),
    ("MATCH (a)-[:BELOW]-(b), (c) RETURN a", 25, "this node needs a label"),
    ("MATCH (a:Room)--(b:Room) RETURN a", 15, "an edge needs a type"),
    ("MATCH (a:Room LIKE 'x.obj') RETURN a", 15, "only an Object can be LIKE"),
    ("MATCH (a:Room) RETURN a, a", 26, 'two columns are named "a"'),
    ("MATCH (a:Room)-[w:NEIGHBOUR]-(b) RETURN w", 41, '"w" is an edge'),
    ("MATCH (score:Room) RETURN score", 8, '"score" cannot name'),
    ("MATCH (a:Room) WHERE score > 1 RETURN a", 22, "score stands in RETURN"),
    ("MATCH (a:Room) WHERE count(*) > 1 RETURN a", 22, "a condition cannot aggregate"),
    ("MATCH (a:Room) RETURN DISTINCT a.name ORDER BY a.area", 48, "ORDER BY takes only what RETURN returns"),
    ("MATCH (a:Room) RETURN a LIMIT -1", 31, "LIMIT takes a whole number from 0"),
    ("MATCH (a:Room) RETURN a LIMIT 1.5", 31, "LIMIT takes a whole number from 0"),
    ("MATCH (a:Room) RETURN a LIMIT 1 LIMIT 2", 33, "LIMIT stands twice"),
    ("MATCH (a:Room)\nWHERE a.area >\nRETURN a", 1, '"RETURN" is not understood here'),
    ("MATCH (a:Room RETURN a", 15, '"RETURN" is not understood here; expected'),
    ("MATCH (a:Room) RETRUN a", 16, "did you mean RETURN?"),
    ("MATCH (a:Room) RETURN", 22, "the question ends too early"),
    ("", 1, "expected MATCH"),
    ("MATCH (a:Room) WHERE a.name = 'x RETURN a", 31, "a text begins here and does not end"),
    ("MATCH (a:Room) WHERE (a)-[:DOOR]-(b) RETURN a", 27, "a pattern in WHERE stands in braces"),
    ("MATCH (a:Room) RETURN *", 23, "RETURN * is not there"),
    ("MATCH (a:Room) RELAX 1 RETURN a", 16, "RELAX stands behind RETURN"),
    ("MATCH (a:Room) WHERE a.area > 1 LIMIT 1 RETURN a", 33, "LIMIT stands behind RETURN"),
    ("MATCH (a:Room) WITH a RETURN a", 16, "WITH is not there"),
    ("MATCH (a:Room) RETURN a UNION MATCH (b:Room) RETURN b", 25, "UNION is not there"),
    ("MATCH (a:Room) RETURN CASE WHEN true THEN 1 END", 28, "CASE is not there"),
    ("CREATE (a:Room)", 1, "CREATE is not there: a question only reads"),
    ("MATCH (a:Room) DETACH DELETE a", 16, "DETACH is not there"),
    ("MATCH (a:Room) SET a.area = 1", 16, "SET is not there"),
    ("MATCH (a:Room) WHERE a.name =~ 'x' RETURN a", 29, "=~ is not there"),
    ("MATCH (a:Room {name: 'a\\qb'}) RETURN a", 22, "there is no escape \\q"),
    ("MATCH (a:Room {area: 1e999}) RETURN a", 22, "a number is too large"),
]


@pytest.fixture(scope="module")
def hotel_store(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Store]:
    with open_store(f"sqlite:{tmp_path_factory.mktemp('errors') / 'hotel.db'}") as store:
        store.write(read_graph(GRAPH))
        yield store


@pytest.mark.parametrize(("question", "column", "sentence"), PLACED)
def test_error_shows_place_and_cause(hotel_store: Store, question: str, column: int, sentence: str) -> None:
    with pytest.raises(QuestionError) as caught:
        answer(hotel_store, question, parameters={"low": 11, "high": 3})

    first, shown, caret = str(caught.value).split("\n")
    assert sentence in first
    assert caught.value.column == column
    assert first.startswith(f"line {caught.value.line}, column {column}: ")
    assert caret == " " * (column + 1) + "^"
    assert shown.strip() in question


@pytest.mark.parametrize(
    ("question", "error", "sentence"),
    [
        ("MATCH (o:Object LIKE object('hotel/o99')) RETURN o", NotFoundError, 'no object "hotel/o99"'),
        ("MATCH (o:Object LIKE 'no/such.obj') RETURN o", EnfiladeError, "no/such.obj"),
        ("MATCH (o:Object LIKE $high) RETURN o", QuestionError, "$high is no example"),
        ("MATCH (a:Room) RETURN count(*) PER BUILDING 2", UnsupportedError, "PER BUILDING does not go with aggregates"),
        ("MATCH (a:Room) RETURN a.area + count(*) AS x", QuestionError, "mixes an aggregate"),
        ("MATCH (a:Room) WHERE a.point_count / 0 > 1 OR 1 / 0 = 1 RETURN a", QuestionError, "divided by zero"),
        ("MATCH " + ", ".join(f"(a{i}:Room)" for i in range(70)) + " RETURN ALL a1", UnsupportedError, "64 tables"),
        (
            "MATCH " + ", ".join(f"(a{i}:Room)" for i in range(12)) + " RETURN score RELAX 1",
            UnsupportedError,
            "symmetries",
        ),
    ],
)
def test_error_names_the_cause(hotel_store: Store, question: str, error: type[Exception], sentence: str) -> None:
    with pytest.raises(error) as caught:
        answer(hotel_store, question, parameters={"high": 3})

    assert sentence in str(caught.value)


@pytest.mark.parametrize(
    ("value", "sentence"),
    [
        (object(), "a object cannot stand in a question"),
        (float("nan"), "a number is too large, or is none"),
        (10**30, "a number is too large"),
        ("\ud800", "half a character"),
    ],
)
def test_a_parameter_that_is_no_value_is_refused(hotel_store: Store, value: object, sentence: str) -> None:
    with pytest.raises(QuestionError) as caught:
        answer(hotel_store, "MATCH (a:Room {name: $x}) RETURN a", parameters={"x": value})

    assert sentence in str(caught.value)


WRONG_PART = {"is": "QueryGraph", "pattern": {"is": "Pattern", "where": 5}, "columns": []}


@pytest.mark.parametrize(
    "document", [None, [], {"is": "Nothing"}, {"is": "Pattern"}, {"is": "QueryGraph", "x": 1}, WRONG_PART]
)
def test_json_that_is_no_question_is_refused(document: object) -> None:
    with pytest.raises(QuestionError, match="in JSON"):
        QueryGraph.from_json(document)
