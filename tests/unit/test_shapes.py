"""Meshes and clouds read from files, and what a scanner would see of them."""

from __future__ import annotations

import base64
import json

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


HEAD = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
FACES = "element face 1\nproperty list uchar int vertex_indices\n"
POINTS = "0 0 0\n1 0 0\n0 1 0\n"
PCD = """# .PCD v0.7
VERSION 0.7
FIELDS x y z _ ring
SIZE 4 4 4 4 2
TYPE F F F F U
COUNT 1 1 1 1 1
WIDTH 2
HEIGHT 1
POINTS 2
DATA ascii
nan nan nan 0 9
4 5 6 0 9
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
    cloud, mesh = tmp_path / "cloud.ply", tmp_path / "mesh.ply"
    cloud.write_text(HEAD + "end_header\n" + POINTS)
    mesh.write_text(HEAD + FACES + "end_header\n" + POINTS + "3 0 1 2\n")
    assert not read_shape(cloud).is_mesh
    assert read_shape(cloud).vertices.shape == (3, 3)
    assert read_shape(mesh).triangles.tolist() == [[0, 1, 2]]


def test_gltf_has_y_up_and_is_turned(tmp_path):
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0]], "<f4").tobytes() + np.array([0, 1, 2], "<u2").tobytes()
    uri = "data:application/octet-stream;base64," + base64.b64encode(corners).decode()
    content = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 2, 0]},
            {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 36, "target": 34962},
            {"buffer": 0, "byteOffset": 36, "byteLength": 6, "target": 34963},
        ],
        "buffers": [{"uri": uri, "byteLength": 42}],
    }
    path = tmp_path / "triangle.gltf"
    path.write_text(json.dumps(content))
    shape = read_shape(path)
    assert shape.vertices[shape.triangles[0]].tolist() == [[0, 0, 0], [1, 0, 0], [0, 0, 2]]


def test_a_pcd_file_is_a_cloud_whose_empty_points_are_left_out(tmp_path):
    text, packed = tmp_path / "text.pcd", tmp_path / "packed.pcd"
    text.write_text(PCD)
    points = np.array([(1, 2, 3, 0, 9), (4, 5, 6, 0, 9)], dtype="<f4,<f4,<f4,<f4,<u2").tobytes()
    packed.write_bytes(PCD.split("DATA")[0].encode() + b"DATA binary\n" + points)
    assert read_shape(text).vertices.tolist() == [[4, 5, 6]]
    assert read_shape(packed).vertices.tolist() == [[1, 2, 3], [4, 5, 6]]


@pytest.mark.parametrize(
    ("name", "content", "cause"),
    [
        ("empty.obj", "", "no points"),
        ("points.obj", "v 0 0 0\nv 1 0 0\n", "no surface"),
        ("beyond.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 9\n", "line 4"),
        ("cut.obj", "v 0 0 0\nv 1 0\n", "line 2"),
        ("nan.obj", "v 0 0 nan\nv 1 0 0\nv 1 1 0\nf 1 2 3\n", "not numbers"),
        ("text.ply", "hello", "PLY"),
        ("long.ply", HEAD.replace("vertex 3", "vertex 999999999") + "end_header\n0 0 0\n", "PLY"),
        ("flat.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n", "no x, y, z"),
        ("lost.ply", HEAD + FACES + "end_header\n" + POINTS + "3 0 1 7\n", "not there"),
        ("mm.obj", "v 0 0 0\nv 900 0 0\nv 0 900 0\nf 1 2 3\n", "900 m across"),
        ("packed.pcd", PCD.replace("ascii", "binary_compressed"), "damaged"),
        ("cut.pcd", PCD.replace("POINTS 2", "POINTS 9").replace("ascii", "binary"), "cut off"),
        ("flat.pcd", PCD.replace("x y z", "a b c"), "damaged"),
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


def test_a_mesh_is_seen_from_eight_sides_and_whole(box):
    views = mesh_views(box)
    assert views.shape == (9, DEFAULT_LAYOUT.bins)
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
