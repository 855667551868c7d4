"""Evaluation: what is asked for apart, why things went wrong, odd inputs, and many buildings."""

from __future__ import annotations

import json
from itertools import pairwise

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st
from test_evaluate import DOORS, ROOMS, TABLE, compare, inside, make_cloud, make_graph

from enfilade.cli import cli
from enfilade.clouds import LABELS, LabelledCloud, write_cloud
from enfilade.errors import InputError
from enfilade.evaluate import evaluate_graphs, evaluate_many, pair_folders, pool, summary_rows
from enfilade.evaluate.correspondence import CELL_M, REACH_M, nearest_by_cell
from enfilade.evaluate.many import cause_rows
from enfilade.schema.exchange import write_graph
from enfilade.schema.graph import BuildingGraph

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
    kept, found = nearest_by_cell(prediction, truth)
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
    said = dict(cause_rows(records))
    assert said["poor"] == "openings missed: none_there (1)"
    assert "lost" in said["lost"]


def test_the_command_prints_many_buildings_and_fails_where_one_does(tmp_path):
    folder_of(tmp_path / "found" / "good", make_graph(), make_cloud())
    folder_of(tmp_path / "true" / "good.truth", make_graph(), make_cloud())
    folders = [str(tmp_path / "found"), str(tmp_path / "true")]
    whole = CliRunner().invoke(cli, ["evaluate", *folders, "--format", "json"])
    assert whole.exit_code == 0
    assert json.loads(whole.stdout)["total"]["rooms"]["f1_at_50"] == 1
    folder_of(tmp_path / "true" / "lost.truth", make_graph(), make_cloud())
    partly = CliRunner().invoke(cli, ["evaluate", *folders])
    assert partly.exit_code == 1
    assert "lost" in partly.stdout
    assert "Traceback" not in partly.output


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
