"""Plans and matches as pictures: what is drawn, into which files, and what is refused."""

from __future__ import annotations

import re

import numpy as np
import pytest
from matplotlib.image import imread
from matplotlib.text import Text

from enfilade.clouds import LabelledCloud
from enfilade.descriptors import Shape
from enfilade.errors import InputError, NotFoundError, StoreError
from enfilade.pictures import draw_match, draw_plan, draw_storeys
from enfilade.pictures.canvas import save
from enfilade.pictures.scene import plan_scene
from enfilade.pictures.solid import Camera, render_mesh, render_points, span_of
from enfilade.pictures.style import OPENING_COLOURS
from enfilade.schema.graph import BuildingGraph

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float), np.array([[0, 1, 2], [0, 2, 3]], np.int32)


@pytest.fixture
def graph():
    """Two storeys: two rooms with a door below, one room above, a table, and names that are hard to set."""
    graph = BuildingGraph("b")
    graph.add_node("b", "Building", name="Haus $\\alpha$ \n \u5bb6")
    for n, name in enumerate(("Ground", "Upper")):
        graph.add_node(f"b/s{n}", "Storey", index=n, name=name)
        graph.add_edge("b", "HAS_STOREY", f"b/s{n}")
    for n, (x0, x1, storey) in enumerate([(0, 4, 0), (4.2, 9, 0), (0, 4, 1)]):
        ring = [x0, 0, x1, 0, x1, 3, x0, 3]
        graph.add_node(
            f"b/r{n}", "Room", name=f"Room_{n}", outline=[ring], area=(x1 - x0) * 3.0, floor_elevation=3.0 * storey
        )
        graph.add_edge(f"b/s{storey}", "HAS_ROOM", f"b/r{n}")
    graph.add_node(
        "b/p0", "Opening", kind="door", state="open", width=0.9, position=[4.1, 1.5, 1.0], normal=[1.0, 0, 0]
    )
    graph.add_node("b/p1", "Opening", kind="stairs", position=[1.0, 1.0, 2.9], normal=[0.0, 0, 1.0])
    for room, opening in (("b/r0", "b/p0"), ("b/r1", "b/p0"), ("b/r0", "b/p1"), ("b/r2", "b/p1")):
        graph.add_edge(room, "OPENS", opening)
    graph.add_node("b/o0", "Object", name="table", segments=["b/o0"], position=[6.0, 1.0, 0.7])
    graph.add_edge("b/r1", "CONTAINS", "b/o0")
    return graph


@pytest.fixture
def cloud():
    x, z = (axis.ravel() for axis in np.meshgrid(np.arange(0, 9, 0.05), np.arange(0, 2.5, 0.05)))
    wall = np.column_stack([x, np.zeros_like(x), z])
    top = np.random.default_rng(0).uniform([5.5, 0.5, 0.7], [6.5, 1.5, 0.72], (400, 3))
    object = np.repeat(np.array([-1, 0], np.int32), [len(wall), len(top)])
    room = np.where(object == 0, 1, 0).astype(np.int32)
    return LabelledCloud(np.concatenate([wall, top]), room * 0, room, object, -object - 1, room * 0)


@pytest.fixture
def texts(monkeypatch):
    """What a picture says, by file name."""
    found = {}

    def save_and_read(figure, path):
        save(figure, path)
        found[path.name] = {text.get_text() for text in figure.findobj(Text)}

    monkeypatch.setattr("enfilade.pictures.plan.save", save_and_read)
    monkeypatch.setattr("enfilade.pictures.match.save", save_and_read)
    return found


def colours(path):
    return set(re.findall(r"#[0-9a-f]{6}", path.read_text(encoding="utf-8")))


def test_a_plan_a_storey(graph, cloud, tmp_path):
    drawn = draw_storeys(graph, tmp_path / "plan.png", cloud=cloud)
    assert [path.name for path in drawn] == ["plan-s0.png", "plan-s1.png"]
    assert all(imread(path).std() > 0.05 for path in drawn)


def test_names_areas_widths_and_stairs_are_written(graph, tmp_path, texts):
    draw_plan(graph, tmp_path / "plan.svg")
    found = texts["plan.svg"]
    assert {"Room_0", "12.0 m²", "Room_1", "up", "Stairs up to Room_2.", "2 rooms, 26.4 m²", "1:50 on A4"} <= found
    draw_plan(graph, tmp_path / "upper.svg", storey="b/s1", title="Above")
    assert {"Above", "Upper", "Room_2", "down", "Stairs down to Room_0."} <= texts["upper.svg"]


def test_kinds_of_openings_have_their_colours_in_a_match(graph, tmp_path):
    draw_match(tmp_path / "match.svg", graph, {"a": "b/r0", "b": "b/r1"})
    drawn = colours(tmp_path / "match.svg")
    assert OPENING_COLOURS["door"] in drawn
    assert OPENING_COLOURS["passage"] not in drawn


def test_a_plan_is_drawn_in_black_and_grey(graph, tmp_path):
    draw_plan(graph, tmp_path / "plan.svg")
    drawn = [[int(colour[n : n + 2], 16) for n in (1, 3, 5)] for colour in colours(tmp_path / "plan.svg")]
    assert all(max(colour) - min(colour) < 32 for colour in drawn)


def test_the_same_plan_gives_the_same_bytes(graph, tmp_path):
    for suffix in (".svg", ".png"):
        first, second = tmp_path / f"a{suffix}", tmp_path / f"b{suffix}"
        draw_plan(graph, first)
        draw_plan(graph, second)
        assert first.read_bytes() == second.read_bytes()


def test_rooms_side_by_side_have_different_tints(graph):
    scene = plan_scene(graph, ["b/r0", "b/r1"])
    assert scene.rooms["b/r0"].tint != scene.rooms["b/r1"].tint


def test_the_node_of_a_bent_room_lies_inside(graph):
    ring = [0, 0, 9, 0, 9, 1, 1, 1, 1, 8, 0, 8]
    graph.nodes["b/r0"].properties["outline"] = [ring]
    room = plan_scene(graph, ["b/r0"]).rooms["b/r0"]
    assert room.polygon.contains(room.polygon.representative_point())
    assert 0 < min(room.place) < 1
    assert max(room.place) < 9


def test_a_graph_made_elsewhere_may_know_only_bounds_or_centres(graph, tmp_path, texts):
    for n, known in enumerate([{"bounds": [0, 0, 0, 4, 3, 2]}, {"centroid": [6.0, 1.0, 0.0]}]):
        properties = graph.nodes[f"b/r{n}"].properties
        del properties["outline"]
        properties.update(known)
    draw_plan(graph, tmp_path / "plan.svg")
    assert {"Room_0", "1"} <= texts["plan.svg"]


def test_what_cannot_be_drawn_is_refused(graph, tmp_path):
    with pytest.raises(NotFoundError, match=r"no storey 'b/s7' in 'b'; it has b/s0, b/s1"):
        draw_plan(graph, tmp_path / "plan.png", storey="b/s7")
    with pytest.raises(InputError, match=r"plan\.bmp cannot be drawn"):
        draw_plan(graph, tmp_path / "plan.bmp")
    for n in range(3):
        del graph.nodes[f"b/r{n}"].properties["outline"]
    with pytest.raises(NotFoundError, match="no room with an outline"):
        draw_storeys(graph, tmp_path / "plan.png")
    with pytest.raises(NotFoundError, match="no room with an outline"):
        draw_plan(graph, tmp_path / "plan.png")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_written_is_named(graph, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(StoreError, match=r"plan\.png cannot be written"):
        draw_plan(graph, tmp_path / "file" / "plan.png")


def test_a_match_shows_its_rooms_objects_and_score(graph, cloud, tmp_path, texts):
    shape = Shape("basin", *SQUARE)
    row = {"a": "b/r0", "area": 12.0, "o": "b/o0", "c": "b/r2", "score": -0.25}
    draw_match(tmp_path / "match.svg", graph, row, cloud=cloud, shapes={"o": shape}, title="Match 1")
    found = texts["match.svg"]
    assert {"Match 1  ·  score -0.250", "a · Room_0", "c · Room_2", "found: o", "asked for", "basin"} <= found
    assert {"Ground", "Upper", "Room_1", "table, 400 points"} <= found


def test_a_match_without_cloud_or_shape_shows_the_plan(graph, tmp_path, texts):
    draw_match(tmp_path / "match.svg", graph, {"a": "b/r1", "o": "b/o0"})
    assert {"a · Room_1", "o"} <= texts["match.svg"]


def test_a_match_that_names_nothing_to_draw_is_refused(graph, tmp_path):
    with pytest.raises(NotFoundError, match="names no room or object"):
        draw_match(tmp_path / "match.png", graph, {"n": 3, "score": None, "text": "b/r99"})


def test_a_mesh_covers_the_pixels_that_it_should():
    vertices, triangles = SQUARE
    image = render_mesh(vertices, triangles, Camera(2.0, pixels=100, elevation_deg=90.0), "#0072b2")
    assert image.shape == (100, 100, 4)
    assert image[..., 3].mean() == pytest.approx(0.25, abs=0.02)
    assert image[0, 0, 3] == 0
    assert image[50, 50, 2] > image[50, 50, 0]


def test_points_look_like_the_mesh_that_they_lie_on():
    vertices, triangles = SQUARE
    points = np.random.default_rng(0).random((4000, 3)) * [1, 1, 0]
    camera = Camera(span_of(vertices), pixels=100)
    mesh, cloud = render_mesh(vertices, triangles, camera, "#ffffff"), render_points(points, camera, "#ffffff")
    covered = (mesh[..., 3] > 0.5) & (cloud[..., 3] > 0.5)
    assert covered.sum() > 0.9 * (mesh[..., 3] > 0.5).sum()
    assert np.abs(mesh - cloud)[covered].mean() < 0.1


def test_of_points_behind_one_another_the_nearest_is_seen():
    camera = Camera(1.0, pixels=50, elevation_deg=90.0)
    floor = np.random.default_rng(0).uniform([-0.4, -0.4, 0], [0.4, 0.4, 0], (3000, 3))
    step = np.random.default_rng(1).uniform([-0.4, -0.4, 0.3], [0.0, 0.4, 0.3], (1500, 3))
    image = render_points(np.concatenate([step, floor]), camera, "#808080")
    # Just beyond the edge of the step the floor lies in its shade.
    rows = image[15:35, :, 0].mean(axis=0)
    edge = np.argmin(rows[10:40]) + 10
    assert rows[edge] < 0.9 * rows[35]
    assert abs(edge - 25) <= 4


def test_a_few_points_are_enough():
    for count in (1, 2, 5):
        image = render_points(np.eye(5, 3)[:count], Camera(3.0, pixels=40), "#0072b2")
        assert image[..., 3].any()
