"""Which rooms can be walked between: pairs joined by an opening, and pairs joined by any way."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from scipy.cluster.hierarchy import DisjointSet

from .openings import Hole
from .rooms import f1
from .sides import Side

_WALKABLE = ("door", "passage", "stairs", "hatch")


@dataclass(frozen=True, slots=True)
class ConnectivityFigures:
    """How well it was found who is connected.

    Attributes
    ----------
    true_pairs, predicted_pairs
        Numbers of pairs of rooms that an open door, a passage or stairs join.
    f1
        F1 of these pairs. A pair that only a closed door joins is neither asked nor held against the prediction.
    true_reachable, predicted_reachable
        Share of all pairs of scanned, and of predicted, rooms with a way from one to the other.
    """

    true_pairs: int
    predicted_pairs: int
    f1: float
    true_reachable: float | None
    predicted_reachable: float | None


def connectivity_figures(found: list[Hole], true: list[Hole], prediction: Side, truth: Side) -> ConnectivityFigures:
    """Compare the pairs of rooms that openings join, and how far one gets through them."""
    scanned = truth.scanned()
    wanted = _joined(hole for hole in true if not hole.closed)
    wanted = {pair for pair in wanted if pair <= scanned}
    excused = _joined(true) - wanted
    walkable = [hole for hole in found if hole.kind in _WALKABLE and not hole.closed and len(hole.rooms) == 2]
    known = _joined(walkable) - excused
    unknown = sum(1 for hole in walkable if hole.joins is None)
    predicted = len(known) + unknown
    own = [prediction.rooms_of(node.id) for node in prediction.graph.of_label("Opening") if _open(node.properties)]
    return ConnectivityFigures(
        true_pairs=len(wanted),
        predicted_pairs=predicted,
        f1=f1(len(wanted & known), predicted, len(wanted)),
        true_reachable=_reachable(scanned, (tuple(pair) for pair in wanted)),
        predicted_reachable=_reachable(prediction.rooms, own),
    )


def _joined(holes: Iterable[Hole]) -> set[frozenset[int]]:
    return {hole.joins for hole in holes if hole.kind in _WALKABLE and hole.joins is not None}


def _open(properties: dict[str, object]) -> bool:
    return properties.get("kind") in _WALKABLE and properties.get("state") != "closed"


def _reachable(rooms: Iterable[int], ways: Iterable[tuple[int, ...]]) -> float | None:
    """Share of pairs of rooms with a way between them; None for fewer than two rooms."""
    groups = DisjointSet(rooms)
    for way in ways:
        if len(way) == 2:
            groups.merge(*way)
    sizes = [len(group) for group in groups.subsets()]
    count, together = sum(sizes), sum(size * (size - 1) for size in sizes)
    return together / (count * (count - 1)) if count > 1 else None
