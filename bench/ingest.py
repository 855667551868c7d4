"""Measures ingest: time, CPU time and memory of every stage, growth with points and buildings, Open3D's chain, bars.

``python bench/ingest.py FOLDER [SCANS...]`` works in FOLDER, prints Markdown and writes ``ingest.json`` there. SCANS
are the files of one building; without them the built-in one is scanned. Every run is a process of its own, so that
its times begin with its start and its peak of memory is its own. Times depend on what else runs on the machine, CPU
times much less. ``--only stages`` leaves out growth and chain, which take most of the time.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, Final

from rewritten_scans import Rewriting, rewrite

PARTS: Final = ("stages", "points", "buildings", "chain", "many")
MANY_POINTS: Final = 100_000_000
"""So many points, of the same building and in the same voxels, are to need no more memory."""
LEAST_RATE: Final = 0.5
MOST_OF_CHAIN: Final = 0.25
MOST_GB: Final = 4.0
MORE_POINTS: Final = {
    "a quarter of the points": Rewriting(share=0.25),
    "half the points": Rewriting(share=0.5),
    "as scanned": Rewriting(),
    "scanned twice": Rewriting(again=2),
    "scanned four times": Rewriting(again=4),
}
MORE_BUILDINGS: Final = {
    "one building": Rewriting(),
    "two buildings": Rewriting(copies=2),
    "four buildings": Rewriting(copies=4),
}

Run = dict[str, Any]


# --- runs ------------------------------------------------------------------------------------------------------


def child(script: str, *arguments: str | Path) -> Run:
    """Run a script beside this one in a process of its own; what it prints is JSON."""
    command = [sys.executable, str(Path(__file__).with_name(script)), *map(str, arguments)]
    printed: Run = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)
    return printed


def built_in(folder: Path) -> list[Path]:
    """Scan the built-in building, if that is not done yet."""
    scans = folder / "built-in.e57"
    if not scans.exists():
        subprocess.run([sys.executable, "-m", "enfilade", "simulate", "-o", scans], check=True)
    return [scans]


def measured(folder: Path, scans: Sequence[Path], times: int = 1) -> Run:
    """Ingest once in a process of its own, the scans read so often."""
    for old in folder.glob("measured.db*"):
        old.unlink()
    return child("measured_ingest.py", folder, str(times), *scans)


def grown(folder: Path, scans: list[Path], sizes: dict[str, Rewriting], run: Run) -> dict[str, Run]:
    """Ingest the scans as they are rewritten in several ways, by what each is called; `run` is that of the scans."""
    runs = {}
    for name, how in sizes.items():
        if how == Rewriting():
            runs[name] = run
            continue
        file = folder / f"{scans[0].stem}, {name}.e57"
        rewrite(scans, file, how)
        runs[name] = measured(folder, [file])
    return runs


# --- tables ----------------------------------------------------------------------------------------------------


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> Iterator[str]:
    """Yield the lines of a Markdown table, numbers to the right."""
    yield f"| {' | '.join(head)} |"
    yield f"| --- |{' ---: |' * (len(head) - 1)}"
    for row in rows:
        yield f"| {' | '.join(row)} |"
    yield ""


def total(run: Run, what: str) -> float:
    """Sum over the stages."""
    return float(sum(stage[what] for stage in run["stages"]))


def peak(run: Run) -> float:
    """Most memory that any stage held, GB."""
    return float(max(stage["peak_gb"] for stage in run["stages"]))


def by_stage(run: Run) -> Iterator[str]:
    """Yield the table of one run's stages."""
    points = run["points"] / 1e6
    whole = {"stage": "**all**", "wall_s": total(run, "wall_s"), "cpu_s": total(run, "cpu_s"), "peak_gb": peak(run)}
    yield f"{points:.1f} M points in {run['scans']} scans, {run['thinned'] / 1e6:.1f} M thinned, {run['rooms']} rooms"
    yield ""
    head = ("stage", "wall, s", "M points / s", "CPU, s", "CPU s / M points", "peak, GB")
    yield from table(head, (_stage_row(stage, points) for stage in [*run["stages"], whole]))


def _stage_row(stage: Run, points: float) -> list[str]:
    wall, cpu = stage["wall_s"], stage["cpu_s"]
    rate = f"{points / wall:.2f}" if wall > 0.0 else ""
    return [stage["stage"], f"{wall:.2f}", rate, f"{cpu:.2f}", f"{cpu / points:.2f}", f"{stage['peak_gb']:.2f}"]


def by_size(runs: dict[str, Run]) -> Iterator[str]:
    """Yield a table with a row a run."""
    head = ("what", "points", "thinned", "scans", "rooms", "wall, s", "M points / s", "CPU s / M points", "peak, GB")
    yield from table(head, (_size_row(name, run) for name, run in runs.items()))


def _size_row(name: str, run: Run) -> list[str]:
    points, wall, cpu = run["points"] / 1e6, total(run, "wall_s"), total(run, "cpu_s")
    counts = [f"{points:.1f} M", f"{run['thinned'] / 1e6:.2f} M", str(run["scans"]), str(run["rooms"])]
    return [name, *counts, f"{wall:.1f}", f"{points / wall:.2f}", f"{cpu / points:.2f}", f"{peak(run):.2f}"]


def growth(runs: dict[str, Run]) -> Iterator[str]:
    """Yield a table of the stages' CPU seconds, a column a run, and how often the first the last is."""
    names, every = list(runs), list(runs.values())
    times = f"times ({every[-1]['points'] / every[0]['points']:.1f} is linear)"
    yield from table(("stage", *(f"{name}, CPU s" for name in names), times), _growth_rows(every))


def _growth_rows(runs: list[Run]) -> Iterator[list[str]]:
    for stages in zip(*(run["stages"] for run in runs), strict=True):
        seconds = [stage["cpu_s"] for stage in stages]
        yield [stages[0]["stage"], *(f"{cpu:.2f}" for cpu in seconds), f"{seconds[-1] / max(seconds[0], 0.01):.1f}"]


def beside(chain: Run, run: Run) -> Iterator[str]:
    """Yield the table of Open3D's chain beside a run."""
    points, cpu, own = chain["points"] / 1e6, sum(step["cpu_s"] for step in chain["steps"]), total(run, "cpu_s")
    rows = [(step["step"], f"{step['cpu_s']:.2f}") for step in chain["steps"]]
    rows += [("**the chain**, without reading", f"{cpu:.2f}"), ("**ingest**, from start to store", f"{own:.2f}")]
    yield from table(("what", "CPU, s"), rows)
    yield f"The chain does {1000 * points / cpu:.0f} thousand points a CPU second, ingest {1000 * points / own:.0f}: "
    yield f"ingest takes {own / cpu:.2f} of its CPU time."
    yield ""


def bars(found: Run) -> Iterator[str]:
    """Yield the table of what was asked for and what was measured."""
    run = found["run"]
    rate, points = run["points"] / 1e6 / total(run, "wall_s"), f"{run['points'] / 1e6:.1f} M points"
    rows = [
        ("M points / s from start to store", f"at least {LEAST_RATE}", f"{rate:.2f}"),
        (
            f"GB for {points} in {run['scans']} scans, {run['rooms']} rooms",
            f"at most {MOST_GB:.0f}",
            f"{peak(run):.2f}",
        ),
    ]
    if "chain" in found:
        share = total(run, "cpu_s") / sum(step["cpu_s"] for step in found["chain"]["steps"])
        rows.append(("share of the CPU time of Open3D's chain", f"at most {MOST_OF_CHAIN}", f"{share:.2f}"))
    if "many" in found:
        many = found["many"]
        what = f"memory for {many['points'] / 1e6:.0f} M points to that for {points}"
        rows.append((what, "1", f"{peak(many) / peak(run):.2f}"))
    yield from table(("what", "asked for", "measured"), rows)


# --- all of it -------------------------------------------------------------------------------------------------


def report(folder: Path, scans: list[Path], parts: Sequence[str]) -> Iterator[str]:
    """Measure and yield lines of Markdown as they are known; write the JSON at the end."""
    found: Run = {"scans": [scan.name for scan in scans], "cpus": os.cpu_count(), "machine": platform.platform()}
    yield f"# Ingest of {', '.join(scan.name for scan in scans)} on {found['cpus']} CPUs\n"
    found["run"] = measured(folder, scans)
    yield from by_stage(found["run"])
    if "points" in parts:
        yield "## The same building, more points\n"
        found["points"] = grown(folder, scans, MORE_POINTS, found["run"])
        yield from by_size(found["points"])
    if "buildings" in parts:
        yield "## More buildings at the same density\n"
        found["buildings"] = grown(folder, scans, MORE_BUILDINGS, found["run"])
        yield from by_size(found["buildings"])
        yield from growth(found["buildings"])
    if "chain" in parts:
        yield "## Open3D's chain on the same scans\n"
        found["chain"] = child("open3d_chain.py", *scans)
        yield from beside(found["chain"], found["run"])
    if "many" in parts:
        yield "## The same building scanned again and again, in the same voxels\n"
        times = -(-MANY_POINTS // found["run"]["points"])
        found["many"] = measured(folder, scans, times)
        yield from by_size({"as scanned": found["run"], f"{times} times": found["many"]})
        yield from growth({"as scanned": found["run"], f"{times} times": found["many"]})
    yield "## Bars\n"
    yield from bars(found)
    (folder / "ingest.json").write_text(json.dumps(found, indent=1), encoding="utf-8")


def main() -> None:
    """Read the command line and print the report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("scans", nargs="*", type=Path)
    parser.add_argument("--compiled", action="store_true", help="All is compiled already: leave out the run before.")
    parser.add_argument("--only", action="append", choices=PARTS, help="measure only this (may be given again)")
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    scans = arguments.scans or built_in(arguments.folder)
    if not arguments.compiled:
        measured(arguments.folder, scans)
    for line in report(arguments.folder, scans, arguments.only or PARTS):
        print(line, flush=True)


if __name__ == "__main__":
    main()
