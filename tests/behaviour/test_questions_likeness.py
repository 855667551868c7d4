"""LIKE a mesh, a cloud, a stored object: foot on foot, at a height, and where descriptors are missing."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from enfilade.descriptors import DEFAULT_LAYOUT, describe
from enfilade.errors import QuestionError, StoreError
from enfilade.queries import Connection, answer
from enfilade.schema.graph import BuildingGraph
from enfilade.stores import Store

BOX = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
FACES = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]


def box_points(size: tuple[float, float, float], foot: float) -> np.ndarray:
    """Points on the sides and the top of a box, 2 cm apart."""
    steps = [np.arange(0, length + 1e-9, 0.02) for length in size]
    points = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)
    on_side = (points[:, :2] < 1e-9).any(axis=1) | (points[:, :2] > np.array(size[:2]) - 0.021).any(axis=1)
    on_top = points[:, 2] > size[2] - 0.021
    return points[on_side | on_top] + (3.0, 4.0, foot)


def write_box(path: Path, size: tuple[float, float, float]) -> Path:
    lines = ["v {} {} {}".format(*(corner * size)) for corner in BOX]
    lines += ["f {} {} {} {}".format(*face) for face in FACES]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


CRATE, SHELF = (0.6, 0.6, 0.5), (1.2, 0.3, 1.7)


@pytest.fixture
def furnished(sqlite_store: Store) -> Store:
    graph = BuildingGraph("b", descriptor_shape=DEFAULT_LAYOUT.shape)
    graph.add_node("b", "Building")
    graph.add_node("b/r0", "Room", area=12.0)
    for number, (size, foot) in enumerate([(CRATE, 0.0), (CRATE, 0.9), (SHELF, 0.0)]):
        points = box_points(size, foot)
        graph.add_node(
            f"b/o{number}",
            "Object",
            parts=1,
            floor_offset=foot,
            descriptor=describe(points, 0.0, DEFAULT_LAYOUT),
            foot_descriptor=describe(points, foot, DEFAULT_LAYOUT) if number < 2 else None,
        )
        graph.add_edge("b/r0", "CONTAINS", f"b/o{number}")
    sqlite_store.write(graph)
    return sqlite_store


def scores(store: Store, text: str, crate: Path) -> dict[str, float]:
    rows = answer(store, f"MATCH (o:Object {text}) RETURN o, score", likenesses={"crate": crate}).rows
    return {row["o"]: row["score"] for row in rows}


def test_a_mesh_is_compared_foot_on_foot(furnished: Store, tmp_path: Path) -> None:
    found = scores(furnished, "LIKE $crate", write_box(tmp_path / "crate.obj", CRATE))

    assert list(found)[2] == "b/o2"  # it has no foot descriptor; the other one takes its place
    assert found["b/o0"] == pytest.approx(found["b/o1"], abs=0.05)
    assert found["b/o0"] > -0.3 > -0.8 > found["b/o2"]


def test_at_sets_a_mesh_at_a_height(furnished: Store, tmp_path: Path) -> None:
    crate = write_box(tmp_path / "crate.obj", CRATE)

    on_floor, on_table = scores(furnished, "LIKE $crate AT 0", crate), scores(furnished, "LIKE $crate AT 0.9", crate)
    anywhere = scores(furnished, "LIKE $crate AT 0..0.9 WITHIN 0.4", crate)

    assert on_floor["b/o0"] > -0.3 > -0.8 > on_floor["b/o1"]
    assert on_table["b/o1"] > -0.3 > -0.8 > on_table["b/o0"]
    assert anywhere.keys() == {"b/o0", "b/o1"}


def test_a_path_a_literal_and_a_parameter_ask_alike(furnished: Store, tmp_path: Path) -> None:
    crate = write_box(tmp_path / "crate.obj", CRATE)
    with Connection(furnished) as connection:
        by_name = connection.query("MATCH (o:Object LIKE $x) RETURN o, score", x=crate)
        written = connection.query(f"MATCH (o:Object LIKE '{crate}') RETURN o, score")
        by_text = connection.query("MATCH (o:Object LIKE $x) RETURN o, score", x=str(crate))

    assert by_name.rows == written.rows == by_text.rows
    assert by_name.to_pandas()["o"].tolist() == [row["o"] for row in by_name.rows]
    assert "ids" not in by_name.explain
    assert by_name.explanation.counts["matches"] == 3
    assert json.loads(json.dumps(by_name.explanation.to_dict()))["steps"][0]["rows"] == 3


def test_within_includes_its_limit_and_like_is_the_distance(furnished: Store) -> None:
    distance = answer(
        furnished,
        "MATCH (o:Object {id: 'b/o1'}) RETURN like(o, object('b/o0')) AS d, like(o, $x) AS e",
        likenesses={"x": "object:b/o1"},
    ).rows[0]
    at_limit = answer(
        furnished,
        "MATCH (o:Object LIKE object('b/o0') WITHIN $d) WHERE like(o, object('b/o0')) > 0 RETURN o",
        parameters={"d": distance["d"]},
    )

    assert distance["e"] == 0
    assert "b/o1" in [row["o"] for row in at_limit.rows]


def test_at_is_refused_for_a_stored_object(furnished: Store) -> None:
    with pytest.raises(QuestionError, match="height of a stored object is known"):
        answer(furnished, "MATCH (o:Object LIKE object('b/o0') AT 1) RETURN o")
    with pytest.raises(QuestionError, match="height of a stored object is known"):
        answer(furnished, "MATCH (o:Object LIKE $x AT 1) RETURN o", likenesses={"x": "object:b/o0"})


def test_the_time_limit_is_one_sentence(furnished: Store) -> None:
    nodes = ", ".join(f"(a{i}:Object), (b{i}:Room)" for i in range(2))
    assert answer(furnished, f"MATCH {nodes} RETURN ALL count(*)", timeout_s=30).rows == [{"count(*)": 0}]
    big = BuildingGraph("big")
    big.add_node("big", "Building")
    for number in range(300):
        big.add_node(f"big/r{number}", "Room", area=float(number))
    furnished.write(big)

    with pytest.raises(StoreError, match=r"took longer than 0\.2 s"):
        answer(
            furnished,
            "MATCH (a:Room), (b:Room), (c:Room), (d:Room) WHERE a.area + 1 < b.area RETURN ALL count(*)",
            timeout_s=0.2,
        )
