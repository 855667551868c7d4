"""The whole way on the built-in building, as a newcomer runs it, and every command on what it leaves behind."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import networkx as nx
import pandas as pd
import pytest
from conftest import Demo, RunningNeo4j
from plyfile import PlyData

pytestmark = pytest.mark.slow
PNG = b"\x89PNG"


def enfilade(demo: Demo, *arguments: str | Path, cwd: Path | None = None) -> str:
    command = [sys.executable, "-m", "enfilade", *map(str, arguments)]
    done = subprocess.run(command, cwd=cwd or demo.folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_demo_prints_tree_rooms_and_matches(demo: Demo) -> None:
    assert "demo/s1  Storey 1" in demo.printed
    assert "area m²" in demo.printed
    matches = demo.printed.split("RETURN a")[1]
    assert matches.count("demo/o") >= 2


def test_demo_finds_the_two_basins_beside_the_stairs(demo: Demo) -> None:
    question = """MATCH (a:Room {area: 10..20})-[:DOOR]-(b:Room {area: 10..20}), (a)-[:STAIRS]-(:Room),
                        (b)-[:CONTAINS]->(o:Object LIKE $basin) RETURN b, o, score LIMIT 2"""
    rows = json.loads(enfilade(demo, "query", question, "--like", "basin=demo/basin.obj", "--format", "json"))
    truth = json.loads((demo.folder / "demo" / "demo.truth" / "graph.json").read_text())
    basins = [n["position"] for n in truth["nodes"] if n["label"] == "Object" and "basin" in n["name"]]
    graph = json.loads((_exported(demo) / "graph.json").read_text())
    positions = {n["id"]: n["position"] for n in graph["nodes"] if n["label"] == "Object"}
    for row in rows:
        x, y, z = positions[row["o"]]
        assert min(abs(x - p[0]) + abs(y - p[1]) + abs(z - p[2]) for p in basins) < 0.3, row
    assert rows[0]["score"] >= rows[1]["score"]
    assert len({row["b"] for row in rows}) == 2


def test_demo_draws_plans_and_matches(demo: Demo) -> None:
    drawn = sorted(path.name for path in (demo.folder / "demo").glob("*.png"))
    assert drawn[-2:] == ["plan-s0.png", "plan-s1.png"]
    assert len(drawn) >= 4
    assert all((demo.folder / "demo" / name).read_bytes()[:4] == PNG for name in drawn)


def test_demo_rooms_agree_with_the_truth(demo: Demo) -> None:
    found = json.loads(enfilade(demo, "evaluate", "demo", "demo/demo.truth", "--format", "json"))
    assert found["rooms"]["f1_at_50"] >= 0.95
    assert found["rooms"]["f1_at_70"] >= 0.9


def test_export_is_read_by_networkx_and_ply_readers(demo: Demo) -> None:
    folder = _exported(demo)
    graph = nx.node_link_graph(json.loads((folder / "graph.json").read_text()), edges="edges")
    assert graph.nodes["demo"]["label"] == "Building"
    assert graph.nodes["demo"]["scan_count"] == 17
    vertex = PlyData.read(str(folder / "cloud.ply"))["vertex"]
    labels = ["storey", "room", "object", "plane", "scan"]
    assert [p.name for p in vertex.properties] == ["x", "y", "z", *labels, "intensity"]
    rooms = {f"demo/r{number}" for number in set(vertex["room"].tolist()) - {-1}}
    assert rooms == {node for node, given in graph.nodes(data=True) if given["label"] == "Room"}


def test_import_gives_the_same_graph_again(demo: Demo, tmp_path: Path) -> None:
    folder = _exported(demo)
    enfilade(demo, "import", folder, cwd=tmp_path)
    enfilade(demo, "export", "demo", "-o", "again", cwd=tmp_path)
    assert json.loads((tmp_path / "again" / "graph.json").read_text()) == json.loads(
        (folder / "graph.json").read_text()
    )
    assert (tmp_path / "again" / "cloud.ply").read_bytes() == (folder / "cloud.ply").read_bytes()


def test_ingest_again_gives_the_same_ids_and_replaces(demo: Demo, tmp_path: Path) -> None:
    scans = demo.folder / "demo" / "demo.e57"
    enfilade(demo, "ingest", scans, cwd=tmp_path)
    enfilade(demo, "export", "demo", "-o", "again", cwd=tmp_path)
    first, second = (
        json.loads((folder / "graph.json").read_text()) for folder in (_exported(demo), tmp_path / "again")
    )
    for graph in (first, second):
        graph["nodes"][0].pop("ingested_at")
    assert first == second
    assert len(list((tmp_path / "enfilade.clouds").iterdir())) == 1


@pytest.mark.parametrize("node", ["demo/s0", "demo/r0", "demo/o0"])
def test_extract_takes_out_the_points_of_a_node(demo: Demo, tmp_path: Path, node: str) -> None:
    enfilade(demo, "extract", node, "-o", tmp_path / "points.ply")
    vertex = PlyData.read(str(tmp_path / "points.ply"))["vertex"]
    column = {"s": "storey", "r": "room", "o": "object"}[node.split("/")[1][0]]
    assert len(vertex) > 0
    assert set(vertex[column].tolist()) == {0}


def test_measure_says_sizes_and_distances(demo: Demo) -> None:
    printed = enfilade(demo, "measure", "demo/r0", "demo/r1")
    assert "area" in printed
    assert "in plan" in printed


def test_show_draws_svg_plans(demo: Demo, tmp_path: Path) -> None:
    enfilade(demo, "show", "demo", "--plan", tmp_path / "plan.svg")
    assert [path.name for path in sorted(tmp_path.iterdir())] == ["plan-s0.svg", "plan-s1.svg"]
    drawn = (tmp_path / "plan-s0.svg").read_text()
    assert all(f'id="{name}"' in drawn for name in ("walls", "room-r0", "label-r0", "scans-r0"))


def test_answers_as_csv_and_parquet(demo: Demo, tmp_path: Path) -> None:
    question = "MATCH (a:Room {area: 10..20}) RETURN a, a.area"
    enfilade(demo, "query", question, "--format", "csv", "-o", tmp_path / "rooms.csv")
    enfilade(demo, "query", question, "--format", "parquet", "-o", tmp_path / "rooms.parquet")
    from_csv, from_parquet = pd.read_csv(tmp_path / "rooms.csv"), pd.read_parquet(tmp_path / "rooms.parquet")
    assert from_csv["a"].tolist() == from_parquet["a"].tolist()
    assert from_parquet["a.area"].between(10, 20).all()


def test_remove_takes_graph_and_cloud(demo: Demo, tmp_path: Path) -> None:
    enfilade(demo, "import", _exported(demo), cwd=tmp_path)
    enfilade(demo, "remove", "demo", "--yes", cwd=tmp_path)
    assert json.loads(enfilade(demo, "buildings", "--format", "json", cwd=tmp_path)) == []
    assert list((tmp_path / "enfilade.clouds").iterdir()) == []


@pytest.mark.neo4j
@pytest.mark.usefixtures("neo4j_store")
def test_copy_to_neo4j_and_ask_there(
    demo: Demo, neo4j_server: RunningNeo4j, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("ENFILADE_PASSWORD", neo4j_server.password)
    enfilade(demo, "copy", "--to", neo4j_server.url)
    question = (
        "MATCH (a:Room)-[:DOOR]-(b:Room)-[:CONTAINS]->(o:Object LIKE 'demo/basin.obj' WITHIN 1) RETURN a, b, o, score"
    )
    here, there = (
        enfilade(demo, *store, "query", question, "--format", "json") for store in ((), ("--store", neo4j_server.url))
    )
    assert json.loads(here) == json.loads(there) != []
    counted = enfilade(demo, "--store", neo4j_server.url, "cypher", "MATCH (r:Room) RETURN count(r) AS rooms")
    assert json.loads(counted)["rooms"] == 14


def _exported(demo: Demo) -> Path:
    folder = demo.folder / "exported"
    if not folder.exists():
        enfilade(demo, "export", "demo", "-o", folder)
    return folder
