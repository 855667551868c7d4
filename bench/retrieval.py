"""Asks with meshes and with scanned objects for their like among furniture scanned in rooms; prints Markdown tables.

``python bench/retrieval.py FOLDER [--meshes FOLDER] [--copies N] [--steps]`` furnishes simulated rooms with the
meshes, scans and ingests them (kept in FOLDER and used again), and ranks what was found. The meshes are two halves,
every other one: one to choose by, one held out; they stand in different rooms.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from furnished import Model, furnished_rooms, read_models
from numpy.typing import NDArray
from peers import Peer
from ranking import FIGURES, Answer, by_class, figures
from scanned import Pool, Target, furnishings_as_scanned, objects_as_ingested, scan_rooms
from ways import CHANGES, COMPARED, OURS, PRINTED, STEPS, Views, Way, measure

SEEDS: Final = {"develop": 1, "held out": 2}
SCANNED: Final = "furnishings as scanned"


@dataclass(frozen=True, slots=True)
class Half:
    """Half of the meshes, what was scanned of them, and what the ingest made of that."""

    name: str
    models: Sequence[Model]
    views: Sequence[Views]
    pools: Mapping[str, Pool]


@dataclass(frozen=True, slots=True)
class Question:
    """A mesh, or the target with that number, asks for its class."""

    mesh: str
    target: int = -1

    @property
    def kind(self) -> str:
        return self.mesh.split("/")[0]


def halves(folder: Path, meshes: Path, copies: int) -> list[Half]:
    """Make both halves, from what the folder has where it has it."""
    models = read_models(meshes)
    found = []
    for number, (name, seed) in enumerate(SEEDS.items()):
        own = models[number :: len(SEEDS)]
        prefix = name.replace(" ", "-")
        done = folder / f"{prefix}-{copies}.done"
        if not done.exists():
            scan_rooms(furnished_rooms(own, copies=copies, seed=seed, name=f"{prefix}-{copies}"), folder)
            done.touch()
        rooms = sorted(folder.glob(f"{prefix}-{copies}-*.npz"))
        pools = {SCANNED: furnishings_as_scanned(rooms), "as ingested": objects_as_ingested(rooms)}
        found.append(Half(name, own, [Views(model) for model in own], pools))
    return found


def by_meshes(half: Half) -> list[Question]:
    """Every mesh asks."""
    return [Question(f"{model.kind}/{model.name}") for model in half.models]


def by_objects(pool: Pool) -> list[Question]:
    """Of each furnishing the first object that is it asks."""
    first: dict[int, int] = {}
    for number, target in enumerate(pool.targets):
        if target.furnishing >= 0:
            first.setdefault(target.furnishing, number)
    return [Question(pool.targets[number].mesh, number) for number in first.values()]


def answer(question: Question, apart: NDArray[Any], pool: Pool, *, own: bool) -> Answer | None:
    """Rank as LIKE does: nearest first, and of objects that share segments the best; None if nothing is to be found."""
    asked = pool.targets[question.target] if question.target >= 0 else None
    wanted = sum(
        mesh.split("/")[0] == question.kind
        and (own or mesh != question.mesh)
        and (asked is None or number != asked.furnishing)
        for number, mesh in pool.furnishings.items()
    )
    if not wanted:
        return None
    used = set(asked.parts if asked else ())
    got: set[int] = {asked.furnishing} if asked else set()
    relevant: list[bool] = []
    for number in np.argsort(apart, kind="stable").tolist():
        target: Target = pool.targets[number]
        same = question.mesh in (target.mesh, target.mostly)
        if (same and not own) or used.intersection(target.parts):
            continue
        used.update(target.parts)
        relevant.append(target.kind == question.kind and target.furnishing not in got)
        got.add(target.furnishing)
    return Answer(question.kind, np.array(relevant, dtype=np.bool_), wanted)


def answers(questions: Sequence[Question], apart: NDArray[Any], pool: Pool, *, own: bool = False) -> list[Answer]:
    """Answers of the questions that have something to find."""
    found = [answer(question, row, pool, own=own) for question, row in zip(questions, apart, strict=True)]
    return [each for each in found if each is not None]


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a Markdown table."""
    for row in (head, ["---"] * len(head), *rows):
        print("|", " | ".join(row), "|", flush=True)
    print()


def compare(half: Half, pool_name: str) -> dict[str, list[Answer]]:
    """Print all figures of all peers on one pool; returns the answers to the meshes."""
    pool, rows, kept = half.pools[pool_name], [], {}
    questions, objects = by_meshes(half), by_objects(pool)
    for name, way in COMPARED.items():
        apart, between = measure(way, half.views, pool.targets, [question.target for question in objects])
        kept[name] = answers(questions, apart, pool)
        shown = [f"{value:.3f}" for value in figures(kept[name]).values()]
        rest = (
            answers(questions, apart, pool, own=True),
            answers(objects, between, pool),
            answers(objects, between, pool, own=True),
        )
        rows.append([name, *shown, *(f"{figures(each)['mAP macro']:.3f}" for each in rest)])
    many, found = len(pool.targets), len(pool.furnishings)
    print(f"**{half.name}, {pool_name}**: {many} objects, {found} furnishings, {len(questions)} meshes ask\n")
    table(["way", *FIGURES, "own scans in", "objects ask", "objects ask, own in"], rows)
    ratio = figures(kept[OURS])["mAP macro"] / figures(kept[PRINTED])["mAP macro"]
    print(f"Enfilade is at {ratio:.2f} times Eqs. 8-11 as printed (mAP macro).\n")
    return kept


def ablate(found: Sequence[Half], title: str, ways: Mapping[str, Way | Peer]) -> None:
    """Print macro mAP of some ways on the furnishings as scanned, which no segmentation blurs, both halves."""
    rows = []
    for name, way in ways.items():
        row = [name]
        for half in found:
            pool = half.pools[SCANNED]
            apart = measure(way, half.views, pool.targets, [0])[0]
            row.append(f"{figures(answers(by_meshes(half), apart, pool))['mAP macro']:.3f}")
        rows.append(row)
    table([title, *(half.name for half in found)], rows)


def main() -> None:
    """Run it all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--meshes", type=Path, default=Path(__file__).parents[2] / "shared" / "data" / "meshes")
    parser.add_argument("--copies", type=int, default=4, help="scans of each mesh")
    parser.add_argument("--steps", action="store_true", help="print the steps from the paper to ours, and changes")
    given = parser.parse_args()
    found = halves(given.folder, given.meshes, given.copies)
    for half in found:
        for name in half.pools:
            kept = compare(half, name)
            classes = by_class(kept[OURS])
            table(["class", *classes], [["Enfilade", *(f"{value:.2f}" for value in classes.values())]])
    if given.steps:
        ablate(found, "steps", STEPS)
        ablate(found, "changes", CHANGES)


if __name__ == "__main__":
    main()
