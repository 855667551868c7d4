"""Holes that rays go through become doors, passages, windows and stairs with the right size and place."""

import numpy as np
import pytest
from box_scene import BoxScene, two_rooms

from enfilade.ingest.neighbours import find_neighbours
from enfilade.ingest.openings import find_openings


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
    assert passage.width == pytest.approx(2.0, abs=0.05)
    assert passage.height == pytest.approx(2.5, abs=0.05)


def test_a_hole_above_the_floor_is_a_window_with_its_sill():
    (window,), *_ = openings_of(two_rooms(holes=[((1.0, 0.9), (2.0, 2.0))]))
    assert window.kind == "window"
    assert window.sill == pytest.approx(0.9, abs=0.04)
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
