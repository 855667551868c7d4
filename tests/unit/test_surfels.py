"""Surfels: normals that fit and face the scanner; the faces of a thin wall stay apart."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scanned_boxes import DOOR, scans

from enfilade.ingest.moments import MOMENTS, add_point, fit_plane
from enfilade.ingest.records import Scan
from enfilade.ingest.surfels import make_surfels
from enfilade.ingest.thinning import thin


def sheet(normal: np.ndarray, offset: float, scanner: np.ndarray, name: str = "a", noise: float = 0.001) -> Scan:
    rng = np.random.default_rng(len(name))
    u = np.cross(normal, [0.3, 0.5, 0.8])
    u /= np.linalg.norm(u)
    grid = rng.uniform(-0.5, 0.5, (8_000, 2))
    points = offset * normal + grid @ np.stack([u, np.cross(normal, u)])
    return Scan.of_points(name, "a.e57", points + noise * rng.normal(size=(len(points), 1)) * normal, scanner)


@given(st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1)).filter(lambda v: np.linalg.norm(v) > 0.2))
def test_normals_of_a_plane_fit_it_and_face_the_scanner(direction: tuple[float, float, float]) -> None:
    normal = np.array(direction) / np.linalg.norm(direction)
    surfels = make_surfels(thin([sheet(normal, 1.0, 3.0 * normal)]))
    inner = np.linalg.norm(surfels.positions - normal, axis=1) < 0.4
    assert inner.sum() > 50
    assert (surfels.normals[inner] @ normal > np.cos(np.radians(4.0))).all()


def test_both_faces_of_a_thin_wall_become_surfels_with_opposite_normals() -> None:
    x = np.array([1.0, 0.0, 0.0])
    faces = [sheet(x, 0.0, -3.0 * x, "west"), sheet(x, 0.06, 3.0 * x, "eastern")]
    surfels = make_surfels(thin(faces))
    inner = np.abs(surfels.positions[:, 1:]).max(axis=1) < 0.4
    west = surfels.positions[:, 0] < 0.03
    assert (surfels.normals[inner & west, 0] < -0.95).all()
    assert (surfels.normals[inner & ~west, 0] > 0.95).all()


def test_the_two_sides_of_a_sheet_of_no_thickness_stay_two() -> None:
    x = np.array([1.0, 0.0, 0.0])
    surfels = make_surfels(thin([sheet(x, 0.022, -3.0 * x, "west"), sheet(x, 0.027, 3.0 * x, "eastern")]))
    inner = np.abs(surfels.positions[:, 1:]).max(axis=1) < 0.4
    assert (surfels.normals[inner, 0] > 0.9).sum() > 100
    assert (surfels.normals[inner, 0] < -0.9).sum() > 100


def test_every_point_in_a_room_finds_its_surfel_close_by() -> None:
    cloud = thin(scans(DOOR))
    surfels = make_surfels(cloud)
    assert (surfels.point_surfel >= 0).mean() > 0.99
    known = surfels.point_surfel >= 0
    apart = np.linalg.norm(cloud.positions[known] - surfels.positions[surfels.point_surfel[known]], axis=1)
    assert apart.max() < np.sqrt(3.0) * 0.05
    assert set(np.unique(surfels.scan)) == {0, 1}


def test_stray_points_and_bare_lines_have_no_surfel() -> None:
    line = np.stack([np.linspace(0.0, 1.0, 200), np.zeros(200), np.zeros(200)], axis=1)
    stray = np.array([[5.0, 5.0, 5.0]])
    surfels = make_surfels(
        thin([Scan.of_points("a", "a.e57", np.concatenate([line, stray]), np.array([0.0, 3.0, 1.0]))])
    )
    assert len(surfels.positions) == 0
    assert (surfels.point_surfel == -1).all()


@pytest.mark.parametrize("seed", range(5))
def test_the_fitted_plane_agrees_with_an_eigenvalue_solver(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(200, 3)) @ np.diag([3.0, 1.0, 0.1]) @ np.linalg.qr(rng.normal(size=(3, 3)))[0] + 20.0
    moments, normal = np.zeros(MOMENTS), np.empty(3)
    for point in points:
        add_point(moments, *point)
    variances = fit_plane(moments, normal)
    values, vectors = np.linalg.eigh(np.cov(points.T, bias=True))
    assert np.allclose(variances, values, rtol=1e-6)
    assert abs(normal @ vectors[:, 0]) > 1.0 - 1e-6
