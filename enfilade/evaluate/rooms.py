"""Rooms: found, missed, invented, split and merged, and why."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Set
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np

from .correspondence import CELL_M, Overlap
from .faults import Fault
from .figures import Figures, f1, share
from .matching import STRICT_IOU, Matching
from .sides import Side

SEEN_M2: Final = 1.0
"""A room of which less surface was seen is not there to be found."""
_LEAK: Final = 0.1


@dataclass(frozen=True, slots=True)
class ApartFigures(Figures):
    """Rooms that are reported apart: how many there are, were found, and say what they are.

    Attributes
    ----------
    true
        Those of which at least `SEEN_M2` of structure was seen.
    found
        Those matched at .5.
    marked
        Of rooms seen from outside: those found that name no scan, either.
    """

    true: int = 0
    found: int = 0
    marked: int = 0


@dataclass(frozen=True, slots=True)
class RoomFigures(Figures):
    """How well rooms were found.

    Attributes
    ----------
    true, predicted
        Numbers of rooms. Rooms that no scan stands in, stair wells and roof spaces are left out of the truth, and so
        are predictions of them.
    matched, matched_strict
        Rooms matched at an intersection over union of at least .5 and .7.
    iou_sum
        Of the matched rooms.
    split_count, merged_count
        Scanned true rooms that several predicted ones lie in; predicted rooms that hold several scanned true ones.
    cells, pairs_together, pairs_true, pairs_predicted
        What the Rand index of the labels on the structure of the scanned rooms is made of.
    all_true, all_predicted, all_matched
        With everything that is otherwise left out, if seen.
    unscanned, stair_wells, roof_spaces
        The rooms that are reported apart.
    stair_rooms, stair_rooms_found
        Scanned true rooms that stairs lead to, and how many of them are matched.
    split, merged, missed, invented
        Names.
    """

    DERIVED: ClassVar[tuple[str, ...]] = ("f1_at_50", "f1_at_70", "f1_of_all", "mean_iou", "ari")

    true: int = 0
    predicted: int = 0
    matched: int = 0
    matched_strict: int = 0
    iou_sum: float = 0.0
    split_count: int = 0
    merged_count: int = 0
    cells: int = 0
    pairs_together: float = 0.0
    pairs_true: float = 0.0
    pairs_predicted: float = 0.0
    all_true: int = 0
    all_predicted: int = 0
    all_matched: int = 0
    unscanned: ApartFigures = ApartFigures()
    stair_wells: ApartFigures = ApartFigures()
    roof_spaces: ApartFigures = ApartFigures()
    stair_rooms: int = 0
    stair_rooms_found: int = 0
    split: tuple[str, ...] = ()
    merged: tuple[str, ...] = ()
    missed: tuple[str, ...] = ()
    invented: tuple[str, ...] = ()

    @property
    def f1_at_50(self) -> float:
        """F1 of the rooms matched at an intersection over union of at least .5."""
        return f1(self.matched, self.predicted, self.true)

    @property
    def f1_at_70(self) -> float:
        """F1 of the rooms matched at .7."""
        return f1(self.matched_strict, self.predicted, self.true)

    @property
    def f1_of_all(self) -> float:
        """F1 at .5 with the rooms that are reported apart."""
        return f1(self.all_matched, self.all_predicted, self.all_true)

    @property
    def mean_iou(self) -> float | None:
        """Mean intersection over union of the matched rooms."""
        return share(self.iou_sum, self.matched)

    @property
    def ari(self) -> float:
        """Adjusted Rand index, 1 for the same partition, 0 for chance."""
        together = (self.pairs_together, self.pairs_true, self.pairs_predicted)
        return _adjusted(*together, self.cells * (self.cells - 1) / 2)


def room_figures(matching: Matching) -> RoomFigures:
    """Count rooms found, missed, invented, split and merged."""
    prediction, truth, asked = matching.prediction, matching.truth, matching.asked
    pairs = [pair for pair in matching.pairs if pair[0] in asked]
    predicted = prediction.rooms.keys() - matching.not_asked
    seen = _seen(matching)
    stair_rooms = _stair_rooms(truth) & truth.scanned
    together, in_true, in_predicted, cells = _pair_counts(matching.overlap, truth.scanned)
    return RoomFigures(
        true=len(asked),
        predicted=len(predicted),
        matched=len(pairs),
        matched_strict=sum(iou >= STRICT_IOU for _, _, iou in pairs),
        iou_sum=sum(iou for _, _, iou in pairs),
        split_count=len(matching.split),
        merged_count=len(matching.merged),
        cells=cells,
        pairs_together=together,
        pairs_true=in_true,
        pairs_predicted=in_predicted,
        all_true=len(seen | asked),
        all_predicted=len(prediction.rooms),
        all_matched=sum(pair[0] in seen | asked for pair in matching.pairs),
        unscanned=_apart(matching, (truth.rooms.keys() - truth.scanned) & seen),
        stair_wells=_apart(matching, truth.stair_wells & truth.scanned),
        roof_spaces=_apart(matching, truth.roof_spaces & truth.scanned),
        stair_rooms=len(stair_rooms),
        stair_rooms_found=len(stair_rooms & matching.predicted_of.keys()),
        split=tuple(f"{truth.name(true)} into {prediction.names(parts)}" for true, parts in matching.split.items()),
        merged=tuple(f"{truth.names(rooms)} in {prediction.name(p)}" for p, rooms in matching.merged.items()),
        missed=tuple(truth.name(room) for room in _missed(matching)),
        invented=tuple(prediction.name(room) for room in _invented(matching)),
    )


def room_faults(matching: Matching) -> Iterator[Fault]:
    """Yield what is wrong with rooms, and why."""
    prediction, truth = matching.prediction, matching.truth
    for true, parts in matching.split.items():
        why = f"into {prediction.names(parts)}"
        yield _fault(truth, "truth", "split", true, "split", why, prediction.ids(parts))
    for room, parts in matching.merged.items():
        why = f"holds {truth.names(parts)}"
        yield _fault(prediction, "prediction", "merged", room, "merged", why, truth.ids(parts))
    for room in _missed(matching):
        cause, why, others = _why_missed(matching, room)
        yield _fault(truth, "truth", "missed", room, cause, why, prediction.ids(others))
    for room in _invented(matching):
        cause, why, others = _why_invented(matching, room)
        yield _fault(prediction, "prediction", "invented", room, cause, why, truth.ids(others))
    for true, predicted, iou in matching.pairs:
        if iou < STRICT_IOU and true in matching.asked:
            why = f"IoU {iou:.2f} with {prediction.name(predicted)}; {_leaks(matching, true, predicted)}"
            yield _fault(truth, "truth", "loose", true, "loose", why, prediction.ids((predicted,)))


def adjusted_rand_index(shared: Overlap, rooms: frozenset[int]) -> float:
    """Agreement of the labels on some true rooms, 1 for the same partition, 0 for chance; unlabelled is a label."""
    together, in_true, in_predicted, cells = _pair_counts(shared, rooms)
    return _adjusted(together, in_true, in_predicted, cells * (cells - 1) / 2)


def _adjusted(together: float, in_true: float, in_predicted: float, all_pairs: float) -> float:
    chance = in_true * in_predicted / all_pairs if all_pairs else 0.0
    most = (in_true + in_predicted) / 2
    return (together - chance) / (most - chance) if most != chance else 1.0


def _pair_counts(shared: Overlap, rooms: frozenset[int]) -> tuple[float, float, float, int]:
    """Pairs of cells together in both partitions, in the true one, in the predicted one, and the number of cells."""
    both = {pair: count for pair, count in shared.both.items() if pair[0] in rooms}
    predicted: dict[int, int] = {}
    for (_, label), count in both.items():
        predicted[label] = predicted.get(label, 0) + count
    in_true = _pairs(shared.true[room] for room in rooms if room in shared.true)
    return _pairs(both.values()), in_true, _pairs(predicted.values()), sum(both.values())


def _pairs(counts: Iterable[int]) -> float:
    """Return the number of pairs within the groups."""
    sizes = np.fromiter(counts, dtype=np.float64)
    return float((sizes * (sizes - 1) / 2).sum())


def _seen(matching: Matching) -> frozenset[int]:
    least = SEEN_M2 / CELL_M**2
    return frozenset(room for room in matching.truth.rooms if matching.overlap.true.get(room, 0) >= least)


def _apart(matching: Matching, rooms: Set[int]) -> ApartFigures:
    found = [matching.predicted_of[room] for room in rooms if room in matching.predicted_of]
    marked = sum(1 for room in found if not matching.prediction.value(room, "scans"))
    return ApartFigures(len(rooms), len(found), marked)


def _missed(matching: Matching) -> list[int]:
    return sorted(matching.asked - matching.predicted_of.keys())


def _invented(matching: Matching) -> list[int]:
    return sorted(matching.prediction.rooms.keys() - matching.not_asked - matching.true_of.keys())


def _stair_rooms(truth: Side) -> frozenset[int]:
    stairs = (node.id for node in truth.graph.of_label("Opening") if node.properties.get("kind") == "stairs")
    return frozenset(room for opening in stairs for room in truth.rooms_of(opening))


def _fault(where: Side, side: str, fault: str, room: int, cause: str, why: str, others: tuple[str, ...]) -> Fault:
    return Fault("room", fault, side, where.id(room), where.name(room), cause, why, others=others)


Reason = tuple[str, str, tuple[int, ...]]


def _why_missed(matching: Matching, room: int) -> Reason:
    """Return cause, words and predicted rooms for a true room without a match."""
    prediction, truth, shared = matching.prediction, matching.truth, matching.overlap
    size = shared.true.get(room, 0)
    if size == 0:
        return "unseen", "none of its structure was seen", ()
    if room in matching.split:
        parts = matching.split[room]
        return "split", f"split into {prediction.names(parts)}", parts
    if room in matching.merged_into:
        whole = matching.merged_into[room]
        others = tuple(other for other in matching.merged[whole] if other != room)
        return "merged", f"merged with {truth.names(others)} in {prediction.name(whole)}", (whole,)
    if 2 * shared.both.get((room, -1), 0) >= size:
        return "unlabelled", f"{_percent(shared.both[room, -1], size)} of its surface is in no room", ()
    best, _ = next(pair for pair in shared.on_true[room] if pair[0] >= 0)
    why = f"best is {prediction.name(best)}, IoU {shared.iou(room, best):.2f}; {_leaks(matching, room, best)}"
    return "overlap", why, (best,)


def _why_invented(matching: Matching, room: int) -> Reason:
    """Return cause, words and true rooms for a predicted room without a match."""
    truth, shared = matching.truth, matching.overlap
    size = shared.predicted.get(room, 0)
    if size == 0:
        return "no_structure", "no wall, floor or ceiling of the truth is in it", ()
    if room in matching.merged:
        parts = matching.merged[room]
        return "merged", f"{truth.names(parts)} in one", parts
    true, count = shared.on_predicted[room][0]
    if true < 0:
        return "outside", f"{_percent(count, size)} of it lies in no room", ()
    of_it, of_room = _percent(count, size), _percent(count, shared.true[true])
    if 2 * count >= size:
        return "part", f"{of_it} of it lies in {truth.name(true)}, of which it is {of_room}", (true,)
    return "overlap", f"lies in several rooms, most in {truth.name(true)} ({of_it})", (true,)


def _leaks(matching: Matching, true: int, predicted: int) -> str:
    """Say where the rest of a true room went, and what the predicted one has beside it."""
    shared = matching.overlap
    lost = [
        f"{_percent(count, shared.true[true])} of it is in {_named(matching.prediction, room)}"
        for room, count in shared.on_true[true]
        if room != predicted and count >= _LEAK * shared.true[true]
    ]
    gained = [
        f"{_percent(count, shared.predicted[predicted])} of that is {_named(matching.truth, room)}"
        for room, count in shared.on_predicted[predicted]
        if room != true and count >= _LEAK * shared.predicted[predicted]
    ]
    return ", ".join(lost + gained) or "frayed in many places"


def _named(where: Side, room: int) -> str:
    return where.name(room) if room >= 0 else "no room"


def _percent(part: float, whole: float) -> str:
    return f"{100 * part / whole:.0f} %"
