"""The same surface in two clouds: which labels truth and prediction give it."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from enfilade.clouds import LabelledCloud
from enfilade.errors import InputError

F64 = NDArray[np.float64]
I32 = NDArray[np.int32]
I64 = NDArray[np.int64]

CELL_M = 0.02
"""One point a cell of this side is compared, so that surface counts and not the nearness of a scanner."""
REACH_M = 0.05
"""A predicted point farther away than this says nothing about a true one: walls are thicker."""
LEAST_COVERED = 0.5
"""Where less of the true surface has a predicted point near it, one of the clouds may be shifted."""
_WIDEST_CELLS = 1 << 21
_SAMPLE = 20_000
_SURE = 0.7


@dataclass(frozen=True, slots=True)
class Cells:
    """One true point a cell, with the labels of the nearest predicted point.

    Attributes
    ----------
    positions
        ``(C, 3) float64``, metres.
    true_room, predicted_room, true_object, predicted_object, predicted_plane
        ``(C,) int32``, -1 for none.
    structure
        ``(C,)`` whether the truth says wall, floor, ceiling or the like.
    covered
        Share of the cells that have a predicted point near them.
    """

    positions: F64
    true_room: I32
    predicted_room: I32
    true_object: I32
    predicted_object: I32
    predicted_plane: I32
    structure: NDArray[np.bool_]
    covered: float


Counted = tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class Overlap:
    """How many cells each true and each predicted label has, and each pair of them; -1 is a label like others."""

    true: dict[int, int]
    predicted: dict[int, int]
    both: dict[tuple[int, int], int]

    @cached_property
    def on_true(self) -> dict[int, Counted]:
        """Predicted labels on each true one, and how many cells each, the most first."""
        return _grouped((true, predicted, count) for (true, predicted), count in self.both.items())

    @cached_property
    def on_predicted(self) -> dict[int, Counted]:
        """True labels under each predicted one, and how many cells each, the most first."""
        return _grouped((predicted, true, count) for (true, predicted), count in self.both.items())

    def iou(self, true: int, predicted: int) -> float:
        """Intersection over union of two labels."""
        shared = self.both.get((true, predicted), 0)
        union = self.true.get(true, 0) + self.predicted.get(predicted, 0) - shared
        return shared / union if union else 0.0


def correspond(
    prediction: LabelledCloud,
    truth: LabelledCloud,
    *,
    rooms: tuple[Collection[int], Collection[int]],
    objects: tuple[Collection[int], Collection[int]],
) -> Cells:
    """Give each cell of the true cloud the labels of the nearest predicted point.

    Parameters
    ----------
    rooms, objects
        Numbers that the prediction's and the truth's graph know; other labels count as none.

    Raises
    ------
    InputError
        If the true cloud is empty, or the predicted one lies elsewhere; it says by how much it is shifted where it is
        the same building.
    """
    kept, found = nearest_by_cell(prediction.positions, truth.positions)
    covered = float((found >= 0).mean()) if len(kept) else 0.0
    if covered < LEAST_COVERED:
        _refuse(prediction.positions, truth.positions, covered)

    def predicted(labels: I32) -> I32:
        return np.where(found >= 0, labels[found], -1).astype(np.int32)

    return Cells(
        truth.positions[kept],
        _known(truth.room[kept], rooms[1]),
        _known(predicted(prediction.room), rooms[0]),
        _known(truth.object[kept], objects[1]),
        _known(predicted(prediction.object), objects[0]),
        predicted(prediction.plane),
        _structure(truth)[kept],
        covered,
    )


def overlap(true: I32, predicted: I32) -> Overlap:
    """Count labels and pairs of labels."""
    width = int(predicted.max(initial=-1)) + 2
    keys, counts = np.unique((true.astype(np.int64) + 1) * width + predicted + 1, return_counts=True)
    pairs = zip((keys // width - 1).tolist(), (keys % width - 1).tolist(), strict=True)
    both = dict(zip(pairs, counts.tolist(), strict=True))
    return Overlap(_counts(true), _counts(predicted), both)


def nearest_by_cell(prediction: F64, truth: F64) -> tuple[I64, I64]:
    """Return the first true point of each cell, and the nearest predicted point to it, -1 where none is in reach.

    Most true points have a predicted one in their own cell, and a walk along both sorted lists of cells finds the
    nearest there. The others look through the cells within reach, which lie in short runs of the sorted list.
    """
    if len(truth) == 0:
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    low = np.nanmin(truth, axis=0) - 2 * REACH_M
    extent = np.floor((np.nanmax(truth, axis=0) + 2 * REACH_M - low) / CELL_M).astype(np.int64) + 1
    if extent.max() > _WIDEST_CELLS:
        raise InputError(f"The true cloud is {extent.max() * CELL_M / 1000:.0f} km wide; take away its stray points.")
    keys, order = _sorted_keys(truth, low, extent)
    starts = np.flatnonzero(np.diff(keys, prepend=-1))
    kept, keys = np.minimum.reduceat(order, starts), keys[starts]
    other_keys, other_order = _sorted_keys(prediction, low, extent)
    points = truth[kept]
    found = _nearest_in_cell(points, keys, prediction, other_keys, other_order)
    left = np.flatnonzero(found < 0)
    _look_around(found, left, points, keys, prediction, other_keys, other_order, extent)
    return kept, found


def _sorted_keys(points: F64, low: F64, extent: I64) -> tuple[I64, I64]:
    """Sorted numbers of the cells of the points that lie in the box, and which points these are."""
    keys = _keys(points, low, extent)
    order = np.argsort(keys)
    order = order[np.searchsorted(keys, 0, sorter=order) :]
    return keys[order], order.astype(np.int64, copy=False)


@njit(cache=True)
def _keys(points: F64, low: F64, extent: I64) -> I64:  # pragma: no cover
    """``(N,)`` number of the cell of each point, -1 outside the box; neighbours along z have neighbouring numbers."""
    keys = np.full(len(points), -1, dtype=np.int64)
    for point in range(len(points)):
        x = np.floor((points[point, 0] - low[0]) / CELL_M)
        y = np.floor((points[point, 1] - low[1]) / CELL_M)
        z = np.floor((points[point, 2] - low[2]) / CELL_M)
        if 0 <= x < extent[0] and 0 <= y < extent[1] and 0 <= z < extent[2]:
            keys[point] = (int(x) * extent[1] + int(y)) * extent[2] + int(z)
    return keys


@njit(cache=True)
def _nearest_in_cell(points: F64, keys: I64, others: F64, other_keys: I64, order: I64) -> I64:  # pragma: no cover
    """Nearest of the other points in the same cell, the first of equals; `order` is where each sorted key is from."""
    found = np.full(len(keys), -1, dtype=np.int64)
    place = 0
    for cell in range(len(keys)):
        while place < len(other_keys) and other_keys[place] < keys[cell]:
            place += 1
        best = np.inf
        while place < len(other_keys) and other_keys[place] == keys[cell]:
            other = order[place]
            distance = 0.0
            for axis in range(3):
                distance += (others[other, axis] - points[cell, axis]) ** 2
            if distance < best or (distance == best and other < found[cell]):
                best, found[cell] = distance, other
            place += 1
    return found


@njit(cache=True)
def _look_around(
    found: I64, left: I64, points: F64, keys: I64, others: F64, other_keys: I64, order: I64, extent: I64
) -> None:  # pragma: no cover
    """Find the nearest point within reach for those that are left; a run of cells along z is one search."""
    reach = int(np.ceil(REACH_M / CELL_M))
    for cell in left:
        best = REACH_M**2
        for x in range(-reach, reach + 1):
            for y in range(-reach, reach + 1):
                middle = keys[cell] + (x * extent[1] + y) * extent[2]
                place = np.searchsorted(other_keys, middle - reach)
                while place < len(other_keys) and other_keys[place] <= middle + reach:
                    other = order[place]
                    distance = 0.0
                    for axis in range(3):
                        distance += (others[other, axis] - points[cell, axis]) ** 2
                    nearer = distance < best or (distance == best and (found[cell] < 0 or other < found[cell]))
                    if nearer:
                        best, found[cell] = distance, other
                    place += 1


def _refuse(prediction: F64, truth: F64, covered: float) -> None:
    """Raise InputError where the clouds have no place in common, or would have more of it if one were moved."""
    if len(truth) == 0:
        raise InputError("The true cloud has no points; there is nothing to compare with.")
    if len(prediction) == 0:
        raise InputError("The predicted cloud has no points; there is nothing to compare.")
    some = truth[:: max(1, len(truth) // _SAMPLE)]
    tree = cKDTree(prediction[:: max(1, len(prediction) // (50 * _SAMPLE))])
    ends = [np.percentile(each, (0, 1, 50, 99, 100), axis=0) for each in (prediction, truth)]
    for way in ends[0] - ends[1]:
        reached = tree.query(some + way, distance_upper_bound=REACH_M)[0]
        if np.isfinite(reached).mean() >= max(_SURE, 1.5 * covered):
            said = ", ".join(f"{step:.2f}" for step in way)
            raise InputError(f"The prediction lies ({said}) m off the truth; move it back, then compare again.")
    if covered == 0:
        raise InputError("The clouds of prediction and truth have no place in common; are they of the same building?")


def _known(labels: I32, numbers: Collection[int]) -> I32:
    """Return labels with those that the graph does not know as none."""
    return np.where(np.isin(labels, np.fromiter(numbers, dtype=np.int64)), labels, -1).astype(np.int32)


def _counts(labels: I32) -> dict[int, int]:
    numbers, counts = np.unique(labels, return_counts=True)
    return dict(zip(numbers.tolist(), counts.tolist(), strict=True))


def _grouped(counted: Iterable[tuple[int, int, int]]) -> dict[int, Counted]:
    groups: dict[int, list[tuple[int, int]]] = {}
    for one, other, count in counted:
        groups.setdefault(one, []).append((other, count))
    return {one: tuple(sorted(group, key=lambda pair: (-pair[1], pair[0]))) for one, group in groups.items()}


def _structure(truth: LabelledCloud) -> NDArray[Any]:
    """Points on planes of the truth; on anything that is no object where the truth knows no planes."""
    on_plane = truth.plane >= 0
    return (truth.object < 0) & (on_plane if on_plane.any() else True)
