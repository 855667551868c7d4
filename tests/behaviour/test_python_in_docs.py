"""Every piece of Python in docs/language.md runs, one after another, and prints what stands below it.

Run with ENFILADE_UPDATE_DOCS=1 to write what is printed anew.
"""

from __future__ import annotations

import io
import os
import re
from contextlib import redirect_stdout
from pathlib import Path

import pytest

from enfilade.schema.graph import BuildingGraph
from enfilade.stores import open_store

PAGE = Path(__file__).parents[2] / "docs" / "language.md"
EXAMPLE = re.compile(r"```python\n(?P<code>.*?)```\n\n```text\n.*?```\n", re.S)


def test_python_prints_what_the_page_shows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, hotel: BuildingGraph
) -> None:
    monkeypatch.chdir(tmp_path)
    with open_store("sqlite:enfilade.db") as store:
        store.write(hotel)
    before = PAGE.read_text(encoding="utf-8")

    now = EXAMPLE.sub(lambda found: f"```python\n{found['code']}```\n\n```text\n{printed(found['code'])}```\n", before)

    if os.environ.get("ENFILADE_UPDATE_DOCS"):
        PAGE.write_text(now, encoding="utf-8")
    assert now == PAGE.read_text(encoding="utf-8")
    assert len(EXAMPLE.findall(before)) == before.count("```python")


def printed(code: str) -> str:
    out = io.StringIO()
    with redirect_stdout(out):
        exec(compile(code, str(PAGE), "exec"), {"__name__": "__main__"})  # the page is ours
    return out.getvalue()
