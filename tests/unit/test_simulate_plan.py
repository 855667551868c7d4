"""Scenes of plans: rooms of any shape under any roof, and holes between them."""

import numpy as np
import pytest
import shapely
from shapely import Point, Polygon

from enfilade.errors import InputError
from enfilade.simulate.build import build
from enfilade.simulate.casting import Caster
from enfilade.simulate.locate import Locator
from enfilade.simulate.plan import Hole, Leaf, Level, Plan, Space, rectangle
from enfilade.simulate.roofs import Roof
from enfilade.simulate.scene import turned
from enfilade.simulate.shells import shell, triangles_of

GABLE = Roof(2.5, ((0.0, 1.0, 1.0), (0.0, -1.0, 5.0)))
"""Knees of 1 m at y = 0 and y = 4, cut off at 2.5 m."""
L_SHAPE = Polygon([(0, 0), (5, 0), (5, 2), (2, 2), (2, 4), (0, 4)])


def volume(mesh):
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def pair(first, second, *holes, roofs=(None, None), floors=(None, None)):
    spaces = tuple(
        Space(name, polygon, roof=roof, floor=floor)
        for name, polygon, roof, floor in zip(("A", "B"), (first, second), roofs, floors, strict=True)
    )
    return build(Plan("pair", rectangle(-1, 12, -1, 6), (Level("Ground", 0.0, 2.5, spaces, holes),), garden=0.0))


def test_triangles_cover_a_polygon_with_a_hole():
    polygon = L_SHAPE.difference(Point(1, 1).buffer(0.4))
    corners = triangles_of(polygon)
    sides = corners[:, 1:] - corners[:, :1]
    areas = (sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0]) / 2
    assert (areas > 0).all()
    assert areas.sum() == pytest.approx(polygon.area)


@pytest.mark.parametrize("polygon", [rectangle(0, 5, 0, 4), L_SHAPE, Point(2, 2).buffer(1.9, quad_segs=3)])
@pytest.mark.parametrize("roof", [Roof(2.5), GABLE])
def test_a_shell_is_closed_and_holds_what_is_under_the_roof(polygon, roof):
    grid = np.stack(np.meshgrid(np.arange(0.005, 5, 0.01), np.arange(0.005, 4, 0.01)), -1).reshape(-1, 2)
    expected = roof.heights(grid[shapely.contains_xy(polygon, grid)]).sum() * 0.01**2
    assert volume(shell(polygon, 0.0, roof)) == pytest.approx(expected, rel=2e-3)


def test_the_lowest_of_ceiling_and_slopes_counts():
    assert GABLE.heights([(1, 0), (1, 1), (1, 2), (1, 3.5)]) == pytest.approx([1.0, 2.0, 2.5, 1.5])
    expected = [(0, 1.0), (1.5, 2.5), (2.0, 2.5), (2.5, 2.5), (4, 1.0)]
    assert np.array(GABLE.profile((0, 0), (0, 4))) == pytest.approx(np.array(expected))


def test_a_door_into_a_round_room_is_as_wide_as_it_says():
    circle = Point(6, 2).buffer(1.9, quad_segs=8)
    scene = pair(rectangle(0, 3.9, 0, 4), circle, Hole("door", ("A", "B"), (4.0, 2.0), 0.9, 2.0))
    (door,) = scene.openings
    assert (door.width, door.normal.tolist()) == (0.9, [1, 0, 0])
    caster = Caster(scene.mesh)
    for along, free in ((-0.4, True), (0.4, True), (-0.5, False), (0.5, False)):
        start = door.position + along * door.axis - 0.5 * door.normal
        assert bool(caster.blocked(start[None], (start + 1.2 * door.normal)[None])[0]) != free


def test_a_door_to_a_higher_floor_stands_on_it():
    hole = Hole("door", ("A", "B"), (4.05, 2.0), 0.9, 2.0)
    scene = pair(rectangle(0, 4, 0, 4), rectangle(4.1, 8, 0, 4), hole, floors=(0.0, 0.36))
    assert scene.openings[0].position[2] == pytest.approx(1.36)


def test_a_hole_that_leads_elsewhere_is_refused():
    with pytest.raises(InputError, match="does not lead from A to B"):
        pair(rectangle(0, 4, 0, 4), rectangle(4.1, 8, 0, 4), Hole("door", ("A", "B"), (2.0, 4.2), 0.9, 2.0))


@pytest.mark.parametrize("into", [0, 1])
@pytest.mark.parametrize("hinge", [-1, 1])
def test_a_leaf_swings_into_its_room_about_its_hinge(into, hinge):
    hole = Hole("door", ("A", "B"), (4.05, 2.0), 0.9, 2.0, leaf=Leaf(90.0, into, hinge))
    scene = pair(rectangle(0, 4, 0, 4), rectangle(4.1, 8, 0, 4), hole)
    (door,) = scene.openings
    assert door.state == "open"
    side = 1 if into else -1
    place = door.position + door.normal * side * (door.depth / 2 + 0.45) + door.axis * hinge * (door.width / 2 - 0.1)
    ranges, _ = Caster(scene.mesh).cast(place, (hinge * door.axis)[None])
    assert ranges[0] == pytest.approx(0.1 - 0.04, abs=1e-3)
    assert Locator(scene.rooms).rooms_of(place[None])[0] == into


@pytest.mark.parametrize(("angle", "state"), [(0.0, "closed"), (20.0, "ajar"), (80.0, "open")])
def test_state_follows_from_the_leaf(angle, state):
    assert Hole("door", ("A", "B"), (0, 0), 1, 2, leaf=Leaf(angle)).state == state


def test_a_turned_scene_keeps_rooms_and_openings_together():
    hole = Hole("door", ("A", "B"), (4.05, 2.0), 0.9, 2.0)
    scene = pair(rectangle(0, 4, 0, 4), rectangle(4.1, 8, 0, 4), hole)
    moved = turned(scene, 30.0, np.array([700.0, -300.0, 50.0]))
    door = moved.openings[0]
    sides = door.position + np.outer([-0.2, 0.2], door.normal)
    assert Locator(moved.rooms).rooms_of(sides).tolist() == [0, 1]
    assert moved.rooms[0].area == pytest.approx(16.0)
    assert moved.rooms[0].floor_elevation == 50.0
    assert moved.storeys[0].elevation == 50.0
