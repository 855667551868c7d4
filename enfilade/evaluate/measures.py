"""Storeys, areas and elevations of the rooms that were found."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.optimize import linear_sum_assignment

from .faults import Fault
from .figures import Figures, middle, ninth_decile, share
from .matching import Matching
from .sides import Side


@dataclass(frozen=True, slots=True)
class StoreyFigures(Figures):
    """Storeys, and on which of them the matched rooms are.

    Attributes
    ----------
    true, predicted
        Numbers of storeys that have rooms.
    placed, right
        Matched rooms with a storey on both sides, and those on their true one.
    misplaced
        Names of the true rooms that are not.
    """

    DERIVED: ClassVar[tuple[str, ...]] = ("rooms_right",)

    true: int = 0
    predicted: int = 0
    placed: int = 0
    right: int = 0
    misplaced: tuple[str, ...] = ()

    @property
    def rooms_right(self) -> float | None:
        """Share of matched rooms on their true storey."""
        return share(self.right, self.placed)


@dataclass(frozen=True, slots=True)
class MeasureFigures(Figures):
    """Errors of the measures of matched rooms that a scan stands in.

    Attributes
    ----------
    area_errors
        Of areas, relative to the true one.
    floor_errors_m, height_errors_m
        Of floor elevations and clear heights.
    """

    DERIVED: ClassVar[tuple[str, ...]] = (
        "area_error",
        "area_error_at_90",
        "floor_error_m",
        "floor_error_at_90_m",
        "height_error_m",
    )

    area_errors: tuple[float, ...] = ()
    floor_errors_m: tuple[float, ...] = ()
    height_errors_m: tuple[float, ...] = ()

    @property
    def area_error(self) -> float | None:
        """Median relative error of the areas."""
        return middle(self.area_errors)

    @property
    def area_error_at_90(self) -> float | None:
        """90th percentile of the relative error of the areas."""
        return ninth_decile(self.area_errors)

    @property
    def floor_error_m(self) -> float | None:
        """Median error of the floor elevations."""
        return middle(self.floor_errors_m)

    @property
    def floor_error_at_90_m(self) -> float | None:
        """90th percentile of the error of the floor elevations."""
        return ninth_decile(self.floor_errors_m)

    @property
    def height_error_m(self) -> float | None:
        """Median error of the clear heights."""
        return middle(self.height_errors_m)


def match_storeys(matching: Matching) -> dict[int, int]:
    """Return the predicted storey that stands for each true one: one to one, with the most rooms on the right one."""
    placed = [(there, here) for _, there, here in _placed(matching)]
    true, predicted = (sorted({pair[k] for pair in placed}) for k in (0, 1))
    counts = np.zeros((len(true), len(predicted)))
    for there, here in placed:
        counts[true.index(there), predicted.index(here)] += 1
    rows, columns = linear_sum_assignment(counts, maximize=True)
    return {true[row]: predicted[column] for row, column in zip(rows, columns, strict=True) if counts[row, column]}


def storey_figures(matching: Matching, same: dict[int, int]) -> StoreyFigures:
    """Count matched rooms on their true storey."""
    wrong = _misplaced(matching, same)
    placed = len(_placed(matching))
    return StoreyFigures(
        true=len(set(matching.truth.storeys.values())),
        predicted=len(set(matching.prediction.storeys.values())),
        placed=placed,
        right=placed - len(wrong),
        misplaced=tuple(matching.truth.name(room) for room in wrong),
    )


def storey_faults(matching: Matching, same: dict[int, int]) -> Iterator[Fault]:
    """Yield the rooms on another storey than their true one."""
    truth, prediction = matching.truth, matching.prediction
    for room in _misplaced(matching, same):
        here, there = prediction.storeys[matching.predicted_of[room]], truth.storeys[room]
        wanted = same.get(there)
        why = f"on s{here} instead of {f's{wanted}' if wanted is not None else 'a storey of its own'}"
        others = prediction.ids((matching.predicted_of[room],))
        yield Fault("room", "misplaced", "truth", truth.id(room), truth.name(room), "storey", why, others=others)


def measure_figures(matching: Matching) -> MeasureFigures:
    """Compare areas, floor elevations and heights of the matched rooms that have both."""
    return MeasureFigures(
        tuple(abs(found / true - 1) for true, found in _both(matching, "area") if true > 0),
        tuple(abs(found - true) for true, found in _both(matching, "floor_elevation")),
        tuple(abs(found - true) for true, found in _both(matching, "height")),
    )


def _placed(matching: Matching) -> list[tuple[int, int, int]]:
    """Return the matched true rooms with their true and their predicted storey."""
    there, here = matching.truth.storeys, matching.prediction.storeys
    pairs = [pair[:2] for pair in matching.pairs]
    return [(true, there[true], here[found]) for true, found in pairs if true in there and found in here]


def _misplaced(matching: Matching, same: dict[int, int]) -> list[int]:
    return sorted(true for true, there, here in _placed(matching) if same.get(there) != here)


def _both(matching: Matching, property: str) -> Iterable[tuple[float, float]]:
    truth: Side = matching.truth
    for true, predicted, _ in matching.pairs:
        there, here = truth.value(true, property), matching.prediction.value(predicted, property)
        if true in truth.scanned and there is not None and here is not None:
            yield there, here
