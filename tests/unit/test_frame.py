"""Unit and vertical axis: found from how scanners stand in rooms, said, and settable."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from enfilade.ingest.readers.frame import UNITS, in_metres
from enfilade.ingest.records import Chunk, Scan

ROOMS = ((4.0, 3.0, 2.5, 1.6), (9.0, 6.0, 3.1, 1.7), (2.0, 2.2, 2.4, 1.4), (14.0, 2.1, 2.6, 1.65))


def room(width: float, depth: float, height: float, scanner: float, seed: int = 0, *, blind: bool = True) -> np.ndarray:
    """What a scanner in the middle of a box sees, relative to it: no floor within 30° of straight down."""
    directions = np.random.default_rng(seed).normal(size=(8000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    if blind:
        directions = directions[directions[:, 2] > -0.86]
    high = np.array([0.4 * width, 0.55 * depth, height - scanner])
    low = np.array([-0.6 * width, -0.45 * depth, -scanner])
    with np.errstate(divide="ignore"):
        reach = np.where(directions > 0.0, high / directions, low / directions)
    return directions * reach.min(axis=1, keepdims=True)


def scans(rooms: Sequence[tuple[float, ...]], unit: str = "m", up: str = "z", *, blind: bool = True) -> list[Scan]:
    made = []
    for number, sizes in enumerate(rooms):
        place = np.array([20.0 * number, 3.0, 1.6])
        points = room(*sizes, seed=number, blind=blind) + place
        if up == "y":
            points, place = points[:, [0, 2, 1]] * [1.0, 1.0, -1.0], place[[0, 2, 1]] * [1.0, 1.0, -1.0]
        made.append(Scan.of_points(f"scan {number}", "a.e57", points / UNITS[unit], place / UNITS[unit]))
    return made


def brought(given: list[Scan], units: str = "auto", up: str = "auto") -> tuple[np.ndarray, list[str]]:
    said: list[str] = []
    points = [chunk.positions for scan in in_metres(given, units, up, said.append) for chunk in scan.chunks]
    return np.concatenate(points), said


@pytest.mark.parametrize("rooms", [ROOMS, ROOMS[:1], ROOMS[1:2], ROOMS[2:3], ROOMS[3:]])
@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("up", ["z", "y"])
def test_units_and_the_vertical_axis_are_found(rooms: Sequence[tuple[float, ...]], unit: str, up: str) -> None:
    truth, _ = brought(scans(rooms), "m", "z")
    found, said = brought(scans(rooms, unit, up))
    assert np.abs(found - truth).max() < 1e-9
    assert len(said) == (unit != "m") + (up != "z")
    names = {"mm": "millimetres", "cm": "centimetres", "ft": "feet", "in": "inches"}
    assert unit == "m" or f"in {names[unit]}" in said[0]
    assert up == "z" or "y is up" in said[-1]


def test_a_scanner_without_a_blind_cone_is_understood_too() -> None:
    truth, _ = brought(scans(ROOMS), "m", "z")
    for unit in UNITS:
        found, _ = brought(scans(ROOMS, unit, blind=False))
        assert np.ptp(found, axis=0) == pytest.approx(np.ptp(truth, axis=0), rel=0.02)


@pytest.mark.parametrize("hall", [(40.0, 25.0, 12.0, 1.7), (30.0, 30.0, 8.0, 2.4), (3.0, 3.0, 2.3, 0.8)])
def test_halls_and_low_tripods_stay_metres(hall: tuple[float, ...]) -> None:
    assert brought(scans([hall]))[1] == []


def test_what_is_set_is_taken() -> None:
    points, said = brought(scans(ROOMS, "mm"), "m", "z")
    assert said == []
    assert np.ptp(points, axis=0).max() > 10_000.0
    points, said = brought(scans(ROOMS), "ft", "y")
    assert np.ptp(points, axis=0).max() < 30.0
    assert said == []


def test_scans_larger_than_the_first_look_are_handed_on_whole() -> None:
    points = np.concatenate([room(*ROOMS[0], seed=seed) for seed in range(400)])
    chunks = iter([Chunk(part) for part in np.array_split(points, 40)])
    large = Scan("large", "a.e57", chunks, np.zeros(3))
    after = scans(ROOMS)
    found = list(in_metres(iter([large, *after]), "auto", "auto", lambda sentence: None))
    assert [scan.name for scan in found] == ["large", *(scan.name for scan in after)]
    assert sum(len(chunk.positions) for chunk in found[0].chunks) == len(points)


def test_no_scans_are_no_trouble() -> None:
    assert list(in_metres([], "auto", "auto", lambda sentence: None)) == []
