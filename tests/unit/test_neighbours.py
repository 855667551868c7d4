"""Rooms back to back are neighbours, with the gap and the area that they share."""

import numpy as np
import pytest
from box_scene import BoxScene, two_rooms

from enfilade.ingest.neighbours import NeighbourParameters, find_neighbours


def neighbours_of(scene, parameters=None):
    _, surfels, planes, labels, rooms = scene.scan(step_deg=0.9)
    return find_neighbours(surfels, planes, labels, rooms, parameters), planes


def test_shared_wall_has_its_thickness_and_area():
    (found,), planes = neighbours_of(two_rooms(thickness=0.24))
    assert (found.room_a, found.room_b) == (0, 1)
    assert found.gap == pytest.approx(0.24, abs=0.005)
    assert found.area == pytest.approx(3 * 2.5, rel=0.1)
    ((a, b),) = found.plane_pairs
    assert np.dot(planes.normals[a], planes.normals[b]) == pytest.approx(-1)


def test_a_thicker_wall_than_allowed_parts_rooms():
    assert neighbours_of(two_rooms(thickness=0.7))[0] == ()


def test_opposite_walls_of_one_room_are_no_neighbours():
    scene = BoxScene()
    scene.room(0, (0, 0, 0), (0.5, 3, 2.5))
    scene.scanners = [((0.25, 1.5, 1.5), 0)]
    assert neighbours_of(scene)[0] == ()


def test_walls_that_face_each_other_are_no_neighbours():
    """Two labels in one narrow space: the walls are close and opposite, but look at each other."""
    scene = BoxScene()
    scene.room(0, (0, 0, 0), (0.5, 3, 2.5), skip=("x1",))
    scene.room(1, (0, 0, 0), (0.5, 3, 2.5), skip=("x0", "y0", "y1", "z0", "z1"))
    scene.scanners = [((0.25, 1.5, 1.5), 0)]
    assert neighbours_of(scene)[0] == ()


def test_rooms_on_two_storeys_share_a_slab():
    scene = BoxScene()
    scene.room(0, (0, 0, 0), (4, 3, 2.5))
    scene.room(1, (2, 0, 2.8), (6, 3, 5.3))
    scene.scanners = [((2, 1.5, 1.5), 0), ((4, 1.5, 4.3), 1)]
    ((found,), planes) = neighbours_of(scene)
    assert found.gap == pytest.approx(0.3, abs=0.005)
    assert found.area == pytest.approx(2 * 3, rel=0.1)
    assert abs(planes.normals[found.plane_pairs[0][0], 2]) == pytest.approx(1)


def test_least_area_is_asked_for():
    assert neighbours_of(two_rooms(), NeighbourParameters(min_area_m2=9.0))[0] == ()


def test_a_wall_in_two_planes_is_one_neighbour_with_two_pairs():
    """A step of 10 cm in the wall on one side: two pairs of planes, the gap is their mean."""
    scene = BoxScene()
    scene.room(0, (0, 0, 0), (4, 3, 2.5))
    scene.room(1, (4.2, 0, 0), (7, 3, 2.5), skip=("x0",))
    scene.add(0, 4.2, (0, 0), (1.5, 2.5), 1, 1)
    scene.add(0, 4.3, (1.5, 0), (3, 2.5), 1, 1)
    scene.scanners = [((2, 1.5, 1.5), 0), ((5.7, 1.5, 1.5), 1)]
    (found,), _ = neighbours_of(scene)
    assert len(found.plane_pairs) == 2
    assert found.gap == pytest.approx(0.25, abs=0.01)
