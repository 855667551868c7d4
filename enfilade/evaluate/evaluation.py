"""The figures of one building, and how they are shown."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from enfilade.clouds import LabelledCloud, read_cloud
from enfilade.schema.exchange import read_graph
from enfilade.schema.graph import BuildingGraph

from .connectivity import ConnectivityFigures, connectivity_figures
from .correspondence import correspond
from .objects import ObjectFigures, object_figures
from .openings import OpeningFigures, opening_figures, predicted_holes, true_holes
from .rooms import (
    MeasureFigures,
    RoomFigures,
    StoreyFigures,
    match_rooms,
    measure_figures,
    room_figures,
    storey_figures,
)
from .sides import side

_MOST_NAMES: Final = 12


@dataclass(frozen=True, slots=True)
class Evaluation:
    """How well one building's graph and cloud agree with the truth.

    A unit of truth is a room of the truth that a scan stands in: spaces between which there is neither a wall nor a
    lintel are one room there already.
    """

    rooms: RoomFigures
    storeys: StoreyFigures
    measures: MeasureFigures
    openings: OpeningFigures
    connectivity: ConnectivityFigures
    objects: ObjectFigures

    def to_dict(self) -> dict[str, Any]:
        """Return all figures as nested plain values, for JSON."""
        return asdict(self)

    def to_table(self) -> list[tuple[str, Any]]:
        """Return rows of (what, value) for people; names of what went wrong at the end, the first dozen of each."""
        return _figures(self) + [(what, _listed(names)) for what, names in _faults(self) if names]


def evaluate(prediction: Path, truth: Path) -> Evaluation:
    """Compare two folders that hold ``graph.json`` and ``cloud.ply``.

    Raises
    ------
    InputError, GraphError
        If a file is missing or damaged, or the clouds have no place in common.
    """
    graphs = [read_graph(folder / "graph.json") for folder in (prediction, truth)]
    clouds = [read_cloud(folder / "cloud.ply") for folder in (prediction, truth)]
    return evaluate_graphs(graphs[0], clouds[0], graphs[1], clouds[1])


def evaluate_graphs(
    graph: BuildingGraph, cloud: LabelledCloud, true_graph: BuildingGraph, true_cloud: LabelledCloud
) -> Evaluation:
    """Compare a graph and its labelled cloud with true ones.

    Raises
    ------
    InputError
        If the clouds have no place in common.
    """
    prediction, truth = side(graph), side(true_graph)
    cells = correspond(cloud, true_cloud)
    matching = match_rooms(cells)
    found, true = predicted_holes(prediction, matching), true_holes(truth)
    return Evaluation(
        room_figures(prediction, truth, matching),
        storey_figures(prediction, truth, matching),
        measure_figures(prediction, truth, matching),
        opening_figures(found, true, truth.scanned()),
        connectivity_figures(found, true, prediction, truth),
        object_figures(prediction, truth, cells),
    )


def _listed(names: tuple[str, ...]) -> str:
    """Return some names in a line; `Evaluation.to_dict` has them all."""
    more = len(names) - _MOST_NAMES
    return "; ".join(names[:_MOST_NAMES]) + (f"; and {more} more" if more > 0 else "")


def _figures(found: Evaluation) -> list[tuple[str, Any]]:
    rooms, openings, ways = found.rooms, found.openings, found.connectivity
    return [
        ("rooms, predicted of true", f"{rooms.predicted} of {rooms.true}"),
        ("rooms, F1 at IoU .5", rooms.f1_at_50),
        ("rooms, F1 at IoU .7", rooms.f1_at_70),
        ("rooms, mean IoU", rooms.mean_iou),
        ("rooms, adjusted Rand index", rooms.ari),
        ("rooms split", len(rooms.split)),
        ("rooms merged", len(rooms.merged)),
        ("rooms with stairs, found", f"{rooms.stair_rooms_found} of {rooms.stair_rooms}"),
        ("storeys, predicted of true", f"{found.storeys.predicted} of {found.storeys.true}"),
        ("storeys, rooms on the right one", found.storeys.rooms_right),
        ("area, median relative error", found.measures.area_error),
        ("floor elevation, median error (m)", found.measures.floor_error_m),
        ("openings, predicted of true", f"{openings.predicted} of {openings.true}"),
        ("openings, precision", openings.precision),
        ("openings, recall", openings.recall),
        ("openings, median width error (m)", openings.width_error_m),
        ("openings, median position error (m)", openings.position_error_m),
        ("openings, kind right", openings.kinds_right),
        ("closed doors, found", f"{openings.closed_found} of {openings.closed_true}"),
        ("closed doors, found and marked", openings.closed_marked),
        ("stairs, found", f"{openings.stairs_found} of {openings.stairs_true}"),
        ("stairs, invented", openings.stairs_invented),
        ("connectivity, F1 of room pairs", ways.f1),
        ("connectivity, reachable pairs, true", ways.true_reachable),
        ("connectivity, reachable pairs, predicted", ways.predicted_reachable),
        ("objects, found", found.objects.found),
        ("objects, mean IoU", found.objects.mean_iou),
        ("objects, segments for true ones", f"{found.objects.predicted} for {found.objects.true}"),
    ]


def _faults(found: Evaluation) -> list[tuple[str, tuple[str, ...]]]:
    return [
        ("rooms missed", found.rooms.missed),
        ("rooms invented", found.rooms.invented),
        ("rooms split", found.rooms.split),
        ("rooms merged", found.rooms.merged),
        ("rooms on another storey", found.storeys.misplaced),
        ("openings missed", found.openings.missed),
        ("openings invented", found.openings.invented),
        ("closed doors invented", found.openings.closed_invented),
        ("objects missed", found.objects.missed),
    ]
