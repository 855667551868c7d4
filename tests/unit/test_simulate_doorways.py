import numpy as np
import pytest

from enfilade.simulate.build import build
from enfilade.simulate.casting import Caster
from enfilade.simulate.doorways import doorways
from enfilade.simulate.flights import stairs_between
from enfilade.simulate.locate import Locator
from enfilade.simulate.plan import Level, Plan, Space, rectangle
from enfilade.simulate.solids import box, merge, slab, wall
from enfilade.simulate.units import units_of

LEFT, RIGHT = box([0, 0, 0], [4, 5, 2.5]), box([4.2, 0, 0], [8, 5, 2.5])


def openings_with(*holes, spaces=(LEFT, RIGHT), doors=()):
    slabs = [slab((-1, 9, -1, 6), -0.3, 0.0), slab((-1, 9, -1, 6), 2.5, 2.8)]
    walls = Caster(merge([*slabs, wall((4.1, 0), (4.1, 5), 0.2, (0.0, 2.5), holes)]))
    units = units_of([(f"Space {k}", mesh) for k, mesh in enumerate(spaces)], [(0.0, "Ground")], walls)
    return doorways(units.borders, units.unit, units.rooms, walls, doors)


def test_a_doorway_under_a_lintel_is_an_open_door():
    (door,) = openings_with((1.0, 2.03, 0.0, 2.12))
    assert (door.kind, door.state, door.rooms) == ("door", "open", (0, 1))
    assert (door.width, door.height, door.depth) == pytest.approx((1.03, 2.12, 0.2), abs=1e-3)
    assert door.position == pytest.approx([4.1, 1.515, 1.06], abs=1e-3)
    assert door.normal == pytest.approx([1, 0, 0])


def test_a_hole_up_to_the_ceiling_is_a_passage():
    (passage,) = openings_with((1.0, 2.6, 0.0, 2.5))
    assert (passage.kind, passage.state) == ("passage", None)
    assert (passage.width, passage.height) == pytest.approx((1.6, 2.5), abs=1e-3)


@pytest.mark.parametrize("hole", [(1.0, 1.3, 0.0, 2.1), (1.0, 2.0, 0.9, 2.1), (1.0, 2.0, 0.0, 1.2)])
def test_what_one_cannot_walk_through_is_no_doorway(hole):
    assert openings_with(hole) == []


def test_a_known_door_is_not_found_again():
    hole = (1.0, 2.0, 0.0, 2.1)
    known = openings_with(hole)
    assert openings_with(hole, doors=known) == []
    assert len(openings_with(hole, (3.0, 4.0, 0.0, 2.1), doors=known)) == 1


def test_a_hole_across_two_spaces_of_one_room_is_one_doorway():
    halves = (LEFT, box([4.2, 0, 0], [8, 2.5, 2.5]), box([4.2, 2.5, 0], [8, 5, 2.5]))
    (door,) = openings_with((1.5, 3.5, 0.0, 2.2), spaces=halves)
    assert door.width == pytest.approx(2.0, abs=1e-3)


def test_stairs_join_the_rooms_at_their_foot_and_head():
    spaces = [Space("Hall", rectangle(0, 6, 0, 3))], [Space("Landing", rectangle(0, 6, 0, 3))]
    levels = tuple(Level(f"Level {k}", 3.0 * k, 3.0 * k + 2.7, tuple(spaces[k])) for k in (0, 1))
    scene = build(Plan("stairs", rectangle(0, 6, 0, 3), levels, garden=0.0))
    steps = merge(box([1 + k / 4, 2, 3 * k / 16], [1.25 + k / 4, 3, 3 * (k + 1) / 16]) for k in range(16))
    slabs = Caster(merge([slab((0, 6, 0, 3), 2.7, 3.0, [(2, 5, 2, 3)]), slab((0, 6, 0, 3), -0.3, 0.0)]))
    found = stairs_between(steps, scene.rooms, Locator(scene.rooms), slabs)
    assert found is not None
    assert found.rooms == (0, 1)
    assert found.position == pytest.approx([3.5, 2.5, 2.85], abs=0.03)
    assert (found.width, found.height, found.depth) == pytest.approx((1.0, 3.0, 0.3), abs=0.06)
    assert found.ends[0][0] < 2
    assert found.ends[1][0] > 4
    assert np.ptp(found.ends[:, 2]) > 2


def test_a_ladder_to_nowhere_joins_nothing():
    scene = build(
        Plan("flat", rectangle(0, 6, 0, 3), (Level("Ground", 0.0, 2.7, (Space("Hall", rectangle(0, 6, 0, 3)),)),))
    )
    steps = merge(box([1 + k, 1, 0.2 * k], [1.3 + k, 2, 0.2 * k + 0.1]) for k in range(4))
    assert stairs_between(steps, scene.rooms, Locator(scene.rooms), Caster(scene.mesh)) is None
