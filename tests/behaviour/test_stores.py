"""What every store does: one suite, run on SQLite and on a real Neo4j."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from strategies import graphs

from enfilade.clouds import LabelledCloud
from enfilade.errors import GraphError, NotFoundError, StoreError
from enfilade.schema.encoding import encode
from enfilade.schema.graph import BuildingGraph
from enfilade.schema.ids import object_id
from enfilade.stores import Store, open_store
from enfilade.stores.archive import Archive, copy_buildings
from enfilade.stores.base import in_batches

ONE_NODE = {"sql": "SELECT id FROM building ORDER BY id", "cypher": "MATCH (b:Building) RETURN b.id ORDER BY b.id"}
PARAMETER = {"sql": "SELECT :text", "cypher": "RETURN $text"}
ENDLESS = {
    "sql": "WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM n) SELECT count(*) FROM n",
    "cypher": "UNWIND range(1, 1000000000) AS x WITH x WHERE x % 7 = 8 RETURN count(x)",
}
COUNTING = {
    "sql": "SELECT count(*), min(area), max(area) FROM room WHERE building = 'a'",
    "cypher": "MATCH (r:Room {building: 'a'}) RETURN count(r), min(r.area), max(r.area)",
}
WRITING = {"sql": "DELETE FROM building", "cypher": "MATCH (n) DETACH DELETE n"}
NONSENSE = {"sql": "SELEKT 1", "cypher": "MATSCH (n) RETURN n"}
HOSTILE = [
    "'; MATCH (n) DETACH DELETE n //",
    "'; DROP TABLE room; --",
    '"quotes" and `backquotes` and \\ and $x and {y}',
    "tab\tnewline\nreturn\r",
    "nul\x00in the middle",
    "Zürich 東京 🏠 e\u0301 \u202e",
    "",
    " ",
]


def building(id: str, rooms: int = 3, **properties: Any) -> BuildingGraph:
    """A building whose rooms all lie on one storey and have the number of rooms as their area."""
    graph = BuildingGraph(id)
    graph.add_node(id, "Building", name=f"Building {id}")
    storey = graph.add_node(f"{id}/s0", "Storey", index=0)
    graph.add_edge(id, "HAS_STOREY", storey.id)
    for number in range(rooms):
        room = graph.add_node(f"{id}/r{number}", "Room", area=float(rooms), **properties)
        graph.add_edge(storey.id, "HAS_ROOM", room.id)
    return graph


def test_a_building_comes_back_as_it_was_written(store: Store, hotel: BuildingGraph) -> None:
    store.write(hotel)
    again = store.read("hotel")
    assert again == hotel
    assert b"".join(encode(again)) == b"".join(encode(hotel))


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(graph=graphs())
def test_any_graph_comes_back_as_it_was_written(store: Store, graph: BuildingGraph) -> None:
    store.write(graph)
    again = store.read(graph.building)
    assert again == graph
    assert list(again.nodes) == list(graph.nodes)
    assert b"".join(encode(again)) == b"".join(encode(graph))
    store.remove(graph.building)


@pytest.mark.parametrize("text", HOSTILE)
def test_hostile_texts_are_just_texts(store: Store, text: str) -> None:
    others = building("other")
    store.write(others)
    graph = building("some", name=text, function=text, scans=[text, text])
    graph.nodes["some"].properties.update(
        {"source_files": [text], "parameters": {text: [text]}, f"unknown {text}": text}
    )
    graph.attributes[text] = text
    graph.edges[0].key = text
    store.write(graph)
    assert store.read("some") == graph
    assert store.read("other") == others
    assert list(store.rows(PARAMETER[store.dialect], {"text": text})) == [(text,)]


@pytest.mark.parametrize(
    "id", [text for text in HOSTILE if text.isprintable() and text and "/" not in text] + ["x" * 200]
)
def test_hostile_ids_are_just_ids(store: Store, id: str) -> None:
    store.write(building("other"))
    store.write(building(id, rooms=1))
    assert store.read(id) == building(id, rooms=1)
    assert {summary.id for summary in store.buildings()} == {"other", id}
    assert store.properties(f"{id}/r0")["area"] == 1.0
    store.remove(id)
    assert store.read("other") == building("other")


def test_writing_again_replaces(store: Store, hotel: BuildingGraph) -> None:
    store.write(building("hotel", rooms=50))
    store.write(hotel)
    assert store.read("hotel") == hotel
    assert [summary.id for summary in store.buildings()] == ["hotel"]


def test_many_are_written_in_one_moment_or_not_at_all(store: Store) -> None:
    store.write_all([building("a"), building("b", rooms=1), building("a", rooms=2)])
    assert [(summary.id, summary.rooms) for summary in store.buildings()] == [("a", 2), ("b", 1)]
    broken = building("d")
    broken.add_edge("d/r0", "OPENS", "d/p0")
    with pytest.raises(GraphError, match="no node 'd/p0'"):
        store.write_all([building("c"), broken])
    store.write_all([])
    assert [store.read(id) for id in ("a", "b")] == [building("a", rooms=2), building("b", rooms=1)]
    assert len(store.buildings()) == 2


def test_an_archive_takes_many_and_keeps_what_came_before_a_fault(store: Store, tmp_path: Path) -> None:
    archive = Archive(store, tmp_path / "clouds")
    cloud = LabelledCloud(np.eye(3), *(np.arange(3, dtype=np.int32) for _ in range(5)))
    broken = GraphError("line 4 is no graph")

    def found() -> Iterator[tuple[BuildingGraph, LabelledCloud | None]]:
        yield building("a"), None
        yield building("b"), cloud
        yield building("c"), None
        raise broken

    done: list[str] = []
    with pytest.raises(GraphError, match="line 4"):
        done.extend(archive.save_all(found()))
    assert [summary.id for summary in store.buildings()] == ["a", "b", "c"]
    assert archive.cloud("b") is not None
    assert list(archive.save_all([(building("b"), None)])) == ["b"]
    assert archive.cloud("b") is None
    assert not list((tmp_path / "clouds").iterdir())


def test_batches_are_as_large_as_asked_for() -> None:
    graphs = [building(str(number), rooms=number) for number in range(6)]
    sizes = [[len(g.nodes) + len(g.edges) for g in batch] for batch in in_batches(graphs, rows=12)]
    assert sizes == [[3, 5, 7], [9, 11], [13]]
    assert list(in_batches([])) == []


def test_other_buildings_stay(store: Store) -> None:
    for id in ("b", "a", "c"):
        store.write(building(id))
    store.write(building("b", rooms=1))
    store.remove("c")
    assert [(summary.id, summary.rooms) for summary in store.buildings()] == [("a", 3), ("b", 1)]
    assert store.read("a") == building("a")


def test_a_summary_counts(store: Store, hotel: BuildingGraph) -> None:
    hotel.nodes["hotel"].properties["ingested_at"] = "2026-01-01T00:00:00Z"
    store.write(hotel)
    (summary,) = store.buildings()
    assert (summary.id, summary.name, summary.ingested_at) == ("hotel", "Hotel", "2026-01-01T00:00:00Z")
    assert (summary.storeys, summary.rooms, summary.openings, summary.objects) == (2, 7, 9, 7)
    assert summary.area == pytest.approx(102.0)


def test_an_area_that_nobody_measured_is_unknown(store: Store) -> None:
    graph = BuildingGraph("plain")
    graph.add_node("plain", "Building")
    store.write(graph)
    assert store.buildings()[0].area is None


def test_buildings_come_by_id(store: Store) -> None:
    ids = ["b", "B", "ä", "🏠", "\uffff", "10", "9"]
    for id in ids:
        store.write(building(id, rooms=0))
    assert [summary.id for summary in store.buildings()] == sorted(ids)


def test_what_is_not_there_is_said(store: Store) -> None:
    store.write(building("a"))
    for ask in (lambda: store.read("b"), lambda: store.remove("b"), lambda: store.properties("b")):
        with pytest.raises(NotFoundError, match=r'no (building|node) "b"'):
            ask()
    with pytest.raises(NotFoundError, match='no node "a/r9"'):
        store.properties("a/r9")


def test_properties_of_a_node_leave_descriptors_out(store: Store, hotel: BuildingGraph) -> None:
    hotel.nodes["hotel/o0"].properties["colour"] = ["red"]
    store.write(hotel)
    assert store.properties("hotel/o0") == {
        "building": "hotel",
        "segments": ["hotel/o0"],
        "parts": 1,
        "colour": ["red"],
    }


def test_a_graph_that_breaks_the_schema_changes_nothing(store: Store) -> None:
    store.write(building("a"))
    broken = building("a", rooms=9)
    broken.add_edge("a/r0", "OPENS", "a/p0")
    with pytest.raises(GraphError, match="no node 'a/p0'"):
        store.write(broken)
    assert store.read("a") == building("a")


def test_rows_only_read(store: Store) -> None:
    store.write(building("a"))
    with pytest.raises(StoreError):
        list(store.rows(WRITING[store.dialect], {}))
    assert list(store.rows(ONE_NODE[store.dialect], {})) == [("a",)]


def test_rows_may_be_left_early(store: Store) -> None:
    for number in range(5):
        store.write(building(f"b{number}", rooms=0))
    rows = store.rows(ONE_NODE[store.dialect], {})
    assert next(rows) == ("b0",)
    rows.close()  # type: ignore[attr-defined]
    store.write(building("b5", rooms=0))
    assert len(list(store.rows(ONE_NODE[store.dialect], {}))) == 6


def test_a_question_that_takes_too_long_is_stopped(store: Store) -> None:
    with pytest.raises(StoreError, match="longer than"):
        list(store.rows(ENDLESS[store.dialect], {}, timeout_s=0.3))
    assert list(store.rows(ONE_NODE[store.dialect], {}, timeout_s=30)) == []


def test_nonsense_is_one_sentence(store: Store) -> None:
    with pytest.raises(StoreError) as caught:
        list(store.rows(NONSENSE[store.dialect], {}))
    assert "\n" not in str(caught.value)


def test_the_engine_tells_its_plan(store: Store) -> None:
    store.write(building("a"))
    assert "building" in store.plan(ONE_NODE[store.dialect], {}).lower()


def test_descriptors_come_building_by_building(store: Store, hotel: BuildingGraph) -> None:
    hotel.nodes["hotel/o1"].properties["foot_descriptor"] = hotel.nodes["hotel/o1"].properties["descriptor"]
    other = BuildingGraph("annexe", descriptor_shape=(1, 1, 2))
    other.add_node("annexe", "Building")
    other.add_node("annexe/o3+o5", "Object", foot_descriptor=np.array([1440, 60000], dtype=np.uint16))
    store.write_all([hotel, other, building("empty")])
    small, none, large = store.descriptors(["annexe", "gone", "empty", "hotel"])
    assert (small.building, small.shape, small.numbers.tolist()) == ("annexe", (1, 1, 2), [[3, 5, -1]])
    assert (small.floor.tolist(), small.foot.tolist()) == ([[0, 0]], [[1440, 60000]])
    assert (none.building, none.shape, len(none.numbers)) == ("empty", None, 0)
    assert (large.building, large.shape, large.floor.dtype, large.floor.shape) == (
        "hotel",
        (1, 2, 4),
        np.uint16,
        (7, 8),
    )
    expected = [node for node in hotel.of_label("Object") if "descriptor" in node.properties]
    assert [object_id("hotel", *(n for n in own if n >= 0)) for own in large.numbers.tolist()] == [
        n.id for n in expected
    ]
    assert np.array_equal(large.floor, [node.properties["descriptor"] for node in expected])
    assert np.array_equal(large.foot[1], large.floor[1])
    assert large.foot[[0, *range(2, 7)]].sum() == 0
    assert {found.building: found.revision for found in (small, none, large)} == store.revisions()


def test_every_writing_is_a_revision_of_its_own(store: Store) -> None:
    store.write_all([building("a"), building("b")])
    before = store.revisions()
    store.write(building("a"))
    after = store.revisions()
    assert before.keys() == after.keys() == {"a", "b"}
    assert before["b"] == after["b"] != None  # noqa: E711 (all three at once)
    assert len({*before.values(), *after.values()}) == 3
    assert store.read("a").attributes == building("a").attributes


def test_readers_see_whole_buildings_while_a_writer_replaces_them(store: Store) -> None:
    sizes = (40, 41)
    store.write(building("a", rooms=sizes[0]))
    done = threading.Event()
    seen: list[int] = []
    failed: list[BaseException] = []

    def read() -> None:
        try:
            while not done.is_set():
                graph = store.read("a")
                rooms = [node.properties["area"] for node in graph.of_label("Room")]
                assert rooms == [float(len(rooms))] * len(rooms)
                assert len(list(graph.of_type("HAS_ROOM"))) == len(rooms)
                assert len(set(next(store.rows(COUNTING[store.dialect], {})))) == 1
                seen.append(len(rooms))
        except BaseException as error:
            failed.append(error)

    readers = [threading.Thread(target=read) for _ in range(2)]
    for reader in readers:
        reader.start()
    for number in range(12):
        store.write(building("a", rooms=sizes[(number + 1) % 2]))
    done.set()
    for reader in readers:
        reader.join()
    assert not failed
    assert set(seen) <= set(sizes)
    assert seen


def test_writers_take_turns(store: Store) -> None:
    failed: list[BaseException] = []

    def write(name: str) -> None:
        try:
            for rooms in range(1, 4):
                store.write(building(name, rooms=rooms))
                store.write(building("shared", rooms=rooms))
        except BaseException as error:
            failed.append(error)

    writers = [threading.Thread(target=write, args=(f"w{number}",)) for number in range(3)]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    assert not failed
    assert [(s.id, s.rooms) for s in store.buildings()] == [("shared", 3), ("w0", 3), ("w1", 3), ("w2", 3)]
    assert store.read("shared") == building("shared")


def test_a_building_goes_from_store_to_store_and_back(store: Store, hotel: BuildingGraph, tmp_path: Path) -> None:
    store.write(hotel)
    with open_store(f"sqlite:{tmp_path / 'other.db'}") as other:
        other.write(store.read("hotel"))
        store.remove("hotel")
        store.write(other.read("hotel"))
        assert store.read("hotel") == other.read("hotel") == hotel
        assert b"".join(encode(store.read("hotel"))) == b"".join(encode(other.read("hotel")))


def without_cloud(graph: BuildingGraph) -> BuildingGraph:
    """The same graph without the file name of its cloud, which each store chooses for itself."""
    graph.nodes[graph.building].properties.pop("cloud", None)
    return graph


def test_stores_that_share_a_folder_keep_their_own_clouds(store: Store, hotel: BuildingGraph, tmp_path: Path) -> None:
    cloud = LabelledCloud(np.eye(3), *(np.arange(3, dtype=np.int32) for _ in range(5)))
    here = Archive(store, tmp_path)
    here.save(hotel, cloud)
    with open_store(f"sqlite:{tmp_path / 'copy.db'}") as other:
        there = Archive(other, tmp_path)
        copy_buildings(here, there)
        here.remove("hotel")
        assert there.cloud("hotel") is not None


def test_a_building_that_is_refused_leaves_the_clouds_as_they_were(
    store: Store, hotel: BuildingGraph, tmp_path: Path
) -> None:
    cloud = LabelledCloud(np.eye(3), *(np.arange(3, dtype=np.int32) for _ in range(5)))
    archive = Archive(store, tmp_path)
    archive.save(hotel, cloud)
    files = list(tmp_path.iterdir())
    hotel.nodes["hotel"].properties["name"] = "\ud800"
    with pytest.raises(GraphError, match="half a character"):
        archive.save(hotel, LabelledCloud(np.eye(3) * 2, *(np.arange(3, dtype=np.int32) for _ in range(5))))
    assert list(tmp_path.iterdir()) == files
    assert archive.cloud("hotel") is not None


def test_a_copy_takes_the_clouds_along(store: Store, hotel: BuildingGraph, tmp_path: Path) -> None:
    labels = {name: np.arange(3, dtype=np.int32) for name in ("storey", "room", "object", "plane", "scan")}
    cloud = LabelledCloud(positions=np.eye(3), **labels)
    source = Archive(store, tmp_path / "source")
    source.save(hotel, cloud)
    store.write(building("annexe"))
    with open_store(f"sqlite:{tmp_path / 'copy.db'}") as other:
        target = Archive(other, tmp_path / "target")
        with pytest.raises(NotFoundError, match="nowhere"):
            copy_buildings(source, target, ["hotel", "nowhere"])
        assert other.buildings() == []
        assert copy_buildings(source, target) == ["annexe", "hotel"]
        assert without_cloud(other.read("hotel")) == without_cloud(store.read("hotel")) == without_cloud(hotel)
        copied = target.cloud("hotel")
        assert copied is not None
        assert np.array_equal(copied.positions, cloud.positions)
        assert target.cloud("annexe") is None


def test_the_address_opens_the_same_store(store: Store, hotel: BuildingGraph, request: pytest.FixtureRequest) -> None:
    store.write(hotel)
    ask = None
    if store.dialect == "cypher":
        password = request.getfixturevalue("neo4j_server").password
        ask = lambda _: password  # noqa: E731
    with open_store(store.url, create=False, ask=ask) as again:
        assert again.url == store.url
        assert again.read("hotel") == hotel
