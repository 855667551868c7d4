import numpy as np
import pytest
from shapely import Polygon
from shapely import box as rectangle

from enfilade.simulate.casting import Caster
from enfilade.simulate.locate import Locator
from enfilade.simulate.polygons import extrude, footprint
from enfilade.simulate.solids import Mesh, box, merge, slab, wall
from enfilade.simulate.spaces import borders_of, sound_spaces, space_of
from enfilade.simulate.units import units_of

LEVELS = [(0.0, "Ground"), (3.0, "Upper")]
LEFT, RIGHT = box([0, 0, 0], [4, 5, 2.5]), box([4.2, 0, 0], [8, 5, 2.5])
SLABS = [slab((-1, 9, -1, 6), -0.3, 0.0), slab((-1, 9, -1, 6), 2.5, 2.8)]


def rooms_with(*walls: Mesh, spaces=(LEFT, RIGHT)):
    bodies = [(f"Space {k}", mesh) for k, mesh in enumerate(spaces)]
    return units_of(bodies, LEVELS, Caster(merge([*SLABS, *walls])))


def dividing_wall(*holes):
    return wall((4.1, 0), (4.1, 5), 0.2, (0.0, 2.5), holes)


def volume(mesh):
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def test_a_wall_parts_two_rooms():
    units = rooms_with(dividing_wall())
    assert [room.area for room in units.rooms] == pytest.approx([20.0, 19.0])


def test_a_door_under_a_lintel_parts_two_rooms():
    units = rooms_with(dividing_wall((1.0, 4.8, 0.0, 2.1)))
    assert len(units.rooms) == 2
    assert np.median(units.borders[0].clear) == pytest.approx(2.1, abs=0.15)


def test_a_passage_between_wall_ends_parts_two_rooms():
    assert len(rooms_with(dividing_wall((1.5, 3.5, 0.0, 2.5))).rooms) == 2


def test_spaces_without_a_wall_between_them_are_one_room():
    units = rooms_with()
    assert [room.name for room in units.rooms] == ["Space 0 + Space 1"]
    assert units.rooms[0].area == pytest.approx(40.0, abs=0.1)


def test_a_side_that_is_open_throughout_joins_a_narrow_space_to_a_wide_one():
    narrow = box([4.2, 0, 0], [8, 1.2, 2.5])
    units = rooms_with(dividing_wall((0.0, 1.2, 0.0, 2.5)), spaces=(LEFT, narrow))
    assert len(units.rooms) == 1


def test_floor_and_ceiling_are_those_of_the_slabs_not_of_the_space():
    short = box([0, 0, 0.1], [4, 5, 2.2])
    room = rooms_with(spaces=(short,)).rooms[0]
    assert (room.floor_elevation, room.ceiling_elevation) == pytest.approx((0.0, 2.5), abs=1e-5)
    heights = np.array([[2.0, 2.0, z] for z in (-0.1, 0.05, 1.0, 2.3, 2.45, 2.6)])
    assert Locator([room]).rooms_of(heights).tolist() == [-1, 0, 0, 0, 0, -1]


def test_a_space_that_holds_others_or_lies_in_the_open_is_none():
    whole = box([-0.1, -0.1, 0], [8.1, 5.1, 2.5])
    terrace = box([0, 0, 2.8], [4, 5, 5])
    units = rooms_with(dividing_wall(), spaces=(whole, LEFT, RIGHT, terrace))
    assert [room.name for room in units.rooms] == ["Space 1", "Space 2"]


def test_a_space_over_two_storeys_is_cut_at_the_upper_floor():
    tall = space_of("Stair", box([0, 0, 0], [2, 4, 5.6]))
    roof = Caster(merge([SLABS[0], slab((-1, 9, -1, 6), 5.6, 5.9)]))
    low, high = sound_spaces([tall], [0.0, 3.0], roof)
    assert (low.bottom, low.top, high.bottom, high.top) == (0.0, 3.0, 3.0, 5.6)
    assert volume(low.boundary) + volume(high.boundary) == pytest.approx(2 * 4 * 5.6)


def test_storeys_are_those_that_have_rooms():
    units = rooms_with()
    assert [(storey.index, storey.name) for storey in units.storeys] == [(0, "Ground")]


def test_no_spaces_make_no_rooms():
    assert rooms_with(spaces=()).rooms == ()


def test_footprint_of_a_sloped_body_is_its_whole_plan():
    body = box([0, 0, 0], [4, 3, 2])
    body.vertices[:, 2] += np.where(body.vertices[:, 2] > 1, body.vertices[:, 0] / 2, 0)
    assert footprint(body).area == pytest.approx(12.0, rel=1e-3)


def test_prism_over_a_polygon_with_a_hole_has_its_volume():
    ring = Polygon([(0, 0), (5, 0), (5, 1), (1, 1), (1, 4), (0, 4)]).difference(rectangle(0.2, 0.2, 0.6, 0.6))
    assert volume(extrude(ring, 1.0, 3.5)) == pytest.approx(ring.area * 2.5)


def test_border_tells_how_wide_the_gap_is():
    spaces = [space_of("a", LEFT), space_of("b", RIGHT)]
    (border,) = borders_of(spaces, Caster(dividing_wall()))
    assert border.gap == pytest.approx(0.2, abs=1e-3)
    assert border.middle[:, 0] == pytest.approx(4.1, abs=1e-3)
    assert not border.open_top.any()
