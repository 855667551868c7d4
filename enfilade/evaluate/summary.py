"""All figures together."""

from __future__ import annotations

from dataclasses import dataclass, field

from .calibration import CalibrationFigures
from .connectivity import ConnectivityFigures, NeighbourFigures
from .figures import Figures
from .measures import MeasureFigures, StoreyFigures
from .objects import ObjectFigures
from .opening_figures import OpeningFigures
from .rooms import RoomFigures


@dataclass(frozen=True, slots=True)
class AllFigures(Figures):
    """All figures of a building, or of many as if they were one."""

    rooms: RoomFigures = field(default_factory=RoomFigures)
    storeys: StoreyFigures = field(default_factory=StoreyFigures)
    measures: MeasureFigures = field(default_factory=MeasureFigures)
    openings: OpeningFigures = field(default_factory=OpeningFigures)
    connectivity: ConnectivityFigures = field(default_factory=ConnectivityFigures)
    neighbours: NeighbourFigures = field(default_factory=NeighbourFigures)
    objects: ObjectFigures = field(default_factory=ObjectFigures)
    calibration: CalibrationFigures = field(default_factory=CalibrationFigures)
