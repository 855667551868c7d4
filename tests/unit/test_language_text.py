"""Text, query graph and JSON are three forms of one question."""

from __future__ import annotations

import json
import random
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import Phase, given, settings
from question_maker import QuestionMaker
from question_strategies import query_graphs

from enfilade.errors import QuestionError
from enfilade.queries import Between, Column, EdgePattern, NodePattern, Pattern, QueryGraph, answer, parse
from enfilade.queries.syntax import Literal, PropertyOf, Variable
from enfilade.schema.exchange import read_graph
from enfilade.stores import Store, open_store

WORKED = json.loads((Path(__file__).parents[1] / "questions" / "hotel.json").read_text(encoding="utf-8"))
MADE = [QuestionMaker(random.Random(seed), ["b/o1", "b/o1+o2"]).question() for seed in range(200)]
HAND_MADE = [
    "match (`a b`:Room {area: -1.5..$high, name: 'it\\'s \\u00e9\\n'}) return `a b` as `x``y`",
    "MATCH (:Room)-[:DOOR]-(b:Room), (c:Room), (b)-[:DOOR]-(c) RETURN b, c",
    "MATCH (c:Room), (b:Room), (b)-[:DOOR]-(c) RETURN b, c",
    "MATCH (a:Room), (b:Room), (c:Room), (a)-[:DOOR]-(c), (c)-[:DOOR]-(b) RETURN a",
    "MATCH (o:Object LIKE 'a\"b.obj' AT 0.8..1 WITHIN $d), (q LIKE $x AT 0) RETURN o, like(q, object('b/o1'))",
    "MATCH (a:Room) WHERE ((a.area > 1 AND a.area < 5) AND a.x = 1) XOR NOT -(a.area) = -(-2) RETURN a",
    "MATCH (a:Room) WHERE 1 - (2 - 3) - 4 < 2 ^ (3 ^ 2) ^ 2 RETURN a",
    'MATCH (a:Room) WHERE a.name = "say \\"x\\"" RETURN count( * ), a.area+1, (a.area) ORDER BY a.area DESC, a',
    "MATCH (a:Room)<-[:STAIRS|`HATCH`]-(b) RETURN ALL DISTINCT a SKIP $s LIMIT 3 PER BUILDING 1",
    "MATCH (a)-[:DOOR*..3 {width: 0.9..}]-(b)-[w:NEIGHBOUR]-(a) RETURN w.gap, collect(DISTINCT a.name)",
    "MATCH (a:Room) WHERE a.area > 1 MATCH (b:Room) WHERE b.area > 2 RETURN a, b",
    "MATCH (a:Room) WHERE exists { match (a)--[:DOOR]-(b) } RETURN a".replace("--[", "-["),
    "MATCH (a:Room) RETURN [a.area, 1, null, true] AS list, percentileCont(a.area, 0.5)",
]


@pytest.fixture(scope="module")
def hotel_store(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Store]:
    with open_store(f"sqlite:{tmp_path_factory.mktemp('text') / 'hotel.db'}") as store:
        store.write(read_graph(Path(__file__).parents[1] / "graphs" / "hotel.graph.json"))
        yield store


@pytest.mark.parametrize("question", [*[worked["question"] for worked in WORKED], *HAND_MADE, *MADE])
def test_printing_parsing_and_json_keep_the_question(question: str) -> None:
    query = parse(question)

    assert parse(str(query)) == query
    assert QueryGraph.from_json(json.loads(json.dumps(query.to_json()))) == query


@settings(max_examples=60, phases=[Phase.explicit, Phase.generate])  # to shrink a question takes minutes
@given(query_graphs())
def test_a_question_built_by_hand_is_printed_and_read_again(query: QueryGraph) -> None:
    assert parse(str(query)) == query
    assert str(parse(str(query))) == str(query)
    assert QueryGraph.from_json(json.loads(json.dumps(query.to_json()))) == query


@pytest.mark.parametrize("question", [*[worked["question"] for worked in WORKED], *MADE[:60]])
def test_text_graph_and_json_compile_alike(hotel_store: Store, question: str) -> None:
    question = question.replace("b/o1+o2", "hotel/o1").replace("b/o1", "hotel/o1")
    query = parse(question)
    forms = [question, query, str(query), QueryGraph.from_json(query.to_json())]

    compiled = [answer(hotel_store, form, explain_only=True).explanation.steps for form in forms]

    assert all(steps == compiled[0] for steps in compiled)


def test_a_question_built_by_hand_is_the_one_that_is_written() -> None:
    built = QueryGraph(
        pattern=Pattern(
            nodes=(NodePattern("a", "Room", (Between("area", Literal(10), Literal(20)),)), NodePattern("b", "Room")),
            edges=(EdgePattern("a", "b", ("DOOR",)),),
        ),
        columns=(Column("a", Variable("a")), Column("b.name", PropertyOf("b", "name"))),
        limit=Literal(5),
    )

    assert built == parse("MATCH (a:Room {area: 10..20})-[:DOOR]-(b:Room) RETURN a, b.name LIMIT 5")
    assert str(built) == "MATCH (a:Room {area: 10..20})-[:DOOR]-(b:Room)\nRETURN a, b.name\nLIMIT 5"


def test_a_node_without_a_name_cannot_be_mentioned_twice() -> None:
    nodes = tuple(NodePattern(name, "Room") for name in ("#1", "b", "c"))
    edges = (EdgePattern("#1", "b", ("DOOR",)), EdgePattern("b", "c", ("DOOR",)), EdgePattern("c", "#1", ("DOOR",)))

    with pytest.raises(QuestionError, match="give it a name"):
        str(QueryGraph(Pattern(nodes, edges), (Column("b", Variable("b")),)))


def test_comments_and_blanks_say_nothing() -> None:
    spread = "MATCH // rooms\n (a:Room /* all\n of them */ {area: 10 .. 20})\r\n\tRETURN a . area;"

    assert parse(spread).pattern == parse("MATCH (a:Room {area: 10..20}) RETURN a").pattern


def test_columns_are_named_as_written_with_single_blanks() -> None:
    query = parse("MATCH (a:Room) RETURN a . area,  a.area  +\n 1, count( * ) /* all */, 'x  y' + a.name, a.name AS n")

    assert [column.name for column in query.columns] == [
        "a . area",
        "a.area + 1",
        "count( * )",
        "'x  y' + a.name",
        "n",
    ]


def test_texts_take_the_escapes_of_cypher() -> None:
    query = parse(r"""MATCH (a:Room {name: 'a\'b\"c\\d\t\u00e9\U0001F600'}) RETURN a""")

    assert query.pattern.nodes[0].constraints[0].value == Literal("a'b\"c\\d\té😀")  # type: ignore[union-attr]
