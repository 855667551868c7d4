"""A store's answer beside the oracle's: the same rows in the same order."""

from __future__ import annotations

import math
import random
from typing import Any

from oracle import Oracle
from question_maker import QuestionMaker, random_building

from enfilade.queries import answer, parse
from enfilade.queries.relaxation import condition_texts
from enfilade.stores import Store


def buildings_and_maker(store: Store, rng: random.Random) -> tuple[Oracle, QuestionMaker]:
    """Put one to three random buildings into a store instead of what it holds; what answers and what asks."""
    for summary in store.buildings():
        store.remove(summary.id)
    buildings = [random_building(rng, name) for name in ("b", "a", "ü")[: rng.randint(1, 3)]]
    for graph in buildings:
        store.write(graph)
    return Oracle(buildings), QuestionMaker(rng, [node.id for graph in buildings for node in graph.of_label("Object")])


def ask_and_compare(store: Store, oracle: Oracle, question: str) -> str:
    """Ask both; AssertionError with the question where they differ."""
    found = [tuple(row.values()) for row in answer(store, question).rows]
    expected = expected_rows(oracle, question)
    assert len(found) == len(expected), f"{question}\n{len(found)} rows, not {len(expected)}"
    for row, other in zip(found, expected, strict=True):
        assert alike(row, other), f"{question}\n{row}\nnot\n{other}"
    return question


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
