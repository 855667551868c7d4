"""What may stand next in a question is what the parser would take, by the names that it could be."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from enfilade.queries.completion import completions
from enfilade.queries.parse import is_unfinished, parser

CASES = [
    ("", ["MATCH"]),
    ("ma", ["MATCH"]),
    ("MATCH (a:R", ["Room"]),
    ("MATCH (a:Room)-[:CO", ["CONTAINS"]),
    ("MATCH (a:Room)-[:DOOR|PA", ["PASSAGE", "PART_OF"]),
    ("MATCH (a:Room {hei", ["height: "]),
    ("MATCH (a:Room {area: 3.., na", ["name: "]),
    ("MATCH (a:Room)-[d:DOOR {wid", ["width: "]),
    ("MATCH (w:Opening {state: ", ["'open'", "'ajar'", "'closed'", "$basin", "false", "null", "true"]),
    ("MATCH (a:Room)-[n:NEIGHBOUR]-(b:Room) WHERE n.", ["gap", "area", "planes"]),
    ("MATCH (a:Room)-[d:DOOR]-(b:Room) RETURN d.heig", ["height"]),
    ("MATCH (room:Room) WHERE ro", ["room"]),
    ("MATCH (`a b`:Room) WHERE ", ["`a b`", "score", "mean_score"]),
    ("MATCH (a:Room) WHERE EX", ["EXISTS { "]),
    ("MATCH (a:Room) WHERE EXISTS { (a)-[:DOOR]-(x:Room {floor", ["floor_elevation: "]),
    ("MATCH (a:Room) WHERE a.name ST", ["STARTS WITH"]),
    ("MATCH (a:Room) WHERE a.height I", ["IN", "IS NULL", "IS NOT NULL"]),
    ("MATCH (o:Object LIKE ", ["object('", "$basin"]),
    ("MATCH (o:Object LIKE $", ["$basin"]),
    ("MATCH (a:Room) RETURN perc", ["percentileCont(", "percentileDisc("]),
    ("MATCH (a:Room) RETURN a OR", ["ORDER BY"]),
    ("MATCH (a:Room) RETURN a ORDER BY a.area D", ["DESC"]),
    ("MATCH (a:Room) RETURN a P", ["PER BUILDING"]),
    ("MATCH (a:Room) RETURN a REL", ["RELAX"]),
    ("MATCH (a:Room {name: 'Ro", []),
    ("MATCH (a:Room)-[", []),
    ("MATCH a wrong one ", []),
]


@pytest.mark.parametrize(("before", "words"), CASES, ids=[case[0] for case in CASES])
def test_completions(before: str, words: list[str]) -> None:
    found = completions(before, parameters=["basin"])

    assert [completion.text for completion in found][: len(words) or None] == words


def test_what_is_behind_the_cursor_tells_what_names_mean() -> None:
    assert [c.text for c in completions("MATCH (a)-[:DOOR]-(b) WHERE a.sil", "", parameters=())] == ["sill"]
    assert [c.text for c in completions("MATCH (a)-[:DOOR]-(b) WHERE a.sil", ", (a:Room)", parameters=())] == []


@given(st.sampled_from([case[0] for case in CASES]), st.integers(0, 60))
def test_a_completed_word_is_no_error_of_its_own(before: str, cut: int) -> None:
    start = before[:cut]
    for completion in completions(start, parameters=["basin"]):
        written = start[: len(start) - completion.typed] + completion.text
        assert completion.typed <= len(start)
        assert is_unfinished(written) or parser().parse(written), written


@pytest.mark.parametrize(
    ("text", "unfinished"),
    [
        ("MATCH (a:Room)", True),
        ("MATCH (a:Room) RETURN", True),
        ("MATCH (a:Room {name: 'Ha", True),
        ("MATCH (a:Room) RETURN a", False),
        ("MATCH (a:Room) RETURN a;", False),
        ("MATCH (a:Rom) RETRUN", False),
        ("MATCH )", False),
    ],
)
def test_a_question_goes_on_until_it_is_whole(text: str, unfinished: bool) -> None:
    assert is_unfinished(text) is unfinished
