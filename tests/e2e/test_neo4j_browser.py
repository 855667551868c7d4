"""Neo4j Browser in a real Chromium: our style and saved questions are taken, and the graph is drawn with them."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest
from conftest import RunningNeo4j
from neo4j_browser import BROWSER_FILES, CHROMIUM, Browser, connected, question, zipped_questions

from enfilade.schema.graph import BuildingGraph
from enfilade.stores import Store

pytestmark = [pytest.mark.neo4j, pytest.mark.slow]


@pytest.fixture
def browser(neo4j_server: RunningNeo4j, neo4j_store: Store, hotel: BuildingGraph) -> Iterator[Browser]:
    if not CHROMIUM.exists() and os.environ.get("ENFILADE_REQUIRE_CHROMIUM") != "1":
        pytest.skip(f"{CHROMIUM} is not installed")
    neo4j_store.write(hotel)
    with connected(neo4j_server.browser, neo4j_server.url, neo4j_server.password) as opened:
        yield opened


def test_the_building_is_drawn_in_our_style(browser: Browser) -> None:
    browser.drop("style.grass", (BROWSER_FILES / "style.grass").read_bytes())
    browser.ask(':config {"autoComplete": false}')
    browser.ask(":clear")
    browser.ask(question("building-storeys-rooms"))
    browser.wait_for_graph()
    assert (browser.drawn("node"), browser.drawn("relationship")) == (10, 9)
    rooms = browser.page.locator("[data-testid=frame] svg .node").filter(has_text="Office A")
    assert rooms.locator("circle.b-outline").get_attribute("fill") == "#88C0D0"
    browser.drop("questions.zip", zipped_questions())
    browser.page.click("[data-testid=navigationFavorites]")
    browser.page.click("[data-testid=expandFolder-Enfilade]")
    browser.page.wait_for_selector("text=Doors that a wheelchair does")
