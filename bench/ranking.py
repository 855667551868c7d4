"""Figures of a ranked list: nearest neighbour, first and second tier, DCG, average precision."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FIGURES = ("nearest neighbour", "first tier", "second tier", "DCG", "mAP micro", "mAP macro")


@dataclass(frozen=True, slots=True)
class Answer:
    """One question's ranked list.

    Attributes
    ----------
    kind
        Class asked for.
    relevant
        ``(n,) bool``, best first: whether each listed object is of the class, each furnishing once.
    wanted
        How many there are to find, listed or not, at least one.
    """

    kind: str
    relevant: NDArray[np.bool_]
    wanted: int


def average_precision(answer: Answer) -> float:
    """Mean of the precision at each relevant object; what is not listed counts 0."""
    places = np.flatnonzero(answer.relevant)
    return float(((np.arange(len(places)) + 1) / (places + 1)).sum() / answer.wanted)


def discounted_gain(answer: Answer) -> float:
    """Gain 1 / log2(place), 1 for the first, of the relevant objects, over that of a perfect list (Shilane 2004)."""
    place = np.arange(max(len(answer.relevant), answer.wanted)) + 1
    gain = 1.0 / np.log2(np.maximum(place, 2))
    return float(gain[: len(answer.relevant)][answer.relevant].sum() / gain[: answer.wanted].sum())


def tier(answer: Answer, times: int) -> float:
    """Share of the wanted objects among the first ``times * wanted``."""
    return float(answer.relevant[: times * answer.wanted].sum() / answer.wanted)


def figures(answers: Sequence[Answer]) -> Mapping[str, float]:
    """Mean of each figure over the questions; macro: over the classes' means."""
    precision = np.array([average_precision(answer) for answer in answers])
    kinds = np.array([answer.kind for answer in answers])
    by_class = [float(precision[kinds == kind].mean()) for kind in np.unique(kinds)]
    values = (
        np.mean([bool(answer.relevant[:1].any()) for answer in answers]),
        np.mean([tier(answer, 1) for answer in answers]),
        np.mean([tier(answer, 2) for answer in answers]),
        np.mean([discounted_gain(answer) for answer in answers]),
        precision.mean(),
        np.mean(by_class),
    )
    return dict(zip(FIGURES, map(float, values), strict=True))


def by_class(answers: Sequence[Answer]) -> Mapping[str, float]:
    """Mean average precision of each class."""
    kinds = sorted({answer.kind for answer in answers})
    return {k: float(np.mean([average_precision(a) for a in answers if a.kind == k])) for k in kinds}
