"""Evaluation on buildings of a few rooms whose figures are known by hand."""

from __future__ import annotations

import json
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from enfilade.clouds import LABELS, LabelledCloud, write_cloud
from enfilade.errors import InputError
from enfilade.evaluate import evaluate, evaluate_graphs, evaluate_many, pair_folders, pool, summary_rows
from enfilade.evaluate.correspondence import CELL_M, REACH_M, nearest_by_cell, overlap
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


WALLS = [(0, 1), (1, 2), (0, 3)]


def faults_of(found, subject="opening"):
    """Sorts of faults with their causes."""
    return [(fault.what, fault.cause) for fault in found.faults if fault.subject == subject]


def neighbours(graph, pairs):
    for a, b in pairs:
        graph.add_edge(f"b/r{a}", "NEIGHBOUR", f"b/r{b}", gap=0.2)
    return graph


@pytest.mark.parametrize(
    ("door", "missed", "invented"),
    [
        (("door", "open", (0, 1), (4.1, 2.4, 1.0), 0.9), "off", "off"),
        (("door", "open", (0, 3), (4.1, 2.0, 1.0), 0.9), "wrong_rooms", "wrong_rooms"),
        (("window", None, (0, 1), (4.1, 2.0, 1.0), 0.9), "wrong_kind", None),
        (("door", "open", (0,), (4.1, 2.0, 1.0), 0.9), "wrong_rooms", None),
        (("door", "closed", (0, 1), (4.1, 2.0, 1.0), 0.9), "said_closed", None),
        (("door", "open", (0, 1), (4.1, 2.0, 5.0), 0.9), "none_near", "none_near"),
    ],
)
def test_a_missed_and_an_invented_door_say_why(door, missed, invented):
    # The closed door beside it is left out, so that nothing is near but what is predicted.
    truth = make_graph(doors=[*DOORS[:2], *DOORS[3:]])
    prediction = make_graph(doors=[door, DOORS[1], *DOORS[3:]], scans=False)
    found = evaluate_graphs(prediction, make_cloud(), truth, make_cloud())
    told = dict(faults_of(found))
    assert told.get("openings missed") == missed
    assert told.get("openings invented") == invented


def test_a_door_that_is_said_closed_is_missed_and_costs_no_precision():
    shut = ("door", "closed", *DOORS[0][2:])
    found = compare(make_graph(doors=[shut, *DOORS[1:]], scans=False))
    assert (found.openings.recall, found.openings.precision) == (0.5, 1)
    assert found.openings.missed == ("p0 (r0 Room 0 – r1 Room 1)",)
    assert found.openings.closed.invented == 0
    assert found.calibration.openings.right == ()


def test_a_door_of_a_merged_room_says_so():
    merged = {0: (0.0, 0.0, 8.2, 4.0), 2: ROOMS[2], 3: ROOMS[3]}
    found = compare(make_graph(merged, [("passage", None, (0, 2), (8.3, 2.0, 1.2), 2.0)]), make_cloud(merged))
    assert ("openings missed", "rooms_not_found") in faults_of(found)
    (why,) = (f.why for f in found.faults if f.fault == "missed" and f.id == "b/p1")
    assert why == "r1 Room 1 was merged into r0 Room 0; p0 (r0 Room 0 – r2 Room 2) is at its place"
    assert faults_of(found, "room")[:2] == [("rooms merged", "merged"), ("rooms missed", "merged")]


def test_a_second_prediction_of_a_door_is_found_already():
    twin = ("door", "open", (1, 0), (4.1, 2.1, 1.0), 0.7)
    assert faults_of(compare(make_graph(doors=[*DOORS, twin], scans=False))) == [("openings invented", "twice")]


def test_ajar_doors_count_neither_way_and_join_rooms():
    truth = make_graph(doors=[("door", "ajar", *DOORS[0][2:]), *DOORS[1:]])
    for state, marked in (("ajar", 1), ("open", 0)):
        prediction = make_graph(doors=[("door", state, *DOORS[0][2:]), *DOORS[1:]], scans=False)
        found = evaluate_graphs(prediction, make_cloud(), truth, make_cloud())
        assert (found.openings.true, found.openings.predicted) == (1, 1)
        assert (found.openings.ajar.true, found.openings.ajar.found, found.openings.ajar_marked) == (1, 1, marked)
        assert (found.connectivity.true_pairs, found.connectivity.f1) == (3, 1)


def test_doors_without_a_state_are_open_only_where_the_truth_says_none_of_any():
    silent = [(kind, None, *rest) for kind, _, *rest in DOORS]
    some = [silent[0], *DOORS[1:]]
    found = evaluate_graphs(make_graph(scans=False), make_cloud(), make_graph(doors=silent), make_cloud()).openings
    assert (found.true, found.unstated.true) == (3, 0)
    found = evaluate_graphs(make_graph(scans=False), make_cloud(), make_graph(doors=some), make_cloud()).openings
    assert (found.true, found.unstated.true, found.unstated.found, found.precision) == (1, 1, 1, 1)


def test_windows_and_doors_to_the_outside_are_asked_for_apart():
    front = ("door", "closed", (2,), (10.4, 0.0, 1.0), 1.0)
    truth = make_graph(doors=[*DOORS, front])
    pane = ("window", "closed", (0,), (0.0, 2.2, 1.4), 1.0)
    spurious = ("window", "closed", (1,), (6.0, 0.0, 1.5), 1.0)
    prediction = make_graph(doors=[*DOORS[:5], pane, spurious, front], scans=False)
    found = evaluate_graphs(prediction, make_cloud(), truth, make_cloud()).openings
    assert (found.windows.true, found.windows.found, found.windows.invented) == (1, 1, 1)
    assert found.windows.width_error_m == pytest.approx(0.2)
    assert found.windows.position_error_m == pytest.approx(np.hypot(0.2, 0.1))
    assert (found.outside.true, found.outside.found, found.outside.invented) == (1, 1, 0)
    assert (found.precision, found.recall) == (1, 1)


def test_a_door_to_a_room_seen_from_outside_is_found_apart():
    assert (compare().openings.apart.true, compare().openings.apart.found) == (1, 1)
    spurious = ("door", "open", (3, 4), (16.7, 3.5, 4.0), 0.9)
    found = compare(make_graph(doors=[*DOORS, spurious], scans=False)).openings
    assert (found.apart.invented, found.precision) == (1, 1)


def test_a_door_from_a_room_to_itself_is_not_asked_for():
    truth = make_graph(doors=[*DOORS, ("door", "open", (0,), (2.0, 2.0, 1.0), 0.9)])
    truth.nodes["b/p6"].properties["normal"] = [1.0, 0.0, 0.0]
    assert evaluate_graphs(make_graph(), make_cloud(), truth, make_cloud()).openings.outside.true == 1
    truth.nodes["b/r0"].properties["outline"] = [[0.0, 0.0, 4.0, 0.0, 4.0, 4.0, 0.0, 4.0]]
    assert evaluate_graphs(make_graph(), make_cloud(), truth, make_cloud()).openings.outside.true == 0


def test_a_stair_well_and_a_roof_space_are_reported_apart():
    truth = make_graph()
    truth.nodes["b/p3"].properties.update(width=3.0, height=3.0)  # 9 of 16 m² of room 2 and of room 3
    truth.nodes["b/r1"].properties["height"] = 1.2
    without = {n: ROOMS[n] for n in (0, 2, 4)}
    found = evaluate_graphs(make_graph(without, doors=[]), make_cloud(without), truth, make_cloud()).rooms
    assert (found.true, found.predicted, found.f1_at_50) == (1, 1, 1)
    assert (found.stair_wells.true, found.stair_wells.found) == (2, 1)
    assert (found.roof_spaces.true, found.roof_spaces.found) == (1, 0)
    assert found.f1_of_all == pytest.approx(2 * 3 / (3 + 5))


def test_rooms_seen_from_outside_are_found_and_marked():
    found = compare(make_graph(scans=True)).rooms.unscanned
    assert (found.true, found.found, found.marked) == (1, 1, 1)


def test_neighbours_are_pairs_of_scanned_rooms():
    truth = neighbours(make_graph(), [*WALLS, (3, 4)])
    prediction = neighbours(make_graph(scans=False), [(1, 0), (2, 1), (2, 3)])
    found = evaluate_graphs(prediction, make_cloud(), truth, make_cloud())
    assert (found.neighbours.true, found.neighbours.predicted, found.neighbours.right) == (3, 3, 2)
    assert faults_of(found, "neighbour") == [("neighbours missed", "missed"), ("neighbours invented", "invented")]
    assert compare(prediction).neighbours.f1 is None


def halves(*edges):
    """Cuts the table into strips at these x, each a segment."""
    return tuple((4 + k, (a, TABLE[1], b, TABLE[3])) for k, (a, b) in enumerate(pairwise(edges)))


@pytest.mark.parametrize(
    ("pieces", "cause"),
    [
        ((), "unlabelled"),
        (halves(1.0, 1.25, 1.5, 1.75, 2.0), "no_combination"),
        (halves(*np.linspace(1.0, 2.0, 9)), "shattered"),
        (halves(1.0, 1.35), "unlabelled"),
    ],
)
def test_a_missed_object_says_why(pieces, cause):
    nodes = [(number, 0, "piece") for number, _ in pieces]
    found = compare(make_graph(scans=False, objects=nodes), make_cloud(objects=pieces))
    assert faults_of(found, "object") == [("objects missed", cause)]


def test_two_objects_in_one_segment_are_merged():
    beside = (2.0, 1.0, 3.2, 1.6)
    truth = make_graph(objects=((0, 0, "table"), (1, 0, "desk")))
    both = make_cloud(objects=((3, (1.0, 1.0, 3.2, 1.6)),))
    found = evaluate_graphs(
        make_graph(objects=((3, 0, "long"),)), both, truth, make_cloud(objects=((0, TABLE), (1, beside)))
    )
    missed = {fault.name: (fault.cause, fault.why) for fault in found.faults if fault.subject == "object"}
    assert missed == {"o0 table": ("merged", "in one segment o3 with o1 desk (55 % of it)")}


def test_a_segment_on_a_wall_is_a_ghost():
    cloud = make_cloud()
    patch = (cloud.positions[:, 2] == 0) & inside(*cloud.positions[:, :2].T, (5.0, 1.0, 6.0, 2.0))
    labels = {name: getattr(cloud, name) for name in LABELS} | {"object": np.where(patch, 9, cloud.object)}
    graph = make_graph(scans=False, objects=((0, 0, "table"), (9, 1, "ghost")))
    found = compare(graph, LabelledCloud(cloud.positions, **labels))
    assert (found.objects.ghosts, found.objects.predicted, found.objects.found) == (1, 2, 1)
    assert faults_of(found, "object") == [("objects invented", "structure")]


def test_calibration_compares_what_is_said_with_what_is_so():
    off = ("door", "open", (1, 2), (8.3, 3.5, 1.2), 0.8)
    graph = make_graph(doors=[*DOORS, off], scans=False)
    for node, said in zip(graph.of_label("Opening"), (0.95, 0.95, 0.4, 0.85, 0.7, 0.95, 0.85), strict=True):
        node.properties["confidence"] = said
    found = compare(graph).calibration
    assert sorted(zip(found.openings.said, found.openings.right, strict=True)) == [
        (0.4, 1), (0.85, 0), (0.85, 1), (0.95, 1), (0.95, 1), (0.95, 1)
    ]  # fmt: skip
    assert found.openings.expected_error == pytest.approx((0.6 + 2 * 0.35 + 3 * 0.05) / 6)
    assert found.openings.brier == pytest.approx((0.36 + 0.7225 + 0.0225 + 3 * 0.0025) / 6)
    assert [(b["from"], b["count"], b["right"]) for b in found.openings.bins] == [
        (0.4, 1, 1),
        (0.8, 2, 0.5),
        (0.9, 3, 1),
    ]
    assert (found.closed_doors.said, found.stairs.said) == ((0.4,), (0.85,))


def test_storeys_are_matched_so_that_the_most_rooms_are_right():
    truth = make_graph(storeys={0: 0, 1: 0, 2: 0, 3: 1, 4: 1})
    found = evaluate_graphs(
        make_graph(storeys={0: 0, 1: 1, 2: 1, 3: 1, 4: 1}), make_cloud(), truth, make_cloud()
    ).storeys
    assert (found.placed, found.right) == (5, 3)


def bare(graph):
    """Takes all properties from a graph but what its edges say."""
    for node in graph.nodes.values():
        node.properties = {name: value for name, value in node.properties.items() if name == "building"}
    return graph


@pytest.mark.parametrize("empty", ["prediction", "truth", "both"])
def test_graphs_without_properties_give_figures(empty, tmp_path):
    prediction = bare(make_graph()) if empty != "truth" else make_graph()
    truth = bare(make_graph()) if empty != "prediction" else make_graph()
    found = evaluate_graphs(prediction, make_cloud(), truth, make_cloud())
    assert found.rooms.f1_at_70 == 1
    assert found.measures.area_error is None
    assert json.loads(json.dumps(found.to_dict()))["openings"]["width_error_m"] is None


def test_an_empty_prediction_finds_nothing():
    graph = BuildingGraph("b")
    graph.add_node("b", "Building")
    found = compare(graph)
    assert (found.rooms.f1_at_50, found.rooms.ari, found.objects.found) == (0, 0, 0)
    assert (found.openings.recall, found.openings.precision, found.connectivity.f1) == (0, None, 0)
    assert {fault.cause for fault in found.faults if fault.subject == "room"} == {"unlabelled"}


def test_clouds_without_points_are_refused():
    nothing = make_cloud().take(slice(0, 0))
    with pytest.raises(InputError, match="predicted cloud has no points"):
        evaluate_graphs(make_graph(), nothing, make_graph(), make_cloud())
    with pytest.raises(InputError, match="true cloud has no points"):
        evaluate_graphs(make_graph(), make_cloud(), make_graph(), nothing)


def test_labels_that_the_graph_does_not_know_are_none():
    without = {n: ROOMS[n] for n in range(1, 5)}
    found = compare(make_graph(without, doors=[], objects=(), scans=False))
    assert found.rooms.missed == ("r0 Room 0",)
    assert found.rooms.invented == ()


@given(st.integers(0, 2**32 - 1))
def test_the_nearest_point_is_found_as_by_a_tree(seed):
    random = np.random.default_rng(seed)
    truth, prediction = random.uniform(0, 0.2, (40, 3)), random.uniform(0, 0.2, (60, 3))
    kept, found = nearest_by_cell(prediction, np.arange(60), truth)
    distances = np.linalg.norm(prediction[None] - truth[kept][:, None], axis=2)
    assert 0 < len(kept) <= len(truth)
    for row, place in zip(distances, found, strict=True):
        nearest = row.min()
        assert (place < 0) == (nearest > REACH_M)
        assert place < 0 or row[place] == nearest or row[place] <= np.sqrt(3) * CELL_M


def folder_of(folder, graph, cloud):
    folder.mkdir(parents=True)
    write_graph(graph, folder / "graph.json")
    write_cloud(folder / "cloud.ply", cloud)


def test_many_buildings_are_pooled_from_their_records(tmp_path):
    folder_of(tmp_path / "found" / "good.exported", make_graph(), make_cloud())
    folder_of(tmp_path / "found" / "poor", make_graph(doors=DOORS[1:]), make_cloud())
    for name in ("good.truth", "poor", "lost.truth"):
        folder_of(tmp_path / "true" / name, make_graph(), make_cloud())
    folders = pair_folders(tmp_path / "found", tmp_path / "true")
    assert list(folders) == ["good", "lost", "poor"]
    records = {outcome.name: outcome.to_dict() for outcome in evaluate_many(folders)}
    assert "lost" in records["lost"]["error"]
    total = pool(json.loads(json.dumps(records)))
    assert (total["buildings"], total["failed"], total["rooms"]["true"]) == (2, 1, 8)
    assert (total["openings"]["true"], total["openings"]["recall"]) == (4, 0.75)
    assert total["causes"] == {"openings missed: none_there": 1}
    assert len(total["measures"]["area_errors"]) == 8
    assert [row[0] for row in summary_rows(records)] == ["lost", "poor", "good", "total"]


def test_one_building_pooled_has_its_own_figures():
    record = json.loads(json.dumps(compare(make_graph(doors=DOORS[:3], scans=False)).to_dict()))
    total = pool({"b": record})
    for figure in ("measures", "connectivity", "neighbours", "calibration"):
        assert total[figure] == record[figure]
    assert (total["rooms"]["f1_at_50"], total["rooms"]["ari"]) == (record["rooms"]["f1_at_50"], record["rooms"]["ari"])
    assert total["openings"]["stairs"] == record["openings"]["stairs"]


def test_folders_without_truth_are_refused(tmp_path):
    with pytest.raises(InputError, match="nor folders NAME"):
        pair_folders(tmp_path, tmp_path)
