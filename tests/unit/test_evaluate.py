"""Evaluation on buildings of a few rooms whose figures are known by hand."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from enfilade.clouds import LABELS, LabelledCloud, write_cloud
from enfilade.errors import InputError
from enfilade.evaluate import evaluate, evaluate_graphs
from enfilade.evaluate.correspondence import overlap
from enfilade.evaluate.rooms import adjusted_rand_index
from enfilade.schema.exchange import write_graph
from enfilade.schema.graph import BuildingGraph

# Four rooms of 4 m x 4 m in a row, 0.2 m of wall between them, the last one storey up; and a landing nobody scanned.
ROOMS = {n: (4.2 * n, 0.0, 4.2 * n + 4.0, 4.0) for n in range(5)}
DOORS = [
    ("door", "open", (0, 1), (4.1, 2.0, 1.0), 0.9),
    ("passage", None, (1, 2), (8.3, 2.0, 1.2), 2.0),
    ("door", "closed", (0, 2), (4.1, 3.0, 1.0), 0.8),
    ("stairs", None, (2, 3), (12.5, 1.0, 2.0), 1.0),
    ("door", "open", (3, 4), (16.7, 2.0, 4.0), 0.9),
    ("window", "closed", (0,), (0.0, 2.0, 1.5), 1.2),
]
TABLE = (1.0, 1.0, 2.0, 1.6)


def make_graph(rooms=ROOMS, doors=DOORS, *, building="b", objects=((0, 0, "table"),), scans=True, storeys=None):
    graph = BuildingGraph(building)
    graph.add_node(building, "Building")
    storeys = storeys or {n: int(n >= 3) for n in rooms}
    for storey in sorted(set(storeys.values())):
        graph.add_node(f"{building}/s{storey}", "Storey", index=storey)
    for n, (x0, y0, x1, y1) in rooms.items():
        scanned = [f"scan {n}"] if scans and n != 4 else []
        area = (x1 - x0) * (y1 - y0)
        graph.add_node(
            f"{building}/r{n}", "Room", name=f"Room {n}", area=area, floor_elevation=3.0 * storeys[n], scans=scanned
        )
        graph.add_edge(f"{building}/s{storeys[n]}", "HAS_ROOM", f"{building}/r{n}")
    for n, (kind, state, ends, position, width) in enumerate(doors):
        id = f"{building}/p{n}"
        graph.add_node(id, "Opening", kind=kind, state=state, position=list(position), width=width)
        for room in ends:
            graph.add_edge(f"{building}/r{room}", "OPENS", id)
    for segments, room, name in objects:
        numbers = (segments,) if isinstance(segments, int) else segments
        id = f"{building}/" + "+".join(f"o{n}" for n in numbers)
        graph.add_node(id, "Object", name=name, size=[1.0, 0.6, 0.0], parts=len(numbers))
        graph.add_edge(f"{building}/r{room}", "CONTAINS", id)
    return graph


def make_cloud(rooms=ROOMS, objects=((0, TABLE),)):
    """Floors on a grid of 5 cm, with tables that hover over them."""
    axes = np.meshgrid(np.arange(0.025, 21, 0.05), np.arange(0.025, 4, 0.05))
    x, y = (axis.ravel() for axis in axes)
    room = np.full(len(x), -1, np.int32)
    for n, rectangle in rooms.items():
        room[inside(x, y, rectangle)] = n
    tables = [(n, inside(x, y, rectangle)) for n, rectangle in objects]
    parts = [(x, y, 0.0, room, -1)] + [(x[top], y[top], 0.7, room[top], n) for n, top in tables]
    positions = np.concatenate([np.column_stack([x, y, np.full_like(x, z)]) for x, y, z, _, _ in parts])
    labels = np.concatenate([part[3] for part in parts])
    object = np.concatenate([np.full(len(part[0]), part[4], np.int32) for part in parts])
    plane = np.where(object < 0, 0, -1).astype(np.int32)
    return LabelledCloud(positions, np.zeros_like(labels), labels, object, plane, np.zeros_like(labels))


def inside(x, y, rectangle):
    x0, y0, x1, y1 = rectangle
    return (x0 < x) & (x < x1) & (y0 < y) & (y < y1)


def moved(cloud, way):
    labels = (getattr(cloud, label) for label in LABELS)
    return LabelledCloud(cloud.positions + way, *labels)


def compare(graph=None, cloud=None):
    return evaluate_graphs(graph or make_graph(scans=False), cloud or make_cloud(), make_graph(), make_cloud())


def test_the_truth_is_as_good_as_can_be():
    found = compare()
    assert (found.rooms.true, found.rooms.predicted) == (4, 4)
    assert (found.rooms.f1_at_50, found.rooms.f1_at_70, found.rooms.ari) == (1, 1, 1)
    assert (found.storeys.rooms_right, found.measures.area_error, found.measures.floor_error_m) == (1, 0, 0)
    assert (found.openings.true, found.openings.precision, found.openings.recall) == (2, 1, 1)
    assert (found.openings.closed_true, found.openings.closed_found, found.openings.closed_marked) == (1, 1, 1)
    assert (found.openings.stairs_true, found.openings.stairs_found, found.openings.stairs_invented) == (1, 1, 0)
    assert (found.connectivity.true_pairs, found.connectivity.f1) == (3, 1)
    assert found.connectivity.true_reachable == 1
    assert (found.objects.true, found.objects.found) == (1, 1)
    assert found.faults == ()


def test_a_room_that_no_scan_stands_in_is_neither_asked_nor_held_against_the_prediction():
    without = {n: ROOMS[n] for n in range(4)}
    assert compare(make_graph(without, DOORS[:4], scans=False), make_cloud(without)).rooms.f1_at_50 == 1
    third = {**ROOMS, 4: (16.8, 0.0, 18.0, 4.0)}
    assert compare(cloud=make_cloud(third)).rooms.f1_at_50 == 1
    assert compare().openings.invented == ()


def test_two_rooms_taken_as_one():
    merged = {0: (0.0, 0.0, 8.2, 4.0), 2: ROOMS[2], 3: ROOMS[3]}
    doors = [("passage", None, (0, 2), (8.3, 2.0, 1.2), 2.0)]
    found = compare(make_graph(merged, doors, scans=False), make_cloud(merged))
    # Neither half reaches IoU .5 with the whole, the wall between them being part of it.
    assert found.rooms.f1_at_50 == pytest.approx(2 * 2 / (3 + 4))
    assert found.rooms.merged == ("r0 Room 0 + r1 Room 1 in r0 Room 0",)
    assert found.rooms.missed == ("r0 Room 0", "r1 Room 1")
    assert found.rooms.invented == ("r0 Room 0",)
    assert found.openings.recall == 0
    assert found.connectivity.f1 == 0


def test_a_room_taken_as_two():
    halves = {**ROOMS, 0: (0.0, 0.0, 2.5, 4.0), 7: (2.5, 0.0, 4.0, 4.0)}
    storeys = {n: int(n in (3, 4)) for n in halves}
    found = compare(make_graph(halves, scans=False, storeys=storeys), make_cloud(halves))
    assert found.rooms.split == ("r0 Room 0 into r0 Room 0 + r7 Room 7",)
    assert found.rooms.f1_at_50 == pytest.approx(2 * 4 / (4 + 5))
    assert found.rooms.f1_at_70 == pytest.approx(2 * 3 / (4 + 5))
    assert found.rooms.invented == ("r7 Room 7",)
    assert 0.8 < found.rooms.ari < 1
    assert found.measures.area_error == 0


def test_rooms_may_be_numbered_otherwise():
    order = {0: 3, 1: 0, 2: 1, 3: 2, 4: 9}
    rooms = {order[n]: rectangle for n, rectangle in ROOMS.items()}
    doors = [(kind, state, tuple(order[n] for n in ends), at, width) for kind, state, ends, at, width in DOORS]
    storeys = {order[n]: int(n >= 3) for n in ROOMS}
    graph = make_graph(rooms, doors, scans=False, storeys=storeys, objects=((0, 3, "table"),))
    assert compare(graph, make_cloud(rooms)).to_dict() == compare().to_dict()


def test_a_room_on_another_storey():
    found = compare(make_graph(scans=False, storeys={0: 0, 1: 0, 2: 1, 3: 1, 4: 1}))
    assert found.storeys.rooms_right == pytest.approx(4 / 5)
    assert found.storeys.misplaced == ("r2 Room 2",)


@pytest.mark.parametrize(
    ("door", "missed", "invented"),
    [
        (("door", "open", (0, 1), (4.1, 2.2, 1.0), 0.9), (), ()),
        (("door", "open", (0, 1), (4.1, 2.4, 1.0), 0.9), ("p0",), ("p0",)),
        (("door", "open", (0, 3), (4.1, 2.0, 1.0), 0.9), ("p0",), ("p0",)),
        (("window", None, (0, 1), (4.1, 2.0, 1.0), 0.9), ("p0",), ()),
        (("door", "open", (0,), (4.1, 2.0, 1.0), 0.9), ("p0",), ()),
    ],
)
def test_an_opening_joins_the_right_rooms_at_the_right_place(door, missed, invented):
    found = compare(make_graph(doors=[door, *DOORS[1:]], scans=False)).openings
    assert tuple(name.split()[0] for name in found.missed) == missed
    assert tuple(name.split()[0] for name in found.invented) == invented
    assert found.recall == (2 - len(missed)) / 2


def test_two_predictions_of_one_door_are_one_too_many():
    twin = ("door", "open", (1, 0), (4.1, 2.1, 1.0), 0.7)
    found = compare(make_graph(doors=[*DOORS, twin], scans=False)).openings
    assert (found.recall, found.precision) == (1, pytest.approx(2 / 3))
    assert found.invented == ("p6 (r1 Room 1 – r0 Room 0)",)


def test_width_and_kind_of_what_was_found():
    doors = [("passage", None, (0, 1), (4.1, 2.0, 1.0), 1.0), ("passage", None, (2, 1), (8.3, 2.0, 1.2), 1.7)]
    found = compare(make_graph(doors=doors, scans=False)).openings
    assert found.width_error_m == pytest.approx(0.2)
    assert found.kinds_right == 0.5
    assert (found.closed_found, found.stairs_found) == (0, 0)


def test_what_only_a_closed_door_joins_counts_neither_way():
    opened = [(kind, "open" if state == "closed" else state, *rest) for kind, state, *rest in DOORS]
    found = compare(make_graph(doors=opened, scans=False))
    assert found.connectivity.f1 == 1
    assert (found.openings.closed_found, found.openings.closed_marked, found.openings.precision) == (1, 0, 1)


def test_rooms_without_doors_cannot_be_reached():
    found = compare(make_graph(doors=DOORS[:1], scans=False)).connectivity
    assert found.predicted_reachable == pytest.approx(1 / 6)
    assert found.reachable_right == pytest.approx(1 / 6)
    assert found.f1 == pytest.approx(2 * 1 / (1 + 3))


def test_an_object_may_be_a_combination_of_segments():
    left, right = (1.0, 1.0, 1.4, 1.6), (1.4, 1.0, 2.0, 1.6)
    cloud = make_cloud(objects=((4, left), (5, right)))
    alone = compare(make_graph(scans=False, objects=((4, 0, "a"), (5, 0, "b"))), cloud).objects
    joined = compare(make_graph(scans=False, objects=((4, 0, "a"), (5, 0, "b"), ((4, 5), 0, "c"))), cloud).objects
    assert alone.mean_iou == pytest.approx(0.6, abs=0.05)
    assert (joined.mean_iou, joined.found, joined.predicted) == (1, 1, 2)
    none = compare(make_graph(scans=False, objects=()), make_cloud(objects=())).objects
    assert (none.found, none.missed) == (0, ("o0 table",))


def test_clouds_of_two_buildings_are_refused():
    elsewhere = make_cloud({0: (300.0, 0.0, 301.0, 1.0)}, objects=())
    elsewhere = LabelledCloud(elsewhere.positions * 3 + 500, *(getattr(elsewhere, label) for label in LABELS))
    with pytest.raises(InputError, match="no place in common"):
        compare(cloud=elsewhere)


@pytest.mark.parametrize("way", [(100.0, 0.0, 0.0), (0.0, -0.4, 0.1), (3e5, 5e6, 0.0)])
def test_a_shifted_prediction_is_refused_and_the_shift_said(way):
    said = ", ".join(f"{step:.2f}" for step in way)
    with pytest.raises(InputError, match=rf"lies \({said}\) m off the truth"):
        compare(cloud=moved(make_cloud(), np.array(way)))


def test_storeys_are_compared_by_the_rooms_on_them_not_by_their_index():
    found = compare(make_graph(scans=False, storeys={n: 5 + int(n >= 3) for n in ROOMS})).storeys
    assert (found.rooms_right, found.misplaced) == (1, ())


def test_of_many_faults_the_table_names_a_dozen():
    doors = [("door", "open", (0, 1), (4.1, 2.0 + n, 30.0), 0.9) for n in range(15)]
    found = compare(make_graph(doors=doors, scans=False))
    named = [which for what, which, _ in found.to_fault_table() if what == "openings invented"]
    assert sum("Room 0" in which for which in named) == 12
    assert named[-1] == "and 3 more"
    assert len(found.openings.invented) == 15


def test_two_folders_are_compared(tmp_path):
    for name, scans in (("prediction", False), ("truth", True)):
        (tmp_path / name).mkdir()
        write_graph(make_graph(scans=scans), tmp_path / name / "graph.json")
        write_cloud(tmp_path / name / "cloud.ply", make_cloud())
    found = evaluate(tmp_path / "prediction", tmp_path / "truth")
    assert json.loads(json.dumps(found.to_dict()))["rooms"]["f1_at_50"] == 1
    assert ("rooms, predicted of true", "4 of 4") in found.to_table()


@given(st.lists(st.integers(0, 3), min_size=2, max_size=60), st.permutations(range(4)))
def test_the_rand_index_of_a_renamed_partition_is_one(labels, names):
    true = np.array(labels, np.int32)
    renamed = np.array([names[label] for label in labels], np.int32)
    assert adjusted_rand_index(overlap(true, renamed), frozenset(range(4))) == pytest.approx(1)


def test_the_rand_index_of_a_textbook_case():
    true, predicted = np.array([0, 0, 0, 1, 1, 1], np.int32), np.array([0, 0, 1, 1, 2, 2], np.int32)
    assert adjusted_rand_index(overlap(true, predicted), frozenset({0, 1})) == pytest.approx(0.24242424)
