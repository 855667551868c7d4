"""A moving scanner: places along its way become scans, and each point is seen from where the scanner was."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scan_writers import Station, write_las

from enfilade.errors import InputError
from enfilade.ingest.readers import ReadingParameters, read_scans
from enfilade.ingest.readers.trajectory import read_trajectory
from enfilade.ingest.thinning import thin

AS_IT_IS = ReadingParameters(units="m", up="z")
START = 1000.0
TIME = START + np.arange(0.0, 40.0, 0.1)


def way(time: np.ndarray) -> np.ndarray:
    """Ten metres along x and back, within 40 s."""
    return np.column_stack([10.0 - np.abs((time - START) / 2.0 - 10.0), np.zeros_like(time), np.full_like(time, 1.5)])


def write_way(path: Path, header: str = "time,x,y,z", separator: str = ",", shift: float = 0.0) -> Path:
    rows = np.column_stack([TIME + shift, way(TIME)])
    lines = [header] if header else []
    path.write_text("\n".join([*lines, *(separator.join(f"{v:.4f}" for v in row) for row in rows)]) + "\n")
    return path


def cloud(path: Path, shift: float = 0.0, count: int = 4000) -> tuple[Path, np.ndarray]:
    rng = np.random.default_rng(0)
    time = rng.uniform(START, START + 39.9, count)
    points = way(time) + rng.normal(0.0, 0.5, (count, 3)) + [0.0, 2.0, 0.0]
    return write_las(path, Station(points, np.zeros(3), time=time + shift)), time


def test_each_point_is_seen_from_where_the_scanner_was(tmp_path: Path) -> None:
    path, time = cloud(tmp_path / "a.laz")
    order = np.argsort(time, kind="stable")
    scans = list(read_scans([path], AS_IT_IS, trajectory=[write_way(tmp_path / "way.csv")]))
    assert len({scan.name for scan in scans}) == len({tuple(scan.scanner_position) for scan in scans})
    assert {scan.source for scan in scans} == {"way.csv"}
    points = {
        tuple(np.round(point, 4)): scan.scanner_position for scan in scans for c in scan.chunks for point in c.positions
    }
    assert len(points) == len(order)
    for point, place in points.items():
        assert abs(point[0] - place[0]) < 0.85 + 0.5 * 4.5


def test_coming_back_to_a_place_makes_no_new_scan(tmp_path: Path) -> None:
    found = read_trajectory([write_way(tmp_path / "way.csv")], 1.5)
    assert len(found.positions) == 7
    there, back = found.stations(np.array([START + 8.0, START + 32.0]))
    assert there == back
    assert found.positions[there] == pytest.approx([4.0, 0.0, 1.5], abs=1.5)


def test_the_places_of_several_files_are_the_same_scans(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    first, _ = cloud(tmp_path / "a" / "1.las")
    second, _ = cloud(tmp_path / "a" / "2.laz", count=3000)
    trajectory = [write_way(tmp_path / "way.csv")]
    both = thin(read_scans([first, second], AS_IT_IS, trajectory=trajectory))
    assert both.raw_count == 7000
    assert len(both.scan_names) == 7
    assert both.scanner_positions.shape == (7, 3)


@pytest.mark.parametrize("shift", [1e9, -1e9, 604_800.0 * 2000 - 1e9])
def test_clocks_of_the_week_and_of_the_epoch_are_understood(tmp_path: Path, shift: float) -> None:
    path, _ = cloud(tmp_path / "a.las", shift=shift)
    trajectory = [write_way(tmp_path / "way.txt", "# gpstime easting northing height", " ")]
    assert thin(read_scans([path], AS_IT_IS, trajectory=trajectory)).raw_count == 4000


@pytest.mark.parametrize(("header", "separator"), [("", " "), ("", ","), ("Time;X;Y;Z", ";"), ("t\tpx\tpy\tpz", "\t")])
def test_tables_of_many_hands_are_read(tmp_path: Path, header: str, separator: str) -> None:
    found = read_trajectory([write_way(tmp_path / "way", header, separator)], 1.5)
    assert len(found.time) == len(TIME)
    assert found.time[0] == START


def test_columns_go_by_their_names(tmp_path: Path) -> None:
    path = tmp_path / "way.csv"
    path.write_text("z,roll,time,y,x\n1.5,0,2,20,10\n1.5,0,1,20,10\n")
    found = read_trajectory([path], 1.5)
    assert found.positions.tolist() == [[10.0, 20.0, 1.5]]
    assert found.time.tolist() == [1.0, 2.0]


@pytest.mark.parametrize(
    ("content", "cause"),
    [
        ("time,lat,lon,height\n1,2,3,4\n", "no column for x, y"),
        ("time,x,y,z\n1,2,3,4\n", "fewer than two moments"),
        ("time,x,y,z\n1,2,3,4\n1,2,here,4\n", "line 3 has something that is no number"),
        ("", "fewer than two moments"),
    ],
)
def test_what_is_no_trajectory_is_named_with_the_cause(tmp_path: Path, content: str, cause: str) -> None:
    (tmp_path / "way.csv").write_text(content)
    with pytest.raises(InputError, match=rf"way\.csv.*{cause}"):
        read_trajectory([tmp_path / "way.csv"], 1.5)


def test_a_way_in_millimetres_is_refused_with_what_to_do(tmp_path: Path) -> None:
    path = tmp_path / "way.csv"
    np.savetxt(path, np.column_stack([np.arange(30_000), 2e3 * np.arange(30_000), np.zeros((30_000, 2))]))
    with pytest.raises(InputError, match=r"20000 places 1\.5 apart.*--units"):
        read_trajectory([path], 1.5)


def test_another_files_trajectory_is_refused(tmp_path: Path) -> None:
    path, _ = cloud(tmp_path / "a.las", shift=5e4)
    with pytest.raises(InputError, match=r"no point of .*a\.las was measured while the trajectory way\.csv"):
        list(read_scans([path], AS_IT_IS, trajectory=[write_way(tmp_path / "way.csv")]))
