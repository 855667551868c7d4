"""Every question in docs/language.md is asked, and its answer stands below it.

Run with ENFILADE_UPDATE_DOCS=1 to write the answers anew.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

from enfilade.errors import QuestionError
from enfilade.queries import answer
from enfilade.queries.result import Result
from enfilade.schema.graph import BuildingGraph
from enfilade.stores import Store

PAGE = Path(__file__).parents[2] / "docs" / "language.md"
EXAMPLE = re.compile(r"```cypher\n(?P<question>.*?)```\n(?:\n```text\n(?P<answer>.*?)```\n)?", re.S)


def test_questions_have_the_answers_that_the_page_shows(sqlite_store: Store, hotel: BuildingGraph) -> None:
    sqlite_store.write(hotel)
    before = PAGE.read_text(encoding="utf-8")

    now = EXAMPLE.sub(lambda found: _with_answer(sqlite_store, found["question"]), before)

    if os.environ.get("ENFILADE_UPDATE_DOCS"):
        PAGE.write_text(now, encoding="utf-8")
    assert now == PAGE.read_text(encoding="utf-8")
    assert len(EXAMPLE.findall(before)) >= 25


def _with_answer(store: Store, question: str) -> str:
    try:
        shown = _table(answer(store, question))
    except QuestionError as error:
        shown = f"{error}\n"
    return f"```cypher\n{question}```\n\n```text\n{shown}```\n"


def _table(result: Result) -> str:
    cells = [result.columns, *([_cell(value) for value in row.values()] for row in result.rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in cells]
    return "\n".join([lines[0], "  ".join("-" * width for width in widths), *lines[1:]]) + "\n"


def _cell(value: object) -> str:
    return "null" if value is None else str(value)
