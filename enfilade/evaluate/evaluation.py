"""One building: its figures, and what went wrong in it."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from enfilade.clouds import LabelledCloud, read_cloud
from enfilade.schema.exchange import read_graph
from enfilade.schema.graph import BuildingGraph

from .calibration import CalibrationFigures, calibration_figures
from .connectivity import (
    ConnectivityFigures,
    NeighbourFigures,
    connectivity_figures,
    neighbour_faults,
    neighbour_figures,
)
from .correspondence import correspond
from .faults import Fault, count_causes
from .holes import predicted_holes, true_holes
from .matching import Matching, match_rooms
from .measures import MeasureFigures, StoreyFigures, match_storeys, measure_figures, storey_faults, storey_figures
from .objects import Furnishings, ObjectFigures, match_objects, object_faults, object_figures
from .opening_faults import opening_faults
from .opening_figures import OpeningFigures, opening_figures
from .openings import Verdicts, judge_openings
from .rooms import RoomFigures, room_faults, room_figures
from .sides import side
from .summary import AllFigures
from .tables import fault_rows, figure_rows


@dataclass(frozen=True)
class Comparison:
    """Which node of the prediction is which of the truth: what figures, faults and pictures are made of.

    Attributes
    ----------
    storeys
        Predicted storey that stands for each true one, by number.
    """

    matching: Matching
    storeys: dict[int, int]
    verdicts: Verdicts
    furnishings: Furnishings


@dataclass(frozen=True, kw_only=True)
class Evaluation:
    """How well one building's graph and cloud agree with the truth.

    A unit of truth is a room of the truth that a scan stands in: spaces between which there is neither a wall nor a
    lintel are one room there already.

    Attributes
    ----------
    covered
        Share of the true surface that has a predicted point within 5 cm.
    faults
        What went wrong, and why.
    comparison
        What was compared with what; not part of `to_dict`.
    """

    rooms: RoomFigures
    storeys: StoreyFigures
    measures: MeasureFigures
    openings: OpeningFigures
    connectivity: ConnectivityFigures
    neighbours: NeighbourFigures
    objects: ObjectFigures
    calibration: CalibrationFigures
    covered: float
    faults: tuple[Fault, ...]
    comparison: Comparison = field(repr=False)

    @property
    def figures(self) -> AllFigures:
        """The figures alone."""
        return AllFigures(*(getattr(self, each.name) for each in fields(AllFigures)))

    def to_dict(self) -> dict[str, Any]:
        """Return all figures and faults as nested plain values, for JSON."""
        told = {"covered": self.covered, "causes": count_causes(self.faults)}
        return self.figures.to_dict() | told | {"faults": [fault.to_dict() for fault in self.faults]}

    def to_table(self) -> list[tuple[str, Any]]:
        """Return the figures as rows of (what, value) for people."""
        return [("true surface with a predicted point", self.covered), *figure_rows(self.figures)]

    def to_fault_table(self) -> list[tuple[str, str, str]]:
        """Return rows of (fault, which, why) for people, the first dozen of each sort."""
        return fault_rows(self.faults)


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
    rooms = (prediction.rooms.keys(), truth.rooms.keys())
    cells = correspond(cloud, true_cloud, rooms=rooms, objects=(prediction.segments, truth.segments))
    matching = match_rooms(prediction, truth, cells)
    storeys = match_storeys(matching)
    found, true = predicted_holes(matching), true_holes(truth)
    verdicts = judge_openings(found, true)
    furnishings = match_objects(prediction, truth, cells)
    faults = (
        *room_faults(matching),
        *storey_faults(matching, storeys),
        *opening_faults(verdicts, found, true, matching, cells),
        *neighbour_faults(matching),
        *object_faults(furnishings),
    )
    return Evaluation(
        rooms=room_figures(matching),
        storeys=storey_figures(matching, storeys),
        measures=measure_figures(matching),
        openings=opening_figures(verdicts),
        connectivity=connectivity_figures(found, true, matching),
        neighbours=neighbour_figures(matching),
        objects=object_figures(furnishings),
        calibration=calibration_figures(verdicts, matching),
        covered=cells.covered,
        faults=faults,
        comparison=Comparison(matching, storeys, verdicts, furnishings),
    )
