"""Which passages leave one room: those up to the ceiling over more than half of the wall between two spaces."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from enfilade.simulate import generate
from enfilade.simulate.build import build
from enfilade.simulate.casting import Caster
from enfilade.simulate.generate import generated_plan
from enfilade.simulate.joining import joined, open_share
from enfilade.simulate.locate import Locator
from enfilade.simulate.plan import Hole, Level, Plan, Run, Space, Stairs, rectangle
from enfilade.simulate.recipes import CORPUS, recipe_of
from enfilade.simulate.roofs import Roof
from enfilade.simulate.spaces import WALL_LESS_M, WALL_LESS_SHARE

ROOMS = (Space("A", rectangle(0, 4, 0, 3)), Space("B", rectangle(4.2, 8, 0, 3)), Space("C", rectangle(0, 8, 3.2, 6)))
"""A and B side by side with 3 m of wall between them, C along both."""


def plan_of(*holes: Hole, spaces: tuple[Space, ...] = ROOMS) -> Plan:
    return Plan("plan", rectangle(-0.3, 8.3, -0.3, 6.3), (Level("Ground", 0.0, 2.5, spaces, holes),), garden=0.0)


def passage(width: float, kind: str = "passage", height: float = 2.5) -> Hole:
    return Hole(kind, ("A", "B"), (4.1, 1.5), width, height)


@settings(max_examples=30, deadline=None)
@given(st.floats(0.7, 2.9))
def test_a_passage_over_more_than_half_of_the_wall_leaves_one_room(width: float) -> None:
    hole = passage(round(width, 2))
    assert open_share(hole, ROOMS) == pytest.approx(hole.width / 3.0, abs=0.01)
    count = len(joined(plan_of(hole)).levels[0].spaces)
    assert count == (2 if hole.width > 1.5 else 3)


WIDE_ROOMS = (Space("A", rectangle(0, 4, 0, 7)), Space("B", rectangle(4.2, 8, 0, 7)))


@pytest.mark.parametrize(("width", "rooms"), [(2.1, 2), (2.3, 1)])
def test_a_passage_wider_than_any_door_leaves_one_room_beside_whatever_wall(width: float, rooms: int) -> None:
    level = Level("Ground", 0.0, 2.5, WIDE_ROOMS, (passage(width),))
    plan = Plan("plan", rectangle(-0.3, 8.3, -0.3, 7.3), (level,), garden=0.0)
    assert len(joined(plan).levels[0].spaces) == rooms


def test_a_lintel_parts_two_rooms_however_wide_the_way_is() -> None:
    plan = plan_of(passage(2.8, "door", 2.3))
    assert joined(plan) == plan


def test_rooms_of_different_floor_or_ceiling_stay_two() -> None:
    for other in (replace(ROOMS[1], floor=0.3), replace(ROOMS[1], roof=Roof(2.4))):
        plan = plan_of(passage(2.4, height=2.2), spaces=(ROOMS[0], other, ROOMS[2]))
        assert joined(plan) == plan


def test_the_one_room_has_the_passage_in_it_and_all_the_other_holes() -> None:
    scene = build(plan_of(passage(2.0), Hole("door", ("B", "C"), (6.0, 3.1), 0.9, 2.0)))
    assert [room.name for room in scene.rooms] == ["A + B", "C"]
    assert scene.rooms[0].area == pytest.approx(12.0 + 11.4 + 2.0 * 0.2, abs=0.01)
    assert [(hole.kind, hole.rooms) for hole in scene.openings] == [("door", (0, 1))]
    inside = np.array([[4.1, 1.5, 1.0], [4.1, 0.2, 1.0]])
    assert Locator(scene.rooms).rooms_of(inside).tolist() == [0, -1]
    across = np.array([[3.5, 1.5, 2.4], [3.5, 0.2, 2.4]])
    assert Caster(scene.mesh).blocked(across, across + np.array([1.2, 0.0, 0.0])).tolist() == [False, True]


def test_the_same_walls_stand_whether_two_rooms_are_joined_or_not() -> None:
    """Rays from anywhere meet the same things: only the names of what they meet differ."""
    holes = (passage(2.0), Hole("door", ("B", "C"), (6.0, 3.1), 0.9, 2.0))
    apart = build(plan_of(replace(holes[0], kind="door"), holes[1]))
    one = build(plan_of(*holes))
    random = np.random.default_rng(1)
    starts = random.uniform([0.2, 0.2, 0.2], [7.8, 2.8, 2.3], (500, 3))
    starts = starts[np.abs(starts[:, 0] - 4.1) > 0.15]
    directions = random.normal(size=starts.shape)
    np.testing.assert_allclose(
        Caster(one.mesh).cast(starts, directions)[0], Caster(apart.mesh).cast(starts, directions)[0], atol=1e-3
    )


def test_three_rooms_in_a_row_become_one_and_its_stairs_lead_on() -> None:
    holes = (
        passage(2.0),
        Hole("passage", ("B", "C"), (6.1, 3.1), 3.0, 2.5),
        Hole("door", ("A", "C"), (1, 3.1), 0.8, 2.0),
    )
    well = rectangle(1.0, 3.0, 0.2, 1.2)
    stairs = Stairs(("A", "D"), (Run((0.5, 0.7), (3.0, 0.7), 1.0, 0.0, 2.8, 15),), well)
    above = Level("Upper", 2.8, 5.3, (Space("D", rectangle(0, 8, 0, 6)),))
    plan = replace(plan_of(*holes), stairs=(stairs,))
    made = joined(replace(plan, levels=(*plan.levels, above)))
    assert [space.name for space in made.levels[0].spaces] == ["A + B + C"]
    assert [hole.rooms for hole in made.levels[0].holes] == [("A + B + C", "A + B + C")]
    assert made.stairs[0].rooms == ("A + B + C", "D")


def test_no_passage_of_a_generated_building_is_near_the_border() -> None:
    passages = [
        (open_share(hole, level.spaces), hole.width)
        for seed in CORPUS
        if "wide passages" in recipe_of(seed).features
        for level in generated_plan(seed).levels
        for hole in level.holes
        if hole.kind == "passage"
    ]
    joining = [share > WALL_LESS_SHARE + 0.09 or width > WALL_LESS_M + 0.4 for share, width in passages]
    parting = [share < WALL_LESS_SHARE - 0.09 and width < WALL_LESS_M - 0.4 for share, width in passages]
    assert any(joining)
    assert any(parting)
    assert all(a or b for a, b in zip(joining, parting, strict=True))


def test_a_generated_loft_has_fewer_rooms_than_spaces() -> None:
    scene = generate(15).scene
    assert len(scene.rooms) < len(generated_plan(15).levels[0].spaces)
    assert not any(hole.kind == "passage" for hole in scene.openings)
    assert all(shapely.is_valid(room.polygon) for room in scene.rooms)
