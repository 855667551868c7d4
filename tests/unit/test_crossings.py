"""The grid that knows the sides."""

from __future__ import annotations

import numpy as np

from enfilade.ingest.openings.crossings import SideGrid, _cells
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


def test_many_rays_on_several_threads_meet_what_each_meets_alone() -> None:
    across = np.array([1.0, 0.0, 0.0])
    up = np.array([0.0, 0.0, 1.0])
    along = np.array([0.0, 1.0, 0.0])
    extent = np.array([0.0, 0.0, 4.0, 2.5])
    sides = [Side(room, (room,), across, 2.0 * room, along, up, extent, np.zeros(0, np.int32)) for room in range(3)]
    grid = SideGrid(sides, [0.03] * len(sides), front_m=0.3, inset_m=0.2)
    rng = np.random.default_rng(5)
    end = rng.uniform([-1.0, -0.5, -0.5], [5.0, 4.5, 3.0], (300, 3)).astype(np.float32)
    start = rng.uniform([-1.0, 0.5, 1.0], [5.0, 3.5, 2.0], (4, 3)).astype(np.float32)
    scan = rng.integers(0, 4, 300).astype(np.int32)
    for meet in (grid.ends, grid.crossings):
        together = meet(end, start, scan)
        met = [(side, ray) for side in range(len(sides)) for ray in together.ray[together.of(side)].tolist()]
        alone = [meet(end[ray : ray + 1], start, scan[ray : ray + 1]) for ray in range(len(end))]
        of_each = [
            (side, ray)
            for side in range(len(sides))
            for ray in range(len(end))
            for _ in alone[ray].ray[alone[ray].of(side)]
        ]
        assert met == of_each
        assert len(met) > 30
