"""Simulates, ingests and evaluates the corpus, and prints Markdown: a row a building, each half as one, the ten worst.

``python bench/buildings.py FOLDER`` works in FOLDER: scans that are there are used again, results go to
``results.json`` one by one. The corpus is the generated buildings, the built-in one, and with ``--models`` IFC files.
The halves of the generated ones are told by `enfilade.simulate.recipes`; of the models in alphabetical order each
second one is in the check half, models of one building (the name up to the first ``-``, digits aside) in the same.
With ``--seeds`` it is the buildings generated from these, which nobody has looked at, instead.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any, Final

from enfilade.atomic import replacing
from enfilade.evaluate.many import COLUMNS, cause_rows, pooled_figures, summary_rows
from enfilade.evaluate.tables import figure_rows
from enfilade.simulate.faults import FAULTS
from enfilade.simulate.generate import name_of
from enfilade.simulate.recipes import CORPUS, HALVES, half_of, recipe_of

WORST: Final = 10
MORE_COLUMNS: Final = ("scanner faults", "scans", "points", "CPU s", "points / CPU s", "memory")


@dataclass(frozen=True)
class Building:
    """A building of the corpus: its name, its half, how bad its scans are, and what `enfilade simulate` makes it of."""

    name: str
    half: str
    level: str
    arguments: tuple[str, ...]


def generated(seed: int) -> Building:
    """Return the building that is generated from a seed, of the corpus or not."""
    return Building(name_of(seed), half_of(seed), recipe_of(seed).faults, ("--generate", str(seed)))


def corpus(models: Path | None) -> list[Building]:
    """Return the whole corpus."""
    made = [generated(seed) for seed in CORPUS]
    paths = sorted(models.glob("*.ifc")) if models is not None else []
    families = list(dict.fromkeys(family(path) for path in paths))
    halves = {name: HALVES[k % 2] for k, name in enumerate(families)}
    made.append(Building("built-in", HALVES[0], "default", ()))
    return [*made, *(Building(p.stem, halves[family(p)], "default", (str(p.resolve()),)) for p in paths)]


def family(model: Path) -> str:
    """Return what models of one building have in common in their names."""
    words = [re.sub(r"\d+", "", word) for word in re.split("[-_ ]", model.stem)]
    return "-".join([word for word in words if len(word) > 2][:2])


def enfilade(*arguments: str | Path, folder: Path) -> tuple[str, float, float]:
    """Run a command; returns its output, its CPU seconds and its peak memory in GB.

    Raises
    ------
    RuntimeError
        With the last line that it wrote, if it fails.
    """
    command = [sys.executable, "-m", "enfilade", *map(str, arguments)]
    with TemporaryFile("w+") as log:
        process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=log, text=True)
        assert process.stdout is not None
        printed = process.stdout.read()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        log.seek(0)
        said = log.read().strip().splitlines()
    if process.returncode:
        raise RuntimeError(said[-1] if said else f"{arguments[0]} stopped with status {process.returncode}")
    return printed, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1e6


def measured(building: Building, folder: Path) -> dict[str, Any]:
    """Return the record of one building: its evaluation with what ingest took, or the error."""
    about = {"half": building.half, "level": building.level}
    try:
        return about | _evaluated(building, folder)
    except RuntimeError as error:
        return about | {"error": str(error)}


def _evaluated(building: Building, folder: Path) -> dict[str, Any]:
    scans, truth = folder / f"{building.name}.e57", folder / f"{building.name}.truth"
    if not scans.exists() or not (truth / "graph.json").exists():
        enfilade("simulate", *building.arguments, "-o", scans.name, folder=folder)
    _, seconds, memory = enfilade("ingest", scans.name, folder=folder)
    asked = f"MATCH (b:Building {{id: '{building.name}'}}) RETURN b.scan_count AS scans, b.point_count AS points"
    counts = json.loads(enfilade("query", asked, "--format", "json", folder=folder)[0])[0]
    found = json.loads(enfilade("evaluate", building.name, truth.name, "--format", "json", folder=folder)[0])
    return {**counts, "cpu_s": seconds, "peak_gb": memory, **found}


def table(columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """Return a Markdown table."""
    lines = [columns, ["---"] * len(columns), *([_text(value) for value in row] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def _text(value: Any) -> str:
    if value is None:
        return "–"
    if isinstance(value, tuple):
        return " / ".join(_text(part) for part in value)
    return f"{value:.3g}" if isinstance(value, float) else str(value).replace("|", "\\|")


def report(records: dict[str, dict[str, Any]]) -> str:
    """Return everything as Markdown."""
    parts = [f"{len(records)} buildings, {_points(records.values()) / 1e6:.1f} M points\n"]
    for half in HALVES:
        members = {name: record for name, record in records.items() if record["half"] == half}
        if members:
            parts += [f"## The {half} half\n", table((*COLUMNS, *MORE_COLUMNS), _rows(members))]
            parts.append(table((f"{half}, all as one", "value"), figure_rows(pooled_figures(members))))
    parts += [f"## The {WORST} worst\n", table(("building", "faults"), cause_rows(records)[:WORST])]
    failed = [(name, record["error"]) for name, record in records.items() if "error" in record]
    if failed:
        parts += ["## Failed\n", table(("building", "why"), failed)]
    return "\n".join(parts)


def _rows(records: dict[str, dict[str, Any]]) -> list[tuple[Any, ...]]:
    return [(*row, *_cost(records.get(row[0], _total(records)))) for row in summary_rows(records)]


def _total(records: dict[str, dict[str, Any]]) -> dict[str, Any]:
    whole = [record for record in records.values() if "error" not in record]
    added = {key: sum(record[key] for record in whole) for key in ("scans", "points", "cpu_s")}
    return {"level": "", **added, "peak_gb": max((record["peak_gb"] for record in whole), default=0.0)}


def _cost(record: dict[str, Any]) -> tuple[Any, ...]:
    if "error" in record or not record["cpu_s"]:
        return record["level"], *(None,) * 5
    points, seconds = record["points"], record["cpu_s"]
    figures = (record["scans"], f"{points / 1e6:.2f} M", round(seconds), f"{points / seconds / 1e3:.0f} k")
    return record["level"], *figures, f"{record['peak_gb']:.2f} GB"


def _points(records: Iterable[dict[str, Any]]) -> int:
    return sum(int(record.get("points", 0)) for record in records)


def main(folder: Path, buildings: list[Building], workers: int) -> None:
    """Do all and print it; a building that fails does not stop the others."""
    folder.mkdir(parents=True, exist_ok=True)
    records: dict[str, dict[str, Any]] = {}
    with ThreadPoolExecutor(workers) as pool:
        waiting = {pool.submit(measured, building, folder): building.name for building in buildings}
        for done in as_completed(waiting):
            records[waiting[done]] = done.result()
            print(waiting[done], records[waiting[done]].get("error", "done"), file=sys.stderr, flush=True)
            with replacing(folder / "results.json") as unfinished:
                unfinished.write(json.dumps(records, indent=1).encode())
    print(report({building.name: records[building.name] for building in buildings}))


def chosen(arguments: argparse.Namespace) -> list[Building]:
    """Return the buildings that the options ask for."""
    if arguments.seeds:
        return [generated(seed) for seed in arguments.seeds]
    found = corpus(arguments.models)
    found = [b for b in found if arguments.half in (None, b.half) and arguments.level in (None, b.level)]
    return [b for b in found if not arguments.only or b.name in arguments.only]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--models", type=Path, help="folder of IFC models that belong to the corpus, too")
    parser.add_argument("--only", nargs="+", metavar="NAME", help="names of buildings")
    parser.add_argument("--seeds", nargs="+", type=int, help="of generated buildings, instead of the corpus")
    parser.add_argument("--half", choices=HALVES)
    parser.add_argument("--level", choices=[*FAULTS, "default"], help="of the scanner's faults")
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    main(options.folder, chosen(options), options.workers)
