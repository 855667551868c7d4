"""A stairwell of two storeys with a landing half way up: two rooms, two storeys, nothing between."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from shapely import box

from enfilade.ingest.pipeline import ingest
from enfilade.schema.graph import BuildingGraph
from enfilade.simulate.build import build
from enfilade.simulate.plan import Hole, Level, Plan, Run, Space, Stairs, rectangle
from enfilade.simulate.scanner import Scanner
from enfilade.simulate.simulation import Parameters, simulate

pytestmark = pytest.mark.slow

RISE = 2.8


def stairwell_plan() -> Plan:
    """A stairwell of 2.4 m by 5 m with a room beside it on each storey."""
    runs = (
        Run((0.6, 1.4), (0.6, 3.7), 1.15, 0.0, RISE / 2, 8),
        Run((1.8, 3.7), (1.8, 1.4), 1.15, RISE / 2, RISE, 8),
    )
    landing = (box(0.0, 3.7, 2.4, 5.0), RISE / 2 - 0.2, RISE / 2)
    stairs = Stairs(("Stairs 1", "Stairs 2"), runs, box(0.0, 1.4, 2.4, 5.0), (landing,))
    levels = tuple(
        Level(
            f"Storey {k}",
            k * RISE,
            k * RISE + 2.5,
            (Space(f"Stairs {k + 1}", rectangle(0, 2.4, 0, 5)), Space(f"Room {k + 1}", rectangle(2.6, 6, 0, 5))),
            (Hole("door", (f"Stairs {k + 1}", f"Room {k + 1}"), (2.5, 0.7), 0.8, 2.0),),
        )
        for k in range(2)
    )
    return Plan("stairwell", rectangle(-0.3, 6.3, -0.3, 5.3), levels, (stairs,))


@pytest.fixture(scope="module")
def graph(tmp_path_factory: pytest.TempPathFactory) -> BuildingGraph:
    out = tmp_path_factory.mktemp("stairwell") / "stairwell.e57"
    stations = np.array([(0.7, 0.6, 1.5), (4.3, 2.5, 1.5), (1.7, 0.6, RISE + 1.5), (4.3, 2.5, RISE + 1.5)])
    simulate(
        replace(build(stairwell_plan()), stations=stations), out, parameters=Parameters(Scanner(angular_step_deg=0.6))
    )
    return ingest([out], building="stairwell").graph


def nodes(graph: BuildingGraph, label: str) -> list[dict[str, Any]]:
    return [node.properties for node in graph.of_label(label)]


def test_a_landing_between_storeys_is_no_storey_and_no_room(graph: BuildingGraph) -> None:
    assert [storey["elevation"] for storey in nodes(graph, "Storey")] == pytest.approx([0.0, RISE], abs=0.02)
    assert len(nodes(graph, "Room")) == 4


def test_a_stairwell_has_floor_and_area_of_its_own_flights_included(graph: BuildingGraph) -> None:
    rooms = sorted(nodes(graph, "Room"), key=lambda room: (round(room["floor_elevation"], 1), room["area"]))
    assert [room["floor_elevation"] for room in rooms] == pytest.approx([0.0, 0.0, RISE, RISE], abs=0.02)
    assert [room["area"] for room in rooms] == pytest.approx([12.0, 17.0, 12.0, 17.0], rel=0.04)
