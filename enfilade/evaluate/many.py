"""Many buildings: which folder belongs to which truth, a record of each, and the figures of all as one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from enfilade.errors import EnfiladeError, InputError

from .evaluation import Evaluation, evaluate
from .summary import AllFigures

COLUMNS: Final = (
    "building",
    "rooms F1 .5 / .7",
    "storeys",
    "area error",
    "doors P / R",
    "width error (m)",
    "closed",
    "windows P / R",
    "pairs F1",
    "objects",
    "ghosts",
)
"""Of `summary_rows`."""
_MOST_CAUSES: Final = 6
_TRUTH: Final = ".truth"
_EXPORTED: Final = ".exported"


@dataclass(frozen=True)
class Outcome:
    """What came out of one building: an evaluation, or the sentence why there is none."""

    name: str
    evaluation: Evaluation | None = None
    error: str | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return the record of the building, as `pool` and `summary_rows` take it."""
        return {"error": self.error} if self.evaluation is None else self.evaluation.to_dict()


def pair_folders(prediction: Path, truth: Path) -> dict[str, tuple[Path, Path]]:
    """Return the two folders of each building, by name.

    In a folder of predictions a building is ``NAME/`` or ``NAME.exported/``, in a folder of truths ``NAME.truth/`` or
    ``NAME/``; the two may be one folder. Each truth needs its prediction; a prediction without a truth is left out.

    Raises
    ------
    InputError
        If there are no truths.
    """
    truths = _buildings(truth, _TRUTH, _EXPORTED)
    if not truths:
        raise InputError(f"{truth} holds neither graph.json nor folders NAME.truth/ or NAME/ that do.")
    predictions = _buildings(prediction, _EXPORTED, _TRUTH)
    return {name: (predictions.get(name, prediction / name), truths[name]) for name in sorted(truths)}


def evaluate_many(folders: Mapping[str, tuple[Path, Path]]) -> Iterator[Outcome]:
    """Evaluate buildings one after the other; one that fails does not stop the others."""
    for name, (prediction, truth) in folders.items():
        try:
            yield Outcome(name, evaluate(prediction, truth))
        except EnfiladeError as error:
            yield Outcome(name, error=str(error))


def pool(records: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Return the figures of many buildings as if they were one, from what `Evaluation.to_dict` or JSON gave.

    Counts are added and errors put together, and shares, medians and calibration are made of them anew. Records with
    an ``error`` are only counted.
    """
    whole = {name: record for name, record in records.items() if not record.get("error")}
    causes: Counter[str] = Counter()
    for record in whole.values():
        causes.update(record.get("causes", {}))
    told = {"buildings": len(whole), "failed": len(records) - len(whole), "causes": dict(causes.most_common())}
    return pooled_figures(whole).to_dict() | told


def pooled_figures(records: Mapping[str, Mapping[str, Any]]) -> AllFigures:
    """Return the pooled figures themselves."""
    figures = [AllFigures.from_dict(record) for record in records.values() if not record.get("error")]
    return AllFigures.pooled(figures) if figures else AllFigures()


def summary_rows(records: Mapping[str, Mapping[str, Any]]) -> list[tuple[Any, ...]]:
    """Return a row of `COLUMNS` a building, the worst first, and the total."""
    return [*(_row(name, records[name]) for name in _ranked(records)), _row("total", pool(records))]


def cause_rows(records: Mapping[str, Mapping[str, Any]]) -> list[tuple[str, str]]:
    """Return the commonest faults of each building that has any, or why there are no figures, in the same order."""
    told = {name: records[name].get("error") or _causes(records[name]) for name in _ranked(records)}
    return [(name, said) for name, said in told.items() if said]


def _ranked(records: Mapping[str, Mapping[str, Any]]) -> list[str]:
    return sorted(records, key=lambda name: (_score(records[name]), name))


def _causes(record: Mapping[str, Any]) -> str:
    causes = list(record.get("causes", {}).items())
    more = len(causes) - _MOST_CAUSES
    said = "; ".join(f"{cause} ({count})" for cause, count in causes[:_MOST_CAUSES])
    return said + (f"; and {more} sorts more" if more > 0 else "")


def _buildings(folder: Path, suffix: str, other: str) -> dict[str, Path]:
    """Folders with a graph by the building's name; one with the suffix goes before one without."""
    found: dict[str, Path] = {}
    for path in sorted(folder.iterdir() if folder.is_dir() else ()):
        if (path / "graph.json").is_file() and not path.name.endswith(other):
            name = path.name.removesuffix(suffix)
            if name != path.name or name not in found:
                found[name] = path
    return found


def _score(record: Mapping[str, Any]) -> float:
    """How well a building went: mean of the F1 of rooms, of openings and of connected pairs, and of objects found."""
    if record.get("error"):
        return -1.0
    figures = AllFigures.from_dict(record)
    doors = figures.openings.open
    scores = [figures.rooms.f1_at_50, figures.connectivity.f1, figures.objects.found]
    scores.append(2 * doors.found / (doors.predicted + doors.true) if doors.predicted + doors.true else None)
    known = [score for score in scores if score is not None]
    return sum(known) / len(known)


def _row(name: str, record: Mapping[str, Any]) -> tuple[Any, ...]:
    if record.get("error"):
        return (name, *(None,) * (len(COLUMNS) - 1))
    figures = AllFigures.from_dict(record)
    rooms, openings = figures.rooms, figures.openings
    return (
        name,
        (rooms.f1_at_50, rooms.f1_at_70),
        figures.storeys.rooms_right,
        figures.measures.area_error,
        (openings.precision, openings.recall),
        openings.width_error_m,
        f"{openings.closed.found} of {openings.closed.true}",
        (openings.windows.precision, openings.windows.recall),
        figures.connectivity.f1,
        figures.objects.found,
        figures.objects.ghosts,
    )
