"""The corpus of the bench: buildings that follow the schema, each told by its number and the seed alone."""

from __future__ import annotations

import gzip
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from enfilade.descriptors import DEFAULT_LAYOUT, quantise
from enfilade.schema.checks import check
from enfilade.schema.exchange import write_graph

BENCH = Path(__file__).parents[2] / "bench"
PLAN = {
    "id": "1",
    "m_per_px": 0.01,
    "rooms": [
        {"id": 0, "type": "Kitchen", "m2": 11.0, "bbox": [0, 0, 300, 400]},
        {"id": 1, "type": "Entry", "m2": 7.0, "bbox": [310, 0, 500, 400]},
        {"id": 2, "type": "Outdoor", "m2": 18.0, "bbox": [0, 410, 500, 800]},
        {"id": 3, "type": "Undefined", "m2": 1.0, "bbox": [900, 900, 1000, 1000]},
    ],
    "doors": [[0, 1, 305, 200, 90], [1, -1, 500, 200, 80], [-1, -1, 0, 0, 80]],
}


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(BENCH))
    import corpus

    return corpus


@pytest.fixture
def plans(tmp_path: Path) -> Path:
    path = tmp_path / "plans.jsonl.gz"
    with gzip.open(path, "wt", encoding="utf-8") as file:
        file.write(json.dumps(PLAN) + "\n")
    return path


def test_a_plan_is_read_in_metres(bench: Any, plans: Path) -> None:
    (home,) = bench.read_homes(plans)
    assert [(room.function, room.area) for room in home.rooms] == [
        ("kitchen", 11.0),
        ("hall", 7.0),
        ("terrace", 18.0),
        (None, 1.0),
    ]
    assert [(door.rooms, door.width) for door in home.doors] == [((0, 1), 0.9), ((1,), 0.8)]
    assert [(wall.rooms, round(wall.gap, 6), round(wall.length, 6)) for wall in home.walls] == [
        ((0, 1), 0.1, 4.0),
        ((0, 2), 0.1, 3.0),
        ((1, 2), 0.1, 1.9),
    ]


def test_a_building_is_told_by_its_number_and_the_seed(bench: Any, plans: Path) -> None:
    homes = bench.read_homes(plans)
    counts = quantise(np.arange(DEFAULT_LAYOUT.bins))
    models = [sys.modules["corpus_objects"].Model((0.5, 0.4, 0.9), 0.1, 500, counts, counts)]

    many = list(bench.buildings(range(12), homes, models))

    assert list(bench.buildings(range(5, 7), homes, models)) == many[5:7]
    assert next(bench.buildings(range(1), homes, models, seed=1)) != many[0]
    for graph in many:
        check(graph)
        assert {node.properties["parts"] for node in graph.of_label("Object")} <= {1, 2}
        assert len(list(graph.of_label("Room"))) == 4 * len(list(graph.of_label("Storey")))
    kinds = {node.properties["kind"] for graph in many for node in graph.of_label("Opening")}
    assert {"door", "window", "stairs"} <= kinds
    singles = [len([n for n in g.of_label("Object") if n.properties["parts"] == 1]) for g in many]
    assert 70 < np.mean(singles) < 110


def test_measured_objects_come_from_graph_files(bench: Any, plans: Path, tmp_path: Path) -> None:
    counts = quantise(np.arange(DEFAULT_LAYOUT.bins))
    model = sys.modules["corpus_objects"].Model((0.5, 0.4, 0.9), 0.1, 500, counts, counts)
    (graph,) = bench.buildings(range(1), bench.read_homes(plans), [model])
    write_graph(graph, tmp_path / "graph.json")

    found = bench.measured_models([tmp_path / "graph.json"])

    assert len(found) == len([n for n in graph.of_label("Object") if n.properties["parts"] == 1])
    with pytest.raises(ValueError, match="no object"):
        bench.measured_models([])
