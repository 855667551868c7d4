"""The same two rooms in every format give the same graph; the real scans at hand load or are refused rightly."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from unit.scan_writers import Station, write_e57, write_las, write_pcd, write_ply, write_positions, write_ptx
from unit.scanned_boxes import DOOR, LEFT, RIGHT, scan

from enfilade.errors import InputError
from enfilade.ingest.parameters import Parameters
from enfilade.ingest.pipeline import Ingested, ingest
from enfilade.ingest.readers import ReadingParameters, read_scans
from enfilade.ingest.thinning import thin

pytestmark = pytest.mark.slow

REAL = Path(__file__).parents[3] / "shared" / "data" / "scans"
FEET = 0.3048
Writer = Callable[[Path, Station], Path]


@pytest.fixture(scope="module")
def stations() -> list[Station]:
    found = []
    for number, box in enumerate((LEFT, RIGHT)):
        seen = scan(box, [LEFT, RIGHT], DOOR, spacing=0.03)
        (chunk,) = seen.chunks
        found.append(Station(chunk.positions, seen.scanner_position, 0.7 * number, seen.name))
    return found


@pytest.fixture(scope="module")
def from_e57(stations: list[Station], tmp_path_factory: pytest.TempPathFactory) -> Ingested:
    return ingest([write_e57(tmp_path_factory.mktemp("e57") / "a.e57", *stations)], building="b")


def measures(result: Ingested) -> dict[str, tuple[str, list[float]]]:
    """What every node is, and its measures."""
    names = ("area", "height", "floor_elevation", "width", "sill", "centroid", "position")
    found = {}
    for node in result.graph.nodes.values():
        values = [node.properties[name] for name in names if node.properties.get(name) is not None]
        found[node.id] = (node.label, np.hstack([np.zeros(0), *values]).tolist())
    return found


def assert_same(one: Ingested, other: Ingested, tolerance: float) -> None:
    assert measures(one).keys() == measures(other).keys()
    for id, (label, values) in measures(one).items():
        assert measures(other)[id][0] == label
        assert measures(other)[id][1] == pytest.approx(values, abs=tolerance)


SINGLE: dict[str, Writer] = {".ply": write_ply, ".pcd": write_pcd, ".laz": write_las}


def converted(suffix: str, folder: Path, stations: list[Station]) -> tuple[list[Path], Path | None]:
    """The scans in a format, and a table of their positions where the format has none."""
    if suffix == ".ptx":
        return [write_ptx(folder / "a.ptx", *stations)], None
    for station in stations:
        SINGLE[suffix](folder / f"{station.name}{suffix}", station)
    table = [(station.name, station.scanner) for station in stations]
    return [folder], None if suffix == ".pcd" else write_positions(folder / "positions.csv", table)


@pytest.mark.parametrize("suffix", [".ptx", ".pcd", ".laz"])
def test_every_format_gives_the_same_graph(
    suffix: str, stations: list[Station], from_e57: Ingested, tmp_path: Path
) -> None:
    sources, positions = converted(suffix, tmp_path, stations)
    assert_same(from_e57, ingest(sources, building="b", positions_csv=positions), 0.01)


def test_feet_with_y_up_give_the_same_graph(stations: list[Station], from_e57: Ingested, tmp_path: Path) -> None:
    for station in stations:
        feet = station.positions[:, [0, 2, 1]] * [1.0, 1.0, -1.0] / FEET
        place = station.scanner[[0, 2, 1]] * [1.0, 1.0, -1.0] / FEET
        write_pcd(tmp_path / f"{station.name}.pcd", Station(feet, place))
    assert_same(from_e57, ingest([tmp_path], building="b"), 0.01)


needs_real = pytest.mark.skipif(not REAL.is_dir(), reason="../shared/data/scans is not there")


@needs_real
@pytest.mark.parametrize("name", ["pumpAVisualReferenceImage.e57", "room_scan1.pcd"])
def test_real_scans_without_a_position_are_refused_for_that(name: str) -> None:
    with pytest.raises(InputError, match=rf"no scanner position in scan .*{name}.*--positions"):
        list(read_scans([REAL / name]))


@needs_real
@pytest.mark.parametrize(
    ("name", "points", "coloured"),
    [("pumpAVisualReferenceImage.e57", 155_201, True), ("room_scan1.pcd", 112_586, False)],
)
def test_real_scans_load_with_a_position(name: str, points: int, coloured: bool, tmp_path: Path) -> None:
    table = write_positions(tmp_path / "positions.csv", [(name, np.zeros(3))])
    cloud = thin(read_scans([REAL / name], ReadingParameters("m", "z"), positions=table))
    assert 0.5 * points < cloud.raw_count <= points
    assert (cloud.colour is not None) == coloured
    assert np.ptp(cloud.positions, axis=0).max() < 200.0


@needs_real
def test_what_the_real_scans_are_is_not_mistaken(tmp_path: Path) -> None:
    said: list[str] = []

    class Listener:
        def start(self, stage: str, total: float | None = None) -> None:
            pass

        def advance(self, amount: float = 1.0) -> None:
            pass

        def note(self, sentence: str) -> None:
            said.append(sentence)

    for name in ("pumpAVisualReferenceImage.e57", "room_scan1.pcd"):
        table = write_positions(tmp_path / "positions.csv", [(name, np.zeros(3))])
        list(read_scans([REAL / name], Parameters().reading, positions=table, progress=Listener()))
    assert said == []
