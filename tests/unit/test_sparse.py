"""Planes that go on over sparse points far from the scanner."""

from __future__ import annotations

import numpy as np
import pytest

from enfilade.ingest.groups import group_scans
from enfilade.ingest.planes import find_planes
from enfilade.ingest.plans import draw_plans
from enfilade.ingest.records import Planes, Scan, Surfels, ThinnedCloud
from enfilade.ingest.rooms import label_rooms
from enfilade.ingest.sparse import extend_planes
from enfilade.ingest.surfels import make_surfels
from enfilade.ingest.thinning import thin

LENGTH, WIDTH, HEIGHT = 11.0, 3.0, 2.6
SCANNER = np.array([1.2, 1.4, 1.5])


def far_room(step_deg: float) -> Scan:
    """What a scanner at one end of a long empty room measures."""
    azimuth = np.radians(np.arange(0.0, 360.0, step_deg))
    elevation = np.radians(np.arange(-60.0, 90.0, step_deg))
    a, e = (grid.ravel() for grid in np.meshgrid(azimuth, elevation))
    rays = np.stack([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)], axis=1)
    with np.errstate(divide="ignore"):
        to_low, to_high = -SCANNER / rays, (np.array([LENGTH, WIDTH, HEIGHT]) - SCANNER) / rays
    distance = np.maximum(to_low, to_high).min(axis=1)
    noise = np.random.default_rng(3).normal(0.0, 0.002, len(rays))
    return Scan.of_points("end", "room.e57", SCANNER + (distance + noise)[:, None] * rays, SCANNER)


@pytest.fixture(scope="module")
def stages() -> tuple[ThinnedCloud, Surfels, Planes]:
    cloud = thin([far_room(0.5)])
    surfels = make_surfels(cloud)
    return cloud, surfels, find_planes(surfels)


def test_a_long_room_scanned_from_one_end_has_all_of_its_area(stages: tuple[ThinnedCloud, Surfels, Planes]) -> None:
    cloud, surfels, planes = stages
    surfels, planes = extend_planes(cloud, surfels, planes)
    groups = group_scans(planes, cloud.scanner_positions)
    plans = draw_plans(cloud, surfels, planes, label_rooms(surfels, planes, groups))
    assert len(plans) == 1
    assert plans[0].area == pytest.approx(LENGTH * WIDTH, rel=0.03)


def test_sparse_points_become_surfels_of_the_plane_that_they_lie_on(
    stages: tuple[ThinnedCloud, Surfels, Planes],
) -> None:
    cloud, surfels, planes = stages
    grown, extended = extend_planes(cloud, surfels, planes)
    before, after = (surfels.point_surfel < 0).mean(), (grown.point_surfel < 0).mean()
    assert after < 0.5 * before
    new = np.arange(len(surfels.positions), len(grown.positions))
    plane = extended.surfel_plane[new]
    height = np.einsum("ij,ij->i", grown.positions[new], planes.normals[plane]) - planes.offsets[plane]
    assert np.abs(height).max() < 0.03
    towards = cloud.scanner_positions[grown.scan[new]] - grown.positions[new]
    assert (np.einsum("ij,ij->i", towards, planes.normals[plane]) > 0.0).all()
    assert np.array_equal(grown.positions[: len(surfels.positions)], surfels.positions)


def test_a_plane_does_not_go_on_along_the_line_in_which_it_would_cross_a_ceiling() -> None:
    leaf = np.stack(np.meshgrid([2.5], np.arange(1.0, 1.9, 0.015), np.arange(0.0, 2.0, 0.015)), -1).reshape(-1, 3)
    room = far_room(0.5)
    points = np.concatenate([chunk.positions for chunk in room.chunks])
    cloud = thin([Scan.of_points("end", "room.e57", np.concatenate([points, leaf]), SCANNER)])
    surfels = make_surfels(cloud)
    planes = find_planes(surfels)
    grown, extended = extend_planes(cloud, surfels, planes)
    on_leaf = np.flatnonzero((np.abs(planes.normals[:, 0]) > 0.9) & (np.abs(np.abs(planes.offsets) - 2.5) < 0.05))
    assert len(on_leaf) == 1
    new = np.arange(len(surfels.positions), len(grown.positions))
    assert grown.positions[new][extended.surfel_plane[new] == on_leaf[0], 2].max(initial=0.0) < 2.2
