"""Runs the commands in the console blocks of a Markdown page and puts what they print below them.

``python tools/console_blocks.py FOLDER PAGE...`` runs them in FOLDER, where ``enfilade demo`` has been run, and writes
the pages anew. A block looks like this; a command may go on over lines that end in a backslash or have an open quote:

    ```console
    $ enfilade buildings
    ...
    ```
"""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

BLOCK = re.compile(r"(?<=^```console\n)(.*?)(?=^```$)", re.MULTILINE | re.DOTALL)
PROMPT = "$ "


def commands(block: str) -> Iterator[tuple[str, str]]:
    """Yield (command, what the page says that it prints) of a block."""
    lines = block.splitlines()
    while lines:
        command = lines.pop(0).removeprefix(PROMPT)
        while command.endswith("\\") or command.count("'") % 2:
            command += "\n" + lines.pop(0)
        printed = []
        while lines and not lines[0].startswith(PROMPT):
            printed.append(lines.pop(0))
        yield command, "\n".join(printed)


def run(command: str, folder: Path) -> str:
    """Return what a command prints on both outputs, without blanks at the ends of lines."""
    enfilade = f"'{sys.executable}' -m enfilade"
    script = re.sub(r"^enfilade\b", lambda _: enfilade, command)
    done = subprocess.run(
        ["bash", "-c", f"{{ {script}\n}} 2>&1"], cwd=folder, capture_output=True, text=True, check=False
    )
    return "\n".join(line.rstrip() for line in done.stdout.splitlines())


def refreshed(page: str, folder: Path) -> str:
    """Return a page with the output of every command as it is now."""

    def block(found: re.Match[str]) -> str:
        parts = (f"{PROMPT}{command}\n{run(command, folder)}".rstrip() for command, _ in commands(found[1]))
        return "\n".join(parts) + "\n"

    return BLOCK.sub(block, page)


if __name__ == "__main__":
    for name in sys.argv[2:]:
        page = Path(name)
        page.write_text(refreshed(page.read_text(encoding="utf-8"), Path(sys.argv[1])), encoding="utf-8")
