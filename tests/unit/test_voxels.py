"""The set of voxels: threads, room to grow and far corners change nothing of what is kept."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from enfilade.ingest import shards as shards_of
from enfilade.ingest.records import Chunk
from enfilade.ingest.voxels import VoxelPoints, VoxelSet

SCANNERS = np.array([[0.0, 0.0, 1.5], [2.0, 0.0, 1.5], [0.0, 3.0, 1.5]])
FIRST_ROOM = 16


@pytest.fixture(autouse=True)
def little_room(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shards_of, "_FIRST_ROOM", FIRST_ROOM)
    monkeypatch.setattr(shards_of, "_FIRST_PLACES", 64)


def chunks(seed: int, spread_m: float) -> list[tuple[Chunk, int]]:
    """Points of three scans, each with its number; some repeat the first one's, which has no colour."""
    rng = np.random.default_rng(seed)
    made = []
    for scan in range(3):
        points = rng.uniform(-spread_m, spread_m, (rng.integers(1, 400), 3))
        if scan and rng.random() < 0.5:
            points[: len(made[0][0].positions)] = made[0][0].positions[: len(points)]
        value = rng.random(len(points)).astype(np.float32)
        made.append((Chunk(points, value, (255 * points[:, :3]).astype(np.uint8)) if scan else Chunk(points), scan))
    return made


def put_in(parts: list[tuple[Chunk, int]], shards: int) -> tuple[VoxelPoints, list[int], list[int]]:
    points = VoxelSet(0.01, np.zeros(3), shards)
    held, copies = np.zeros(3, np.int64), np.zeros(3, np.int64)
    for chunk, scan in parts:
        assert points.add(chunk, scan, SCANNERS, held, copies)
    return points.finish(), held.tolist(), copies.tolist()


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=40)
@given(st.integers(0, 10_000), st.sampled_from((0.05, 1.0, 5000.0)), st.integers(2, 7))
def test_the_number_of_threads_changes_nothing(seed: int, spread_m: float, shards: int) -> None:
    parts = chunks(seed, spread_m)
    (one, *counts), (other, *its_counts) = put_in(parts, 1), put_in(parts, shards)
    assert counts == its_counts
    assert sum(counts[0]) == len(one.positions)
    assert np.array_equal(one.positions, other.positions)
    assert np.array_equal(one.scan, other.scan)
    assert np.array_equal(one.intensity, other.intensity, equal_nan=True)
    assert np.array_equal(one.colour, other.colour)


@pytest.mark.parametrize("shards", [1, 4])
def test_there_is_room_for_more_than_at_first(shards: int) -> None:
    points = np.random.default_rng(3).uniform(0.0, 3.0, (5_000, 3))
    kept, held, _ = put_in([(Chunk(points), 0)], shards)
    cells = np.unique(np.floor(points.astype(np.float32).astype(np.float64) / 0.01), axis=0)
    assert len(kept.positions) == len(cells) == held[0]
    assert len(cells) > 10 * FIRST_ROOM


@given(st.integers(0, 10_000), st.sampled_from((0.05, 5000.0)))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=20)
def test_blocks_come_in_order_of_their_morton_numbers(seed: int, spread_m: float) -> None:
    kept, _, _ = put_in(chunks(seed, spread_m), 3)
    cells = np.floor(kept.positions.astype(np.float64) / 0.01).astype(np.int64) + (1 << 20)
    numbers = [
        sum((int(cell[2 - axis]) >> bit & 1) << (3 * bit + axis) for bit in range(21) for axis in range(3))
        for cell in cells
    ]
    assert numbers == sorted(numbers)


@pytest.mark.parametrize("shards", [1, 3])
def test_a_point_out_of_reach_is_refused_by_all_threads(shards: int) -> None:
    points = VoxelSet(0.01, np.zeros(3), shards)
    far = np.array([[0.0, 0.0, 0.0], [points.reach_m + 1.0, 0.0, 0.0]])
    assert not points.add(Chunk(far), 0, SCANNERS, np.zeros(3, np.int64), np.zeros(3, np.int64))
