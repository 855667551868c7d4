"""The best few answers, found from the best few objects, are those that the whole answer begins with."""

from __future__ import annotations

import os
import random
from typing import Any

import numpy as np
import pytest
from oracle import Oracle
from oracle_comparison import alike
from question_maker import QuestionMaker, random_building

from enfilade.descriptors import quantise
from enfilade.errors import StoreError
from enfilade.queries import answer, parse
from enfilade.queries.run import best_objects
from enfilade.schema.graph import BuildingGraph
from enfilade.stores import Store

QUESTIONS_A_SEED = 15
SQLITE_SEEDS = int(os.environ.get("ENFILADE_FUZZ_SEEDS", "25"))
NEO4J_SEEDS = int(os.environ.get("ENFILADE_FUZZ_NEO4J_SEEDS", "6"))


class LimitedQuestionMaker(QuestionMaker):
    """Asks for the best few only, of what is like something."""

    def question(self) -> str:
        if self.rng.random() < 0.6:
            return self.furnished()
        while True:
            text = super().question().partition(" RELAX ")[0]
            if "LIKE" in text.partition(" RETURN ")[0].partition(" WHERE ")[0].partition(" OPTIONAL ")[0]:
                return text

    def furnished(self) -> str:
        """Objects in rooms, of which there are many matches."""
        rng = self.rng
        one, other, third = (self.likeness() for _ in range(3))
        pattern = rng.choice(
            (
                f"(o:Object {one})",
                f"(o:Object {one}), (p:Object {one})",
                f"(o:Object {one}), (p:Object {other})",
                f"(o:Object {one})-[:NEAR]-(p:Object {other})",
                f"(o:Object {one})-[:PART_OF]-(:Object {one})",
                f"(a:Room)-[:CONTAINS]->(o:Object {one})",
                f"(a:Room)-[:DOOR]-(b:Room)-[:CONTAINS]->(o:Object {one})",
                f"(a:Room)-[:CONTAINS]->(o:Object {one}), (a)-[:CONTAINS]->(p:Object {other})",
                f"(a:Room)-[:CONTAINS]->(o:Object {one}), (b:Room)-[:CONTAINS]->(p:Object {one})",
                f"(o:Object {one}), (p:Object {other}), (q:Object {third})",
            )
        )
        text = f"MATCH {pattern}" + rng.choice(
            (
                "",
                "",
                f" WHERE like(o, object('{rng.choice(self.objects)}')) < 1",
                f" WHERE NOT EXISTS {{ (o)-[:NEAR]-(:Object {self.likeness()}) }}",
            )
        )
        if rng.random() < 0.3:
            text += f" OPTIONAL MATCH (z:Object {self.likeness()})-[:NEAR]-(o)"
        self.labels = {name: "" for name in "abopqz" if f"({name}:" in text}
        return f"{text} {self.returning()}"

    def symmetric(self) -> str:
        """Add to a symmetric question what makes it one for the best few."""
        return f"{super().symmetric().partition(' RETURN ')[0]} {self.returning()}"

    def returning(self) -> str:
        rng = self.rng
        names = list(self.labels) or ["a", "score"]
        columns = list(dict.fromkeys([*rng.sample(names, min(len(names), rng.choice((1, 2)))), "score"]))
        if rng.random() < 0.3:
            columns = columns[:1]
        word = rng.choice(("", "", "", "ALL ", "DISTINCT "))
        if word == "DISTINCT ":
            columns = list(dict.fromkeys([*columns, "score"]))
        text = f"RETURN {word}{', '.join(columns)}"
        if rng.random() < 0.3:
            text += " ORDER BY score DESC" + rng.choice(("", f", {columns[0]}", f", {columns[0]} DESC"))
        if rng.random() < 0.3:
            text += f" SKIP {rng.choice((1, 2))}"
        text += f" LIMIT {rng.choice((1, 2, 3, 5))}"
        return text + (f" PER BUILDING {rng.choice((1, 2))}" if rng.random() < 0.25 else "")


@pytest.fixture
def _few_at_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """So few objects at first that a small building has more."""
    monkeypatch.setattr(best_objects, "FIRST_OBJECTS", 1)
    monkeypatch.setattr(best_objects, "GROWTH", 2)
    monkeypatch.setattr(best_objects, "MOST_SHARE", 2.0)


@pytest.mark.usefixtures("_few_at_first")
@pytest.mark.parametrize("seed", range(SQLITE_SEEDS))
def test_sqlite_answers_from_the_best_as_from_all(sqlite_store: Store, seed: int) -> None:
    compare_with_all(sqlite_store, seed)


@pytest.mark.neo4j
@pytest.mark.usefixtures("_few_at_first")
@pytest.mark.parametrize("seed", range(1000, 1000 + NEO4J_SEEDS))
def test_neo4j_answers_from_the_best_as_from_all(neo4j_store: Store, seed: int) -> None:
    compare_with_all(neo4j_store, seed)


def compare_with_all(store: Store, seed: int) -> None:
    rng = random.Random(seed)
    buildings = [random_building(rng, name) for name in ("b", "a", "ü")[: rng.randint(1, 3)]]
    for graph in buildings:
        if seed % 3:
            tell_apart(graph, np.random.default_rng(seed))
        store.write(graph)
    oracle = Oracle(buildings)
    maker = LimitedQuestionMaker(rng, [node.id for graph in buildings for node in graph.of_label("Object")])
    for _ in range(QUESTIONS_A_SEED):
        question = maker.question()

        found = rows(store, question)

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(best_objects, "MOST_TIMES", 0)
            assert found == rows(store, question), question
        expected = oracle.rows(parse(question))
        assert len(found) == len(expected), question
        assert all(alike(a, b) for a, b in zip(found, expected, strict=True)), question


def tell_apart(graph: BuildingGraph, rng: np.random.Generator) -> None:
    """Give every object a shape of its own, so that few are tied."""
    for node in graph.of_label("Object"):
        if node.properties.get("descriptor") is not None:
            node.properties["descriptor"] = quantise(rng.gamma(1.0, size=8))


def rows(store: Store, question: str) -> list[tuple[Any, ...]]:
    return [tuple(row.values()) for row in answer(store, question).rows]


def furnished_corpus(buildings: int, objects: int) -> list[BuildingGraph]:
    """Buildings of one room whose objects all differ, the first of each less from one another."""
    rng = np.random.default_rng(0)
    kinds = rng.gamma(0.5, size=(objects, 8))
    found = []
    for number in range(buildings):
        graph = BuildingGraph(f"b{number}", descriptor_shape=(1, 2, 4))
        graph.add_node(graph.building, "Building")
        graph.add_node(f"{graph.building}/r0", "Room", area=float(number))
        for i in range(objects):
            id = f"{graph.building}/o{i}"
            counts = quantise(kinds[i] * rng.lognormal(0, 0.1, 8))
            graph.add_node(id, "Object", parts=1, descriptor=counts)
            graph.add_edge(f"{graph.building}/r0", "CONTAINS", id)
        found.append(graph)
    return found


def test_few_are_asked_for_and_few_are_measured(sqlite_store: Store) -> None:
    sqlite_store.write_all(furnished_corpus(buildings=200, objects=20))
    like = "LIKE object('b7/o3')"

    result = answer(sqlite_store, f"MATCH (a:Room)-[:CONTAINS]->(o:Object {like}) RETURN a, o, score LIMIT 5")

    (search,) = result.explanation.likeness
    assert len(result.rows) == 5
    assert result.rows[0] == {"a": "b7/r0", "o": "b7/o3", "score": 0.0}
    assert search.candidates == 4000
    assert search.distances < 1000
    assert search.distances + search.pruned == search.candidates
    assert [step.rows for step in result.explanation.steps] == [64]
    whole = answer(sqlite_store, f"MATCH (a:Room)-[:CONTAINS]->(o:Object {like}) RETURN a, o, score")
    assert len(whole.rows) == 4000
    assert whole.rows[:5] == result.rows


def test_two_likened_nodes_stop_at_the_sum(sqlite_store: Store) -> None:
    sqlite_store.write_all(furnished_corpus(buildings=50, objects=10))
    pattern = "MATCH (o:Object LIKE object('b7/o3'))<-[:CONTAINS]-(a:Room)-[:CONTAINS]->(p:Object LIKE object('b9/o5'))"

    best = answer(sqlite_store, f"{pattern} RETURN o, p, score LIMIT 3")

    whole = answer(sqlite_store, f"{pattern} RETURN o, p, score")
    assert best.rows == whole.rows[:3]
    assert len(whole.rows) == 50 * 10 * 9
    assert sum(step.rows or 0 for step in best.explanation.steps) < 2000


def test_a_named_room_is_asked_for_first(sqlite_store: Store) -> None:
    sqlite_store.write_all(furnished_corpus(buildings=50, objects=20))

    result = answer(
        sqlite_store,
        "MATCH (a:Room {id: 'b3/r0'})-[:CONTAINS]->(o:Object LIKE object('b7/o3') WITHIN 0.5) RETURN o LIMIT 2",
    )

    (step,) = result.explanation.steps
    assert result.rows[0] == {"o": "b3/o3"}
    assert step.after == ["o LIKE object('b7/o3') WITHIN 0.5"]
    assert step.rows == 20
    assert result.explanation.likeness[0].distances == 20


def test_like_in_where_is_found_by_bounds(sqlite_store: Store) -> None:
    sqlite_store.write_all(furnished_corpus(buildings=100, objects=20))
    pattern = "MATCH (a:Room)-[:CONTAINS]->(o:Object)"

    found = answer(sqlite_store, f"{pattern} WHERE a.area >= 3 AND 0.05 >= like(o, object('b7/o3')) RETURN o")

    whole = answer(sqlite_store, f"{pattern} WHERE a.area >= 3 RETURN o, like(o, object('b7/o3')) AS d")
    assert [row["o"] for row in found.rows] == [row["o"] for row in whole.rows if row["d"] <= 0.05]
    assert 0 < len(found.rows) < 200
    assert found.explanation.likeness[0].distances < 1000
    assert found.explanation.steps[0].rows == len(found.rows)


def test_like_in_where_may_be_unknown_or_not(sqlite_store: Store) -> None:
    graphs = furnished_corpus(buildings=3, objects=5)
    del graphs[0].nodes["b0/o1"].properties["descriptor"]
    sqlite_store.write_all(graphs)
    for condition in (
        "like(o, object('b1/o1')) < 0.5",
        "NOT like(o, object('b1/o1')) < 0.5",
        "like(o, object('b1/o1')) <= 0",
        "like(o, object('b1/o1')) = 0",
        "like(o, object('b1/o1')) < -1",
        "like(o, object('b1/o1')) < 0.5 OR o.parts = 1",
        "like(o, object('b1/o1')) < 0.5 AND like(o, object('b1/o2')) < 1.2",
        "like(o, object('b1/o1')) > 0.5",
    ):
        question = f"MATCH (o:Object) WHERE {condition} RETURN o"

        expected = Oracle(graphs).rows(parse(question))

        assert rows(sqlite_store, question) == expected, condition


def test_the_clock_is_looked_at_while_objects_are_measured(sqlite_store: Store) -> None:
    sqlite_store.write_all(furnished_corpus(buildings=5, objects=20))
    sqlite_store.described.current()

    with pytest.raises(StoreError, match="took longer than 0 s"):
        answer(sqlite_store, "MATCH (o:Object LIKE object('b1/o1')) RETURN o LIMIT 1", timeout_s=0)
