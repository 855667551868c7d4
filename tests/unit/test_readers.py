"""E57 files in: posed, structured or not, Cartesian or spherical; and a sentence for each that cannot be used."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pye57
import pytest
from pye57 import libe57

from enfilade.errors import InputError
from enfilade.ingest.readers import e57, read_scans, scan_files
from enfilade.ingest.readers.whereabouts import Whereabouts
from enfilade.ingest.records import Scan

POINTS = np.random.default_rng(0).uniform(-2.0, 2.0, (400, 3))
TURN = np.array([np.cos(0.3), 0.0, 0.0, np.sin(0.3)])
PLACE = np.array([10.0, -4.0, 1.5])

UNTURNED = np.array([1.0, 0.0, 0.0, 0.0])


def columns(points: np.ndarray, **more: Any) -> dict[str, np.ndarray]:
    return {
        f"cartesian{axis}": np.ascontiguousarray(column) for axis, column in zip("XYZ", points.T, strict=True)
    } | more


def write(path: Path, *scans: dict[str, np.ndarray], rotation: np.ndarray = TURN, place: np.ndarray = PLACE) -> Path:
    with pye57.E57(str(path), mode="w") as file:
        for number, scan in enumerate(scans):
            file.write_scan_raw(scan, name=f"Station {number}", rotation=rotation, translation=place + number)
    return path


def write_without_pose(path: Path, points: np.ndarray) -> Path:
    """Write one scan with spherical coordinates and no pose, which pye57 itself never does."""
    with pye57.E57(str(path), mode="w") as file:
        image = file.image_file
        scan, prototype = libe57.StructureNode(image), libe57.StructureNode(image)
        fields = ("sphericalRange", "sphericalAzimuth", "sphericalElevation")
        for field in fields:
            prototype.set(field, libe57.FloatNode(image, 0.0, libe57.E57_DOUBLE, -100.0, 100.0))
        arrays, buffers = file.make_buffers(fields, len(points))
        for field, column in zip(fields, points.T, strict=True):
            arrays[field][:] = column
        vector = libe57.CompressedVectorNode(image, prototype, libe57.VectorNode(image, True))
        scan.set("points", vector)
        file.data3d.append(scan)
        writer = vector.writer(buffers)
        writer.write(len(points))
        writer.close()
    return path


def world(points: np.ndarray, place: np.ndarray = PLACE) -> np.ndarray:
    c, s = np.cos(0.6), np.sin(0.6)
    return points @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]).T + place


def read(path: Path) -> list[Scan]:
    """All scans of a file with their points in memory."""
    return [Scan(s.name, s.source, list(s.chunks), s.scanner_position) for s in e57.read(path, Whereabouts())]


def points_of(scan: Scan) -> np.ndarray:
    return np.concatenate([chunk.positions for chunk in scan.chunks])


def test_points_come_out_in_the_common_coordinates_with_name_and_scanner(tmp_path: Path) -> None:
    (scan,) = read(write(tmp_path / "a.e57", columns(POINTS)))
    assert scan.name == "Station 0"
    assert scan.source == "a.e57"
    assert scan.scanner_position.tolist() == PLACE.tolist()
    assert points_of(scan).dtype == np.float64
    assert np.abs(points_of(scan) - world(POINTS)).max() < 1e-5


def test_several_scans_of_a_file_each_have_their_own_pose(tmp_path: Path) -> None:
    first, second = read(write(tmp_path / "a.e57", columns(POINTS), columns(POINTS[:50])))
    assert [first.name, second.name] == ["Station 0", "Station 1"]
    assert np.abs(points_of(second) - world(POINTS[:50], PLACE + 1.0)).max() < 1e-5


def test_points_flagged_invalid_are_dropped(tmp_path: Path) -> None:
    state = np.zeros(len(POINTS), np.int8)
    state[::4] = 2
    path = write(tmp_path / "a.e57", columns(POINTS, cartesianInvalidState=state))
    assert len(points_of(read(path)[0])) == 300


def test_points_that_are_no_numbers_are_dropped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(tmp_path / "a.e57", columns(POINTS))
    spoil(monkeypatch, [np.nan, np.inf, -np.inf])
    assert len(points_of(read(path)[0])) == 397


def test_a_scan_of_nothing_but_nan_is_refused_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(tmp_path / "a.e57", columns(POINTS))
    spoil(monkeypatch, [np.nan] * 400)
    with pytest.raises(InputError, match=r"scan 'Station 0' of .*a\.e57 has no usable point: all 400"):
        read(path)


def spoil(monkeypatch: pytest.MonkeyPatch, values: list[float]) -> None:
    """Make reading give these x first: pye57 cannot write them."""
    place = e57.place

    def spoiled(first: np.ndarray, *more: Any) -> Any:
        first[: len(values)] = values
        return place(first, *more)

    monkeypatch.setattr(e57, "place", spoiled)


def test_one_scan_may_stand_at_the_origin(tmp_path: Path) -> None:
    path = write(tmp_path / "a.e57", columns(POINTS), columns(POINTS), rotation=UNTURNED, place=np.zeros(3))
    first, second = read(path)
    assert first.scanner_position.tolist() == [0.0, 0.0, 0.0]
    assert second.scanner_position.tolist() == [1.0, 1.0, 1.0]
    np.testing.assert_allclose(points_of(first), POINTS)


def test_two_scans_at_the_origin_have_lost_their_positions(tmp_path: Path) -> None:
    path = tmp_path / "a.e57"
    with pye57.E57(str(path), mode="w") as file:
        for number in range(2):
            file.write_scan_raw(columns(POINTS), name=f"Station {number}", rotation=UNTURNED, translation=np.zeros(3))
    with pytest.raises(
        InputError, match=r"scan 'Station 0' of .*a\.e57 and scan 'Station 1' of .* both stand at the origin"
    ):
        read(path)


def test_a_missing_pose_is_refused_by_name(tmp_path: Path) -> None:
    path = write_without_pose(tmp_path / "lost.e57", np.ones((10, 3)))
    with pytest.raises(InputError, match=r"no scanner position in scan 'lost 0' of .*lost\.e57"):
        read(path)


def test_spherical_coordinates_become_cartesian(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_without_pose(tmp_path / "a.e57", np.array([[2.0, np.pi / 2, 0.0], [3.0, 0.0, np.pi / 2]]))
    monkeypatch.setattr(e57, "_pose", lambda header, what: (np.eye(3), np.array([1.0, 0.0, 0.0])))
    monkeypatch.setattr(Whereabouts, "scanner", lambda *arguments, **more: np.zeros(3))
    assert points_of(read(path)[0]) == pytest.approx(np.array([[1.0, 2.0, 0.0], [1.0, 0.0, 3.0]]))


@pytest.mark.parametrize(
    ("damage", "cause"),
    [
        (lambda whole: b"", "is empty"),
        (lambda whole: whole[:40], "cannot be read as E57"),
        (lambda whole: whole[: len(whole) // 2], "size in file header not same as actual"),
        (lambda whole: b"hello world" * 200, "cannot be read as E57"),
        (lambda whole: whole[:1500] + bytes(100) + whole[1600:], "checksum mismatch"),
    ],
)
def test_a_damaged_file_is_named_with_its_cause(tmp_path: Path, damage: Any, cause: str) -> None:
    path = write(tmp_path / "a.e57", columns(POINTS))
    path.write_bytes(damage(path.read_bytes()))
    with pytest.raises(InputError) as caught:
        read(path)
    assert str(path) in str(caught.value)
    assert cause in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_file_without_scans_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds no scans"):
        list(read_scans([write(tmp_path / "a.e57")]))


def test_folders_give_their_scan_files_by_name(tmp_path: Path) -> None:
    for name in ("b.e57", "a.E57", "notes.txt"):
        write(tmp_path / name, columns(POINTS))
    assert [file.name for file in scan_files([tmp_path])] == ["a.E57", "b.e57"]
    assert [file.name for file in scan_files([tmp_path / "?.[eE]57"])] == ["a.E57", "b.e57"]
    assert [scan.source for scan in read_scans([tmp_path, tmp_path / "b.e57"])] == ["a.E57", "b.e57"]


@pytest.mark.parametrize(
    ("name", "cause"), [("absent.e57", "no file or folder"), ("empty", "holds no scans"), ("a.txt", "format")]
)
def test_sources_that_are_no_scans_are_named(tmp_path: Path, name: str, cause: str) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "a.txt").write_text("1 2 3")
    with pytest.raises(InputError, match=cause) as caught:
        scan_files([tmp_path / name])
    assert name in str(caught.value)


def test_no_sources_are_refused() -> None:
    with pytest.raises(InputError, match="no scan files were given"):
        scan_files([])


def test_a_path_that_is_no_text_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "\udcff"
    folder.mkdir()
    (folder / "a.e57").touch()
    with pytest.raises(InputError, match=r"udcff.*not UTF-8 text"):
        scan_files([folder])
