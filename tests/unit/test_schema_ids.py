"""Keys are made and taken apart."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import building_ids

from enfilade.errors import GraphError
from enfilade.schema.ids import Key, check_building, object_id, opening_id, parse, room_id, storey_id

numbers = st.integers(0, 10**9)


@given(building=building_ids, number=numbers, other=st.lists(numbers, min_size=1, max_size=3, unique=True))
def test_a_key_is_taken_apart_as_it_was_made(building: str, number: int, other: list[int]) -> None:
    assert parse(building) == Key(building, "Building", ())
    assert parse(storey_id(building, number)) == Key(building, "Storey", (number,))
    assert parse(room_id(building, number)) == Key(building, "Room", (number,))
    assert parse(opening_id(building, number)) == Key(building, "Opening", (number,))
    assert parse(object_id(building, *other)) == Key(building, "Object", tuple(other))


@pytest.mark.parametrize(
    "id",
    [
        "a/",
        "a/r",
        "a/x1",
        "a/r01",
        "a/r-1",
        "a/r1 ",
        "a/r1+r2",
        "a/o1+2",
        "a/o1+o1",
        "a/o1+o2+o3+o4",
        "a/b/r1",
        "a/r１",
    ],
)
def test_what_is_no_key_is_refused(id: str) -> None:
    with pytest.raises(GraphError):
        parse(id)


@pytest.mark.parametrize("building", ["", "x" * 201, "a/b", "a\nb", "a\x00", "a\x7f", "\x85", "\ud800", 7, None])
def test_what_cannot_be_a_building_is_refused(building: Any) -> None:
    with pytest.raises(GraphError, match="building's id"):
        check_building(building)


@pytest.mark.parametrize("building", ["x", "x" * 200, "'; DROP TABLE x; --", "..", " ", "Zürich 🏠"])
def test_what_can_be_a_building_is_taken(building: str) -> None:
    assert check_building(building) == building
