"""Every command shown in README and docs runs on the demo, and prints what the page says, numbers apart."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import Demo

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from console_blocks import BLOCK, commands, run  # noqa: E402

SHOWN = [
    pytest.param(command, printed, id=f"{page.name}: {command.splitlines()[0][:60]}")
    for page in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
    for block in BLOCK.findall(page.read_text(encoding="utf-8"))
    for command, printed in commands(block)
]


def words(printed: str) -> list[str]:
    """What was printed, rules of tables and widths of columns apart, every number as 0."""
    text = re.sub(r"[━─┏┓┗┛┡┩┳┻╇┴┬┃│╈├└]+", " ", printed)
    return re.sub(r"\d[\d.,:T+-]*", "0", text.replace("-0", "0")).split()


@pytest.mark.slow
@pytest.mark.parametrize(("command", "printed"), SHOWN)
def test_shown_command_prints_what_the_page_says(demo: Demo, command: str, printed: str) -> None:
    assert words(run(command, demo.folder)) == words(printed)


@pytest.mark.slow
def test_python_of_the_readme_runs(demo: Demo) -> None:
    (snippet,) = re.findall(r"^```python\n(.*?)^```$", (ROOT / "README.md").read_text(encoding="utf-8"), re.M | re.S)
    done = subprocess.run([sys.executable, "-c", snippet], cwd=demo.folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "score" in done.stdout.splitlines()[0]
    assert "demo/o" in done.stdout


def test_readme_shows_commands() -> None:
    assert len(SHOWN) >= 8


def test_words_tell_outputs_apart() -> None:
    assert words("│ demo/r1 │ 12.5 │") == words("┃ demo/r7 ┃ 9 ┃") != words("│ demo/s1 │ 12.5 │")
