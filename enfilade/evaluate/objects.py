"""Furnishings: is there a segment, or a combination of segments, that is this one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from statistics import mean

from enfilade.schema.graph import Node
from enfilade.schema.ids import parse

from .correspondence import Cells, Overlap, overlap
from .sides import Side, label, number_of

LEAST_SIZE_M = 0.3
"""Smaller furnishings are not asked for."""
MATCH_IOU = 0.5
LEAST_CELLS = 25
"""Furnishings with fewer cells than this (1 dm²) were hardly seen."""


@dataclass(frozen=True, slots=True)
class ObjectFigures:
    """How well furnishings were found.

    Attributes
    ----------
    true
        Furnishings of at least `LEAST_SIZE_M`, seen by a scan, in scanned rooms.
    found
        Share of them with a segment or combination whose points have an intersection over union of at least .5.
    mean_iou
        Mean over all of them of the best intersection over union.
    predicted
        Segments.
    missed
        Furnishings without such a segment or combination.
    """

    true: int
    found: float | None
    mean_iou: float | None
    predicted: int
    missed: tuple[str, ...]


def object_figures(prediction: Side, truth: Side, cells: Cells) -> ObjectFigures:
    """Find the best segment or combination of each furnishing."""
    shared = overlap(cells.true_object, cells.predicted_object)
    nodes = _nodes_by_segment(prediction)
    touching: dict[int, list[int]] = {}
    for true, segment in shared.both:
        touching.setdefault(true, []).append(segment)
    best: dict[str, float] = {}
    for node in _asked(truth, shared):
        number = number_of(node.id)
        candidates = {key: parts for segment in touching.get(number, []) for key, parts in nodes.get(segment, [])}
        best[label(node)] = max((_iou(shared, number, parts) for parts in candidates.values()), default=0.0)
    missed = tuple(name for name, iou in best.items() if iou < MATCH_IOU)
    return ObjectFigures(
        true=len(best),
        found=1 - len(missed) / len(best) if best else None,
        mean_iou=mean(best.values()) if best else None,
        predicted=sum(1 for node in prediction.graph.of_label("Object") if len(parse(node.id).numbers) == 1),
        missed=missed,
    )


def _asked(truth: Side, shared: Overlap) -> Iterator[Node]:
    """Yield the furnishings that a prediction should have."""
    scanned = truth.scanned()
    for node in truth.graph.of_label("Object"):
        room = truth.topology.room_of.get(node.id)
        large = max(node.properties.get("size", (0.0,))) >= LEAST_SIZE_M
        seen = shared.true.get(number_of(node.id), 0) >= LEAST_CELLS
        if large and seen and room is not None and number_of(room) in scanned:
            yield node


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
