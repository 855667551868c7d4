"""Fits the weights of the evidence for openings, and shows how well they are calibrated.

``python bench/confidence.py FOLDER`` ingests every generated building of FOLDER (NAME-SEED.e57 with NAME-SEED.truth
beside it), asks which openings are there, fits the weights on the develop half and prints them, and what both halves
say of them.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, Final
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

from enfilade.clouds import read_cloud
from enfilade.evaluate.evaluation import evaluate_graphs
from enfilade.ingest.openings import find_openings
from enfilade.ingest.pipeline import ingest
from enfilade.ingest.records import Opening
from enfilade.schema.exchange import read_graph
from enfilade.simulate.generate import name_of
from enfilade.simulate.recipes import CORPUS, half_of

EVIDENCE: Final = {
    "through_wall": ("rays", "framed", "filled", "both_sides", "glazed", "agreed"),
    "closed": ("framed", "leaf", "passed", "room_behind", "glazed"),
    "outside": ("framed", "leaf", "passed", "glazed"),
}
BINS: Final = (0.0, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 1.01)
STRENGTH: Final = 1.0
"""Of the prior that holds weights near zero."""


def judged(scans: Path) -> Iterator[tuple[Opening, bool]]:
    """Yield the openings of one building that can be judged, and whether each is there."""
    found: list[Opening] = []

    def remember(*arguments: Any) -> tuple[Opening, ...]:
        found.extend(find_openings(*arguments))
        return tuple(found)

    with patch("enfilade.ingest.pipeline.find_openings", remember):
        building = ingest([scans], building="b")
    truth = scans.with_suffix(".truth")
    verdicts = evaluate_graphs(
        building.graph, building.cloud, read_graph(truth / "graph.json"), read_cloud(truth / "cloud.ply")
    ).comparison.verdicts
    for verdict in (verdicts.doors, verdicts.outside, verdicts.windows):
        right = [hole for hole, _ in verdict.pairs]
        for hole in (*right, *verdict.invented):
            yield found[int(hole.id.rsplit("/p", 1)[1])], hole in right


def model_of(opening: Opening) -> str:
    """Which weights an opening's confidence is made with."""
    if "rays" in opening.evidence:
        return "through_wall"
    return "closed" if opening.kind == "door" else "outside"


def fitted(evidence: NDArray[np.float64], right: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weights of a logistic model, the constant first, by Newton's method."""
    weights = np.zeros(evidence.shape[1])
    prior = np.where(np.arange(len(weights)) == 0, 0.01, STRENGTH)
    for _ in range(50):
        said = 1.0 / (1.0 + np.exp(-evidence @ weights))
        slope = evidence.T @ (said - right) + prior * weights
        weights -= np.linalg.solve((evidence.T * (said * (1.0 - said))) @ evidence + np.diag(prior), slope)
    return weights


def show(half: str, said: NDArray[np.float64], right: NDArray[np.float64]) -> None:
    """Print a line a bin: how many, what was said, what is so."""
    for low, high in pairwise(BINS):
        inside = (said >= low) & (said < high)
        if inside.any():
            print(f"| {half} | {low:.2f} | {inside.sum()} | {said[inside].mean():.2f} | {right[inside].mean():.2f} |")


def main(folder: Path) -> None:
    """Fit on the develop half, show both."""
    rows: list[tuple[str, Opening, bool]] = []
    for scans in sorted(folder.glob("*.e57")):
        seed = scans.stem.rsplit("-", 1)[-1]
        if seed.isdigit() and int(seed) in CORPUS and scans.stem == name_of(int(seed)):
            half = half_of(int(seed))
            rows += [(half, opening, right) for opening, right in judged(scans) if opening.orientation == "horizontal"]
    for model, names in EVIDENCE.items():
        of_half = {half: _table(rows, half, model, names) for half in ("develop", "check")}
        weights = fitted(*of_half["develop"])
        print(f"\n{model}:", dict(zip(("constant", *names), weights.round(2).tolist(), strict=True)), "\n")
        print("| half | from | openings | said | there |\n|---|---|---|---|---|")
        for half, (evidence, right) in of_half.items():
            show(half, 1.0 / (1.0 + np.exp(-evidence @ weights)), right)


def _table(
    rows: Sequence[tuple[str, Opening, bool]], half: str, model: str, names: Sequence[str]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    some = [(opening, right) for of, opening, right in rows if of == half and model_of(opening) == model]
    evidence = [[1.0, *(opening.evidence[name] for name in names)] for opening, _ in some]
    return np.array(evidence).reshape(-1, len(names) + 1), np.array([float(right) for _, right in some])


if __name__ == "__main__":
    main(Path(sys.argv[1]))
