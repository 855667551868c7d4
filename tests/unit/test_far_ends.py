"""Pieces of floor that only other rooms' scanners saw well belong to the room that looks along at them."""

from __future__ import annotations

import numpy as np
import pytest

from enfilade.ingest.far_ends import give_far_ends

FLOOR = np.array([[x, y, 0.0] for x in np.arange(14.0, 16.0, 0.2) for y in (0.4, 0.8, 1.2)], np.float32)
CORRIDOR, OFFICE = 0, 1


class Walls:
    """Structure with one wall, closed over its doors, along y = 1.6 and another across the corridor at some x."""

    def __init__(self, across: float = np.inf, until: float = np.inf) -> None:
        self.across, self.until = across, until

    def blocked(self, starts, ends):
        through_side = (starts[:, 1] - 1.6) * (ends[:, 1] - 1.6) < 0.0
        through_end = (starts[:, 0] - self.across) * (ends[:, 0] - self.across) < 0.0
        return through_side | (through_end & (starts[:, 1] < self.until))


def given(structure: Walls, *, viewpoint=(2.0, 0.8, 2.3), floor: float = 0.0, asked: bool = True) -> int:
    room = np.full(1, -1, np.int32)
    viewpoints = np.array([viewpoint, (15.0, 3.0, 2.3)], np.float32)
    scan_room, floors = np.array([CORRIDOR, OFFICE], np.int32), np.array([floor, 0.0])
    component, chosen = np.zeros(len(FLOOR), np.int32), np.array([asked])
    limits = {"along_m": 25.0, "step_m": 0.5, "least_in_sight": 0.5}
    give_far_ends(room, FLOOR, component, chosen, scan_room, floors, viewpoints, structure, **limits)
    return int(room[0])


def test_the_far_end_of_a_corridor_is_of_the_corridor_that_looks_along_at_it() -> None:
    assert given(Walls()) == CORRIDOR


@pytest.mark.parametrize(
    "why",
    [
        pytest.param({"structure": Walls(across=10.0)}, id="a wall between"),
        pytest.param({"structure": Walls(across=10.0, until=1.0)}, id="most of it hidden"),
        pytest.param({"structure": Walls(), "viewpoint": (-15.0, 0.8, 2.3)}, id="too far"),
        pytest.param({"structure": Walls(), "floor": -3.0}, id="of another storey"),
        pytest.param({"structure": Walls(), "asked": False}, id="not asked"),
    ],
)
def test_what_no_room_looks_along_at_is_of_none(why: dict) -> None:
    assert given(**why) == -1


def test_a_piece_that_has_a_room_keeps_it() -> None:
    room = np.array([OFFICE], np.int32)
    viewpoints = np.array([(2.0, 0.8, 2.3)], np.float32)
    component, chosen = np.zeros(len(FLOOR), np.int32), np.array([True])
    limits = {"along_m": 25.0, "step_m": 0.5, "least_in_sight": 0.5}
    give_far_ends(room, FLOOR, component, chosen, np.array([CORRIDOR]), np.zeros(1), viewpoints, Walls(), **limits)
    assert room.tolist() == [OFFICE]
