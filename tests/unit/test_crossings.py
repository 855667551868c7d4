"""The grid that knows the sides."""

from __future__ import annotations

import numpy as np

from enfilade.ingest.openings.crossings import SideGrid, _cells


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
