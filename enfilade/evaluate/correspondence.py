"""The same surface in two clouds: which labels truth and prediction give it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from enfilade.clouds import LabelledCloud
from enfilade.errors import InputError

I32 = NDArray[np.int32]
I64 = NDArray[np.int64]

CELL_M = 0.02
"""One point a cell of this side is compared, so that surface counts and not the nearness of a scanner."""
REACH_M = 0.05
"""A predicted point farther away than this says nothing about a true one: walls are thicker."""


@dataclass(frozen=True, slots=True)
class Cells:
    """One true point a cell, with the labels of the nearest predicted point.

    Attributes
    ----------
    true_room, predicted_room, true_object, predicted_object
        ``(C,) int32``, -1 for none.
    structure
        ``(C,)`` whether the truth says wall, floor, ceiling or the like.
    """

    true_room: I32
    predicted_room: I32
    true_object: I32
    predicted_object: I32
    structure: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Overlap:
    """How many cells each true and each predicted label has, and each pair of them; -1 is a label like others."""

    true: dict[int, int]
    predicted: dict[int, int]
    both: dict[tuple[int, int], int]

    def iou(self, true: int, predicted: int) -> float:
        """Intersection over union of two labels."""
        shared = self.both.get((true, predicted), 0)
        union = self.true.get(true, 0) + self.predicted.get(predicted, 0) - shared
        return shared / union if union else 0.0


def correspond(prediction: LabelledCloud, truth: LabelledCloud) -> Cells:
    """Give each cell of the true cloud the labels of the nearest predicted point.

    Raises
    ------
    InputError
        If no predicted point lies near a true one.
    """
    kept = _one_a_cell(truth.positions)
    near = _one_a_cell(prediction.positions)
    found = np.full(len(kept), -1)
    if len(kept) and len(near):
        tree = cKDTree(prediction.positions[near], balanced_tree=False, compact_nodes=False)
        reached, index = tree.query(truth.positions[kept], distance_upper_bound=REACH_M, workers=-1)
        found = np.where(np.isfinite(reached), near[np.minimum(index, len(near) - 1)], -1)
    if not (found >= 0).any():
        raise InputError("The clouds of prediction and truth have no place in common; are they of the same building?")
    return Cells(
        truth.room[kept],
        np.where(found >= 0, prediction.room[found], -1).astype(np.int32),
        truth.object[kept],
        np.where(found >= 0, prediction.object[found], -1).astype(np.int32),
        _structure(truth)[kept],
    )


def overlap(true: I32, predicted: I32) -> Overlap:
    """Count labels and pairs of labels."""
    width = int(predicted.max(initial=-1)) + 2
    keys, counts = np.unique((true.astype(np.int64) + 1) * width + predicted + 1, return_counts=True)
    pairs = zip((keys // width - 1).tolist(), (keys % width - 1).tolist(), strict=True)
    both = dict(zip(pairs, counts.tolist(), strict=True))
    return Overlap(_counts(true), _counts(predicted), both)


def _counts(labels: I32) -> dict[int, int]:
    numbers, counts = np.unique(labels, return_counts=True)
    return dict(zip(numbers.tolist(), counts.tolist(), strict=True))


def _structure(truth: LabelledCloud) -> NDArray[np.bool_]:
    """Points on planes of the truth; on anything that is no object where the truth knows no planes."""
    on_plane = truth.plane >= 0
    return (truth.object < 0) & (on_plane if on_plane.any() else True)


def _one_a_cell(positions: NDArray[np.float64]) -> I64:
    """Return the index of the first point of each cell."""
    if len(positions) == 0:
        return np.empty(0, dtype=np.int64)
    cells = np.floor(positions / CELL_M).astype(np.int64)
    cells -= cells.min(axis=0)
    extent = cells.max(axis=0) + 1
    keys = (cells[:, 0] * extent[1] + cells[:, 1]) * extent[2] + cells[:, 2]
    return np.unique(keys, return_index=True)[1].astype(np.int64)
