"""Thinning: one point a voxel, the one nearest its scanner, whatever the order of scans and points."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from enfilade.errors import InputError
from enfilade.ingest.records import Chunk, Scan, ThinnedCloud
from enfilade.ingest.thinning import ThinningParameters, thin

VOXEL = 0.01
clouds = arrays(np.float64, st.tuples(st.integers(1, 60), st.just(3)), elements=st.floats(-0.0625, 0.0625, width=32))
several = st.lists(clouds, min_size=1, max_size=5)


def scan(points: np.ndarray, number: int = 0) -> Scan:
    return Scan.of_points(f"scan {number}", "a.e57", points, np.array([number + 1.0, 0.5, 1.5]))


def voxels(positions: np.ndarray) -> np.ndarray:
    return np.floor(positions.astype(np.float64) / VOXEL).astype(np.int64)


def kept(cloud: ThinnedCloud) -> set[tuple[float, ...]]:
    return {tuple(point) for point in cloud.positions.tolist()}


@given(several)
def test_every_voxel_that_held_points_keeps_exactly_one_of_them(parts: list[np.ndarray]) -> None:
    cloud = thin([scan(points, number) for number, points in enumerate(parts)])
    everything = np.concatenate(parts).astype(np.float32)
    assert len(np.unique(voxels(cloud.positions), axis=0)) == len(cloud.positions)
    assert len(cloud.positions) == len(np.unique(voxels(everything), axis=0))
    assert kept(cloud) <= {tuple(point) for point in everything.tolist()}
    assert cloud.raw_count == len(everything)


@given(several, st.randoms(use_true_random=False))
def test_order_of_scans_and_points_changes_nothing(parts: list[np.ndarray], random: object) -> None:
    scans = [scan(points, number) for number, points in enumerate(parts)]
    shuffled = [cut(s, 1 + random.randrange(9)) for s in scans]
    random.shuffle(shuffled)
    one, other = thin(shuffled), thin(scans)
    assert one.positions.tolist() == other.positions.tolist()
    assert one.scan_names == other.scan_names
    assert one.scan.tolist() == other.scan.tolist()
    assert one.scanner_positions.tolist() == other.scanner_positions.tolist()


def test_scans_are_numbered_by_name_as_people_count() -> None:
    cloud = thin([scan(np.full((1, 3), 0.1 * number), number) for number in (10, 9, 1)])
    assert cloud.scan_names == ("scan 1", "scan 9", "scan 10")
    assert cloud.read_as.tolist() == [2, 1, 0]


def cut(whole: Scan, size: int) -> Scan:
    """The same scan in small chunks, the last point first."""
    (chunk,) = whole.chunks
    points = chunk.positions[::-1]
    chunks = [Chunk(points[start : start + size]) for start in range(0, len(points), size)]
    return Scan(whole.name, whole.source, chunks, whole.scanner_position)


class Notes:
    """Keeps what is said."""

    def __init__(self) -> None:
        self.said: list[str] = []

    def start(self, stage: str, total: float | None = None) -> None:
        pass

    def advance(self, amount: float = 1.0) -> None:
        pass

    def note(self, sentence: str) -> None:
        self.said.append(sentence)


def room(seed: int, count: int = 3000) -> np.ndarray:
    return np.random.default_rng(seed).uniform(0.0, 1.0, (count, 3))


def test_a_copy_of_a_scan_is_said_and_used_once() -> None:
    first, second = scan(room(0), 0), scan(room(1), 1)
    copy = Scan.of_points("again", "b.e57", room(1)[::-1] + 1e-6, second.scanner_position)
    notes = Notes()
    cloud = thin([first, second, copy], progress=notes)
    assert notes.said == ["scan 'again' of b.e57 repeats scan 'scan 1' of a.e57: it was used once"]
    assert cloud.scan_names == ("scan 0", "scan 1")
    assert cloud.raw_count == 6000
    assert cloud.scan.max() == 1
    assert len(cloud.scanner_positions) == 2


def test_scans_of_the_same_room_are_no_copies() -> None:
    floor = np.random.default_rng(0).uniform(0.0, 0.5, (40_000, 3)) * [1.0, 1.0, 0.0]
    noise = np.random.default_rng(1).normal(0.0, 0.002, (2, 40_000, 3))
    notes = Notes()
    thin([scan(floor + noise[0], 0), scan(floor[::-1] + noise[1], 1)], progress=notes)
    assert notes.said == []


def test_parts_of_a_scan_are_one_scan() -> None:
    parts = [scan(room(seed), 0) for seed in range(3)]
    cloud = thin([parts[0], scan(room(9), 1), *parts[1:]])
    assert cloud.scan_names == ("scan 0", "scan 1")
    whole = thin([scan(np.concatenate([room(seed) for seed in range(3)]), 0), scan(room(9), 1)])
    assert cloud.positions.tolist() == whole.positions.tolist()
    assert cloud.raw_count == 12_000


def test_scans_of_several_files_that_are_named_alike_keep_their_files_names() -> None:
    parts = [
        Scan.of_points("Setup 1", source, room(seed), np.zeros(3)) for seed, source in enumerate(("a.e57", "b.e57"))
    ]
    assert thin(parts).scan_names == ("a.e57/Setup 1", "b.e57/Setup 1")


def test_intensity_and_colour_stay_with_their_points() -> None:
    points = room(0)
    marked = Chunk(points, points[:, 0].astype(np.float32), (255 * points).astype(np.uint8))
    plain = Chunk(points + 2.0)
    cloud = thin([Scan("a", "a.e57", [marked], np.zeros(3)), Scan("b", "a.e57", [plain], np.zeros(3))])
    first = cloud.scan == 0
    assert np.array_equal(cloud.intensity[first], cloud.positions[first, 0])
    assert np.abs(cloud.colour[first] - 255 * cloud.positions[first]).max() <= 1.001
    assert np.isnan(cloud.intensity[~first]).all()
    assert not cloud.colour[~first].any()
    assert thin([Scan("b", "a.e57", [plain], np.zeros(3))]).intensity is None


def test_more_points_than_the_set_has_room_for_at_first() -> None:
    points = np.random.default_rng(3).uniform(0.0, 3.0, (300_000, 3))
    cloud = thin([scan(points)])
    assert len(cloud.positions) == len(np.unique(voxels(points.astype(np.float32)), axis=0))


def test_the_point_nearest_its_scanner_stays() -> None:
    near = Scan.of_points("near", "a.e57", np.array([[0.001, 0.001, 0.001]]), np.array([1.0, 0.0, 0.0]))
    far = Scan.of_points("far", "a.e57", np.array([[0.002, 0.002, 0.002]]), np.array([9.0, 0.0, 0.0]))
    for order in ([near, far], [far, near]):
        cloud = thin(order)
        assert [cloud.scan_names[index] for index in cloud.scan] == ["near"]


def test_small_coordinates_keep_a_zero_origin() -> None:
    cloud = thin([scan(np.full((1, 3), 400.0))])
    assert cloud.origin.tolist() == [0.0, 0.0, 0.0]


def test_large_coordinates_lose_whole_metres_before_they_are_rounded() -> None:
    here = np.array([466_123.25, 5_410_987.75, 112.5])
    points = here + np.random.default_rng(0).uniform(-2.0, 2.0, (500, 3))
    cloud = thin([Scan.of_points("utm", "a.e57", points, here)])
    assert cloud.origin.tolist() == [466_000.0, 5_411_000.0, 0.0]
    back = cloud.positions + cloud.origin
    assert np.abs(np.sort(back, axis=0) - np.sort(points, axis=0)).max() < 1e-4
    assert np.abs(cloud.scanner_positions).max() <= 500.0


def test_scans_kilometres_apart_are_refused_by_name() -> None:
    far = Scan.of_points("Lobby", "b.e57", np.array([[50_000.0, 0.0, 0.0]]), np.array([50_000.0, 0.0, 1.0]))
    with pytest.raises(InputError, match=r"'Lobby' of b\.e57 lies more than 10 km"):
        thin([scan(np.zeros((1, 3))), far])


def test_no_scans_are_refused() -> None:
    with pytest.raises(InputError, match="no scans"):
        thin([])


def test_the_voxel_size_is_a_parameter() -> None:
    points = np.random.default_rng(1).uniform(0.0, 1.0, (2_000, 3))
    coarse = thin([scan(points)], ThinningParameters(voxel_size_m=0.5))
    assert len(coarse.positions) == 8
