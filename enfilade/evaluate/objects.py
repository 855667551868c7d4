"""Furnishings: is there a segment, or a combination of segments, that is this one, and what became of it if not."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Final

import numpy as np

from enfilade.schema.graph import Node
from enfilade.schema.ids import MAX_SEGMENTS, parse

from .correspondence import Cells, Overlap, overlap
from .faults import Fault
from .figures import Figures, share
from .sides import Side, label, number_of

LEAST_SIZE_M: Final = 0.3
"""Smaller furnishings are not asked for."""
MATCH_IOU: Final = 0.5
LEAST_CELLS: Final = 25
"""Furnishings with fewer cells than this (1 dm²) were hardly seen."""
GHOST_SHARE: Final = 0.5
"""A segment with less than this share of its cells on furnishings of the truth is none of them."""
_MERGED_SHARE: Final = 0.2
_PART_SHARE: Final = 0.05


@dataclass(frozen=True, slots=True)
class ObjectFigures(Figures):
    """How well furnishings were found.

    Attributes
    ----------
    true
        Furnishings of at least `LEAST_SIZE_M`, seen by a scan, in scanned rooms.
    found_count
        Those with a segment or combination whose points have an intersection over union of at least .5.
    iou_sum
        Of the best intersections over union of all of them.
    predicted
        Segments.
    ghosts
        Segments that are no furnishing: less than half of their points lie on one.
    missed
        Names of furnishings without such a segment or combination.
    """

    DERIVED: ClassVar[tuple[str, ...]] = ("found", "mean_iou", "ghost_share")

    true: int = 0
    found_count: int = 0
    iou_sum: float = 0.0
    predicted: int = 0
    ghosts: int = 0
    missed: tuple[str, ...] = ()

    @property
    def found(self) -> float | None:
        """Share of furnishings found."""
        return share(self.found_count, self.true)

    @property
    def mean_iou(self) -> float | None:
        """Mean of the best intersections over union."""
        return share(self.iou_sum, self.true)

    @property
    def ghost_share(self) -> float | None:
        """Share of segments that are no furnishing."""
        return share(self.ghosts, self.predicted)


@dataclass(frozen=True)
class Furnishings:
    """Furnishings beside segments.

    Attributes
    ----------
    shared
        Cells of furnishings and of segments.
    best
        Key of the best segment or combination of each furnishing asked for, None where none touches it, and its
        intersection over union.
    """

    prediction: Side
    truth: Side
    cells: Cells
    shared: Overlap
    best: dict[int, tuple[str | None, float]]

    @cached_property
    def names(self) -> dict[int, str]:
        """Names of all furnishings of the truth."""
        return {number_of(node.id): label(node) for node in self.truth.graph.of_label("Object")}

    @cached_property
    def on_planes(self) -> Overlap:
        """Cells of furnishings, and whether (1) the prediction has them on a plane and in no object."""
        cells = self.cells
        taken = (cells.predicted_plane >= 0) & (cells.predicted_object < 0)
        return overlap(cells.true_object, taken.astype(np.int32))

    @cached_property
    def of_structure(self) -> Overlap:
        """Whether (1) a cell is structure in the truth, and the segment that it is in."""
        return overlap(self.cells.structure.astype(np.int32), self.cells.predicted_object)

    @cached_property
    def missed(self) -> list[int]:
        """Furnishings that were not found."""
        return [number for number, (_, iou) in self.best.items() if iou < MATCH_IOU]

    @cached_property
    def ghosts(self) -> list[Node]:
        """Segments that are no furnishing; of one without a point on a true surface nothing can be said."""
        known = (node for node in _segments(self.prediction) if number_of(node.id) in self.shared.predicted)
        return [node for node in known if self.on_furnishings(number_of(node.id)) < GHOST_SHARE]

    def on_furnishings(self, segment: int) -> float:
        """Share of a segment that lies on any furnishing."""
        return 1 - self.shared.both.get((-1, segment), 0) / self.shared.predicted[segment]


def match_objects(prediction: Side, truth: Side, cells: Cells) -> Furnishings:
    """Find the best segment or combination of each furnishing."""
    shared = overlap(cells.true_object, cells.predicted_object)
    nodes = _nodes_by_segment(prediction)
    best: dict[int, tuple[str | None, float]] = {}
    for node in _asked(truth, shared):
        number = number_of(node.id)
        touching = (segment for segment, _ in shared.on_true[number])
        candidates = {key: parts for segment in touching for key, parts in nodes.get(segment, [])}
        scored = [(_iou(shared, number, parts), key) for key, parts in candidates.items()]
        iou, key = max(scored, key=lambda pair: (pair[0], pair[1]), default=(0.0, None))
        best[number] = (key, iou)
    return Furnishings(prediction, truth, cells, shared, best)


def object_figures(furnishings: Furnishings) -> ObjectFigures:
    """Count furnishings found, and segments that are none."""
    best, missed = furnishings.best, furnishings.missed
    return ObjectFigures(
        true=len(best),
        found_count=len(best) - len(missed),
        iou_sum=float(sum(iou for _, iou in best.values())),
        predicted=len(_segments(furnishings.prediction)),
        ghosts=len(furnishings.ghosts),
        missed=tuple(furnishings.names[number] for number in missed),
    )


def object_faults(furnishings: Furnishings) -> Iterator[Fault]:
    """Yield furnishings that were missed and segments that are none, each with its likeliest cause."""
    truth = {number_of(node.id): node for node in furnishings.truth.graph.of_label("Object")}
    building = furnishings.prediction.graph.building
    for number in furnishings.missed:
        cause, why, segments = _why_missed(furnishings, number)
        node = truth[number]
        others = tuple(f"{building}/o{segment}" for segment in segments)
        yield Fault("object", "missed", "truth", node.id, label(node), cause, why, others=others)
    for node in furnishings.ghosts:
        cause, why = _why_ghost(furnishings, node)
        yield Fault("object", "invented", "prediction", node.id, label(node), cause, why)


def _why_missed(furnishings: Furnishings, number: int) -> tuple[str, str, tuple[int, ...]]:
    """Return cause, words and segments of a furnishing that was not found."""
    shared, size = furnishings.shared, furnishings.shared.true[number]
    parts = [(s, count) for s, count in shared.on_true[number] if s >= 0 and count >= _PART_SHARE * size]
    segments = tuple(segment for segment, _ in parts)
    lost = shared.both.get((number, -1), 0)
    if 2 * lost > size or not parts:
        return _lost(furnishings, number, lost / size), _lost_words(furnishings, number, lost / size), segments
    main, _ = parts[0]
    other, count = next(((o, n) for o, n in shared.on_predicted[main] if o not in (number, -1)), (-1, 0))
    if count >= _MERGED_SHARE * shared.predicted[main]:
        more = 100 * count / shared.predicted[main]
        name = furnishings.names.get(other, f"o{other}")
        return "merged", f"in one segment o{main} with {name} ({more:.0f} % of it)", segments
    united = _iou(shared, number, segments[:MAX_SEGMENTS])
    if len(segments) > MAX_SEGMENTS and united < MATCH_IOU:
        return "shattered", f"in {len(segments)} segments; the largest three have IoU {united:.2f}", segments
    if united >= MATCH_IOU:
        return "no_combination", f"in {len(segments)} segments that no combination joins", segments
    structure = shared.both.get((-1, main), 0) / shared.predicted[main]
    if structure >= _MERGED_SHARE:
        return "with_structure", f"{100 * structure:.0f} % of its segment o{main} is no furnishing", segments
    return (
        "partial",
        f"best IoU {furnishings.best[number][1]:.2f}; {100 * lost / size:.0f} % of it is in no object",
        segments,
    )


def _lost(furnishings: Furnishings, number: int, share: float) -> str:
    return "lost_in_structure" if _on_planes(furnishings, number) > 0.5 * share else "unlabelled"


def _lost_words(furnishings: Furnishings, number: int, share: float) -> str:
    planes = _on_planes(furnishings, number)
    return f"{100 * share:.0f} % of it is in no object, {100 * planes:.0f} % taken for structure"


def _on_planes(furnishings: Furnishings, number: int) -> float:
    """Share of a furnishing that the prediction puts on a plane and in no object."""
    return furnishings.on_planes.both.get((number, 1), 0) / furnishings.shared.true[number]


def _why_ghost(furnishings: Furnishings, node: Node) -> tuple[str, str]:
    segment = number_of(node.id)
    size = furnishings.shared.predicted[segment]
    structure = furnishings.of_structure.both.get((1, segment), 0) / size
    if structure >= GHOST_SHARE:
        return "structure", f"{100 * structure:.0f} % of it is wall, floor, ceiling or the like"
    strange = 1 - furnishings.on_furnishings(segment)
    return "clutter", f"{100 * strange:.0f} % of it is no furnishing, {100 * structure:.0f} % structure"


def _asked(truth: Side, shared: Overlap) -> Iterator[Node]:
    """Yield the furnishings that a prediction should have."""
    for node in truth.graph.of_label("Object"):
        room = truth.topology.room_of.get(node.id)
        large = max(node.properties.get("size", (LEAST_SIZE_M,))) >= LEAST_SIZE_M
        seen = shared.true.get(number_of(node.id), 0) >= LEAST_CELLS
        if (
            len(parse(node.id).numbers) == 1
            and large
            and seen
            and room is not None
            and number_of(room) in truth.scanned
        ):
            yield node


def _segments(prediction: Side) -> list[Node]:
    return [node for node in prediction.graph.of_label("Object") if len(parse(node.id).numbers) == 1]


def _nodes_by_segment(prediction: Side) -> dict[int, list[tuple[str, tuple[int, ...]]]]:
    """Object nodes, as key and numbers of segments, under each of their segments."""
    nodes: dict[int, list[tuple[str, tuple[int, ...]]]] = {}
    for node in prediction.graph.of_label("Object"):
        parts = parse(node.id).numbers
        for segment in parts:
            nodes.setdefault(segment, []).append((node.id, parts))
    return nodes


def _iou(shared: Overlap, true: int, parts: tuple[int, ...]) -> float:
    """Intersection over union of a furnishing and the union of some segments."""
    inside = sum(shared.both.get((true, part), 0) for part in parts)
    return inside / (shared.true[true] + sum(shared.predicted.get(part, 0) for part in parts) - inside)
