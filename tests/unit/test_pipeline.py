"""The pipeline as a whole on scans that show next to nothing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pye57
import pytest

from enfilade.errors import InputError
from enfilade.ingest.pipeline import ingest

SCANNER = np.array([1.0, 2.0, 1.6])


def scan(path: Path, points: np.ndarray) -> Path:
    columns = {f"cartesian{axis}": np.ascontiguousarray(points[:, i]) for i, axis in enumerate("XYZ")}
    with pye57.E57(str(path), mode="w") as file:
        file.write_scan_raw(columns, name="Scan", rotation=np.array([1.0, 0.0, 0.0, 0.0]), translation=SCANNER)
    return path


@pytest.mark.parametrize("points", [np.random.default_rng(0).random((1000, 3)), np.ones((1, 3)), np.ones((1000, 3))])
def test_scans_without_any_plane_are_refused(points: np.ndarray, tmp_path: Path) -> None:
    path = scan(tmp_path / "few.e57", points)
    with pytest.raises(InputError, match=r"few\.e57 show no walls, floors or ceilings"):
        ingest([path], building="few")


@pytest.mark.parametrize(("name", "kept"), [(None, "floor"), ("'; MATCH (n) DETACH DELETE n //\n🏠", None), ("", None)])
def test_a_building_is_named_as_one_likes(name: str | None, kept: str | None, tmp_path: Path) -> None:
    floor = np.random.default_rng(0).random((20_000, 3)) * [3, 3, 0] - [1.5, 1.5, 1.6]
    graph = ingest([scan(tmp_path / "floor.e57", floor)], building="floor", name=name).graph
    assert graph.nodes["floor"].properties["name"] == (name if kept is None else kept)
