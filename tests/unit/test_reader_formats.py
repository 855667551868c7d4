"""Scan files of every format in: the same points, scanners, intensities and colours come out."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scan_writers import (
    Station,
    write_e57,
    write_las,
    write_pcd,
    write_ply,
    write_positions,
    write_ptx,
)

from enfilade.errors import InputError
from enfilade.ingest.readers import ReadingParameters, read_scans
from enfilade.ingest.records import Chunk, Scan

RNG = np.random.default_rng(0)
PLACE = np.array([10.0, -4.0, 1.5])
STATION = Station(
    RNG.uniform(-2.0, 2.0, (500, 3)) + PLACE,
    PLACE,
    0.6,
    "Hall",
    RNG.integers(0, 200, 500).astype(float),
    RNG.integers(0, 256, (500, 3), dtype=np.uint8),
)
AS_IT_IS = ReadingParameters(units="m", up="z")

Writer = Callable[[Path, Station], Path]
WRITERS: dict[str, Writer] = {
    "a.e57": write_e57,
    "a.ptx": write_ptx,
    "text.ply": lambda path, s: write_ply(path, s, "ascii"),
    "little.ply": write_ply,
    "big.ply": lambda path, s: write_ply(path, s, "binary_big_endian", "f4"),
    "text.pcd": lambda path, s: write_pcd(path, s, "ascii"),
    "binary.pcd": write_pcd,
    "packed.pcd": lambda path, s: write_pcd(path, s, "binary_compressed"),
    "a.las": write_las,
    "a.laz": write_las,
}
WITHOUT_POSITION = ("text.ply", "little.ply", "big.ply", "a.las", "a.laz")


def read(path: Path, **options: Any) -> list[Scan]:
    """All scans of a file with their points in memory."""
    parameters = options.pop("parameters", AS_IT_IS)
    return [
        Scan(s.name, s.source, list(s.chunks), s.scanner_position) for s in read_scans([path], parameters, **options)
    ]


def whole(scan: Scan) -> Chunk:
    chunks = list(scan.chunks)
    columns = {}
    for name in ("intensity", "colour"):
        values = [getattr(chunk, name) for chunk in chunks]
        columns[name] = None if values[0] is None else np.concatenate(values)
    return Chunk(np.concatenate([chunk.positions for chunk in chunks]), **columns)


def options_for(name: str, folder: Path, place: np.ndarray = PLACE) -> dict[str, Path]:
    if name not in WITHOUT_POSITION:
        return {}
    return {"positions": write_positions(folder / "positions.csv", [(name, place)])}


@pytest.mark.parametrize("name", WRITERS)
def test_points_scanner_intensity_and_colour_come_out(name: str, tmp_path: Path) -> None:
    path = WRITERS[name](tmp_path / name, STATION)
    (scan,) = read(path, **options_for(name, tmp_path))
    found = whole(scan)
    assert scan.source == name
    assert scan.scanner_position == pytest.approx(PLACE)
    assert found.positions.dtype == np.float64
    assert np.abs(found.positions - STATION.positions).max() < 2e-5
    assert found.intensity == pytest.approx(STATION.intensity)
    assert np.array_equal(found.colour, STATION.colour)


@pytest.mark.parametrize("name", WRITERS)
def test_what_was_not_measured_is_absent(name: str, tmp_path: Path) -> None:
    path = WRITERS[name](tmp_path / name, Station(STATION.positions, PLACE))
    (scan,) = read(path, **options_for(name, tmp_path))
    assert whole(scan).intensity is None or name.startswith(("a.ptx", "a.la"))
    assert whole(scan).colour is None or not whole(scan).colour.any()


@pytest.mark.parametrize("name", [name for name in WRITERS if not name.endswith((".las", ".laz"))])
def test_points_that_are_no_numbers_are_dropped(name: str, tmp_path: Path) -> None:
    positions = STATION.positions.copy()
    positions[:7, 1] = np.nan
    positions[7:9, 2] = np.inf
    spoilt = Station(positions, PLACE, 0.6, "Hall", STATION.intensity, STATION.colour)
    if name == "a.e57":
        pytest.skip("its writer refuses them")
    (scan,) = read(WRITERS[name](tmp_path / name, spoilt), **options_for(name, tmp_path))
    found = whole(scan)
    assert np.abs(found.positions - positions[9:]).max() < 2e-5
    assert np.array_equal(found.colour, STATION.colour[9:])


@pytest.mark.parametrize("name", WITHOUT_POSITION)
def test_a_format_without_positions_asks_for_them(name: str, tmp_path: Path) -> None:
    path = WRITERS[name](tmp_path / name, STATION)
    with pytest.raises(InputError, match=r"no scanner position in scan .*--positions"):
        read(path)


def test_the_default_viewpoint_tells_nothing(tmp_path: Path) -> None:
    path = write_pcd(tmp_path / "a.pcd", STATION, viewpoint=False)
    with pytest.raises(InputError, match=r"no scanner position in scan 'a' of .*a\.pcd"):
        read(path)
    table = write_positions(tmp_path / "positions.csv", [("a", PLACE)], by="scan")
    assert read(path, positions=table)[0].scanner_position.tolist() == PLACE.tolist()


def test_a_ptx_file_holds_several_scans_with_points_that_met_nothing(tmp_path: Path) -> None:
    other = Station(STATION.positions[:40] + 1.0, PLACE + 1.0, -0.4)
    path = write_ptx(tmp_path / "a.ptx", STATION, other)
    lines = path.read_text().splitlines()
    lines[15] = "0 0 0 0.5 0 0 0"
    path.write_text("\r\n".join(lines))
    first, second = read(path)
    assert [first.name, second.name] == ["a 0", "a 1"]
    assert len(whole(first).positions) == 499
    assert np.abs(whole(second).positions - other.positions).max() < 1e-5
    assert second.scanner_position == pytest.approx(PLACE + 1.0)
    unread = read_scans([path], AS_IT_IS)
    assert [scan.name for scan in unread] == ["a 0", "a 1"]


def test_two_ptx_scans_at_the_origin_have_lost_their_positions(tmp_path: Path) -> None:
    lost = Station(STATION.positions - PLACE, np.zeros(3))
    with pytest.raises(InputError, match=r"scan 'a 0' of .* and scan 'a 1' of .* both stand at the origin"):
        read(write_ptx(tmp_path / "a.ptx", lost, lost))


def test_colours_of_eight_bits_in_las_stay(tmp_path: Path) -> None:
    path = write_las(tmp_path / "a.las", STATION, wide_colour=False)
    (scan,) = read(path, positions=write_positions(tmp_path / "p.csv", [("a.las", PLACE)]))
    assert np.array_equal(whole(scan).colour, STATION.colour)


def test_a_ply_file_may_have_other_things_before_and_after_its_points(tmp_path: Path) -> None:
    path = tmp_path / "a.ply"
    header = "ply\nformat ascii 1.0\nelement camera 1\nproperty float f\nelement vertex 2\nproperty float x\n"
    header += "property float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    path.write_text(header + "5\n1 2 3\n4 5 6\n3 0 1 1\n")
    (scan,) = read(path, positions=write_positions(tmp_path / "p.csv", [("a", PLACE)]))
    assert whole(scan).positions.tolist() == [[1, 2, 3], [4, 5, 6]]


@pytest.mark.parametrize("name", [name for name in WRITERS if not name.endswith(".e57")])
def test_a_file_that_is_cut_off_is_named(name: str, tmp_path: Path) -> None:
    path = WRITERS[name](tmp_path / name, STATION)
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 2 // 3])
    with pytest.raises(InputError) as caught:
        read(path, **options_for(name, tmp_path))
    assert name in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("table", "cause"),
    [
        ("scan,x,y\n", "line 1: the header must be"),
        ("", "line 1: the header must be"),
        ("file,x,y,z\na.ply,1,2\n", "line 2: a name and three coordinates"),
        ("file,x,y,z\n\na.ply,1,2,high\n", "line 3: the coordinates 1, 2, high are not three numbers"),
        ("file,x,y,z\na.ply,1,2,nan\n", "line 2: the coordinates are not finite"),
        ("file,x,y,z\na.ply,1,2,3\na.ply,1,2,4\n", "line 3: file 'a.ply' was in line 2 already"),
        ("file,x,y,z\na.ply,1,2,3\nb.ply,1,2,3\n", "line 3: there is no file 'b.ply'"),
    ],
)
def test_a_table_of_positions_that_is_wrong_is_named_with_the_line(table: str, cause: str, tmp_path: Path) -> None:
    path = write_ply(tmp_path / "a.ply", STATION)
    (tmp_path / "p.csv").write_text(table)
    with pytest.raises(InputError, match=cause):
        read(path, positions=tmp_path / "p.csv")
