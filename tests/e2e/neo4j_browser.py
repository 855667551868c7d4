"""Drives Neo4j Browser in a real Chromium: for the pictures of docs/neo4j-browser.md, and for the test of it.

``python tests/e2e/neo4j_browser.py GRAPH...`` starts a Neo4j of its own, puts the graphs in and takes the pictures.
"""

from __future__ import annotations

import io
import sys
import tempfile
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

from enfilade import server
from enfilade.schema.exchange import read_graphs
from enfilade.stores import open_store

ROOT = Path(__file__).resolve().parents[2]
BROWSER_FILES = ROOT / "docker" / "neo4j-browser"
PICTURES = ROOT / "docs" / "images"
CHROMIUM = Path("/usr/bin/chromium")

_FLAGS = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-background-networking"]
_PATIENCE_MS = 120_000
_DROP = """([name, bytes]) => {
    const target = document.querySelector('.filedrop');
    const transfer = new DataTransfer();
    transfer.items.add(new File([new Uint8Array(bytes)], name));
    for (const kind of ['dragenter', 'dragover', 'drop'])
        target.dispatchEvent(new DragEvent(kind, {bubbles: true, cancelable: true, dataTransfer: transfer}));
}"""


def question(name: str) -> str:
    """Return one of the saved questions."""
    return (BROWSER_FILES / "questions" / f"{name}.cypher").read_text(encoding="utf-8")


def zipped_questions() -> bytes:
    """Return all saved questions as the zip file that Browser takes as favourites."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for path in sorted((BROWSER_FILES / "questions").glob("*.cypher")):
            archive.write(path, f"Enfilade/{path.name}")
    return packed.getvalue()


@dataclass(frozen=True)
class Browser:
    """Neo4j Browser, connected."""

    page: Page

    def drop(self, name: str, content: bytes) -> None:
        """Drop a file onto the page, as a user would from a file manager."""
        self.page.evaluate(_DROP, [name, list(content)])

    def ask(self, text: str) -> None:
        """Run a question or a command and wait for the answer."""
        self.page.click(".monaco-editor")
        self.page.keyboard.press("Control+A")
        self.page.keyboard.press("Delete")
        self.page.keyboard.insert_text(text)
        self.page.keyboard.press("Control+Enter")
        if text != ":clear":
            first = text.strip().splitlines()[0]
            self.page.locator("[data-testid=frame]").first.get_by_text(first).first.wait_for(timeout=_PATIENCE_MS)

    def wait_for_graph(self) -> None:
        """Wait until nodes are drawn and have come to rest."""
        self.page.locator("[data-testid=frame] svg .node").first.wait_for(timeout=_PATIENCE_MS)
        self.page.wait_for_timeout(4000)

    def drawn(self, kind: str) -> int:
        """Return how many nodes (``node``) or edges (``relationship``) the newest answer shows."""
        return self.page.locator("[data-testid=frame]").first.locator(f"svg .{kind}").count()

    def picture(self, name: str) -> None:
        """Save what is to be seen now."""
        PICTURES.mkdir(parents=True, exist_ok=True)
        self.page.screenshot(path=PICTURES / f"neo4j-{name}.png")


@contextmanager
def connected(address: str, url: str, password: str) -> Iterator[Browser]:
    """Open Browser in Chromium and connect it."""
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=_FLAGS)
        page = chromium.new_page(viewport={"width": 1280, "height": 690})
        page.goto(f"{address}?dbms={url}&db=neo4j")
        page.wait_for_selector("[data-testid=username]", timeout=_PATIENCE_MS)
        page.fill("[data-testid=password]", password)
        page.keyboard.press("Enter")
        page.wait_for_selector("text=You are connected", timeout=_PATIENCE_MS)
        try:
            yield Browser(page)
        finally:
            chromium.close()


def take_pictures(browser: Browser) -> None:
    """Walk the tour of docs/neo4j-browser.md."""
    browser.drop("style.grass", (BROWSER_FILES / "style.grass").read_bytes())
    browser.ask(':config {"autoComplete": false}')
    for name in ("building-storeys-rooms", "doors-and-stairs", "two-rooms-one-with-stairs", "furniture-of-a-room"):
        _draw(browser, name)
        browser.picture(name)
    _draw(browser, "hubs")
    browser.page.locator("[data-testid=frame] svg .node").filter(has_text="Room").first.click()
    browser.page.wait_for_timeout(1000)
    browser.picture("a-room")
    browser.ask(":clear")
    browser.ask(question("rooms-by-area"))
    browser.page.wait_for_timeout(1000)
    browser.picture("rooms-by-area")
    _draw(browser, "longest-way")
    browser.drop("questions.zip", zipped_questions())
    browser.page.click("[data-testid=navigationFavorites]")
    browser.page.click("[data-testid=expandFolder-Enfilade]")
    browser.page.wait_for_timeout(1000)
    browser.picture("favourites")


def _draw(browser: Browser, name: str) -> None:
    browser.ask(":clear")
    browser.ask(question(name))
    browser.wait_for_graph()


def main(graphs: list[Path]) -> None:
    """Start a Neo4j, fill it, take the pictures, stop it."""
    with tempfile.TemporaryDirectory() as folder, _started(Path(folder)) as running:
        password = running.password_file.read_text(encoding="utf-8")
        with open_store(running.url, ask=lambda _: password) as store:
            for path in graphs:
                for graph in read_graphs(path):
                    store.write(graph)
        with connected(running.browser, running.url, password) as browser:
            take_pictures(browser)


@contextmanager
def _started(home: Path) -> Iterator[server.ServerStatus]:
    try:
        yield server.start(home, settings=server.Settings(bolt_port=0, http_port=0))
    finally:
        server.stop(home)


if __name__ == "__main__":
    main([Path(name) for name in sys.argv[1:]])
