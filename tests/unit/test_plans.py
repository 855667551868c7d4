"""Plans as an architect draws them: sheets, walls, doors, stairs, names."""

from __future__ import annotations

import time
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import LineString, Point, Polygon, box

from enfilade.clouds import LabelledCloud
from enfilade.errors import NotFoundError
from enfilade.faces import WallFaces, true_polygon, without_spurs
from enfilade.pictures.endings import wall_cells
from enfilade.pictures.faces import wall_faces
from enfilade.pictures.flights import find_flights
from enfilade.pictures.frame import AS_SCANNED, PageFrame, page_frame
from enfilade.pictures.leaves import draw_door
from enfilade.pictures.lettering import place_labels
from enfilade.pictures.paper import choose_sheet, lay_out
from enfilade.pictures.plan import draw_plan, draw_plans, find_storey
from enfilade.pictures.reveals import plan_grid
from enfilade.pictures.scene import PlannedRoom, plan_scene
from enfilade.pictures.steps import all_flights, draw_stairs, find_stairs
from enfilade.pictures.storey_plan import plan_storeys, surroundings
from enfilade.schema.graph import BuildingGraph, Node

ODD = "<img src=x> & $\\alpha$"


def add_room(graph, number, ring, **more):
    graph.add_node(
        f"b/r{number}", "Room", name=f"Room {number}", outline=[[c for corner in ring for c in corner]], **more
    )
    graph.add_edge("b/s0", "HAS_ROOM", f"b/r{number}")


def add_opening(graph, number, kind, position, normal, rooms, **more):
    graph.add_node(f"b/p{number}", "Opening", kind=kind, position=position, normal=normal, **more)
    for room in rooms:
        graph.add_edge(room, "OPENS", f"b/p{number}")


def rectangle(x0, y0, x1, y1):
    return [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]


@pytest.fixture
def graph():
    """Two rooms 0.2 m apart: an open door and a doubtful shut one between them, a window and a door to the outside."""
    graph = BuildingGraph("b")
    graph.add_node("b", "Building", name="Haus")
    graph.add_node("b/s0", "Storey", index=0, name="Ground", elevation=0.0)
    graph.add_edge("b", "HAS_STOREY", "b/s0")
    add_room(graph, 0, rectangle(0, 0, 4, 3), area=12.0, floor_elevation=0.0, ceiling_elevation=2.5)
    add_room(
        graph, 1, rectangle(4.2, 0, 9, 3), area=14.4, floor_elevation=0.0, ceiling_elevation=2.5, function="kitchen"
    )
    both = ["b/r0", "b/r1"]
    add_opening(graph, 0, "door", [4.1, 0.8, 1.0], [1.0, 0, 0], both, width=0.9, state="open", confidence=0.9)
    add_opening(graph, 1, "door", [4.1, 2.3, 1.0], [1.0, 0, 0], both, width=0.8, state="closed", confidence=0.3)
    add_opening(graph, 2, "window", [2.0, 3.0, 1.5], [0, 1.0, 0], ["b/r0"], width=1.5, sill=0.9)
    add_opening(graph, 3, "door", [0.0, 1.5, 1.0], [1.0, 0, 0], ["b/r0"], width=1.0, state="ajar")
    return graph


def groups(path):
    """Ids of an SVG's groups with the texts in them; reading it proves that it is whole XML."""
    found = {}
    for group in ElementTree.parse(path).iter("{http://www.w3.org/2000/svg}g"):
        found[group.get("id")] = "".join(group.itertext()).strip()
    return found


def plans_of(graph, cloud=None):
    return plan_storeys(surroundings(graph, cloud, furniture=False), list(graph.of_label("Storey")))


def on_page(plan, xy):
    return plan.scene.frame.points(np.asarray(xy, float))


def test_an_svg_names_each_room_and_opening(graph, tmp_path):
    graph.nodes["b/r1"].properties["name"] = ODD
    draw_plan(graph, tmp_path / "plan.svg")
    found = groups(tmp_path / "plan.svg")
    assert {"room-r0", "room-r1", "walls", "door-p0", "door-p1", "door-p3", "window-p2"} <= found.keys()
    assert found["label-r0"] == "Room 0"
    written = (tmp_path / "plan.svg").read_text(encoding="utf-8")
    assert "&lt;img" in written
    assert "<img" not in written
    assert "kitchen" in written


def test_walls_fill_what_is_between_rooms_and_openings_break_them(graph):
    (plan,) = plans_of(graph)
    solid = plan.walls.solid
    assert solid.covers(Point(on_page(plan, (4.1, 1.55))))
    assert solid.covers(Point(on_page(plan, (-0.15, 0.5))))
    assert not solid.intersects(LineString(on_page(plan, [(3.9, 0.8), (4.3, 0.8)])))
    assert not solid.intersects(LineString(on_page(plan, [(2.0, 2.9), (2.0, 3.35)])))
    assert all(solid.intersection(room.polygon).area < 1e-6 for room in plan.scene.rooms.values())


def test_doors_swing_into_the_room_with_fewer_doors_within_its_walls(graph):
    (plan,) = plans_of(graph)
    for key in ("b/p0", "b/p1"):
        (leaf,) = plan.leaves[key]
        assert plan.scene.rooms["b/r1"].polygon.buffer(1e-6).covers(leaf.sector())
    (entry,) = plan.leaves["b/p3"]
    assert plan.scene.rooms["b/r0"].polygon.buffer(1e-6).covers(entry.sector())


def test_a_wide_door_has_two_leaves_and_a_very_wide_one_none(graph):
    graph.nodes["b/p0"].properties["width"] = 1.6
    graph.nodes["b/p1"].properties["width"] = 2.4
    (plan,) = plans_of(graph)
    assert len(plan.leaves["b/p0"]) == 2
    assert "b/p1" not in plan.leaves


def test_doubtful_doors_are_dashed_and_the_sheet_says_so(graph, tmp_path):
    draw_plan(graph, tmp_path / "with.svg")
    graph.nodes["b/p1"].properties["confidence"] = 0.9
    draw_plan(graph, tmp_path / "without.svg")
    dashes = [(tmp_path / f"{name}.svg").read_text().count("stroke-dasharray") for name in ("with", "without")]
    assert dashes[0] > dashes[1] == 0
    assert "doubtful" in (tmp_path / "with.svg").read_text()
    assert "doubtful" not in (tmp_path / "without.svg").read_text()


def test_the_scale_is_true(graph, tmp_path):
    draw_plan(graph, tmp_path / "plan.svg")
    walls = ElementTree.parse(tmp_path / "plan.svg").find(".//*[@id='room-r1']/{http://www.w3.org/2000/svg}path")
    numbers = [float(word) for word in walls.get("d").replace("\n", " ").split() if word not in ("M", "L", "z")]
    assert np.ptp(numbers[::2]) * 25.4 / 72 == pytest.approx(4800 / 50, rel=1e-3)


def test_sheets_grow_with_the_building():
    chosen = [choose_sheet((0, 0, wide, wide / 2), 40.0) for wide in (8, 15, 25, 38, 75, 400, 5000)]
    assert [sheet.scale for sheet in chosen] == sorted(sheet.scale for sheet in chosen)
    assert (chosen[0].name, chosen[0].scale) == ("A4", 50)
    for wide, sheet in zip((8, 15, 25, 38, 75, 400, 5000), chosen, strict=True):
        assert wide * sheet.mm_per_m <= sheet.room_mm[0]


def test_a_turned_building_is_drawn_along_the_page(graph):
    turn, away = np.array([[0.8, 0.6], [-0.6, 0.8]]), np.array([690000.0, 5330000.0])
    for node in graph.nodes.values():
        if "outline" in node.properties:
            rings = [np.reshape(ring, (-1, 2)) @ turn + away for ring in node.properties["outline"]]
            node.properties["outline"] = [ring.ravel().tolist() for ring in rings]
    rooms = surroundings(graph, None, furniture=False)
    assert np.degrees(rooms.frame.angle) == pytest.approx(-np.degrees(np.arctan2(0.6, 0.8)), abs=1e-6)
    (plan,) = plans_of(graph)
    x0, y0, x1, y1 = plan.scene.rooms["b/r1"].polygon.bounds
    assert (x1 - x0, y1 - y0) == pytest.approx((4.8, 3.0), abs=1e-6)


def test_a_straight_building_is_not_turned():
    assert page_frame([np.array(rectangle(0, 0, 4, 3), float)]).angle == 0.0
    assert page_frame([]) is AS_SCANNED


def faces_of(lines):
    starts, ends = np.array(lines, float).transpose(1, 0, 2)
    way = ends - starts
    length = np.hypot(*way.T)
    return WallFaces((starts + ends) / 2, way / length[:, None], np.column_stack([-length / 2, length / 2]))


def test_outlines_are_drawn_true_to_the_faces_of_walls():
    room = box(0, 0, 5, 4)
    faces = faces_of([[(0, 0), (5, 0)], [(5, 0), (5, 4)], [(5, 4), (0, 4)], [(0, 4), (0, 0)]])
    # Corners cut by the raster, a hidden corner, a shelf along a wall, the way into a doorway.
    ring = [(0.1, 0), (2, -0.05), (2.1, -0.3), (2.8, -0.3), (2.9, 0.04), (4.9, 0), (5, 0.1), (4.96, 3.2), (4.3, 4)]
    ring += [(3, 3.95), (2.9, 3.8), (2, 3.8), (1.9, 4), (0.04, 4)]
    drawn = true_polygon(Polygon(ring), faces)
    assert drawn.symmetric_difference(room).area < 0.02
    assert len(drawn.simplify(0.001).exterior.coords) == 5


def test_a_shape_without_faces_stays_as_it_was():
    round_room = Point(0, 0).buffer(3)
    none = WallFaces(np.empty((0, 2)), np.empty((0, 2)), np.empty((0, 2)))
    assert true_polygon(round_room, none).equals(round_room)
    chamfered = Polygon([(0, 0), (5, 0), (5, 2.5), (3.5, 4), (0, 4)])
    faces = faces_of([[(0, 0), (5, 0)], [(5, 0), (5, 2.5)], [(5, 2.5), (3.5, 4)], [(3.5, 4), (0, 4)], [(0, 4), (0, 0)]])
    assert true_polygon(chamfered, faces).symmetric_difference(chamfered).area < 0.02


def test_what_is_seen_through_a_gap_is_no_part_of_a_room():
    room = box(0, 0, 5, 4)
    faces = faces_of([[(0, 0), (5, 0)], [(5, 0), (5, 4)], [(5, 4), (0, 4)], [(0, 4), (0, 0)]])
    spur = Polygon([(2, 3.9), (2.3, 3.9), (2.6, 6), (2.4, 6)])
    niche = box(1, -0.6, 1.6, 0.1)
    assert true_polygon(room.union(spur), faces).symmetric_difference(room).area < 0.05
    assert without_spurs(room.union(niche)).equals(room.union(niche))
    assert without_spurs(box(0, 0, 0.3, 2)).equals(box(0, 0, 0.3, 2))


def cloud_of(positions, room=0, plane=None):
    labels = np.full(len(positions), -1, np.int32)
    plane = labels if plane is None else np.asarray(plane, np.int32)
    return LabelledCloud(positions, labels, np.full(len(positions), room, np.int32), labels, plane, labels)


@given(st.floats(-44, 44))
@settings(max_examples=20, deadline=None)
def test_faces_tell_how_a_building_lies_where_the_outlines_raster_does_not(degrees):
    rng = np.random.default_rng(0)
    along, z = rng.uniform(-0.5, 0.5, (2, 3000))
    flat = np.zeros(3000)
    walls = [(6 * along, flat), (6 * along, flat + 3), (flat - 3, 3 * along + 1.5), (along, 0.5 + along)]
    xy = np.concatenate([np.column_stack(wall) for wall in walls])
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    positions = np.column_stack([xy @ np.array([[c, s], [-s, c]]), np.tile(z + 1.5, 4)])
    rough = PageFrame(np.radians(1.2 - degrees), np.zeros(2))
    frame, faces = wall_faces(cloud_of(positions, plane=np.repeat(np.arange(4), 3000)), rough)
    assert np.degrees(frame.angle) == pytest.approx(-degrees, abs=0.05)
    assert np.abs(faces[0].along).max(axis=1)[:3] == pytest.approx(1.0, abs=1e-9)


def test_specks_and_what_hangs_from_the_ceiling_are_no_walls(graph):
    rng = np.random.default_rng(0)
    specks = np.column_stack([np.arange(0, 4, 0.1), np.full(40, 1.0), rng.uniform(0.5, 2, 40)])
    ceiling = np.column_stack([rng.uniform(0, 4, 2000), np.full(2000, 2.0), rng.uniform(2.3, 2.9, 2000)])
    cupboard = np.column_stack([np.full(500, 3.0), rng.uniform(0, 1, 500), rng.uniform(0.0, 0.9, 500)])
    places = wall_cells(cloud_of(np.concatenate([specks, ceiling, cupboard])), AS_SCANNED, graph)[0]
    assert places[:, 0] == pytest.approx(3.0)
    assert len(places) >= 9


def flight_points(risers, tread, width, angle):
    """Points on the treads and risers of a flight that starts at the origin."""
    rng = np.random.default_rng(3)
    rise = 2.8 / risers
    flat = [
        np.column_stack(
            [rng.uniform(n * tread, (n + 1) * tread, 400), rng.uniform(0, width, 400), np.full(400, (n + 1) * rise)]
        )
        for n in range(risers - 1)
    ]
    steep = [
        np.column_stack([np.full(200, n * tread), rng.uniform(0, width, 200), rng.uniform(n, n + 1, 200) * rise])
        for n in range(risers)
    ]
    points = np.concatenate(flat + steep)
    c, s = np.cos(angle), np.sin(angle)
    points[:, :2] = points[:, :2] @ np.array([[c, s], [-s, c]])
    return points + rng.normal(0, 0.004, points.shape)


@pytest.mark.parametrize("angle", [0.0, 2.1, -1.2])
def test_a_flight_is_found_with_its_direction_size_and_treads(graph, angle):
    points = flight_points(16, 0.27, 1.0, angle)
    middle = points[:, :2].mean(axis=0)
    add_opening(graph, 9, "stairs", [*middle, 2.8], [0, 0, 1.0], ["b/r0"])
    opening = plan_scene(graph, ["b/r0"]).openings[-1]
    (flight,) = find_flights(plan_grid(cloud_of(points), AS_SCANNED), opening, 0.0, 2.8)
    assert flight.up @ [np.cos(angle), np.sin(angle)] > 0.999
    assert flight.length == pytest.approx(15 * 0.27, abs=0.3)
    assert flight.width == pytest.approx(1.0, abs=0.1)
    assert flight.treads == 15


def test_a_flight_that_nearly_runs_with_the_walls_does(graph):
    points = flight_points(16, 0.27, 1.0, 0.08)
    add_opening(graph, 9, "stairs", [*points[:, :2].mean(axis=0), 2.8], [0, 0, 1.0], ["b/r0"])
    opening = plan_scene(graph, ["b/r0"]).openings[-1]
    (flight,) = find_flights(plan_grid(cloud_of(points), AS_SCANNED), opening, 0.0, 2.8)
    assert flight.up.tolist() == [1.0, 0.0]


class Drawn:
    """A pen that only counts lines."""

    def __init__(self):
        self.count = 0

    def lines(self, lines, **_):
        self.count += len(lines)

    def area(self, *_, **__):
        pass

    write = area


@pytest.mark.parametrize(("width", "length", "lines"), [(1.0, 3.0, 13), (3.7, 4.3, 2)])
def test_a_hole_wider_than_stairs_is_crossed_and_has_no_treads(graph, width, length, lines):
    add_opening(graph, 9, "stairs", [2.0, 1.5, 2.8], [0, 0, 1.0], ["b/r0"], width=width, height=length)
    scene = plan_scene(graph, ["b/r0"])
    (stairs,) = find_stairs(scene, all_flights([scene], None))
    pen = Drawn()
    draw_stairs(pen, stairs, scene)
    assert pen.count == lines


def test_no_flight_is_found_in_a_room_with_walls_and_tables(graph):
    rng = np.random.default_rng(0)
    wall = np.column_stack([np.full(4000, 1.5), rng.uniform(0, 4, 4000), rng.uniform(0, 2.7, 4000)])
    table = np.column_stack([rng.uniform(0, 1.4, (3000, 2)), np.full(3000, 0.75)])
    add_opening(graph, 9, "stairs", [1.0, 1.0, 2.8], [0, 0, 1.0], ["b/r0"])
    opening = plan_scene(graph, ["b/r0"]).openings[-1]
    assert find_flights(plan_grid(cloud_of(np.concatenate([wall, table])), AS_SCANNED), opening, 0.0, 2.8) == []


def test_reveals_tell_how_thick_outer_walls_are(graph):
    rng = np.random.default_rng(0)
    jambs = [
        np.column_stack([np.full(300, x), rng.uniform(3.0, 3.42, 300), rng.uniform(1, 2, 300)]) for x in (1.25, 2.75)
    ]
    graph.nodes["b/p2"].properties["height"] = 1.2
    (plan,) = plans_of(graph, cloud_of(np.concatenate(jambs)))
    assert plan.outer_m == pytest.approx(0.42, abs=0.03)


def test_a_room_that_no_scan_saw_is_enclosed_by_partitions_and_left_empty(graph):
    for room in list(graph.of_label("Room")):
        room.properties["outline"] = [[c for corner in rectangle(20, 0, 24, 3) for c in corner]]
    frame = [rectangle(0, 0, 6, 2), rectangle(0, 4, 6, 6), rectangle(0, 2.1, 2, 3.9), rectangle(4, 2.1, 6, 3.9)]
    for number, ring in enumerate(frame, start=2):
        add_room(graph, number, ring)
    (plan,) = plans_of(graph)
    assert not plan.walls.solid.intersects(Point(on_page(plan, (3, 3))))
    assert plan.walls.solid.covers(LineString(on_page(plan, [(2.01, 3.7), (2.1, 3.7)])))
    assert not plan.walls.solid.intersects(Point(on_page(plan, (2.2, 3.7))))


def test_small_notches_in_outer_faces_are_filled_and_wide_ones_stay(graph):
    add_room(graph, 2, [(0, 3.2), (4, 3.2), (4, 5), (3.5, 5.6), (0.5, 5.6), (0, 5)])
    add_room(graph, 3, rectangle(4.2, 3.2, 9, 5.6))
    (plan,) = plans_of(graph)
    assert plan.walls.solid.covers(Point(on_page(plan, (4.1, 5.85))))
    assert plan.bounds[3] - plan.bounds[1] == pytest.approx(5.6 + 2 * plan.outer_m, abs=0.01)


def test_a_shut_leaf_lies_within_its_wall(graph):
    (plan,) = plans_of(graph)
    figure, pen, _ = lay_out(choose_sheet(plan.bounds, 0.0), plan.bounds)
    (one,) = (one for one in plan.gaps if one.opening.node.id == "b/p1")
    draw_door(pen, one, plan.leaves["b/p1"])
    board = next(artist for artist in figure.axes[0].patches if artist.get_gid() == "door-p1")
    rooms = shapely.union_all([room.polygon.buffer(-1e-6) for room in plan.scene.rooms.values()])
    assert not rooms.intersects(Polygon(board.get_path().vertices))


def test_where_no_wall_was_seen_none_is_drawn(graph):
    x, z = (axis.ravel() for axis in np.meshgrid(np.arange(0, 9, 0.04), np.arange(0, 2.5, 0.05)))
    (plan,) = plans_of(graph, cloud_of(np.column_stack([x, np.zeros_like(x), z])))
    assert plan.walls.solid.covers(Point(on_page(plan, (6, -0.1))))
    assert not plan.walls.solid.covers(Point(on_page(plan, (6, 3.1))))
    assert plan.walls.unseen.distance(Point(on_page(plan, (6, 3)))) < 0.01


def test_a_hall_is_a_void_on_the_storey_above(graph, tmp_path):
    graph.add_node("b/s1", "Storey", index=1, name="Upper", elevation=2.8)
    graph.add_edge("b", "HAS_STOREY", "b/s1")
    ring = [c for corner in rectangle(0, 0, 4, 3) for c in corner]
    graph.add_node("b/r2", "Room", outline=[ring], floor_elevation=2.8, ceiling_elevation=5.2)
    graph.add_edge("b/s1", "HAS_ROOM", "b/r2")
    graph.nodes["b/r1"].properties["ceiling_elevation"] = 5.2
    _, upper = plans_of(graph)
    (void,) = upper.voids
    assert void.room == "b/r1"
    hall = Polygon(on_page(upper, rectangle(4.2, 0, 9, 3)))
    assert void.shape.symmetric_difference(hall).area < 0.1
    draw_plan(graph, tmp_path / "upper.svg", storey="Upper")
    assert "void over" in (tmp_path / "upper.svg").read_text()


@st.composite
def rooms(draw):
    """A room: a rectangle, perhaps without a corner, perhaps with a column, anywhere, at any angle."""
    size = st.floats(0.4, 20)
    wide, high = draw(size), draw(size)
    shape = box(0, 0, wide, high)
    if draw(st.booleans()):
        shape = shape.difference(box(wide * draw(st.floats(0.2, 0.9)), high * draw(st.floats(0.2, 0.9)), 99, 99))
    if draw(st.booleans()):
        shape = shape.difference(Point(wide * 0.3, high * 0.3).buffer(0.1 * min(wide, high)))
    shape = shapely.affinity.rotate(shape, draw(st.floats(0, 90)), origin=(0, 0))
    return shapely.affinity.translate(shape, draw(st.floats(-50, 50)), draw(st.floats(-50, 50)))


@settings(deadline=None, max_examples=60)
@given(
    rooms(),
    st.sampled_from(["Bad", "Room 12", "Besprechungsraum Nord", "会議室", "a b c d e f"]),
    st.sampled_from([20.0, 10.0, 5.0]),
)
def test_names_lie_within_their_rooms_clear_of_doors(polygon, name, mm_per_m):
    swing = Point(polygon.exterior.coords[0]).buffer(0.9)
    rings = tuple(np.asarray(ring.coords) for ring in (polygon.exterior, *polygon.interiors))
    room = PlannedRoom(
        Node("b/r0", "Room", {"name": name}), rings, polygon, np.array(polygon.representative_point().coords[0]), ""
    )
    (label,) = place_labels([room], {"b/r0": ("12.3 m²",)}, [swing], mm_per_m)
    written = box(*label.box)
    if label.number is None:
        assert polygon.covers(written)
        assert not swing.buffer(-1e-6).intersects(written)
        assert " ".join(label.names) == name
    else:
        assert polygon.buffer(1e-6).covers(Point(label.place))


def test_rooms_too_small_for_a_name_get_a_number_and_a_list(graph, tmp_path):
    for n in range(3):
        add_room(graph, 10 + n, rectangle(n * 0.6, 5, n * 0.6 + 0.25, 5.25), area=0.06)
    draw_plan(graph, tmp_path / "plan.svg")
    found = groups(tmp_path / "plan.svg")
    assert [found[f"label-r{10 + n}"] for n in range(3)] == ["1", "2", "3"]
    assert "Room 12, 0.1 m²" in (tmp_path / "plan.svg").read_text()


def test_names_keep_clear_of_marks_where_there_is_space():
    polygon = box(0, 0, 4, 3)
    room = PlannedRoom(Node("b/r0", "Room", {"name": "Hall"}), (), polygon, np.array([2.0, 1.5]), "")
    (beside,) = place_labels([room], {}, [], 20.0, [box(1.9, 1.4, 2.1, 1.6)])
    assert not box(*beside.box).intersects(box(1.9, 1.4, 2.1, 1.6))
    (over,) = place_labels([room], {}, [], 20.0, [polygon])
    assert over.number is None


def test_rooms_over_one_another_do_not_share_a_place_for_names(graph):
    add_room(graph, 2, rectangle(1, 1, 3, 2), area=2.0)
    (plan,) = plans_of(graph)
    labels = place_labels(list(plan.scene.rooms.values()), plan.lines, plan.obstacles, 20.0)
    boxes = [box(*label.box) for label in labels]
    assert not any(boxes[a].intersects(boxes[b]) for a in range(3) for b in range(a))


def test_rooms_without_outline_are_counted_on_the_sheet(graph, tmp_path):
    del graph.nodes["b/r1"].properties["outline"]
    graph.nodes["b/r1"].properties["centroid"] = [6.0, 1.0, 0.0]
    draw_plan(graph, tmp_path / "plan.svg")
    text = (tmp_path / "plan.svg").read_text()
    assert "No outline is known of 1 of 2 rooms" in text
    assert "Room 1" in text


def test_outlines_that_cross_themselves_or_are_no_numbers_do_not_stop_a_plan(graph, tmp_path):
    graph.nodes["b/r0"].properties["outline"] = [[0, 0, 4, 3, 4, 0, 0, 3]]
    graph.nodes["b/r1"].properties["outline"] = [[0, float("nan"), 4, 3, 4, 0]]
    draw_plan(graph, tmp_path / "plan.svg")
    assert "label-r0" in groups(tmp_path / "plan.svg")


def test_a_folder_gets_png_and_svg_and_a_storey_its_own_file(graph, tmp_path):
    graph.building = "b"
    drawn = draw_plans(graph, tmp_path / "plans")
    assert [path.relative_to(tmp_path).as_posix() for path in drawn] == ["plans/b-s0.png", "plans/b-s0.svg"]
    assert draw_plans(graph, tmp_path / "one.pdf", storey="0") == [tmp_path / "one.pdf"]
    assert (tmp_path / "one.pdf").read_bytes().startswith(b"%PDF")


def test_a_storey_is_found_by_id_name_or_index(graph):
    assert {find_storey(graph, name).id for name in ("b/s0", "s0", "Ground", "0", None)} == {"b/s0"}
    with pytest.raises(NotFoundError, match=r"no storey 'attic' in 'b'; it has b/s0"):
        find_storey(graph, "attic")


def office(count):
    """A storey with many rooms along corridors, each with a door."""
    graph = BuildingGraph("b")
    graph.add_node("b", "Building")
    graph.add_node("b/s0", "Storey", index=0)
    graph.add_edge("b", "HAS_STOREY", "b/s0")
    for n in range(count):
        x, y = 3.1 * (n % 50), 7.0 * (n // 50)
        add_room(graph, n, rectangle(x, y, x + 3, y + 4), area=12.0)
        add_opening(graph, n, "door", [x + 0.7, y, 1.0], [0, 1.0, 0], [f"b/r{n}"], width=0.9)
    return graph


def test_time_grows_with_the_number_of_rooms():
    spent = []
    for count in (150, 600):
        graph = office(count)
        start = time.process_time()
        (plan,) = plans_of(graph)
        place_labels(list(plan.scene.rooms.values()), plan.lines, plan.obstacles, 5.0)
        spent.append(time.process_time() - start)
    assert spent[1] < 8 * spent[0] + 0.5
