"""Structure as rays see it: front and back, holes, and doors closed under their lintel."""

from __future__ import annotations

import numpy as np
import pytest

from enfilade.ingest.records import Bitmap, Planes
from enfilade.ingest.structure import Structure


def wall(occupancy: np.ndarray) -> Planes:
    """A wall of 10 cm cells in the plane x = 0 that faces +x; rows go up, columns along +y."""
    axes = (np.array(axis, np.float32) for axis in ((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    bitmap = Bitmap(*axes, 0.1, occupancy.astype(np.float32))
    return Planes(np.array([[1.0, 0.0, 0.0]], np.float32), np.zeros(1, np.float32), np.zeros(0, np.int32), (bitmap,))


@pytest.fixture
def with_door() -> np.ndarray:
    """3 m wide, 2.5 m high, with a door of 0.9 m by 2 m and a slit of 0.2 m up to the top."""
    occupancy = np.ones((25, 30))
    occupancy[:20, 10:19] = 0.0
    occupancy[:, 25:27] = 0.0
    return occupancy


def ray(y: float, z: float, side: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    return np.array([[2.0 * side, y, z]], np.float32), np.array([[-side, 0.0, 0.0]], np.float32)


def test_a_ray_meets_a_wall_at_its_distance_and_knows_the_side(with_door: np.ndarray) -> None:
    structure = Structure(wall(with_door))
    for side in (1.0, -1.0):
        hits = structure.cast(*ray(0.55, 1.05, side))
        assert hits.distance == pytest.approx([2.0])
        assert hits.plane.tolist() == [0]
        assert hits.front.tolist() == [side > 0.0]


def test_a_ray_goes_through_a_door_and_not_through_a_closed_one(with_door: np.ndarray) -> None:
    through_door, through_slit = ray(1.45, 1.05), ray(2.6, 1.05)
    assert np.isinf(Structure(wall(with_door)).cast(*through_door).distance).all()
    closed = Structure(wall(with_door), close_doors_m=2.4)
    assert closed.cast(*through_door).plane.tolist() == [0]
    assert np.isinf(closed.cast(*through_slit).distance).all()


def test_a_hole_higher_than_doors_stays_open(with_door: np.ndarray) -> None:
    assert np.isinf(Structure(wall(with_door), close_doors_m=1.5).cast(*ray(1.45, 1.05)).distance).all()


def test_rectangles_tile_exactly_the_occupied_cells() -> None:
    occupancy = np.random.default_rng(0).random((12, 17)) > 0.4
    structure = Structure(wall(occupancy))
    i, j = (index.ravel() for index in np.indices(occupancy.shape))
    starts = np.stack([np.ones(len(i)), 0.1 * j + 0.05, 0.1 * i + 0.05], axis=1).astype(np.float32)
    hits = structure.cast(starts, np.tile(np.array([[-1.0, 0.0, 0.0]], np.float32), (len(i), 1)))
    assert np.array_equal(hits.plane >= 0, occupancy.ravel())


def test_what_lies_between_two_places_blocks_them(with_door: np.ndarray) -> None:
    structure = Structure(wall(with_door))
    starts = np.array([[1.0, 0.5, 1.0], [1.0, 1.45, 1.0], [1.0, 0.5, 1.0]], np.float32)
    ends = np.array([[-1.0, 0.5, 1.0], [-1.0, 1.45, 1.0], [0.5, 0.5, 1.0]], np.float32)
    assert structure.blocked(starts, ends).tolist() == [True, False, False]


def test_without_planes_nothing_is_hit() -> None:
    nothing = Planes(np.zeros((0, 3), np.float32), np.zeros(0, np.float32), np.zeros(0, np.int32), ())
    structure = Structure(nothing)
    assert structure.cast(*ray(0.0, 0.0)).plane.tolist() == [-1]
    assert not structure.blocked(*ray(0.0, 0.0)).any()
