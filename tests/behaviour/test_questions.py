"""The worked questions on the hotel, on every store: the rows, their order, the scores."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from enfilade.queries import answer
from enfilade.schema.graph import BuildingGraph
from enfilade.stores import Store

WORKED = json.loads((Path(__file__).parents[1] / "questions" / "hotel.json").read_text(encoding="utf-8"))

# A descriptor in the store is counts that sum to 61440; thirds and fifths come back exactly, sevenths do not.
QUANTISATION = 2e-5


@pytest.mark.parametrize("worked", WORKED, ids=[worked["why"] for worked in WORKED])
def test_worked_question(store: Store, hotel: BuildingGraph, worked: dict[str, Any]) -> None:
    store.write(hotel)

    result = answer(store, worked["question"])

    assert result.rows == [approximately(row) for row in worked["rows"]]


def approximately(row: dict[str, Any]) -> dict[str, Any]:
    return {
        name: pytest.approx(value, abs=QUANTISATION) if isinstance(value, float) else value
        for name, value in row.items()
    }
