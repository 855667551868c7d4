"""Which predicted room is which true one: one to one, by the surface that they share."""

from __future__ import annotations

from collections.abc import Set
from dataclasses import dataclass
from functools import cached_property
from typing import Final

from .correspondence import Cells, Overlap, overlap
from .sides import Side

MATCH_IOU: Final = 0.5
"""Two rooms are the same from this intersection over union on."""
STRICT_IOU: Final = 0.7
SPLIT_SHARE: Final = 0.1
"""A part of a room from this share of it on makes a room split; less is fraying at the edges."""


@dataclass(frozen=True)
class Matching:
    """Which predicted room is which true one, by number, and how well they overlap.

    Attributes
    ----------
    prediction, truth
        The two graphs.
    pairs
        (true, predicted, intersection over union), best first; at least `MATCH_IOU`.
    overlap
        On structure.
    """

    prediction: Side
    truth: Side
    pairs: tuple[tuple[int, int, float], ...]
    overlap: Overlap

    @cached_property
    def true_of(self) -> dict[int, int]:
        """True room of each matched predicted one."""
        return {predicted: true for true, predicted, _ in self.pairs}

    @cached_property
    def predicted_of(self) -> dict[int, int]:
        """Predicted room of each matched true one."""
        return {true: predicted for true, predicted, _ in self.pairs}

    @cached_property
    def asked(self) -> frozenset[int]:
        """True rooms that count: a scan stands in them, and they are neither stair wells nor roof spaces."""
        return self.truth.scanned - self.truth.stair_wells - self.truth.roof_spaces

    @cached_property
    def not_asked(self) -> frozenset[int]:
        """Predicted rooms that are, or for the most part lie in, true rooms that do not count."""
        return self._standing_for(self.truth.rooms.keys() - self.asked)

    @cached_property
    def unscanned(self) -> frozenset[int]:
        """Predicted rooms that are, or for the most part lie in, true rooms that no scan stands in."""
        return self._standing_for(self.truth.rooms.keys() - self.truth.scanned)

    @cached_property
    def split(self) -> dict[int, tuple[int, ...]]:
        """Scanned true rooms in which several predicted ones lie, each with a tenth of the room at least."""
        parts: dict[int, list[int]] = {}
        for (true, predicted), count in sorted(self.overlap.both.items()):
            inside = predicted >= 0 and 2 * count >= self.overlap.predicted[predicted]
            if true in self.truth.scanned and inside and count >= SPLIT_SHARE * self.overlap.true[true]:
                parts.setdefault(true, []).append(predicted)
        return {true: tuple(rooms) for true, rooms in parts.items() if len(rooms) > 1}

    @cached_property
    def merged(self) -> dict[int, tuple[int, ...]]:
        """Predicted rooms that hold most of several scanned true ones."""
        parts: dict[int, list[int]] = {}
        for (true, predicted), count in sorted(self.overlap.both.items()):
            if true in self.truth.scanned and predicted >= 0 and 2 * count >= self.overlap.true[true]:
                parts.setdefault(predicted, []).append(true)
        return {predicted: tuple(rooms) for predicted, rooms in sorted(parts.items()) if len(rooms) > 1}

    @cached_property
    def merged_into(self) -> dict[int, int]:
        """Predicted room that holds each true room of `merged`."""
        return {true: predicted for predicted, rooms in self.merged.items() for true in rooms}

    def _standing_for(self, rooms: Set[int]) -> frozenset[int]:
        matched = {predicted for predicted, true in self.true_of.items() if true in rooms}
        inside: dict[int, int] = {}
        for (true, predicted), count in self.overlap.both.items():
            if true in rooms and predicted >= 0 and predicted not in self.true_of:
                inside[predicted] = inside.get(predicted, 0) + count
        mostly = {predicted for predicted, count in inside.items() if 2 * count >= self.overlap.predicted[predicted]}
        return frozenset(matched | mostly)


def match_rooms(prediction: Side, truth: Side, cells: Cells) -> Matching:
    """Match rooms one to one, best intersection over union first, ties by number.

    Above one half this is the best matching there is: labels do not overlap one another, so a room has one partner
    with which it shares more than half of their union, or none.
    """
    shared = overlap(cells.true_room[cells.structure], cells.predicted_room[cells.structure])
    candidates = [(true, predicted, shared.iou(true, predicted)) for true, predicted in shared.both]
    candidates = [pair for pair in candidates if min(pair[:2]) >= 0 and pair[2] >= MATCH_IOU]
    pairs, taken_true, taken_predicted = [], set(), set()
    for pair in sorted(candidates, key=lambda pair: (-pair[2], pair[0], pair[1])):
        if pair[0] not in taken_true and pair[1] not in taken_predicted:
            pairs.append(pair)
            taken_true.add(pair[0])
            taken_predicted.add(pair[1])
    return Matching(prediction, truth, tuple(pairs), shared)
