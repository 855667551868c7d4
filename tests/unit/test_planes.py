"""Planes: one a side, whole, with bitmaps whose area is that of the surface."""

from __future__ import annotations

import numpy as np
import pytest
from scanned_boxes import DOOR, LEFT, RIGHT, scan, scans

from enfilade.ingest.planes import find_planes
from enfilade.ingest.records import Planes, Scan, Surfels
from enfilade.ingest.surfels import make_surfels
from enfilade.ingest.thinning import thin


@pytest.fixture(scope="module")
def closed() -> tuple[Surfels, Planes]:
    surfels = make_surfels(thin(scans(None)))
    return surfels, find_planes(surfels)


def plane_at(planes: Planes, normal: tuple[float, float, float], offset: float) -> int:
    fits = (planes.normals @ np.array(normal) > 0.99) & (np.abs(planes.offsets - offset) < 0.02)
    assert fits.sum() == 1
    return int(np.argmax(fits))


def test_the_wall_between_two_rooms_is_two_planes_back_to_back(closed: tuple[Surfels, Planes]) -> None:
    _, planes = closed
    assert plane_at(planes, (-1.0, 0.0, 0.0), -4.0) != plane_at(planes, (1.0, 0.0, 0.0), 4.15)


def test_floors_of_two_rooms_of_one_level_are_one_plane(closed: tuple[Surfels, Planes]) -> None:
    surfels, planes = closed
    floor = plane_at(planes, (0.0, 0.0, 1.0), 0.0)
    on_floor = surfels.positions[planes.surfel_plane == floor]
    assert on_floor[:, 0].min() < 0.1
    assert on_floor[:, 0].max() > 7.9
    assert planes.horizontal[floor]
    assert not planes.vertical[floor]


def test_nearly_all_surfels_of_bare_rooms_lie_on_a_plane(closed: tuple[Surfels, Planes]) -> None:
    surfels, planes = closed
    on_plane = planes.surfel_plane >= 0
    assert on_plane.mean() > 0.98
    plane = planes.surfel_plane[on_plane]
    height = np.einsum("ij,ij->i", surfels.positions[on_plane], planes.normals[plane]) - planes.offsets[plane]
    assert np.abs(height).max() < 0.05


def test_a_bitmap_covers_its_wall_and_leaves_out_the_door() -> None:
    surfels = make_surfels(thin([scan(LEFT, [LEFT, RIGHT], DOOR)]))
    planes = find_planes(surfels)
    wall = planes.bitmaps[plane_at(planes, (-1.0, 0.0, 0.0), -4.0)]
    area, perimeter = 3.0 * 2.5 - 0.9 * 2.05, 2 * 3.0 + 2 * 2.5 + 2 * 2.05
    covered = (wall.occupancy > 0.5).sum() * wall.cell_m**2
    assert covered == pytest.approx(area, abs=perimeter * wall.cell_m / 2)
    centre_of_door = np.array([4.0, 1.45, 1.0]) - wall.origin
    i, j = int(centre_of_door @ wall.v / wall.cell_m), int(centre_of_door @ wall.u / wall.cell_m)
    assert wall.occupancy[i, j] == 0.0


def test_parts_of_a_wall_left_and_right_of_a_full_height_gap_are_one_plane() -> None:
    rng = np.random.default_rng(0)
    left, right = rng.uniform(0.0, 2.0, (30_000, 2)), rng.uniform(0.0, 2.0, (30_000, 2))
    along = np.concatenate([left[:, 0], right[:, 0] + 2.5])
    points = np.stack([along, np.zeros(len(along)), np.concatenate([left[:, 1], right[:, 1]])], axis=1)
    surfels = make_surfels(thin([Scan.of_points("a", "a.e57", points, np.array([2.0, 3.0, 1.0]))]))
    assert len(find_planes(surfels).normals) == 1


def test_small_patches_and_no_surfels_are_no_planes() -> None:
    empty = np.zeros((0, 3), np.float32)
    nothing = Surfels(empty, empty, np.zeros(0, np.int32), np.zeros(0, np.int32))
    assert len(find_planes(nothing).normals) == 0
    patch = np.random.default_rng(0).uniform(0.0, 0.3, (5_000, 3)) * [1.0, 1.0, 0.0]
    surfels = make_surfels(thin([Scan.of_points("a", "a.e57", patch, np.array([0.0, 0.0, 2.0]))]))
    assert len(surfels.positions) > 0
    assert len(find_planes(surfels).normals) == 0
