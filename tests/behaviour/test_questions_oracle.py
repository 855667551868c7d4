"""Random questions about random buildings, every store against the oracle: the same rows in the same order."""

from __future__ import annotations

import math
import os
import random
from typing import Any

import pytest
from oracle import Oracle
from question_maker import QuestionMaker, random_building

from enfilade.queries import answer, parse
from enfilade.queries.relaxation import condition_texts
from enfilade.stores import Store

QUESTIONS_A_SEED = 20
SQLITE_SEEDS = int(os.environ.get("ENFILADE_FUZZ_SEEDS", "25"))
NEO4J_SEEDS = int(os.environ.get("ENFILADE_FUZZ_NEO4J_SEEDS", "6"))


@pytest.mark.parametrize("seed", range(SQLITE_SEEDS))
def test_sqlite_answers_as_the_oracle(sqlite_store: Store, seed: int) -> None:
    compare_with_oracle(sqlite_store, seed)


@pytest.mark.neo4j
@pytest.mark.parametrize("seed", range(1000, 1000 + NEO4J_SEEDS))
def test_neo4j_answers_as_the_oracle(neo4j_store: Store, seed: int) -> None:
    compare_with_oracle(neo4j_store, seed)


def compare_with_oracle(store: Store, seed: int) -> None:
    rng = random.Random(seed)
    buildings = [random_building(rng, name) for name in ("b", "a", "ü")[: rng.randint(1, 3)]]
    for graph in buildings:
        store.write(graph)
    oracle = Oracle(buildings)
    maker = QuestionMaker(rng, [node.id for graph in buildings for node in graph.of_label("Object")])
    for _ in range(QUESTIONS_A_SEED):
        question = maker.question()

        found = [tuple(row.values()) for row in answer(store, question).rows]

        expected = expected_rows(oracle, question)
        assert len(found) == len(expected), question
        assert all(alike(a, b) for a, b in zip(found, expected, strict=True)), question


def expected_rows(oracle: Oracle, question: str) -> list[tuple[Any, ...]]:
    """The oracle's rows; it numbers the conditions that a near miss does not meet, and here they get their names."""
    query = parse(question)
    if query.relax is None:
        return oracle.rows(query)
    names = condition_texts(query.pattern, query.text)
    return [(*values, [names[number] for number in unmet]) for *values, unmet in oracle.rows(query)]


def alike(a: Any, b: Any) -> bool:
    """Whether two values are the same, numbers up to the last digits of their sums."""
    if isinstance(a, tuple | list) and isinstance(b, tuple | list):
        return len(a) == len(b) and all(map(alike, a, b))
    if isinstance(a, float) and isinstance(b, int | float):
        return math.isclose(a, b, rel_tol=1e-9, abs_tol=1e-9)
    return type(a) is type(b) and bool(a == b)
