"""Sheets of evaluations: the right things on the right storey, with the right verdict."""

from __future__ import annotations

import pytest
from test_evaluate import DOORS, ROOMS, make_cloud, make_graph

from enfilade.errors import NotFoundError
from enfilade.evaluate import evaluate_graphs
from enfilade.pictures import draw_evaluation
from enfilade.pictures.evaluation_marks import Verdict, evaluation_sheets


def outlined(graph):
    for node in graph.of_label("Room"):
        x0, y0, x1, y1 = ROOMS[int(node.id.rsplit("r", 1)[-1])]
        node.properties["outline"] = [[x0, y0, x1, y0, x1, y1, x0, y1]]
    for node in graph.of_label("Object"):
        node.properties["position"] = [1.5, 1.3, 0.7]
    return graph


@pytest.fixture
def found():
    shut = ("door", "closed", *DOORS[0][2:])
    spurious = ("door", "open", (0, 1), (4.1, 0.5, 1.0), 0.9)
    rooms = {n: ROOMS[n] for n in (0, 1, 3, 4)}
    prediction = outlined(make_graph(rooms, [shut, spurious], scans=False))
    return evaluate_graphs(prediction, make_cloud(rooms), outlined(make_graph()), make_cloud())


def test_marks_say_what_became_of_each_thing(found):
    ground, upper = evaluation_sheets(found)
    assert (ground.name, upper.name) == ("s0", "s1")
    rooms = {mark.name: mark for mark in ground.truth.rooms}
    assert rooms["r2 Room 2"].verdict is Verdict.MISSED
    assert rooms["r2 Room 2"].tint is None
    assert {mark.name: mark.tint for mark in ground.prediction.rooms} == {
        "r0 is r0 Room 0": rooms["r0 Room 0"].tint,
        "r1 is r1 Room 1": rooms["r1 Room 1"].tint,
    }
    assert [mark.verdict for mark in ground.prediction.openings] == [Verdict.RIGHT, Verdict.INVENTED]
    assert ground.truth.openings[0].verdict is Verdict.SAID_CLOSED
    assert ground.truth.openings[1].verdict is Verdict.MISSED
    assert [mark.verdict for mark in ground.truth.objects] == [Verdict.RIGHT]
    assert len(upper.truth.rooms) == 2


def test_faults_are_numbered_as_they_are_listed(found):
    ground = next(evaluation_sheets(found))
    numbers = [mark.number for half in (ground.truth, ground.prediction) for mark in half.numbers]
    listed = {int(line.split()[0]): line for line in ground.faults}
    assert set(numbers) <= listed.keys()
    assert "r2 Room 2" in listed[min(listed)]
    assert any("said closed" in line for line in listed.values())


def test_a_sheet_is_drawn_for_each_storey_and_again_the_same(found, tmp_path):
    drawn = draw_evaluation(found, tmp_path / "new", name="b")
    assert [path.name for path in drawn] == ["b-s0.png", "b-s1.png"]
    again = draw_evaluation(found, tmp_path / "other", name="b")
    assert [path.read_bytes() for path in drawn] == [path.read_bytes() for path in again]


def test_without_places_there_is_nothing_to_draw(tmp_path):
    found = evaluate_graphs(make_graph(), make_cloud(), make_graph(), make_cloud())
    with pytest.raises(NotFoundError, match="an outline to draw"):
        draw_evaluation(found, tmp_path)
