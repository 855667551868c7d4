"""The compiled text of questions, kept in files that people read: tests/golden/*.txt.

A changed compiler shows here as a changed file. Run with ENFILADE_UPDATE_GOLDEN=1 to write the files anew, and read
the difference before you commit it.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from enfilade.queries import answer
from enfilade.stores import Store

GOLDEN = sorted((Path(__file__).parents[1] / "golden").glob("*.txt"))
PARAMETERS = {"basin": "object:hotel/o4", "start": "O'", "x": 14}


@pytest.mark.parametrize("file", GOLDEN, ids=[file.stem for file in GOLDEN])
def test_compiled_text(sqlite_store: Store, file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = file.read_text(encoding="utf-8")
    question = before.split("\n\n")[0].strip()
    parts = [question]
    for dialect in ("sql", "cypher"):
        monkeypatch.setattr(type(sqlite_store), "dialect", dialect)
        explanation = answer(sqlite_store, question, parameters=PARAMETERS, explain_only=True).explanation
        parts += [f"-- {dialect}", *map(str, explanation.steps)]
    now = "\n\n".join(parts) + "\n"

    if os.environ.get("ENFILADE_UPDATE_GOLDEN"):
        file.write_text(now, encoding="utf-8")
    assert now == file.read_text(encoding="utf-8")
