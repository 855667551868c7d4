"""Scans of the built-in building in, its graph and cloud out, compared with the truth."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pye57
import pytest

from enfilade.clouds import write_cloud
from enfilade.errors import InputError
from enfilade.evaluate import evaluate
from enfilade.ingest.pipeline import Ingested, ingest
from enfilade.schema.checks import check
from enfilade.schema.exchange import write_graph
from enfilade.simulate import Parameters, Scanner, demo_scene, simulate

pytestmark = pytest.mark.slow

FAR = np.array([466_000.0, 5_410_000.0, 250.0])


@pytest.fixture(scope="module")
def scans(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("scans")
    return simulate(demo_scene(), folder / "demo.e57", parameters=Parameters(Scanner(angular_step_deg=0.6)))


@pytest.fixture(scope="module")
def ingested(scans: Path) -> Ingested:
    return ingest([scans], building="demo")


def moved(
    scans: Path, path: Path, *, order: int = 1, offset: np.ndarray | float = 0.0, seed: int | None = None
) -> Path:
    """The same scans in another order and place, with a seed their points in any order."""
    with pye57.E57(str(scans)) as source, pye57.E57(str(path), mode="w") as target:
        for index in range(source.scan_count)[::order]:
            header = source.get_header(index)
            points = source.read_scan(index, transform=False, ignore_missing_fields=True)
            xyz = {name: points[name] for name in ("cartesianX", "cartesianY", "cartesianZ")}
            if seed is not None:
                anyhow = np.random.default_rng(seed).permutation(len(xyz["cartesianX"]))
                xyz = {axis: values[anyhow] for axis, values in xyz.items()}
            name = header["name"].value()
            target.write_scan_raw(xyz, name=name, rotation=header.rotation, translation=header.translation + offset)
    return path


def rooms_of(result: Ingested) -> dict[tuple[str, ...], dict[str, object]]:
    """Rooms by the scans that stand in them."""
    return {tuple(sorted(node.properties["scans"])): node.properties for node in result.graph.of_label("Room")}


def test_rooms_storeys_and_areas_are_those_of_the_truth(scans: Path, ingested: Ingested, tmp_path: Path) -> None:
    write_graph(ingested.graph, tmp_path / "graph.json")
    write_cloud(tmp_path / "cloud.ply", ingested.cloud)
    figures = evaluate(tmp_path, scans.with_suffix(".truth"))
    assert figures.rooms.f1_at_50 == 1.0
    assert figures.rooms.f1_at_70 > 0.9
    assert figures.storeys.rooms_right == 1.0
    assert figures.measures.area_error < 0.02
    assert figures.measures.floor_error_m < 0.01


def test_the_graph_keeps_to_the_schema_and_knows_its_sources(scans: Path, ingested: Ingested) -> None:
    check(ingested.graph)
    building = ingested.graph.nodes["demo"].properties
    assert building["source_files"] == ["demo.e57"]
    with pye57.E57(str(scans)) as file:
        assert building["scan_count"] == file.scan_count
        assert building["point_count"] == sum(file.get_header(i).point_count for i in range(file.scan_count))
    assert building["parameters"]["thinning"] == {"voxel_size_m": 0.01}
    assert len(building["content_hash"]) == 64
    assert set(ingested.timings) >= {"read and thin", "surfels", "planes", "groups", "rooms", "graph"}


def test_the_cloud_and_the_graph_count_the_same_points(ingested: Ingested) -> None:
    for node in ingested.graph.of_label("Room"):
        number = int(node.id.split("/r")[1])
        assert node.properties["point_count"] == np.count_nonzero(ingested.cloud.room == number)


@pytest.mark.parametrize(("order", "seed"), [(-1, None), (1, 5)], ids=["scans backwards", "points shuffled"])
def test_nothing_depends_on_the_order_of_scans_and_points(
    scans: Path, tmp_path: Path, order: int, seed: int | None
) -> None:
    there = ingest([moved(scans, tmp_path / "there.e57")], building="demo")
    again = ingest([moved(scans, tmp_path / "again.e57", order=order, seed=seed)], building="demo")
    for label in ("Room", "Opening", "Object"):
        first, second = ({n.id: n.properties for n in each.graph.of_label(label)} for each in (there, again))
        assert first.keys() == second.keys()
        assert all(str(first[id]) == str(second[id]) for id in first)
    assert np.array_equal(there.cloud.object, again.cloud.object)


def test_far_from_the_origin_nothing_but_the_place_changes(scans: Path, ingested: Ingested, tmp_path: Path) -> None:
    far = ingest([moved(scans, tmp_path / "demo.e57", offset=FAR)], building="demo")
    assert np.abs(np.array(far.graph.nodes["demo"].properties["origin"]) - FAR).max() < 530.0
    for scan_names, room in rooms_of(ingested).items():
        there = rooms_of(far)[scan_names]
        assert there["name"] == room["name"]
        assert there["area"] == pytest.approx(room["area"], rel=0.02)
        assert np.allclose(np.array(there["centroid"]) - FAR, room["centroid"], atol=0.05)


def test_a_grouping_table_joins_rooms(scans: Path, ingested: Ingested, tmp_path: Path) -> None:
    (tmp_path / "rooms.csv").write_text("scan,room\nScan 001,suite\nScan 002,suite\n")
    joined = ingest([scans], building="demo", rooms_csv=tmp_path / "rooms.csv")
    assert ("Scan 001", "Scan 002") in rooms_of(joined)
    assert len(rooms_of(joined)) == len(rooms_of(ingested)) - 1
    hashes = [result.graph.nodes["demo"].properties["content_hash"] for result in (ingested, joined)]
    assert hashes[0] != hashes[1]


def test_a_table_with_a_scan_that_is_not_there_names_its_line(scans: Path, tmp_path: Path) -> None:
    (tmp_path / "rooms.csv").write_text("scan,room\nScan 001,a\nCellar,b\n")
    with pytest.raises(InputError, match="line 3: there is no scan 'Cellar'"):
        ingest([scans], building="demo", rooms_csv=tmp_path / "rooms.csv")
