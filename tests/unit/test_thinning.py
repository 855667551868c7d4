"""Thinning: one point a voxel, the one nearest its scanner, whatever the order of scans and points."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from enfilade.errors import InputError
from enfilade.ingest.records import Scan, ThinnedCloud
from enfilade.ingest.thinning import ThinningParameters, thin

VOXEL = 0.01
clouds = arrays(np.float64, st.tuples(st.integers(1, 60), st.just(3)), elements=st.floats(-0.0625, 0.0625, width=32))
several = st.lists(clouds, min_size=1, max_size=5)


def scan(points: np.ndarray, number: int = 0) -> Scan:
    return Scan(f"scan {number}", "a.e57", points, np.array([number + 1.0, 0.5, 1.5]))


def voxels(positions: np.ndarray) -> np.ndarray:
    return np.floor(positions.astype(np.float64) / VOXEL).astype(np.int64)


def kept(cloud: ThinnedCloud) -> set[tuple[float, ...]]:
    return {tuple(point) for point in cloud.positions.tolist()}


@given(several)
def test_every_voxel_that_held_points_keeps_exactly_one_of_them(parts: list[np.ndarray]) -> None:
    cloud = thin([scan(points, number) for number, points in enumerate(parts)])
    everything = np.concatenate(parts).astype(np.float32)
    assert len(np.unique(voxels(cloud.positions), axis=0)) == len(cloud.positions)
    assert len(cloud.positions) == len(np.unique(voxels(everything), axis=0))
    assert kept(cloud) <= {tuple(point) for point in everything.tolist()}
    assert cloud.raw_count == len(everything)


@given(several, st.randoms(use_true_random=False))
def test_order_of_scans_and_points_changes_nothing(parts: list[np.ndarray], random: object) -> None:
    scans = [scan(points, number) for number, points in enumerate(parts)]
    shuffled = [Scan(s.name, s.source, s.positions[::-1], s.scanner_position) for s in scans]
    random.shuffle(shuffled)
    assert kept(thin(shuffled)) == kept(thin(scans))


def test_the_point_nearest_its_scanner_stays() -> None:
    near = Scan("near", "a.e57", np.array([[0.001, 0.001, 0.001]]), np.array([1.0, 0.0, 0.0]))
    far = Scan("far", "a.e57", np.array([[0.002, 0.002, 0.002]]), np.array([9.0, 0.0, 0.0]))
    for order in ([near, far], [far, near]):
        cloud = thin(order)
        assert [cloud.scan_names[index] for index in cloud.scan] == ["near"]


def test_small_coordinates_keep_a_zero_origin() -> None:
    cloud = thin([scan(np.full((1, 3), 9_000.0))])
    assert cloud.origin.tolist() == [0.0, 0.0, 0.0]


def test_large_coordinates_lose_whole_metres_before_they_are_rounded() -> None:
    here = np.array([466_123.25, 5_410_987.75, 112.5])
    points = here + np.random.default_rng(0).uniform(-2.0, 2.0, (500, 3))
    cloud = thin([Scan("utm", "a.e57", points, here)])
    assert np.array_equal(cloud.origin, np.round(cloud.origin))
    back = cloud.positions + cloud.origin
    assert np.abs(np.sort(back, axis=0) - np.sort(points, axis=0)).max() < 1e-6
    assert np.abs(cloud.scanner_positions).max() <= 0.5


def test_scans_kilometres_apart_are_refused_by_name() -> None:
    far = Scan("Lobby", "b.e57", np.array([[50_000.0, 0.0, 0.0]]), np.array([50_000.0, 0.0, 1.0]))
    with pytest.raises(InputError, match=r"'Lobby' of b\.e57 lies more than 10 km"):
        thin([scan(np.zeros((1, 3))), far])


def test_no_scans_are_refused() -> None:
    with pytest.raises(InputError, match="no scans"):
        thin([])


def test_the_voxel_size_is_a_parameter() -> None:
    points = np.random.default_rng(1).uniform(0.0, 1.0, (2_000, 3))
    coarse = thin([scan(points)], ThinningParameters(voxel_size_m=0.5))
    assert len(coarse.positions) == 8
