"""Storeys: bins of floor elevation, whatever the order of the rooms."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from enfilade.ingest.records import Room
from enfilade.ingest.storeys import StoreyParameters, find_storeys


def room(number: int, floor: float, area: float = 10.0) -> Room:
    return Room(number, area, floor, floor + 2.5, np.zeros(3), np.zeros(6), (), 0, (), 1.0, 0)


def test_floors_close_together_are_one_storey_from_the_lowest_up() -> None:
    storeys = find_storeys([room(0, 3.0), room(1, 0.0), room(2, 0.15), room(3, 6.1), room(4, 2.9)])
    assert [storey.index for storey in storeys] == [0, 1, 2]
    assert [storey.rooms for storey in storeys] == [(1, 2), (0, 4), (3,)]


def test_a_storeys_elevation_is_that_of_most_of_its_floor_area() -> None:
    (storey,) = find_storeys([room(0, 0.0, 5.0), room(1, 0.4, 50.0), room(2, 0.6, 5.0)])
    assert storey.elevation == 0.4


def test_half_a_storey_up_is_another_storey() -> None:
    assert len(find_storeys([room(0, 0.0), room(1, 1.4), room(2, 2.8)])) == 3


@given(st.permutations(range(8)), st.lists(st.floats(-10, 30), min_size=8, max_size=8))
def test_bins_hold_every_room_once_are_no_wider_than_asked_and_know_no_order(
    order: list[int], floors: list[float]
) -> None:
    rooms = [room(number, floor) for number, floor in enumerate(floors)]
    storeys = find_storeys(rooms, StoreyParameters(bin_m=1.0))
    assert sorted(number for storey in storeys for number in storey.rooms) == list(range(8))
    assert all(max(floors[n] for n in s.rooms) - min(floors[n] for n in s.rooms) <= 1.0 for s in storeys)
    assert find_storeys([rooms[number] for number in order], StoreyParameters(bin_m=1.0)) == storeys


def test_no_rooms_have_no_storeys() -> None:
    assert find_storeys([]) == ()
