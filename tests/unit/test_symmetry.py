"""Symmetries of a question: enough of them, found in little time however many there are."""

from __future__ import annotations

import random
import time

import pytest
from question_maker import QuestionMaker

from enfilade.errors import UnsupportedError
from enfilade.queries import parse
from enfilade.queries.checks import resolve
from enfilade.queries.symmetry import Symmetry, order_of_appearance, question_symmetries, smaller_first

STAR = "MATCH " + ", ".join(f"(a)-[:NEIGHBOUR]-(b{i}:Room)" for i in range(30)) + " RETURN a"
LOOSE = "MATCH " + ", ".join(f"(a{i}:Room)" for i in range(30)) + " RETURN count(*)"
PARALLEL = "MATCH " + ", ".join(["(a:Room)-[:DOOR]-(b:Room)"] * 12) + " RETURN a"
RING = "MATCH " + "-[:DOOR]-".join(f"(a{i}:Room)" for i in range(30)) + "-[:DOOR]-(a0) RETURN count(*)"
SORTED = LOOSE.replace(" RETURN", " WHERE " + " AND ".join(f"a{i}.area < a{i + 1}.area" for i in range(29)) + " RETURN")


def found(text: str) -> tuple[list[str], list[Symmetry]]:
    query = resolve(parse(text))
    return order_of_appearance(query.pattern), question_symmetries(query)


@pytest.mark.parametrize("seed", range(30))
def test_enough_of_them_keep_the_same_matches_as_all(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    maker = QuestionMaker(random.Random(seed), ["b/o1"])
    for _ in range(20):
        text = maker.question()
        order, some = found(text)
        with monkeypatch.context() as patch:
            patch.setattr("enfilade.queries.symmetry._Search.enough", lambda search, order: search.all())
            _, every = found(text)
        assert set(smaller_first(order, some)) == set(smaller_first(order, every)), text


@pytest.mark.parametrize(
    ("text", "pairs"), [(STAR, 30 * 29 // 2), (LOOSE, 30 * 29 // 2), (PARALLEL, 12 * 11 // 2), (RING, 30), (SORTED, 0)]
)
def test_many_like_nodes_take_little_time(text: str, pairs: int) -> None:
    start = time.process_time()
    order, symmetries = found(text)
    assert len(smaller_first(order, symmetries)) == pairs
    assert time.process_time() - start < 5


def test_a_question_that_needs_too_many_is_refused_soon() -> None:
    start = time.process_time()
    with pytest.raises(UnsupportedError, match="too many symmetries"):
        found(STAR.replace("(a)", "(a:Room)").replace("RETURN a", "OPTIONAL MATCH (a)-[:DOOR]-(c:Room) RETURN a"))
    assert time.process_time() - start < 20
