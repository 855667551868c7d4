"""Rooms back to back are neighbours, with the gap and the area that they share."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from box_scene import BoxScene, two_rooms
from hypothesis import given
from hypothesis import strategies as st

from enfilade.ingest.borders import plan_borders, plan_of
from enfilade.ingest.neighbours import NeighbourParameters, find_neighbours
from enfilade.ingest.records import Room


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


def room_of(number, outline, floor=0.0, ceiling=2.5):
    low, high = outline.min(axis=0), outline.max(axis=0)
    return Room(
        number=number,
        area=float(shapely.Polygon(outline).area),
        floor_elevation=floor,
        ceiling_elevation=ceiling,
        centroid=np.append((low + high) / 2, floor),
        bounds=np.array([*low, floor, *high, ceiling]),
        outline=(outline,),
        point_count=1,
        scans=(),
        confidence=1.0,
        floor_plane=-1,
    )


def rectangle(x0, y0, x1, y1, angle=0.0):
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]]) @ turn


def borders_of(*rooms):
    plans = {room.number: plan_of(room) for room in rooms}
    return {(a, b): border for a, b, border in plan_borders(rooms, plans, max_gap_m=0.6, max_slab_m=0.8)}


@given(st.floats(0.05, 0.55), st.floats(0.5, 4.0), st.floats(0.0, 1.5), st.booleans())
def test_a_wall_between_plans_is_as_thick_and_as_wide_as_it_is_however_they_lie(gap, width, angle, turned):
    a = room_of(0, rectangle(0, 0, 4, 5, angle))
    b = room_of(1, rectangle(4 + gap, 5 - width, 7, 8, angle), ceiling=2.2)
    found = borders_of(b, a) if turned else borders_of(a, b)
    assert found.keys() == {(0, 1)}
    assert found[0, 1].gap == pytest.approx(gap, abs=1e-6)
    assert found[0, 1].area == pytest.approx(2.2 * width, abs=0.25)
    assert not found[0, 1].level


def test_plans_that_meet_at_a_corner_only_or_on_two_storeys_share_no_wall():
    a = room_of(0, rectangle(0, 0, 4, 3))
    assert borders_of(a, room_of(1, rectangle(4.2, 3.2, 7, 6))) == {}
    assert borders_of(a, room_of(1, rectangle(4.2, 0, 7, 3), floor=2.8, ceiling=5.3))[0, 1].area == 0.0


def test_a_floor_over_a_ceiling_shares_what_lies_in_both_plans():
    lower, upper = room_of(0, rectangle(0, 0, 4, 3)), room_of(1, rectangle(3, 1, 9, 3), floor=2.8, ceiling=5.3)
    border = borders_of(upper, lower)[0, 1]
    assert (border.gap, border.area, border.level) == (pytest.approx(0.3), pytest.approx(2.0), True)


def test_planes_of_rooms_on_two_storeys_whose_plans_do_not_overlap_are_no_slab():
    """Labels that stray over a wall put some of a ceiling under another room's floor."""
    scene = BoxScene()
    scene.room(0, (0, 0, 0), (4, 3, 2.5))
    scene.room(1, (3, 0, 2.8), (6, 3, 5.3))
    scene.scanners = [((2, 1.5, 1.5), 0), ((4.5, 1.5, 4.3), 1)]
    _, surfels, planes, labels, rooms = scene.scan(step_deg=0.9)
    assert len(find_neighbours(surfels, planes, labels, rooms)) == 1
    apart = (replace(rooms[0], outline=(rectangle(0, 0, 2.9, 3),)), replace(rooms[1], outline=(rectangle(3, 0, 6, 3),)))
    assert find_neighbours(surfels, planes, labels, apart) == ()
