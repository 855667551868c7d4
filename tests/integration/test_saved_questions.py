"""The questions saved for Neo4j Browser run on the real Neo4j, and the style knows our labels."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from enfilade.schema.definition import EDGES, NODES
from enfilade.schema.graph import BuildingGraph
from enfilade.stores.neo4j import Neo4jStore

FILES = Path(__file__).parents[2] / "docker" / "neo4j-browser"
QUESTIONS = sorted((FILES / "questions").glob("*.cypher"))
TOUR = Path(__file__).parents[2] / "docs" / "neo4j-browser.md"


def rows(store: Neo4jStore, name: str) -> list[dict[str, object]]:
    return list(store.cypher((FILES / "questions" / f"{name}.cypher").read_text(encoding="utf-8"), {}))


@pytest.mark.neo4j
@pytest.mark.parametrize("path", QUESTIONS, ids=lambda path: path.stem)
def test_every_question_runs_and_finds_something(path: Path, neo4j_store: Neo4jStore, hotel: BuildingGraph) -> None:
    hotel.nodes["hotel/p7"].properties["state"] = "closed"
    hotel.nodes["hotel/r0"].properties["area"] = 15.0
    neo4j_store.write(hotel)
    assert rows(neo4j_store, path.stem)


@pytest.mark.neo4j
def test_the_answers_are_right(neo4j_store: Neo4jStore, hotel: BuildingGraph) -> None:
    neo4j_store.write(hotel)
    assert [row["room"] for row in rows(neo4j_store, "rooms-by-area")][:2] == ["Lobby", "Suite"]
    assert [(row["room"], row["way_in"]) for row in rows(neo4j_store, "dead-ends")] == [
        ("Bath", None),
        ("Kitchen", None),
    ]
    assert {(row["from"], row["to"]) for row in rows(neo4j_store, "narrow-doors")} == {("Lobby", "WC")}
    storeys = rows(neo4j_store, "storeys-compared")
    assert [(row["storey"], row["rooms"], row["area_m2"]) for row in storeys] == [(0, 5, 74.0), (1, 2, 28.0)]


def test_every_question_says_what_it_asks() -> None:
    firsts = [path.read_text(encoding="utf-8").splitlines()[0] for path in QUESTIONS]
    assert all(first.startswith("// ") for first in firsts)
    assert len(set(firsts)) == len(QUESTIONS) > 10


def test_the_style_knows_every_label_and_edge_type() -> None:
    style = (FILES / "style.grass").read_text(encoding="utf-8")
    assert set(re.findall(r"^node\.(\w+) {", style, re.MULTILINE)) == set(NODES)
    assert set(re.findall(r"^relationship\.(\w+) {", style, re.MULTILINE)) == set(EDGES)


def test_the_tour_shows_pictures_that_are_there_and_names_every_question() -> None:
    tour = TOUR.read_text(encoding="utf-8")
    pictures = re.findall(r"!\[[^]]+\]\(([^)]+)\)", tour)
    assert len(pictures) >= 5
    assert all((TOUR.parent / picture).stat().st_size > 10_000 for picture in pictures)
    assert all(f"`{path.stem}`" in tour for path in QUESTIONS)
