"""The grid that knows the sides."""

from __future__ import annotations

import numpy as np
import pytest

from enfilade.ingest.openings.crossings import SideGrid, _cells
from enfilade.ingest.records import F32, I32
from enfilade.ingest.sides import Side


def test_the_grid_is_around_the_sides_wherever_the_origin_is() -> None:
    places = np.random.default_rng(2).uniform(0.0, 8.0, (500, 3))
    number = np.arange(500) % 7
    near, far = _cells(places, number, 0.1), _cells(places + 800.0, number, 0.1)
    assert len(near.first) < 20**3
    assert abs(len(far.first) - len(near.first)) <= 0.2 * len(near.first)


def test_without_sides_no_ray_meets_any() -> None:
    grid = SideGrid([], [], front_m=0.1, inset_m=0.1)
    end, start, scan = np.ones((4, 3), np.float32), np.zeros((1, 3), np.float32), np.zeros(4, np.int32)
    assert len(grid.crossings(end, start, scan).ray) == 0
    assert len(grid.ends(end, start, scan).ray) == 0


def _wall(room: int, normal: tuple[float, float, float], offset: float) -> Side:
    facing, up = np.array(normal), np.array([0.0, 0.0, 1.0])
    extent = np.array([-4.0, 0.0, 4.0, 2.5])
    return Side(room, (room,), facing, offset, np.cross(up, facing), up, extent, np.zeros(0, np.int32))


SIDES = [_wall(room, (1.0, 0.0, 0.0), 2.0 * room) for room in range(3)] + [_wall(3, (0.0, 1.0, 0.0), 2.0)]


def _grid(sides: list[Side]) -> SideGrid:
    return SideGrid(sides, [0.03] * len(sides), front_m=0.3, inset_m=0.2)


def _rays(count: int) -> tuple[F32, F32, I32]:
    """Ends, starts, and the start of each end."""
    rng = np.random.default_rng(5)
    end = rng.uniform([-1.0, -0.5, -0.5], [5.0, 4.5, 3.0], (count, 3)).astype(np.float32)
    start = rng.uniform([-1.0, 0.5, 1.0], [5.0, 3.5, 2.0], (4, 3)).astype(np.float32)
    return end, start, rng.integers(0, 4, count).astype(np.int32)


def test_many_rays_on_several_threads_meet_what_each_meets_alone() -> None:
    end, start, scan = _rays(300)
    grid = _grid(SIDES)
    for meet in (grid.ends, grid.crossings):
        together = meet(end, start, scan)
        alone = [meet(end[ray : ray + 1], start, scan[ray : ray + 1]) for ray in range(len(end))]
        for side in range(len(SIDES)):
            meets = [ray for ray in range(len(end)) if len(alone[ray].ray[alone[ray].of(side)])]
            assert together.ray[together.of(side)].tolist() == meets
        assert len(together.ray) > 30


def test_how_a_ray_meets_a_side_does_not_depend_on_the_other_sides() -> None:
    rays = _rays(20_000)
    among = _grid(SIDES).ends(*rays)
    for number, side in enumerate(SIDES):
        alone, own = _grid([side]).ends(*rays), among.of(number)
        assert np.array_equal(among.ray[own], alone.ray)
        assert np.array_equal(among.place[own], alone.place)
        assert np.array_equal(among.depth[own], alone.depth)


@pytest.mark.parametrize("shift", np.arange(0.0, 0.5, 0.02).tolist())
def test_points_before_and_behind_a_side_are_met_wherever_it_stands_among_the_cells(shift: float) -> None:
    sides = [_wall(0, (1.0, 0.0, 0.0), -3.0), _wall(1, (1.0, 0.0, 0.0), 1.0 + shift)]
    depth = np.linspace(-0.29, 0.19, 49)
    end = np.column_stack([1.0 + shift - depth, np.zeros(49), np.ones(49)]).astype(np.float32)
    start, scan = np.array([[4.0, 0.0, 1.0]], np.float32), np.zeros(49, np.int32)
    meetings = _grid(sides).ends(end, start, scan)
    assert meetings.ray[meetings.of(1)].tolist() == list(range(49))
