"""Meshes and clouds read from files, and what a scanner would see of them."""

from __future__ import annotations

import numpy as np
import pytest

from enfilade.descriptors import DEFAULT_LAYOUT, Shape, Viewing, describe, distances, mesh_views, read_shape
from enfilade.descriptors.views import sample_surface
from enfilade.errors import InputError

BOX = """# a box of 1 m x 0.6 m x 0.8 m, and a vertex that no face uses
v -0.5 -0.3 0
v 0.5 -0.3 0
v 0.5 0.3 0
v -0.5 0.3 0
v -0.5 -0.3 0.8
v 0.5 -0.3 0.8
v 0.5 0.3 0.8
v -0.5 0.3 0.8
v 0 0 -7
f 4 3 2 1
f 5/1 6/2 7/3 8/4
f 1//1 2//1 6//1 5//1
f -8 -7 -3 -4
f 3 4 8 7
f 4 1 5 8
"""


@pytest.fixture
def box(tmp_path):
    path = tmp_path / "Kästchen.obj"
    path.write_text(BOX, encoding="utf-8")
    return read_shape(path)


def test_polygons_of_an_obj_file_become_triangles(box):
    assert box.name == "Kästchen"
    assert box.vertices.shape == (8, 3)
    assert box.triangles.shape == (12, 3)
    assert box.foot == 0.0


def test_a_ply_file_is_a_mesh_or_a_cloud(tmp_path):
    head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    points = "0 0 0\n1 0 0\n0 1 0\n"
    cloud, mesh = tmp_path / "cloud.ply", tmp_path / "mesh.ply"
    cloud.write_text(head + "end_header\n" + points)
    faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    mesh.write_text(head + faces + points + "3 0 1 2\n")
    assert not read_shape(cloud).is_mesh
    assert read_shape(cloud).vertices.shape == (3, 3)
    assert read_shape(mesh).triangles.tolist() == [[0, 1, 2]]


@pytest.mark.parametrize(
    ("name", "content", "cause"),
    [
        ("empty.obj", "", "no points"),
        ("points.obj", "v 0 0 0\nv 1 0 0\n", "no surface"),
        ("beyond.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 9\n", "line 4"),
        ("cut.obj", "v 0 0 0\nv 1 0\n", "line 2"),
        ("nan.obj", "v 0 0 nan\nv 1 0 0\nv 1 1 0\nf 1 2 3\n", "not numbers"),
        ("text.ply", "hello", "no PLY"),
        ("junk.stl", "hello", "no points"),
        ("junk.xyz", "hello", "no points"),
        ("chair.docx", "hello", "neither a mesh nor a point cloud"),
    ],
)
def test_unusable_files_are_named_with_the_cause(tmp_path, capfd, name, content, cause):
    path = tmp_path / name
    path.write_text(content)
    with pytest.raises(InputError, match=cause) as caught:
        read_shape(path)
    assert name in str(caught.value)
    assert capfd.readouterr() == ("", "")


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"no file .*basin\.obj"):
        read_shape(tmp_path / "basin.obj")


def test_samples_lie_evenly_on_the_surface(box):
    samples = sample_surface(box)
    on_top = np.isclose(samples[:, 2], 0.8).mean()
    area = 2 * (1.0 * 0.6 + 1.0 * 0.8 + 0.6 * 0.8)
    assert on_top == pytest.approx(0.6 / area, rel=0.02)
    assert np.histogram(samples[np.isclose(samples[:, 2], 0.8), 0], 10)[0].std() < 10


def test_a_mesh_is_seen_from_eight_sides_in_pairs_and_whole(box):
    views = mesh_views(box)
    assert views.shape == (17, DEFAULT_LAYOUT.bins)
    assert np.array_equal(views, mesh_views(box))


def test_a_side_shows_what_faces_it_and_the_top(box):
    front = mesh_views(box)[0]
    x, y, z = np.meshgrid(np.arange(-0.49, 0.5, 0.02), np.arange(-0.29, 0.3, 0.02), np.arange(0.01, 0.8, 0.02))
    near = np.column_stack([np.full(x[:, 0].size, 0.5), y[:, 0].ravel(), z[:, 0].ravel()])
    top = np.column_stack([x[..., 0].ravel(), y[..., 0].ravel(), np.full(x[..., 0].size, 0.8)])
    expected = describe(np.concatenate([near, top]), 0.0)
    assert distances(front, expected[None], DEFAULT_LAYOUT.shape)[0] < 0.05


def test_what_stands_high_is_seen_from_below(box):
    on_floor, on_wall = (mesh_views(box, floor_offset_m=offset)[0] for offset in (0.0, 2.0))
    height = (
        on_wall.reshape(DEFAULT_LAYOUT.shape).sum(axis=(1, 2)),
        on_floor.reshape(DEFAULT_LAYOUT.shape).sum(axis=(1, 2)),
    )
    assert height[0][:2].sum() > height[1][:2].sum()
    assert height[0][4:7].sum() < height[1][4:7].sum()


def test_the_base_may_lie_below_the_foot(box):
    raised = mesh_views(box, base_offset_m=0.9)[-1].reshape(DEFAULT_LAYOUT.shape)
    assert raised[:5].sum() == 0
    assert raised[5:].sum() > 0


def test_a_cloud_has_one_view():
    points = np.random.default_rng(1).random((50, 3))
    cloud = Shape("cloud", points, np.empty((0, 3), np.int32))
    views = mesh_views(cloud, viewing=Viewing(sides=4))
    assert np.array_equal(views, describe(points, points[:, 2].min())[None])


def test_a_surface_without_area_is_refused():
    line = Shape("line", np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), np.array([[0, 1, 2]], np.int32))
    with pytest.raises(InputError, match="line has no area"):
        mesh_views(line)
