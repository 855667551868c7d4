"""The reference page of the graph is what the definition gives."""

from __future__ import annotations

from pathlib import Path

import pytest

from enfilade.schema.definition import EDGE_TYPES, NODE_TYPES
from enfilade.schema.reference import main, reference

PAGE = Path(__file__).parents[2] / "docs" / "graph.md"


def test_the_page_is_current() -> None:
    assert PAGE.read_text(encoding="utf-8") == reference()


def test_the_page_names_everything() -> None:
    page = reference()
    for node in NODE_TYPES:
        assert all(f"| `{property.name}` |" in page for property in node.properties)
    for edge in EDGE_TYPES:
        assert f"| `{edge.type}` |" in page


def test_the_command_writes_and_checks(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = tmp_path / "graph.md"
    assert main(["--check", str(page)]) == 1
    assert "make docs" in capsys.readouterr().err
    assert main([str(page)]) == 0
    assert main(["--check", str(page)]) == 0
