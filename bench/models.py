"""Simulates, ingests and evaluates building models, and prints a Markdown table of how well it went.

``python bench/models.py FOLDER [MODEL...]`` works in FOLDER; without MODEL the built-in building is taken. Scans that
are there already are used again.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, Final

COLUMNS: Final = (
    "model",
    "points",
    "rooms F1 .5 / .7",
    "ARI",
    "storeys right",
    "area, floor error",
    "doors P / R",
    "width error",
    "room pairs F1",
    "objects",
    "time, points/s",
    "memory",
)


def enfilade(*arguments: str | Path, folder: Path) -> tuple[str, float, float]:
    """Run a command; returns its output, its seconds and its peak memory in GB."""
    command = [sys.executable, "-m", "enfilade", *map(str, arguments)]
    start = time.perf_counter()
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        assert process.stdout is not None
        printed = process.stdout.read()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"failed: {' '.join(command)}")
    return printed, time.perf_counter() - start, usage.ru_maxrss / 1e6


def measured(model: Path | None, folder: Path) -> list[str]:
    """Return one row of the table."""
    name = "built-in" if model is None else model.stem
    scans, truth = folder / f"{name}.e57", folder / f"{name}.truth"
    if not scans.exists() or not truth.exists():
        enfilade("simulate", *([model.resolve()] if model else []), "-o", scans.name, folder=folder)
    _, seconds, memory = enfilade("ingest", scans.name, folder=folder)
    exported = folder / f"{name}.exported"
    enfilade("export", name, "-o", exported.name, folder=folder)
    building = json.loads((exported / "graph.json").read_text(encoding="utf-8"))["nodes"][0]
    found = json.loads(enfilade("evaluate", exported.name, truth.name, "--format", "json", folder=folder)[0])
    return row(name, building["point_count"], found, seconds, memory)


def row(name: str, points: int, found: dict[str, Any], seconds: float, memory: float) -> list[str]:
    """Return the figures of one building as texts."""
    rooms, measures, openings = found["rooms"], found["measures"], found["openings"]
    return [
        name,
        f"{points / 1e6:.1f} M",
        f"{rooms['f1_at_50']:.2f} / {rooms['f1_at_70']:.2f}",
        f"{rooms['ari']:.2f}",
        f"{100 * found['storeys']['rooms_right']:.0f} %",
        f"{100 * measures['area_error']:.1f} %, {1000 * measures['floor_error_m']:.1f} mm",
        f"{openings['precision']:.2f} / {openings['recall']:.2f}",
        f"{1000 * openings['width_error_m']:.0f} mm",
        f"{found['connectivity']['f1']:.2f}",
        f"{found['objects']['found']:.2f}",
        f"{seconds:.0f} s, {points / seconds / 1e6:.2f} M",
        f"{memory:.1f} GB",
    ]


def main(folder: Path, models: list[Path]) -> None:
    """Print the table, a row as soon as it is known."""
    folder.mkdir(parents=True, exist_ok=True)
    print("|", " | ".join(COLUMNS), "|")
    print("|", " | ".join("---" for _ in COLUMNS), "|")
    chosen: list[Path | None] = [*models] or [None]
    for model in chosen:
        print("|", " | ".join(measured(model, folder)), "|", flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), [Path(name) for name in sys.argv[2:]])
