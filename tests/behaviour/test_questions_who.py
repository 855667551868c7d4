"""The tables in docs/language.md of who does what are what the compilers do, for both stores.

Run with ENFILADE_UPDATE_DOCS=1 to write them anew.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from enfilade.errors import UnsupportedError
from enfilade.queries import answer
from enfilade.queries.explanation import Step
from enfilade.stores import Store

PAGE = Path(__file__).parents[2] / "docs" / "language.md"
FIRST, SECOND = "## What the store does, and what is done after it", "The rest of a question goes to the store"
ASKED_OF = "MATCH (a:Room)-[d:DOOR]-(b:Room), (a)-[:CONTAINS]->(o:Object) WHERE {} RETURN a"
LONG = "MATCH " + ", ".join(f"(a{i}:Room)-[:DOOR]-(a{i + 1}:Room)" for i in range(17)) + " RETURN ALL a0"
ROW = re.compile(r"^\| (?P<what>[^\n]*?) \| (?P<examples>`[^\n]*`) \| [^|]* \| [^|]* \|(?P<rest>.*)$", re.M)


@pytest.fixture
def steps(sqlite_store: Store, monkeypatch: pytest.MonkeyPatch):
    def compiled(question: str, dialect: str) -> list[Step]:
        monkeypatch.setattr(type(sqlite_store), "dialect", dialect)
        parameters = {"x": 4, "t": "e"}
        likenesses = {"basin": "object:hotel/o4"}
        found = answer(sqlite_store, question, parameters=parameters, likenesses=likenesses, explain_only=True)
        return found.explanation.steps

    return compiled


def test_the_tables_say_who_does_what(steps) -> None:
    before = PAGE.read_text(encoding="utf-8")
    start, middle = before.index(FIRST), before.index(SECOND)
    end = before.index("\n## ", middle)

    def condition(found: re.Match[str]) -> str:
        cells = [_who(found["examples"], dialect, steps) for dialect in ("sql", "cypher")]
        return f"| {found['what']} | {found['examples']} | {' | '.join(cells)} |{found['rest']}"

    def construct(found: re.Match[str]) -> str:
        cells = [_statements(found["examples"], dialect, steps) for dialect in ("sql", "cypher")]
        return f"| {found['what']} | {found['examples']} | {' | '.join(cells)} |{found['rest']}"

    now = "".join(
        [
            before[:start],
            ROW.sub(condition, before[start:middle]),
            ROW.sub(construct, before[middle:end]),
            before[end:],
        ]
    )

    if os.environ.get("ENFILADE_UPDATE_DOCS"):
        PAGE.write_text(now, encoding="utf-8")
    assert now == PAGE.read_text(encoding="utf-8")
    assert len(ROW.findall(before[start:middle])) >= 15
    assert len(ROW.findall(before[middle:end])) >= 9


def _examples(cell: str) -> list[str]:
    return [text.replace("\\|", "|") for text in re.findall(r"`([^`]*)`", cell)]


def _who(cell: str, dialect: str, steps) -> str:
    """Who tests each of the examples: they stand in one row because it is the same for all."""
    (who,) = {bool(steps(ASKED_OF.format(example), dialect)[0].after) for example in _examples(cell)}
    return "after it" if who else "store"


def _statements(cell: str, dialect: str, steps) -> str:
    (example,) = _examples(cell)
    try:
        count = len(steps(LONG if "…" in example else example, dialect))
    except UnsupportedError:
        return "refused"
    return f"{count} statement{'s' * (count > 1)}"
