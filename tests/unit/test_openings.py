"""Holes that rays go through become doors, passages, windows and stairs with the right size and place."""

from dataclasses import replace

import numpy as np
import pytest
from box_scene import BoxScene, two_rooms
from shapely import Polygon, box

from enfilade.ingest.neighbours import find_neighbours
from enfilade.ingest.openings import find_openings
from enfilade.ingest.openings.behind import within_room
from enfilade.ingest.openings.blind import above_floor, above_hidden, bounds_room, is_doorway
from enfilade.ingest.openings.evidence import Walls
from enfilade.ingest.openings.holes import Hole
from enfilade.ingest.openings.leads import group_holes, known_by_plan
from enfilade.ingest.openings.parameters import OpeningParameters
from enfilade.ingest.openings.rays import rays_of
from enfilade.ingest.records import Room, Surfels
from enfilade.ingest.sides import Patch, Side, cut_by_room, join_patches


def openings_of(scene, **scan):
    cloud, surfels, planes, labels, rooms = scene.scan(**scan)
    neighbours = find_neighbours(surfels, planes, labels, rooms)
    return find_openings(cloud, surfels, planes, labels, rooms, neighbours), cloud, labels, surfels


DOOR = ((1.0, 0.0), (1.9, 2.05))


def test_a_door_has_its_size_and_place():
    (door,), *_ = openings_of(two_rooms(holes=[DOOR]))
    assert (door.kind, door.orientation, door.state) == ("door", "horizontal", "open")
    assert (door.room_a, door.room_b) == (0, 1)
    assert door.width == pytest.approx(0.9, abs=0.03)
    assert door.height == pytest.approx(2.05, abs=0.04)
    assert door.sill == pytest.approx(0.0, abs=0.02)
    assert door.lintel == pytest.approx(0.45, abs=0.03)
    np.testing.assert_allclose(door.position, [4.1, 1.45, 1.025], atol=0.04)
    assert abs(door.normal[0]) == pytest.approx(1.0)
    assert 0.7 < door.confidence <= 1


def test_rays_are_those_that_join_the_rooms():
    (door,), cloud, labels, surfels = openings_of(two_rooms(holes=[DOOR]))
    start, end = labels.scan_room[cloud.scan], labels.after[surfels.point_surfel]
    assert door.ray_count == pytest.approx(np.count_nonzero(start != end), rel=0.25)


def test_two_doors_between_the_same_rooms_are_two():
    found, *_ = openings_of(two_rooms(holes=[((0.2, 0.0), (1.0, 2.0)), ((2.0, 0.0), (2.8, 2.0))]))
    assert sorted(round(float(door.position[1]), 1) for door in found) == [0.6, 2.4]


def test_a_wall_without_hole_has_no_opening():
    assert openings_of(two_rooms())[0] == ()


def test_a_hole_up_to_the_ceiling_is_a_passage():
    (passage,), *_ = openings_of(two_rooms(holes=[((0.5, 0.0), (2.5, 2.5))]))
    assert passage.kind == "passage"
    assert passage.lintel == 0.0
    assert passage.width == pytest.approx(2.0, abs=0.05)
    assert passage.height == pytest.approx(2.5, abs=0.05)


def test_a_hole_above_the_floor_is_a_window_with_its_sill():
    (window,), *_ = openings_of(two_rooms(holes=[((1.0, 0.9), (2.0, 2.0))]))
    assert window.kind == "window"
    assert window.sill == pytest.approx(0.9, abs=0.04)
    assert window.lintel == pytest.approx(0.5, abs=0.04)
    assert window.width == pytest.approx(1.0, abs=0.04)


def test_rooms_without_wall_between_them_meet_in_a_passage():
    """One space, two labels: the floors touch, and no wall plane has the hole."""
    scene = BoxScene()
    scene.room(0, (0, 0, 0), (4, 3, 2.5), skip=("x1",))
    scene.room(1, (4, 0, 0), (8, 3, 2.5), skip=("x0",))
    scene.scanners = [((2.2, 1.3, 1.5), 0), ((5.8, 1.6, 1.5), 1)]
    (passage,), *_ = openings_of(scene)
    assert passage.kind == "passage"
    assert passage.width == pytest.approx(3.0, abs=0.15)
    np.testing.assert_allclose(passage.position[:2], [4.0, 1.5], atol=0.15)


def test_a_hole_in_the_slab_is_stairs():
    hole = ((1.0, 0.5), (3.0, 1.5))
    scene = BoxScene()
    scene.room(0, (0, 0, 0), (4, 3, 2.5), holes={"z1": [hole]})
    scene.room(1, (0, 0, 2.8), (4, 3, 5.3), holes={"z0": [hole]})
    scene.scanners = [((2, 2.0, 1.5), 0), ((2.2, 1.0, 4.3), 1)]
    (stairs,), *_ = openings_of(scene)
    assert (stairs.kind, stairs.orientation) == ("stairs", "vertical")
    assert stairs.width == pytest.approx(1.0, abs=0.1)
    assert stairs.height == pytest.approx(2.0, abs=0.1)
    np.testing.assert_allclose(stairs.position[:2], [2.0, 1.0], atol=0.1)


@pytest.mark.parametrize(("length", "kind"), [(0.9, "hatch"), (1.5, "stairs")])
def test_a_hole_in_the_slab_too_short_for_stairs_is_a_hatch(length, kind):
    hole = ((1.0, 0.5), (1.0 + length, 1.2))
    scene = BoxScene()
    scene.room(0, (0, 0, 0), (4, 3, 2.5), holes={"z1": [hole]})
    scene.room(1, (0, 0, 2.8), (4, 3, 5.3), holes={"z0": [hole]})
    scene.scanners = [((1.4, 1.5, 1.5), 0), ((1.6, 1.5, 4.3), 1)]
    (found,), *_ = openings_of(scene)
    assert (found.kind, found.orientation, found.state) == (kind, "vertical", "open")
    assert (found.room_a, found.room_b) == (0, 1)
    assert found.width == pytest.approx(0.7, abs=0.1)
    assert found.height == pytest.approx(length, abs=0.1)


def test_a_door_seen_from_one_side_only_is_found():
    scene = two_rooms(holes=[DOOR])
    scene.scanners = scene.scanners[:1]
    (door,), *_ = openings_of(scene)
    assert door.width == pytest.approx(0.9, abs=0.05)


def test_a_recess_of_the_own_room_is_no_opening():
    """A hole in the wall with the same room behind it."""
    scene = two_rooms(holes=[DOOR])
    cloud, surfels, planes, labels, rooms = scene.scan()
    labels.after[:] = 0
    labels.scan_room[:] = 0
    assert find_openings(cloud, surfels, planes, labels, rooms[:1], ()) == ()


def test_a_closed_door_is_found_by_its_inset_and_doubted():
    """The leaf lies 5 cm behind the wall of room 0 and 11 cm behind that of room 1 (Figure 6 of the paper)."""
    scene = two_rooms(holes=[DOOR])
    scene.add(0, 4.05, DOOR[0], DOOR[1], -1, 0, plane=False)
    scene.add(0, 4.09, DOOR[0], DOOR[1], 1, 1, plane=False)
    (door,), *_ = openings_of(scene)
    assert (door.kind, door.state, door.room_a, door.room_b) == ("door", "closed", 0, 1)
    assert door.width == pytest.approx(0.9, abs=0.04)
    assert door.height == pytest.approx(2.05, abs=0.04)
    assert door.ray_count == 0
    (open_door,) = openings_of(two_rooms(holes=[DOOR]))[0]
    assert door.confidence < open_door.confidence


def glazed_room():
    """One room with a hole of 1.2 x 1.1 m in an outer wall, behind which nothing sends a ray back."""
    scene = BoxScene()
    scene.room(0, (0, 0, 0), (4, 3, 2.5), holes={"y1": [((1.0, 0.9), (2.2, 2.0))]})
    scene.scanners = [((2.2, 1.3, 1.5), 0), ((0.8, 1.0, 1.5), 0)]
    return scene


def test_a_hole_that_sends_nothing_back_is_a_window_to_the_outside():
    (window,), *_ = openings_of(glazed_room())
    assert (window.kind, window.state, window.room_a, window.room_b) == ("window", "closed", 0, None)
    assert window.width == pytest.approx(1.2, abs=0.04)
    assert window.height == pytest.approx(1.1, abs=0.04)
    assert window.sill == pytest.approx(0.9, abs=0.03)
    np.testing.assert_allclose(window.position, [1.6, 3.0, 1.45], atol=0.03)


def test_a_wall_hidden_by_a_cupboard_has_no_window():
    """The cupboard leaves a clean rectangle in the wall, as a window would."""
    scene = BoxScene()
    scene.room(0, (0, 0, 0), (4, 3, 2.5))
    scene.block((1.0, 2.4, 0.0), (2.2, 2.98, 1.9), 0)
    scene.scanners = [((2.2, 0.8, 1.5), 0), ((0.8, 0.8, 1.5), 0)]
    assert openings_of(scene)[0] == ()


def test_order_of_points_makes_no_difference():
    cloud, surfels, planes, labels, rooms = two_rooms(holes=[DOOR]).scan(step_deg=1.0)
    neighbours = find_neighbours(surfels, planes, labels, rooms)
    shuffled = np.random.default_rng(5).permutation(len(cloud.scan))
    other_cloud = replace(cloud, positions=cloud.positions[shuffled], scan=cloud.scan[shuffled])
    other_surfels = replace(surfels, point_surfel=surfels.point_surfel[shuffled])
    (one,) = find_openings(cloud, surfels, planes, labels, rooms, neighbours)
    (two,) = find_openings(other_cloud, other_surfels, planes, labels, rooms, neighbours)
    assert (one.room_a, one.room_b, one.ray_count, one.kind) == (two.room_a, two.room_b, two.ray_count, two.kind)
    assert one.width == pytest.approx(two.width, abs=1e-9)


def test_stairs_in_a_larger_void_are_where_the_upper_treads_are():
    hole = ((0.3, 0.3), (4.7, 2.7))
    scene = BoxScene()
    scene.room(0, (0, 0, 0), (6, 3, 2.5), holes={"z1": [hole]})
    scene.room(1, (0, 0, 2.8), (6, 3, 5.3), holes={"z0": [hole]})
    for step in range(10):
        x = 0.6 + 0.27 * step
        scene.add(2, 0.25 * (step + 1), (x, 0.5), (x + 0.27, 1.5), 1, 0)
    scene.scanners = [((3, 2.3, 1.5), 0), ((5.3, 1.5, 4.3), 1)]
    (stairs,), *_ = openings_of(scene)
    assert stairs.kind == "stairs"
    assert stairs.width < 1.1
    np.testing.assert_allclose(stairs.position[:2], [2.7, 1.0], atol=0.35)


def test_a_door_far_from_the_origin_is_where_it_is():
    """A wall whose plane was fitted a tenth of a degree off is a metre off at the origin, half a kilometre away."""
    scene = two_rooms(holes=[DOOR])
    cloud, surfels, planes, labels, rooms = scene.scan(step_deg=1.0)
    away = np.array([420.0, -310.0, 55.0])
    tilted = planes.normals + np.array([0.0, 0.002, 0.002], np.float32) * planes.normals[:, :1]
    tilted /= np.linalg.norm(tilted, axis=1, keepdims=True)
    moved = [
        replace(
            room,
            floor_elevation=room.floor_elevation + away[2],
            ceiling_elevation=room.ceiling_elevation + away[2],
            bounds=room.bounds + np.tile(away, 2),
            centroid=room.centroid + away,
        )
        for room in rooms
    ]
    cloud = replace(
        cloud,
        positions=(cloud.positions + away).astype(np.float32),
        scanner_positions=(cloud.scanner_positions + away).astype(np.float32),
    )
    surfels = replace(surfels, positions=(surfels.positions + away).astype(np.float32))
    planes = replace(planes, normals=tilted.astype(np.float32))
    neighbours = find_neighbours(surfels, planes, labels, tuple(moved))
    (door,) = find_openings(cloud, surfels, planes, labels, tuple(moved), neighbours)
    np.testing.assert_allclose(door.position - away, [4.1, 1.45, 1.025], atol=0.05)
    assert door.sill == pytest.approx(0.0, abs=0.02)
    assert door.height == pytest.approx(2.05, abs=0.05)


def test_a_hole_that_sends_a_few_rays_back_all_over_is_glass():
    """A pane up to the ceiling that gives back one ray in ten, at one depth: rays go through, people do not."""
    scene = two_rooms(holes=[((0.5, 0.0), (2.5, 2.5))])
    for y in np.arange(0.5, 2.5, 0.1):
        for z in np.arange(0.0, 2.5, 0.1):
            scene.add(0, 4.1, (y + 0.03, z + 0.03), (y + 0.065, z + 0.065), -1, 0, plane=False)
    (pane,), *_ = openings_of(scene, step_deg=1.0)
    assert (pane.kind, pane.state) == ("window", "closed")
    assert pane.width == pytest.approx(2.0, abs=0.08)


def test_what_a_scanner_sees_without_looking_through_a_wall_is_of_its_room():
    """The part of room 1 behind the door was left without a label, as the far end of a corridor may be."""
    scene = two_rooms(holes=[DOOR])
    cloud, surfels, planes, labels, rooms = scene.scan()
    unknown = (labels.after == 1) & (surfels.positions[:, 0] < 5.8)
    labels = replace(labels, after=np.where(unknown, -1, labels.after).astype(np.int32))
    (door,) = find_openings(cloud, surfels, planes, labels, rooms, ())
    assert (door.kind, door.room_a, door.room_b) == ("door", 0, 1)


def test_a_hole_that_the_other_face_of_the_wall_covers_is_a_mirror():
    _, surfels, planes, labels, _ = two_rooms().scan(step_deg=1.5)
    walls = join_patches(cut_by_room(surfels, planes, labels, 40), surfels, max_angle_deg=8, max_offset_m=0.05)
    front = next(side for side in walls if side.room == 0 and side.normal[0] < -0.9)
    none = np.zeros(0)
    left, right = np.sort([front.u @ [4.0, y, 0.0] for y in (1.0, 1.8)])
    edges = np.array([left, 0.9, right, 1.9])
    hole = Hole(front, edges, np.ones(4, bool), none.astype(np.int32), none, none, none.astype(bool), 1.0, 0.6, 0.0)
    assert Walls(walls, surfels, 0.6).covered(hole) > 0.9
    only_front = [side for side in walls if side.room == 0]
    assert Walls(only_front, surfels, 0.6).covered(hole) == 0.0


def test_a_hole_in_something_before_the_wall_does_not_move_the_door():
    """Room 1 has a screen with a hole 0.4 m before its wall."""
    scene = two_rooms(holes=[DOOR])
    scene.add(0, 4.6, (0.0, 0.0), (3.0, 2.2), 1, 1, holes=[((0.9, 0.3), (2.2, 2.0))])
    (door,) = [opening for opening in openings_of(scene)[0] if opening.room_b == 1]
    np.testing.assert_allclose(door.position, [4.1, 1.45, 1.025], atol=0.04)


def test_a_door_of_which_each_side_hides_another_half_is_one():
    cloud, surfels, planes, labels, rooms = two_rooms(holes=[DOOR]).scan(step_deg=1.5)
    walls = join_patches(cut_by_room(surfels, planes, labels, 40), surfels, max_angle_deg=8, max_offset_m=0.05)
    halves = []
    for room, part in ((0, (1.0, 1.5)), (1, (1.4, 1.9))):
        side = next(s for s in walls if s.room == room and s.normal[0] * (0.5 - room) < -0.4)
        left, right = np.sort([side.u @ [side.offset, y, 0.0] for y in part])
        ray = np.flatnonzero(labels.scan_room[cloud.scan] != labels.after[surfels.point_surfel]).astype(np.int32)
        outbound = labels.scan_room[cloud.scan[ray]] == room
        edges, far = np.array([left, 0.0, right, 2.05]), np.ones(len(ray))
        halves.append(Hole(side, edges, np.ones(4, bool), ray, cloud.positions[ray, 1:], far, outbound, 1.0, 0.4, 0.0))
    known = {room.number: room for room in rooms}
    (group,) = group_holes(halves, rays_of(cloud, surfels, labels), known, OpeningParameters())
    assert len(group.leads) == 2


def unscanned_hall():
    """Rooms 0 and 1 with doors to a hall between them that no scanner stands in, and room 2 beside room 1."""
    scene = BoxScene()
    scene.room(0, (0, 0, 0), (4, 3, 2.5), holes={"x1": [DOOR]})
    scene.room(1, (5.6, 0, 0), (9, 3, 2.5), holes={"x0": [DOOR]})
    scene.room(2, (4.2, -2, 0), (5.4, 5, 2.5), skip=("x0", "x1"))
    for at, sign in ((4.2, 1), (5.4, -1)):
        scene.add(0, at, (-2.0, 0.0), (5.0, 2.5), sign, 2, holes=[DOOR])
    scene.scanners = [((2.2, 1.3, 1.5), 0), ((7.0, 1.6, 1.5), 1)]
    return scene


def test_rooms_on_the_two_sides_of_a_hall_without_scans_have_no_door_between_them():
    cloud, surfels, planes, labels, rooms = unscanned_hall().scan()
    seen_wrongly = surfels.positions[:, 1] > 2.5  # a little of the hall was given to room 1
    hall = labels.after == 2
    after = np.where(hall, np.where(seen_wrongly, 1, -1), labels.after).astype(np.int32)
    found = find_openings(cloud, surfels, planes, replace(labels, after=after), rooms[:2], ())
    assert {(opening.room_a, opening.room_b) for opening in found} <= {(0, None), (1, None)}


def test_a_hole_behind_which_the_own_room_goes_on_is_none_whatever_is_seen_farther_on():
    """As in the wall beside a flight of stairs: the next room is close behind it, but its door is another."""
    scene = BoxScene()
    scene.room(0, (0, 0, 0), (4, 3, 2.5), holes={"x1": [DOOR]})
    scene.room(1, (4.2, 0, 0), (8, 3, 2.5), holes={"x0": [DOOR]})
    for sign in (-1, 1):
        scene.add(0, 3.15 + 0.03 * sign, (0.0, 0.0), (3.0, 2.5), sign, 0, holes=[((0.4, 0.0), (2.6, 1.9))])
    scene.scanners = [((1.5, 1.3, 1.5), 0), ((5.8, 1.6, 1.5), 1)]
    (door,) = openings_with_plans(scene, [(0, 0, 4, 3), (4.2, 0, 8, 3)])
    assert door.position[0] == pytest.approx(4.1, abs=0.05)


def test_a_door_leads_to_the_room_right_behind_it_not_to_the_one_that_more_is_seen_of():
    """From a closet one looks through the bath into the hall; the scanner of the bath hardly sees its own door."""
    scene = BoxScene()
    scene.room(0, (0, 0, 0), (4, 3, 2.5), holes={"x1": [DOOR]})
    scene.room(1, (4.2, 0, 0), (6, 1.95, 2.5), holes={"x0": [DOOR], "y1": [((4.4, 0.0), (5.2, 2.05))]})
    scene.room(2, (4.2, 2.1, 0), (6, 3.6, 2.5), holes={"y0": [((4.4, 0.0), (5.2, 2.05))]})
    scene.scanners = [((3.8, 2.2, 1.5), 0), ((4.22, 0.1, 1.5), 1), ((5.0, 2.35, 1.5), 2)]
    found = openings_with_plans(scene, [(0, 0, 4, 3), (4.2, 0, 6, 1.95), (4.2, 2.1, 6, 3.6)])
    assert {(door.room_a, door.room_b) for door in found} == {(0, 1), (1, 2)}


def openings_with_plans(scene, plans):
    """Openings between rooms whose plans are boxes (low x, low y, high x, high y)."""
    cloud, surfels, planes, labels, rooms = scene.scan()
    outlined = [replace(r, outline=(np.array(box(*p).exterior.coords),)) for r, p in zip(rooms, plans, strict=True)]
    found = find_openings(cloud, surfels, planes, labels, outlined, ())
    return [opening for opening in found if opening.room_b is not None]


def test_a_door_that_is_only_looked_through_from_a_third_room_is_found():
    """The scanner stands behind the door opposite: no ray begins in one of the two rooms and ends in the other."""
    scene = BoxScene()
    scene.room(0, (0, 0, 0), (4, 3, 2.5), holes={"x0": [DOOR], "x1": [DOOR]})
    scene.room(1, (4.2, 0, 0), (8, 3, 2.5), holes={"x0": [DOOR]})
    scene.room(2, (-4, 0, 0), (-0.2, 3, 2.5), holes={"x1": [DOOR]})
    scene.scanners = [((-1.5, 1.4, 1.5), 2)]
    found, *_ = openings_of(scene)
    assert {(door.kind, door.room_a, door.room_b) for door in found} >= {("door", 0, 1), ("door", 0, 2)}
    (door,) = [opening for opening in found if (opening.room_a, opening.room_b) == (0, 1)]
    np.testing.assert_allclose(door.position[:2], [4.1, 1.45], atol=0.11)  # in the face of the wall that was seen


def test_points_too_sparse_to_tell_their_room_do_not_hide_the_one_that_a_door_leads_to():
    """As at the far end of a corridor: three points of four behind the door belong to no surfel."""
    scene = two_rooms(holes=[DOOR])
    scene.scanners = scene.scanners[:1]
    cloud, surfels, planes, labels, rooms = scene.scan()
    sparse = (cloud.positions[:, 0] > 4.3) & (np.arange(len(cloud.positions)) % 4 > 0)
    surfels = replace(surfels, point_surfel=np.where(sparse, -1, surfels.point_surfel).astype(np.int32))
    (door,) = find_openings(cloud, surfels, planes, labels, rooms, ())
    assert (door.kind, door.room_a, door.room_b) == ("door", 0, 1)


def test_what_lies_in_the_plan_of_a_room_that_other_rays_lead_to_is_of_that_room():
    """Not so what lies in the plan of a room that no ray leads to, nor what was not asked."""
    far = np.array([1, -1, -1, -1, -1, 2], np.int32)
    asked = np.array([True, True, True, True, False, False])
    ends = np.array([[0.5, 0.5, 1], [0.5, 0.9, 1], [3.0, 0.5, 1], [1.5, 0.5, 1], [0.1, 0.1, 1], [3.0, 0.6, 1]])
    plans = {1: Polygon([(0, 0), (1, 0), (1, 1), (0, 1)]), 2: Polygon([(2, 0), (4, 0), (4, 1), (2, 1)])}
    assert known_by_plan(far, asked, ends, plans).tolist() == [1, 1, -1, -1, -1, 2]


def test_a_window_that_shows_the_ground_outside_has_the_middle_of_its_wall():
    """The sill is hidden by a chest, the ground 3 m below is seen, and the reveal is 0.3 m deep."""
    scene = glazed_room()
    scene.block((0.6, 2.3, 0.0), (2.6, 2.9, 0.85), 0)
    low, high = (1.0, 0.9), (2.2, 2.0)
    for x, sign in ((low[0], 1), (high[0], -1)):
        scene.add(0, x, (3.0, low[1]), (3.3, high[1]), sign, 0, plane=False)
    scene.add(2, high[1], (low[0], 3.0), (high[0], 3.3), -1, 0, plane=False)
    scene.add(2, -1.0, (-20.0, 3.3), (20.0, 30.0), 1, -1, plane=False)
    (window,) = openings_of(scene)[0]
    assert (window.kind, window.room_b) == ("window", None)
    np.testing.assert_allclose(window.position, [1.6, 3.15, 1.45], atol=0.06)


def test_a_mirror_on_an_outer_wall_is_no_window():
    """Behind the wall there is the image of the room."""
    scene = glazed_room()
    inner = list(scene.rectangles)
    for r in inner:
        if r.axis == 1:
            scene.add(1, 6.0 - r.at, r.low, r.high, -r.sign, -1, plane=False)
        else:
            which = r.others.index(1)
            low, high = list(r.low), list(r.high)
            low[which], high[which] = 6.0 - r.high[which], 6.0 - r.low[which]
            scene.add(r.axis, r.at, tuple(low), tuple(high), r.sign, -1, plane=False)
    assert openings_of(scene)[0] == ()


def test_the_leaf_of_a_door_does_not_tilt_the_wall_that_it_was_joined_to():
    """The leaf is 2.5 cm behind the wall."""
    rng = np.random.default_rng(3)
    wall = np.column_stack([rng.uniform(0, 3, 1200), np.zeros(1200), rng.uniform(0, 2.5, 1200)])
    wall = wall[(wall[:, 0] < 0.3) | (wall[:, 0] > 1.2) | (wall[:, 2] > 2.0)][:800]
    leaf = np.column_stack([rng.uniform(0.3, 1.2, 250), np.full(250, -0.025), rng.uniform(0, 2.0, 250)])
    positions = (np.concatenate([wall, leaf]) + rng.normal(0, 0.002, (1050, 3))).astype(np.float32)
    normals = np.tile(np.array([0, 1, 0], np.float32), (1050, 1))
    surfels = Surfels(positions, normals, np.zeros(1050, np.int32), np.arange(1050, dtype=np.int32))
    parts = np.arange(800, dtype=np.int32), np.arange(800, 1050, dtype=np.int32)
    patches = [
        Patch(0, k, np.array([0.0, 1.0, 0.0]), off, own)
        for k, (off, own) in enumerate(zip((0, -0.025), parts, strict=True))
    ]
    (side,) = join_patches(patches, surfels, max_angle_deg=8, max_offset_m=0.05)
    assert abs(side.offset) < 0.003
    assert side.normal[1] == pytest.approx(1.0, abs=1e-5)


def upright_hole(x: float, edges: tuple[float, float, float, float]) -> tuple[Hole, Surfels]:
    """Return a hole in a wall at x that faces -x, and the wall around it."""
    places = np.stack(np.meshgrid([x], np.arange(0.0, 4.0, 0.05), np.arange(-2.0, 2.5, 0.05)), axis=-1).reshape(-1, 3)
    count, none = len(places), np.zeros(0)
    surfels = Surfels(
        places.astype(np.float32),
        np.tile(np.float32([-1, 0, 0]), (count, 1)),
        np.zeros(count, np.int32),
        np.arange(count, dtype=np.int32),
    )
    axes = np.array([-1.0, 0.0, 0.0]), -x, np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
    side = Side(0, (0,), *axes, np.array([0.0, -2.0, 4.0, 2.5]), np.arange(count, dtype=np.int32))
    ends = none.reshape(0, 2), none, none.astype(bool)
    return Hole(side, np.array(edges), np.ones(4, bool), none.astype(np.int32), *ends, 1.0, 0.3, 0.0), surfels


@pytest.mark.parametrize(("x", "bounds"), [(4.0, True), (3.9, True), (2.4, False), (4.4, True)])
def test_a_hole_bounds_its_room_only_in_the_walls_of_its_outline(x: float, *, bounds: bool) -> None:
    """The last lies in the recess of a window that the outline leaves out."""
    hole, surfels = upright_hole(x, (1.0, 0.9, 2.0, 2.0))
    assert bounds_room(hole, Polygon([(0, 0), (4, 0), (4, 4), (0, 4)]), surfels) is bounds


def test_a_wall_around_a_recess_bounds_the_room_though_the_outline_goes_into_the_recess() -> None:
    hole, surfels = upright_hole(4.0, (1.0, 0.9, 2.0, 2.0))
    outline = Polygon([(0, 0), (4, 0), (4, 1), (4.7, 1), (4.7, 2), (4, 2), (4, 4), (0, 4)])
    assert bounds_room(hole, outline, surfels)


@pytest.mark.parametrize(
    ("depth", "top", "pane", "within"),
    [
        (4.0, 2.5, 0.0, True),
        (4.0, 2.1, 0.0, False),
        (4.0, 2.5, 0.9, False),
        (0.7, 2.5, 0.0, False),
        (0.0, 2.5, 0.0, False),
    ],
)
def test_the_mouth_of_an_arm_of_a_corridor_is_no_opening(
    depth: float, top: float, pane: float, *, within: bool
) -> None:
    """Unless there is a lintel, or glass with a little of the room's plan behind; a recess is no arm."""
    hole = replace(upright_hole(4.0, (1.0, 0.0, 2.0, top))[0], pane=pane)
    arm = [(4, 1), (4 + depth, 1), (4 + depth, 2), (4, 2)] if depth else []
    outline = np.array([(0, 0), (4, 0), *arm, (4, 4), (0, 4), (0, 0)], np.float64)
    bounds = np.array([0.0, 0.0, 0.0, 4.0 + depth, 4.0, 2.5])
    room = Room(0, 16.0 + depth, 0.0, 2.5, np.zeros(3), bounds, (outline,), 1000, (), 1.0, 0)
    assert within_room(hole, room, OpeningParameters()) is within


@pytest.mark.parametrize(("bottom", "cut"), [(0.9, 0.9), (0.0, 0.0), (-0.05, -0.05), (-1.5, 0.0)])
def test_a_hole_ends_at_the_floor_of_its_room(bottom: float, cut: float) -> None:
    hole = above_floor(upright_hole(4.0, (1.0, bottom, 2.0, 2.0))[0], 0.0)
    assert hole is not None
    assert hole.edges[1] == pytest.approx(cut)


@pytest.mark.parametrize(
    ("bottom", "lowest", "cut"), [(0.0, 0.85, 0.85), (0.0, 0.1, 0.0), (0.0, np.inf, 0.0), (0.9, 1.1, 0.9)]
)
def test_a_hole_begins_where_rays_begin_to_go_through_it(bottom: float, lowest: float, cut: float) -> None:
    """A parapet that furniture hides has no points; a hole with a sill keeps it."""
    hole = replace(upright_hole(4.0, (1.0, bottom, 2.0, 2.0))[0], lowest=lowest)
    found = above_hidden(hole, 0.0, OpeningParameters())
    assert found is not None
    assert found.edges[1] == pytest.approx(cut)
    assert found.bounded[1] == (cut == bottom)


def test_a_hole_below_the_floor_is_none_of_the_room() -> None:
    assert above_floor(upright_hole(4.0, (1.0, -2.0, 2.0, -0.3))[0], 0.0) is None


@pytest.mark.parametrize(
    ("edges", "bounded", "lintel", "doorway"),
    [
        ((1.0, 0.0, 1.9, 2.0), (1, 1, 1, 1), 0.4, True),
        ((1.0, 0.3, 1.9, 2.0), (1, 0, 1, 1), 0.4, True),
        ((1.0, 0.9, 1.9, 2.0), (1, 1, 1, 1), 0.4, False),
        ((1.0, 0.0, 1.2, 2.0), (1, 1, 1, 1), 0.4, False),
        ((1.0, 0.0, 1.9, 1.2), (1, 1, 1, 1), 0.4, False),
        ((1.0, 0.0, 1.9, 2.0), (0, 1, 1, 1), 0.4, False),
        ((1.0, 0.0, 1.9, 2.0), (1, 1, 1, 1), 0.0, False),
    ],
)
def test_a_doorway_is_as_large_as_a_door_and_has_wall_on_both_sides_and_above(
    edges: tuple[float, float, float, float], bounded: tuple[int, ...], lintel: float, *, doorway: bool
) -> None:
    hole = replace(upright_hole(4.0, edges)[0], bounded=np.array(bounded, bool), lintel=lintel)
    assert is_doorway(hole, 0.0, OpeningParameters()) is doorway
