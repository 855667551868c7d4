"""Which rooms can be walked between, and which lie wall to wall or floor to ceiling."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Set
from dataclasses import dataclass
from typing import ClassVar

from scipy.cluster.hierarchy import DisjointSet

from .faults import Fault
from .figures import Figures, f1, middle, share
from .holes import WALKABLE, Hole
from .matching import Matching
from .sides import number_of

Pair = frozenset[int]


@dataclass(frozen=True, slots=True)
class ConnectivityFigures(Figures):
    """How well it was found who is connected.

    Attributes
    ----------
    true_pairs, predicted_pairs, right_pairs
        Pairs of scanned rooms that an open door, a passage, stairs or a hatch join. A pair that only a closed door
        joins is neither asked nor held against the prediction.
    true_room_pairs, true_reachable_pairs, predicted_room_pairs, predicted_reachable_pairs
        Pairs of scanned, and of predicted, rooms, and those with a way from one to the other.
    agreeing_pairs
        Pairs of scanned true rooms of which the prediction says the same: that there is a way, or that there is none.
    """

    DERIVED: ClassVar[tuple[str, ...]] = ("f1", "true_reachable", "predicted_reachable", "reachable_right")

    true_pairs: int = 0
    predicted_pairs: int = 0
    right_pairs: int = 0
    true_room_pairs: int = 0
    true_reachable_pairs: int = 0
    predicted_room_pairs: int = 0
    predicted_reachable_pairs: int = 0
    agreeing_pairs: int = 0

    @property
    def f1(self) -> float:
        """F1 of the pairs."""
        return f1(self.right_pairs, self.predicted_pairs, self.true_pairs)

    @property
    def true_reachable(self) -> float | None:
        """Share of pairs of scanned true rooms with a way between them."""
        return share(self.true_reachable_pairs, self.true_room_pairs)

    @property
    def predicted_reachable(self) -> float | None:
        """Share of pairs of predicted rooms with a way between them."""
        return share(self.predicted_reachable_pairs, self.predicted_room_pairs)

    @property
    def reachable_right(self) -> float | None:
        """Share of pairs of true rooms of which truth and prediction say the same."""
        return share(self.agreeing_pairs, self.true_room_pairs)


@dataclass(frozen=True, slots=True)
class NeighbourFigures(Figures):
    """How well it was found which scanned rooms share a wall or slab; all None where the truth has no NEIGHBOUR.

    Attributes
    ----------
    true, predicted, right
        Pairs of scanned rooms.
    gap_errors_m
        Errors of the thickness of what is between them.
    """

    DERIVED: ClassVar[tuple[str, ...]] = ("f1", "precision", "recall", "gap_error_m")

    true: int = 0
    predicted: int = 0
    right: int = 0
    gap_errors_m: tuple[float, ...] = ()

    @property
    def f1(self) -> float | None:
        """F1 of the pairs."""
        return f1(self.right, self.predicted, self.true) if self.true else None

    @property
    def precision(self) -> float | None:
        """Of the predicted pairs, the share that is right."""
        return share(self.right, self.predicted) if self.true else None

    @property
    def recall(self) -> float | None:
        """Of the true pairs, the share that was found."""
        return share(self.right, self.true)

    @property
    def gap_error_m(self) -> float | None:
        """Median error of the gap."""
        return middle(self.gap_errors_m)


def connectivity_figures(found: Iterable[Hole], true: Iterable[Hole], matching: Matching) -> ConnectivityFigures:
    """Compare the pairs of rooms that openings join, and how far one gets through them."""
    prediction, truth = matching.prediction, matching.truth
    wanted, excused = _true_pairs(true, truth.scanned)
    walkable = [hole for hole in found if _walkable(hole) and not hole.apart]
    known = {hole.joins for hole in walkable if hole.joins is not None} - excused
    strange = {_ends(matching, hole) for hole in walkable if hole.joins is None}
    kept = prediction.rooms.keys() - matching.unscanned
    ways = (_ends(matching, hole) for hole in walkable)
    here = _groups(kept, ways)
    there = _groups(truth.scanned, wanted)
    true_room_pairs, true_reachable = _reachable(there)
    room_pairs, reachable = _reachable(here)
    return ConnectivityFigures(
        len(wanted),
        len(known) + len(strange),
        len(wanted & known),
        true_room_pairs,
        true_reachable,
        room_pairs,
        reachable,
        _agreeing(there, here, matching),
    )


def neighbour_figures(matching: Matching) -> NeighbourFigures:
    """Compare pairs of neighbours."""
    true, predicted, strange = _neighbours(matching)
    right = true.keys() & predicted.keys()
    gaps = ((true[pair], predicted[pair]) for pair in sorted(right, key=sorted))
    errors = tuple(abs(here - there) for there, here in gaps if here is not None and there is not None)
    return NeighbourFigures(len(true), len(predicted) + len(strange), len(right), errors)


def neighbour_faults(matching: Matching) -> Iterator[Fault]:
    """Yield neighbours that were missed or invented; those whose rooms were not found are left out."""
    truth, prediction = matching.truth, matching.prediction
    true, predicted, _ = _neighbours(matching)
    for pair in sorted(true.keys() - predicted.keys(), key=sorted) if true else ():
        if matching.predicted_of.keys() >= pair:
            yield _pair_fault("missed", "truth", truth.ids(tuple(pair)), truth.names(sorted(pair)), "no such edge")
    for pair in sorted(predicted.keys() - true.keys(), key=sorted) if true else ():
        ends = sorted(matching.predicted_of[room] for room in pair)
        why = "they share no wall or slab"
        yield _pair_fault("invented", "prediction", prediction.ids(ends), prediction.names(ends), why)


def _pair_fault(fault: str, side: str, ids: tuple[str, ...], name: str, why: str) -> Fault:
    return Fault("neighbour", fault, side, "|".join(sorted(ids)), name, fault, why)


def _true_pairs(true: Iterable[Hole], scanned: Set[int]) -> tuple[set[Pair], set[Pair]]:
    """Pairs of scanned rooms that are asked for, and pairs that only closed doors join."""
    joined: dict[bool, set[Pair]] = {True: set(), False: set()}
    for hole in true:
        if hole.kind in WALKABLE and len(hole.rooms) == 2 and hole.joins is not None:
            joined[hole.closed].add(hole.joins)
    wanted = {pair for pair in joined[False] if pair <= scanned}
    return wanted, joined[True] - wanted


def _walkable(hole: Hole) -> bool:
    return hole.kind in WALKABLE and not hole.closed and len(hole.rooms) == 2


def _ends(matching: Matching, hole: Hole) -> Pair:
    return frozenset(matching.prediction.rooms_of(hole.id))


def _groups(rooms: Set[int], ways: Iterable[Pair]) -> DisjointSet:
    groups = DisjointSet(sorted(rooms))
    for way in ways:
        if len(way) == 2 and way <= rooms:
            groups.merge(*way)
    return groups


def _reachable(groups: DisjointSet) -> tuple[int, int]:
    """Return the number of pairs of rooms, and of those with a way between them."""
    sizes = [len(group) for group in groups.subsets()]
    return _pairs(sum(sizes)), sum(map(_pairs, sizes))


def _pairs(count: int) -> int:
    return count * (count - 1) // 2


def _agreeing(there: DisjointSet, here: DisjointSet, matching: Matching) -> int:
    """Count pairs of true rooms that are in one group on both sides, or on neither; a missed room is alone."""
    groups: dict[tuple[object, object], int] = {}
    true: dict[object, int] = {}
    predicted: dict[object, int] = {}
    rooms = sorted(matching.truth.scanned)
    for room in rooms:
        found = matching.predicted_of.get(room)
        ends = there[room], ("missed", room) if found is None or found not in here else here[found]
        groups[ends] = groups.get(ends, 0) + 1
        true[ends[0]] = true.get(ends[0], 0) + 1
        predicted[ends[1]] = predicted.get(ends[1], 0) + 1
    both, one, other = (sum(map(_pairs, counts.values())) for counts in (groups, true, predicted))
    return _pairs(len(rooms)) - one - other + 2 * both


def _neighbours(matching: Matching) -> tuple[dict[Pair, float | None], dict[Pair, float | None], set[Pair]]:
    """Pairs of scanned true rooms with their gap, the same of predicted rooms, and pairs of rooms that are none."""
    true: dict[Pair, float | None] = {}
    for edge in matching.truth.graph.of_type("NEIGHBOUR"):
        pair = frozenset((number_of(edge.source), number_of(edge.target)))
        if pair <= matching.truth.scanned:
            true[pair] = edge.properties.get("gap")
    predicted: dict[Pair, float | None] = {}
    strange: set[Pair] = set()
    for edge in matching.prediction.graph.of_type("NEIGHBOUR"):
        ends = frozenset((number_of(edge.source), number_of(edge.target)))
        if ends & matching.unscanned:
            continue
        known = frozenset(matching.true_of[room] for room in ends if room in matching.true_of)
        if len(known) == 2:
            predicted[known] = edge.properties.get("gap")
        else:
            strange.add(ends)
    return true, predicted, strange
