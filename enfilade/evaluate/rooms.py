"""Rooms: one-to-one matching by the surface they share, and what follows from it."""

from __future__ import annotations

from collections.abc import Iterable, Set
from dataclasses import dataclass
from statistics import median

import numpy as np

from .correspondence import Cells, Overlap, overlap
from .sides import Side

MATCH_IOU = 0.5
"""Two rooms are the same from this intersection over union on."""
STRICT_IOU = 0.7
SPLIT_SHARE = 0.1
"""A part of a room from this share of it on makes a room split; less is fraying at the edges."""


@dataclass(frozen=True, slots=True)
class RoomFigures:
    """How well rooms were found.

    Attributes
    ----------
    true, predicted
        Numbers of rooms. Rooms that no scan stands in are left out of the truth, and so are predictions of them.
    f1_at_50, f1_at_70
        F1 of the rooms matched at an intersection over union of at least .5 and .7.
    mean_iou
        Mean intersection over union of the matched rooms.
    ari
        Adjusted Rand index of the room labels on the structure of the true rooms.
    split
        True rooms that two or more predicted ones lie in, each with at least a tenth of the room.
    merged
        Predicted rooms that most of two or more true ones lie in.
    missed, invented
        True and predicted rooms without a match at .5.
    stair_rooms, stair_rooms_found
        True rooms that stairs lead to, and how many of them are matched at .5.
    """

    true: int
    predicted: int
    f1_at_50: float
    f1_at_70: float
    mean_iou: float | None
    ari: float
    split: tuple[str, ...]
    merged: tuple[str, ...]
    missed: tuple[str, ...]
    invented: tuple[str, ...]
    stair_rooms: int
    stair_rooms_found: int


@dataclass(frozen=True, slots=True)
class StoreyFigures:
    """Storeys, and on which of them the matched rooms are.

    Attributes
    ----------
    true, predicted
        Numbers of storeys.
    rooms_right
        Share of matched rooms on their true storey.
    misplaced
        True rooms that are not.
    """

    true: int
    predicted: int
    rooms_right: float | None
    misplaced: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class MeasureFigures:
    """Median errors over the matched rooms: of the area, relative to the true one, and of the floor, in metres."""

    area_error: float | None
    floor_error_m: float | None


@dataclass(frozen=True, slots=True)
class Matching:
    """Which predicted room is which true one, by number, and how well they overlap.

    Attributes
    ----------
    pairs
        (true, predicted, intersection over union), best first; at least `MATCH_IOU`.
    overlap
        On structure.
    """

    pairs: tuple[tuple[int, int, float], ...]
    overlap: Overlap

    def true_of(self) -> dict[int, int]:
        """Return the true room of each matched predicted one."""
        return {predicted: true for true, predicted, _ in self.pairs}


def match_rooms(cells: Cells) -> Matching:
    """Match rooms one to one, best intersection over union first, ties by number."""
    shared = overlap(cells.true_room[cells.structure], cells.predicted_room[cells.structure])
    candidates = [(true, predicted, shared.iou(true, predicted)) for true, predicted in shared.both]
    candidates = [pair for pair in candidates if min(pair[:2]) >= 0 and pair[2] >= MATCH_IOU]
    pairs, taken_true, taken_predicted = [], set(), set()
    for pair in sorted(candidates, key=lambda pair: (-pair[2], pair[0], pair[1])):
        if pair[0] not in taken_true and pair[1] not in taken_predicted:
            pairs.append(pair)
            taken_true.add(pair[0])
            taken_predicted.add(pair[1])
    return Matching(tuple(pairs), shared)


def room_figures(prediction: Side, truth: Side, matching: Matching) -> RoomFigures:
    """Count rooms found, missed, invented, split and merged."""
    scanned = truth.scanned()
    pairs = [pair for pair in matching.pairs if pair[0] in scanned]
    matched, matched_predicted = {pair[0] for pair in pairs}, {pair[1] for pair in pairs}
    unscanned = truth.rooms.keys() - scanned
    predicted = sorted(prediction.rooms.keys() - (_lying_in(unscanned, matching.overlap) - matched_predicted))
    stair_rooms = _stair_rooms(truth) & scanned
    return RoomFigures(
        true=len(scanned),
        predicted=len(predicted),
        f1_at_50=f1(len(pairs), len(predicted), len(scanned)),
        f1_at_70=f1(sum(iou >= STRICT_IOU for _, _, iou in pairs), len(predicted), len(scanned)),
        mean_iou=sum(iou for _, _, iou in pairs) / len(pairs) if pairs else None,
        ari=adjusted_rand_index(matching.overlap, scanned),
        split=_split(prediction, truth, matching.overlap, scanned),
        merged=_merged(prediction, truth, matching.overlap, scanned),
        missed=tuple(truth.name(room) for room in sorted(scanned - matched)),
        invented=tuple(prediction.name(room) for room in predicted if room not in matched_predicted),
        stair_rooms=len(stair_rooms),
        stair_rooms_found=len(stair_rooms & matched),
    )


def storey_figures(prediction: Side, truth: Side, matching: Matching) -> StoreyFigures:
    """Count matched rooms on their true storey; storeys are matched one to one by the rooms that they share."""
    placed = [
        (true, truth.storeys[true], prediction.storeys[predicted])
        for true, predicted, _ in matching.pairs
        if true in truth.storeys and predicted in prediction.storeys
    ]
    counts: dict[tuple[int, int], int] = {}
    for _, true_storey, predicted_storey in placed:
        counts[true_storey, predicted_storey] = counts.get((true_storey, predicted_storey), 0) + 1
    same: dict[int, int] = {}
    for true_storey, predicted_storey in sorted(counts, key=lambda pair: (-counts[pair], pair)):
        if true_storey not in same and predicted_storey not in same.values():
            same[true_storey] = predicted_storey
    wrong = sorted(true for true, there, here in placed if same.get(there) != here)
    return StoreyFigures(
        true=sum(1 for _ in truth.graph.of_label("Storey")),
        predicted=sum(1 for _ in prediction.graph.of_label("Storey")),
        rooms_right=1 - len(wrong) / len(placed) if placed else None,
        misplaced=tuple(truth.name(room) for room in wrong),
    )


def measure_figures(prediction: Side, truth: Side, matching: Matching) -> MeasureFigures:
    """Compare areas and floor elevations of the matched rooms that have both."""
    areas = list(_both(prediction, truth, matching, "area"))
    floors = list(_both(prediction, truth, matching, "floor_elevation"))
    return MeasureFigures(
        median(abs(found / true - 1) for true, found in areas) if areas else None,
        median(abs(found - true) for true, found in floors) if floors else None,
    )


def adjusted_rand_index(shared: Overlap, rooms: frozenset[int]) -> float:
    """Agreement of the labels on some true rooms, 1 for the same partition, 0 for chance; unlabelled is a label."""
    both = {pair: count for pair, count in shared.both.items() if pair[0] in rooms}
    predicted: dict[int, int] = {}
    for (_, label), count in both.items():
        predicted[label] = predicted.get(label, 0) + count
    together = _pairs(both.values())
    in_true = _pairs(shared.true[room] for room in rooms if room in shared.true)
    in_predicted, all_pairs = _pairs(predicted.values()), _pairs([sum(both.values())])
    chance = in_true * in_predicted / all_pairs if all_pairs else 0.0
    most = (in_true + in_predicted) / 2
    return (together - chance) / (most - chance) if most != chance else 1.0


def f1(right: int, predicted: int, true: int) -> float:
    """Harmonic mean of precision and recall; 1 where there is nothing to find and nothing was found."""
    return 2 * right / (predicted + true) if predicted + true else 1.0


def _pairs(counts: Iterable[int]) -> float:
    """Return the number of pairs within the groups."""
    sizes = np.fromiter(counts, dtype=np.float64)
    return float((sizes * (sizes - 1) / 2).sum())


def _split(prediction: Side, truth: Side, shared: Overlap, scanned: frozenset[int]) -> tuple[str, ...]:
    parts: dict[int, list[int]] = {}
    for (true, predicted), count in sorted(shared.both.items()):
        inside = predicted in prediction.rooms and 2 * count >= shared.predicted[predicted]
        if true in scanned and inside and count >= SPLIT_SHARE * shared.true[true]:
            parts.setdefault(true, []).append(predicted)
    return tuple(
        f"{truth.name(true)} into {_listed(prediction, rooms)}" for true, rooms in parts.items() if len(rooms) > 1
    )


def _merged(prediction: Side, truth: Side, shared: Overlap, scanned: frozenset[int]) -> tuple[str, ...]:
    parts: dict[int, list[int]] = {}
    for (true, predicted), count in sorted(shared.both.items()):
        if true in scanned and predicted in prediction.rooms and 2 * count >= shared.true[true]:
            parts.setdefault(predicted, []).append(true)
    return tuple(
        f"{_listed(truth, rooms)} in {prediction.name(predicted)}"
        for predicted, rooms in sorted(parts.items())
        if len(rooms) > 1
    )


def _lying_in(rooms: Set[int], shared: Overlap) -> frozenset[int]:
    """Predicted rooms that lie for the most part in some true rooms."""
    inside: dict[int, int] = {}
    for (true, predicted), count in shared.both.items():
        if true in rooms:
            inside[predicted] = inside.get(predicted, 0) + count
    return frozenset(predicted for predicted, count in inside.items() if 2 * count >= shared.predicted[predicted])


def _listed(where: Side, rooms: list[int]) -> str:
    return " + ".join(where.name(room) for room in rooms)


def _stair_rooms(truth: Side) -> frozenset[int]:
    stairs = (node.id for node in truth.graph.of_label("Opening") if node.properties.get("kind") == "stairs")
    return frozenset(room for opening in stairs for room in truth.rooms_of(opening))


def _both(prediction: Side, truth: Side, matching: Matching, property: str) -> Iterable[tuple[float, float]]:
    for true, predicted, _ in matching.pairs:
        there, here = truth.value(true, property), prediction.value(predicted, property)
        if there is not None and here is not None:
            yield there, here
