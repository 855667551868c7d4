"""``graph.json``: what goes out comes back, and what is wrong is said in one sentence."""

from __future__ import annotations

import gzip
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from strategies import graphs

from enfilade.errors import GraphError, VersionError
from enfilade.schema.encoding import encode
from enfilade.schema.exchange import read_graph, read_graphs, write_graph, write_graphs
from enfilade.schema.graph import BuildingGraph

HOTEL = Path(__file__).parents[1] / "graphs" / "hotel.graph.json"

Document = dict[str, Any]


@pytest.fixture
def document() -> Document:
    loaded: Document = json.loads(HOTEL.read_text(encoding="utf-8"))
    return loaded


@pytest.fixture
def read(tmp_path: Path) -> Callable[[Any], BuildingGraph]:
    def read_document(document: Any) -> BuildingGraph:
        path = tmp_path / "some.graph.json"
        path.write_text(json.dumps(document), encoding="utf-8")
        return read_graph(path)

    return read_document


def test_a_foreign_file_comes_out_as_it_went_in(tmp_path: Path, document: Document) -> None:
    write_graph(read_graph(HOTEL), tmp_path / "out.json")
    assert json.loads((tmp_path / "out.json").read_text(encoding="utf-8")) == document


@settings(max_examples=30)
@given(graph=graphs())
def test_any_graph_comes_back_and_gives_the_same_bytes(graph: BuildingGraph, tmp_path_factory: Any) -> None:
    path = tmp_path_factory.mktemp("graph") / "graph.json"
    write_graph(graph, path)
    again = read_graph(path)
    assert again == graph
    assert list(again.nodes) == list(graph.nodes)
    assert b"".join(encode(again)) == path.read_bytes()


@pytest.mark.parametrize("name", ["many.jsonl", "many.jsonl.gz"])
def test_many_buildings_lie_one_a_line(tmp_path: Path, hotel: BuildingGraph, name: str) -> None:
    other = BuildingGraph("über\u2028'🏠'")
    other.add_node(other.building, "Building", name="line\nbreak")
    write_graphs(iter([hotel, other]), tmp_path / name)
    assert list(read_graphs(tmp_path / name)) == [hotel, other]
    opened = gzip.open if name.endswith("gz") else open
    with opened(tmp_path / name, "rb") as file:
        assert [json.loads(line)["graph"]["building"] for line in file] == ["hotel", other.building]


def test_packed_files_do_not_depend_on_time_or_name(tmp_path: Path, hotel: BuildingGraph) -> None:
    write_graphs([hotel], tmp_path / "a.jsonl.gz")
    write_graphs([hotel], tmp_path / "b.jsonl.gz")
    assert (tmp_path / "a.jsonl.gz").read_bytes() == (tmp_path / "b.jsonl.gz").read_bytes()


def test_networkx_reads_it(tmp_path: Path, hotel: BuildingGraph) -> None:
    write_graph(hotel, tmp_path / "graph.json")
    loaded = nx.node_link_graph(json.loads((tmp_path / "graph.json").read_text(encoding="utf-8")), edges="edges")
    assert loaded.nodes["hotel/r1"]["area"] == 14.0
    assert loaded.number_of_edges() == len(hotel.edges)
    written = nx.node_link_data(loaded, edges="edges")
    assert {node["id"] for node in written["nodes"]} == set(hotel.nodes)


def test_what_networkx_writes_is_read(
    hotel: BuildingGraph, tmp_path: Path, read: Callable[[Any], BuildingGraph]
) -> None:
    write_graph(hotel, tmp_path / "graph.json")
    loaded = nx.node_link_graph(json.loads((tmp_path / "graph.json").read_text(encoding="utf-8")), edges="edges")
    again = read(nx.node_link_data(loaded, edges="edges"))
    assert again.nodes == hotel.nodes
    assert sorted(map(str, again.edges)) == sorted(map(str, hotel.edges))


def test_numbers_take_the_kind_of_the_schema(document: Document, read: Callable[[Any], BuildingGraph]) -> None:
    nodes = {node["id"]: node for node in document["nodes"]}
    nodes["hotel/r0"].update(area=30, point_count=7.0, centroid=[1, 2, 3])
    room = read(document).nodes["hotel/r0"].properties
    assert [type(room[name]) for name in ("area", "point_count")] == [float, int]
    assert all(isinstance(part, float) for part in room["centroid"])


def test_null_is_absent_where_the_schema_knows_the_property(
    document: Document, read: Callable[[Any], BuildingGraph]
) -> None:
    document["nodes"][3].update(height=None, colour=None)
    room = read(document).nodes["hotel/r0"].properties
    assert "height" not in room
    assert room["colour"] is None


def test_a_building_without_its_own_node_gets_one(document: Document, read: Callable[[Any], BuildingGraph]) -> None:
    document["nodes"] = [node for node in document["nodes"] if node["label"] != "Building"]
    document["edges"] = [edge for edge in document["edges"] if edge["type"] != "HAS_STOREY"]
    assert read(document).nodes["hotel"].label == "Building"


def test_edges_without_a_key_are_numbered_per_pair(document: Document, read: Callable[[Any], BuildingGraph]) -> None:
    for edge in document["edges"]:
        del edge["key"]
    assert {edge.key for edge in read(document).edges} == {0}


def test_a_descriptor_near_one_is_normalised(document: Document, read: Callable[[Any], BuildingGraph]) -> None:
    document["nodes"][-1]["descriptor"] = [0.5004, 0.5, 0, 0, 0, 0, 0, 0]
    counts = read(document).nodes["hotel/o5"].properties["descriptor"]
    assert counts.dtype == np.uint16
    assert counts.sum() == 61440


def test_a_file_with_a_byte_order_mark_is_read(tmp_path: Path) -> None:
    path = tmp_path / "bom.json"
    path.write_bytes(b"\xef\xbb\xbf" + HOTEL.read_bytes())
    assert read_graph(path).building == "hotel"


def _node(document: Document, id: str) -> Document:
    found: Document = next(node for node in document["nodes"] if node["id"] == id)
    return found


def _set(node: str, /, **properties: Any) -> Callable[[Document], None]:
    return lambda document: _node(document, node).update(properties)


FAULTS: dict[str, tuple[Callable[[Document], Any], str]] = {
    "format": (lambda d: d["graph"].update(format="other"), "is no graph of Enfilade"),
    "nodes missing": (lambda d: d.pop("nodes"), 'no list of "nodes"'),
    "links": (lambda d: d.update(links=d.pop("edges")), 'write it with edges="edges"'),
    "undirected": (lambda d: d.update(directed=False), "undirected"),
    "node is a list": (lambda d: d["nodes"].insert(2, []), "node 2, counted from 0"),
    "id is a number": (_set("hotel/r0", id=3), "node 3, counted from 0"),
    "edge without type": (lambda d: d["edges"][5].pop("type"), "edge 5, counted from 0"),
    "twice the same id": (_set("hotel/r1", id="hotel/r0"), "two nodes have the id 'hotel/r0'"),
    "descriptor sum": (_set("hotel/o1", descriptor=[0.5] * 8), "must sum to 1, not to 4"),
    "descriptor below 0": (_set("hotel/o1", descriptor=[-1.0, 2.0] + [0] * 6), "none below 0"),
    "descriptor of texts": (_set("hotel/o1", descriptor=["a"] * 8), "must be a list of numbers"),
    "descriptor is true": (_set("hotel/o1", descriptor=[True] + [0] * 7), "must be a list of numbers"),
    "descriptor is empty": (_set("hotel/o1", descriptor=[]), "must sum to 1, not to 0"),
    "descriptor beyond numbers": (_set("hotel/o1", descriptor=[10**400] + [0] * 7), "list of finite numbers"),
    "descriptor without end": (_set("hotel/o1", descriptor=[1e400] + [0] * 7), "Infinity"),
    "descriptor length": (_set("hotel/o1", descriptor=[1.0, 0.0]), 'has 2 bins, "descriptor_shape" says 8'),
    "no shape": (lambda d: d["graph"].pop("descriptor_shape"), 'no "descriptor_shape"'),
    "shape of two": (lambda d: d["graph"].update(descriptor_shape=[2, 4]), "three numbers"),
    "shape of texts": (lambda d: d["graph"].update(descriptor_shape=["1", "2", "4"]), "three whole numbers"),
    "building is a number": (lambda d: d["graph"].update(building=7), "a building's id is a text"),
    "huge number": (_set("hotel/r0", point_count=2**63), "at most 64 bits"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_one_sentence_with_the_file(
    fault: str, document: Document, read: Callable[[Any], BuildingGraph]
) -> None:
    spoil, said = FAULTS[fault]
    spoil(document)
    with pytest.raises(GraphError) as caught:
        read(document)
    assert said in str(caught.value)
    assert "some.graph.json" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "is no JSON"),
        (b'{"directed": true,', "is no JSON"),
        (b"[" * 100_000, "too deep"),
        (b"\xff\xfe", "is not UTF-8"),
        (b'{"graph": NaN}', "NaN"),
        (b'{"graph": ' + b"9" * 5000 + b"}", "too many digits"),
        (b"[]", "is no graph of Enfilade"),
        (b"null", "is no graph of Enfilade"),
    ],
)
def test_broken_text_is_one_sentence_with_the_file(tmp_path: Path, content: bytes, said: str) -> None:
    path = tmp_path / "broken.json"
    path.write_bytes(content)
    with pytest.raises(GraphError, match=said) as caught:
        read_graph(path)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize("version", [2, 0, "1", True, None, 1.5])
def test_another_version_is_refused(document: Document, read: Callable[[Any], BuildingGraph], version: Any) -> None:
    document["graph"]["version"] = version
    with pytest.raises(VersionError, match="this Enfilade reads version 1"):
        read(document)


def test_deep_unknown_properties_are_refused(document: Document, read: Callable[[Any], BuildingGraph]) -> None:
    deep: list[Any] = []
    for _ in range(200):
        deep = [deep]
    document["nodes"][0]["deep"] = deep
    with pytest.raises(GraphError, match="deep in one another"):
        read(document)


def test_the_line_of_many_is_named(tmp_path: Path, hotel: BuildingGraph) -> None:
    path = tmp_path / "many.jsonl"
    write_graphs([hotel], path)
    path.write_bytes(path.read_bytes() + b"\n{}\n")
    with pytest.raises(GraphError, match="line 3: is no graph"):
        list(read_graphs(path))


def test_a_damaged_packed_file_is_said(tmp_path: Path, hotel: BuildingGraph) -> None:
    path = tmp_path / "many.jsonl.gz"
    write_graphs([hotel], path)
    path.write_bytes(path.read_bytes()[:-20])
    with pytest.raises(GraphError, match="cannot be read"):
        list(read_graphs(path))


def test_a_missing_file_is_said(tmp_path: Path) -> None:
    with pytest.raises(GraphError, match="No such file"):
        read_graph(tmp_path / "missing.json")


def test_one_graph_is_wanted(tmp_path: Path, hotel: BuildingGraph) -> None:
    write_graphs([hotel, hotel], tmp_path / "two.jsonl")
    (tmp_path / "none.jsonl").touch()
    with pytest.raises(GraphError, match="several buildings"):
        read_graph(tmp_path / "two.jsonl")
    with pytest.raises(GraphError, match="no building"):
        read_graph(tmp_path / "none.jsonl")


def test_a_place_that_cannot_be_written_is_said(tmp_path: Path, hotel: BuildingGraph) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(GraphError, match="cannot be written"):
        write_graph(hotel, tmp_path / "file" / "graph.json")
    with pytest.raises(GraphError, match="cannot be written"):
        write_graphs([hotel], tmp_path / "file" / "graph.jsonl")
