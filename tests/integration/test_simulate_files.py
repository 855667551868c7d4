"""The files that a simulation writes, read back."""

import csv
from pathlib import Path

import numpy as np
import pye57
import pytest

from enfilade.clouds import LabelledCloud, read_cloud
from enfilade.descriptors import DEFAULT_LAYOUT, Shape, distances, mesh_views
from enfilade.errors import InputError
from enfilade.schema.exchange import read_graph
from enfilade.schema.graph import BuildingGraph
from enfilade.simulate import Parameters, Scanner, Scene, basin_mesh, demo_scene, mesh_scene, simulate, write_obj

COARSE = Parameters(Scanner(angular_step_deg=1.5))


@pytest.fixture(scope="module")
def scene() -> Scene:
    return demo_scene()


@pytest.fixture(scope="module")
def scans(scene: Scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return simulate(scene, tmp_path_factory.mktemp("simulated") / "demo.e57", parameters=COARSE)


@pytest.fixture(scope="module")
def graph(scans: Path) -> BuildingGraph:
    return read_graph(scans.with_suffix(".truth") / "graph.json")


@pytest.fixture(scope="module")
def cloud(scans: Path) -> LabelledCloud:
    return read_cloud(scans.with_suffix(".truth") / "cloud.ply")


def world_points(file: pye57.E57, index: int) -> np.ndarray:
    points = file.read_scan(index, transform=True, ignore_missing_fields=True)
    return np.column_stack([points[f"cartesian{axis}"] for axis in "XYZ"])


def raw_points(path: Path) -> list[np.ndarray]:
    file = pye57.E57(str(path))
    scans = [file.read_scan_raw(index) for index in range(file.scan_count)]
    file.close()
    return [np.column_stack([scan[name] for name in sorted(scan)]) for scan in scans]


def distance_to_box(points, low, high):
    """Distance of points to a box, 0 inside."""
    return np.linalg.norm(np.maximum(np.maximum(low - points, points - high), 0), axis=1)


def test_every_scan_has_its_pose_and_lies_in_the_world_where_the_truth_is(scans, cloud):
    file = pye57.E57(str(scans))
    assert file.scan_count == cloud.scan.max() + 1
    for index in range(file.scan_count):
        header = file.get_header(index)
        assert header["name"].value() == f"Scan {index + 1:03d}"
        assert header.has_pose()
        written = world_points(file, index)
        true = cloud.positions[cloud.scan == index]
        cells = {tuple(cell) for cell in np.round(written / 0.01).astype(int)}
        near = np.mean([tuple(cell) in cells for cell in np.round(true / 0.01).astype(int)])
        assert near > 0.98  # single precision in the file moves a few over the edge of a cell
    file.close()


def test_points_of_a_scan_surround_its_scanner(scans):
    file = pye57.E57(str(scans))
    local = raw_points(scans)[0][:, :3]
    assert np.linalg.norm(local, axis=1).min() > 0.3
    assert (np.abs(np.mean(local > 0, axis=0)[:2] - 0.5) < 0.2).all()
    world = world_points(file, 0)
    scanner = file.get_header(0).translation
    assert np.linalg.norm(world - scanner, axis=1) == pytest.approx(np.linalg.norm(local, axis=1), abs=1e-4)
    file.close()


def test_truth_graph_keeps_the_schema_and_says_what_was_built(graph, scene):
    assert graph.building == "demo"
    assert [room.properties["name"] for room in graph.of_label("Room")] == [room.name for room in scene.rooms]
    assert len(list(graph.of_label("Opening"))) == len(scene.openings)
    assert len(list(graph.of_type("BELOW"))) == 1
    rooms = {node.id: node for node in graph.of_label("Room")}
    assert rooms["demo/r2"].properties["area"] == pytest.approx(5.75 * 2.6)
    assert rooms["demo/r2"].properties["height"] == pytest.approx(2.6)
    assert sum(node.properties["point_count"] for node in rooms.values()) > 100_000


def test_each_opening_leaves_from_its_rooms(graph, scene):
    for number, opening in enumerate(scene.openings):
        sources = [e.source for e in graph.of_type("OPENS") if e.target == f"demo/p{number}"]
        assert sources == [f"demo/r{room}" for room in opening.rooms if room >= 0]


def test_each_object_is_contained_where_it_stands(graph, scene):
    for piece in scene.furnishings:
        (room,) = [e.source for e in graph.of_type("CONTAINS") if e.target == f"demo/o{piece.number}"]
        assert room == f"demo/r{piece.room}"


def test_objects_are_described_by_what_was_seen_of_them(graph, scene):
    described = [node for node in graph.of_label("Object") if "foot_descriptor" in node.properties]
    assert len(described) == len(scene.furnishings)
    basins = [node for node in described if node.properties["name"] == "basin"]
    others = [node for node in described if node.properties["name"] in ("wardrobe", "bed", "table")]
    asked = basin_mesh()
    views = mesh_views(Shape("basin", asked.vertices, asked.triangles))
    assert graph.descriptor_shape == DEFAULT_LAYOUT.shape
    near, far = (
        distances(views, np.array([n.properties["foot_descriptor"] for n in nodes]), DEFAULT_LAYOUT.shape)
        for nodes in (basins, others)
    )
    assert near.max() < far.min()


def test_neighbours_share_a_wall_or_a_slab(graph):
    pairs = {frozenset((e.source, e.target)): e.properties for e in graph.of_type("NEIGHBOUR")}
    bath_hall = pairs[frozenset(("demo/r0", "demo/r2"))]
    assert bath_hall["gap"] == pytest.approx(0.15, abs=0.01)
    assert bath_hall["area"] == pytest.approx(3.55 * 2.6, rel=0.05)
    above = pairs[frozenset(("demo/r0", "demo/r7"))]
    assert above["gap"] == pytest.approx(0.3, abs=0.01)
    assert above["area"] == pytest.approx(3.55 * 3.15, rel=0.05)
    assert frozenset(("demo/r0", "demo/r5")) not in pairs


def test_structure_points_of_a_room_lie_in_it_or_in_a_reveal(cloud, scene):
    structure = cloud.plane >= 0
    for room in scene.rooms:
        points = cloud.positions[structure & (cloud.room == room.number)]
        far = distance_to_box(points, *room.boundary.bounds) > 0.02
        for opening in scene.openings:
            if room.number in opening.rooms:
                frame = np.stack([opening.axis, opening.normal, np.cross(opening.normal, opening.axis)])
                half = np.array([opening.width, opening.depth, opening.height]) / 2 + 0.08
                far &= (np.abs((points - opening.position) @ frame.T) > half).any(axis=1)
        assert len(points) > 1000
        assert far.mean() < 0.0005, room.name


def test_points_of_an_object_lie_on_it_and_in_its_room(cloud, scene):
    for piece in scene.furnishings:
        of_piece = cloud.object == piece.number
        corners = scene.mesh.vertices[scene.mesh.triangles[scene.furnishing == piece.number]].reshape(-1, 3)
        assert distance_to_box(cloud.positions[of_piece], corners.min(axis=0), corners.max(axis=0)).max() < 0.03
        assert (cloud.room[of_piece] == piece.room).all()


def test_storeys_are_those_of_the_rooms(cloud, scene):
    storeys = np.array([room.storey for room in scene.rooms] + [-1])
    assert (cloud.storey == storeys[cloud.room]).all()


def test_cloud_is_thin_and_sorted_by_room_and_object(cloud):
    cells = np.floor(cloud.positions / 0.01).astype(np.int64)
    assert len(np.unique(cells, axis=0)) == len(cells)
    keys = cloud.room.astype(np.int64) * 10_000 + cloud.object
    assert (np.diff(keys) >= 0).all()


def test_grouping_names_the_room_of_every_scan(scans, scene):
    with (scans.with_suffix(".truth") / "grouping.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    poses = pye57.E57(str(scans))
    assert len(rows) == poses.scan_count
    for index, row in enumerate(rows):
        assert row["scan"] == f"Scan {index + 1:03d}"
        low, high = scene.rooms[int(row["room"])].boundary.bounds
        position = poses.get_header(index).translation
        assert ((position > low) & (position < high)).all()
    poses.close()


def test_the_same_seed_writes_the_same_points_and_truth(scans, scene, tmp_path):
    again = simulate(scene, tmp_path / "demo.e57", parameters=COARSE)
    for first, second in zip(raw_points(scans), raw_points(again), strict=True):
        assert first.tobytes() == second.tobytes()
    for name in ("graph.json", "cloud.ply", "grouping.csv"):
        files = [path.with_suffix(".truth") / name for path in (scans, again)]
        assert files[0].read_bytes() == files[1].read_bytes()


def test_a_mesh_gives_scans_and_a_cloud_without_rooms(tmp_path):
    model = write_obj(tmp_path / "model.obj", demo_scene().mesh)
    scene = mesh_scene(model, stations=np.array([[1.5, 1.5, 1.5], [8.0, 6.0, 1.5]]))
    out = simulate(scene, tmp_path / "model.e57", parameters=COARSE)
    graph = read_graph(out.with_suffix(".truth") / "graph.json")
    assert [node.label for node in graph.nodes.values()] == ["Building"]
    assert (read_cloud(out.with_suffix(".truth") / "cloud.ply").room == -1).all()
    assert (out.with_suffix(".truth") / "grouping.csv").read_text() == "scan,room\n"


def test_a_position_that_sees_nothing_is_named_and_leaves_no_file(tmp_path):
    model = write_obj(tmp_path / "model.obj", demo_scene().mesh)
    scene = mesh_scene(model, stations=np.array([[900.0, 1.5, 1.5]]))
    with pytest.raises(InputError, match="sees nothing at"):
        simulate(scene, tmp_path / "model.e57", parameters=COARSE)
    assert [path.name for path in tmp_path.iterdir()] == ["model.obj"]


def test_a_folder_that_cannot_be_written_is_named(scene, tmp_path):
    (tmp_path / "taken").write_text("a file")
    with pytest.raises(InputError, match="cannot be written"):
        simulate(scene, tmp_path / "taken" / "demo.e57", parameters=COARSE)


def test_a_new_folder_is_made(scene, tmp_path):
    scanner = Scanner(angular_step_deg=5.0)
    out = simulate(scene, tmp_path / "a" / "b" / "demo.e57", parameters=Parameters(scanner), grouping=False)
    assert {path.name for path in out.parent.iterdir()} == {"demo.e57", "demo.truth"}
    assert {path.name for path in (out.parent / "demo.truth").iterdir()} == {"graph.json", "cloud.ply"}
