"""The labelled cloud on disk."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from plyfile import PlyData, PlyElement

from enfilade import clouds
from enfilade.clouds import LABELS, LabelledCloud, read_cloud, read_object, read_room, write_cloud
from enfilade.errors import InputError, StoreError


def make_cloud(count, seed=0):
    rng = np.random.default_rng(seed)
    positions = rng.normal([600_000.0, 5_600_000.0, 100.0], 20.0, (count, 3))
    return LabelledCloud(positions, *(rng.integers(-1, 4, count, dtype=np.int32) for _ in LABELS))


def rows(cloud):
    """The points as a sorted list, to compare whatever their order."""
    columns = (*cloud.positions.T, *(getattr(cloud, label) for label in LABELS))
    return sorted(zip(*(column.tolist() for column in columns), strict=True))


@pytest.fixture
def path(tmp_path):
    return tmp_path / "cloud.ply"


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=25)
@given(st.integers(0, 200), st.integers(0, 1000))
def test_what_was_written_comes_back_sorted_by_room_and_object(path, count, seed):
    cloud = make_cloud(count, seed)
    write_cloud(path, cloud)
    found = read_cloud(path)
    assert rows(found) == rows(cloud)
    assert (np.diff(found.room * 100 + found.object) >= 0).all()
    assert found.positions.dtype == np.float64
    assert found.room.dtype == np.int32


@pytest.mark.parametrize("chunk", [1, 7, 1000])
def test_the_file_does_not_depend_on_its_chunks(path, monkeypatch, chunk):
    cloud = measured(make_cloud(100))
    write_cloud(path, cloud)
    whole = path.read_bytes()
    monkeypatch.setattr(clouds, "_CHUNK", chunk)
    write_cloud(path, cloud)
    assert path.read_bytes() == whole


def test_where_the_points_cannot_be_written_the_older_file_stays(path, monkeypatch):
    write_cloud(path, make_cloud(20))
    before = path.read_bytes()

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(clouds, "_vertices", full)
    with pytest.raises(StoreError, match="No space left"):
        write_cloud(path, make_cloud(30))
    assert path.read_bytes() == before
    assert list(path.parent.iterdir()) == [path]


def test_a_room_and_an_object_are_read_alone(path):
    cloud = make_cloud(500)
    write_cloud(path, cloud)
    for room in (-1, 0, 3, 9):
        assert rows(read_room(path, room)) == rows(cloud.take(cloud.room == room))
        chosen = (cloud.room == room) & (cloud.object == 2)
        assert rows(read_object(path, room, 2)) == rows(cloud.take(chosen))


def test_other_tools_read_it(path):
    cloud = make_cloud(50)
    write_cloud(path, cloud)
    vertices = PlyData.read(str(path))["vertex"]
    assert [p.name for p in vertices.properties] == ["x", "y", "z", *LABELS]
    assert np.array_equal(vertices["x"], read_cloud(path).positions[:, 0])


def measured(cloud, seed=0):
    """The cloud with intensity, some of it missing, and colour."""
    rng = np.random.default_rng(seed)
    intensity = np.where(rng.random(len(cloud)) < 0.2, np.nan, rng.random(len(cloud))).astype(np.float32)
    return replace(cloud, intensity=intensity, colour=rng.integers(0, 256, (len(cloud), 3), dtype=np.uint8))


def test_intensity_and_colour_go_with_their_points(path):
    cloud = measured(make_cloud(300))
    write_cloud(path, cloud)
    found = read_room(path, 2)
    (chosen,) = np.nonzero(cloud.room == 2)
    chosen = chosen[np.argsort(cloud.object[chosen], kind="stable")]
    assert np.array_equal(found.intensity, cloud.intensity[chosen], equal_nan=True)
    assert np.array_equal(found.colour, cloud.colour[chosen])
    names = [p.name for p in PlyData.read(str(path))["vertex"].properties]
    assert names == ["x", "y", "z", *LABELS, "intensity", "red", "green", "blue"]


def test_what_was_not_measured_is_absent(path):
    write_cloud(path, replace(measured(make_cloud(20)), intensity=None))
    found = read_cloud(path)
    assert found.intensity is None
    assert found.colour is not None
    assert found.take(slice(0, 5)).colour.shape == (5, 3)


def save(path, vertices):
    PlyData([PlyElement.describe(vertices, "vertex")], byte_order="<").write(str(path))


def test_a_cloud_that_another_tool_wrote_in_another_order_is_understood(path):
    room = make_cloud(60).room
    labels = [(label, "i4") for label in LABELS]
    vertices = np.zeros(60, [*labels, ("red", "u1"), *((axis, "f4") for axis in "zxy")])
    vertices["room"], vertices["y"] = room, np.arange(60)
    save(path, vertices)
    assert read_cloud(path).positions[:, 1].tolist() == list(range(60))
    assert read_room(path, 2).positions[:, 1].tolist() == np.flatnonzero(room == 2).tolist()


def test_a_failed_write_leaves_the_old_file_alone(path, monkeypatch):
    write_cloud(path, make_cloud(10))
    before = path.read_bytes()

    def full(file):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(StoreError, match=r"cloud\.ply cannot be written: No space left"):
        write_cloud(path, make_cloud(20))
    assert path.read_bytes() == before
    assert [p.name for p in path.parent.iterdir()] == ["cloud.ply"]


@pytest.mark.parametrize(
    ("content", "cause"),
    [
        (b"", "does not begin"),
        (b"ply\n", "no end"),
        (b"ply\n" + b"comment\n" * 1000, "no end"),
        (b"ply\nformat ascii 1.0\nelement vertex 1\nend_header\n", "binary little endian"),
        (b"ply\nformat binary_little_endian 1.0\nelement vertex -1\nend_header\n", "no list of vertices"),
        (b"ply\nformat binary_little_endian 1.0\nend_header\n", "no list of vertices"),
        (
            b"ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty list uchar int x\nend_header\n",
            "not plain numbers",
        ),
        (b"ply\nformat binary_little_endian 1.0\nelement vertex 0\nproperty double x\nend_header\n", "have no y, z"),
    ],
)
def test_foreign_and_damaged_files_are_named_with_the_cause(path, content, cause):
    path.write_bytes(content)
    with pytest.raises(InputError, match=cause) as caught:
        read_cloud(path)
    assert str(path) in str(caught.value)


def test_a_truncated_file_is_refused(path):
    write_cloud(path, make_cloud(100))
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(InputError, match="truncated: it should hold 100 points"):
        read_room(path, 1)


def test_a_missing_file_is_named(path):
    with pytest.raises(InputError, match="no labelled cloud"):
        read_cloud(path)
