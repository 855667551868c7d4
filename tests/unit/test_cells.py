"""Cells: what has equal keys comes together, in order, whatever the keys."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from enfilade.ingest.cells import CellGrid, Gathered, extent, members_of, tile_rectangles

KEYS = st.one_of(st.integers(0, 5), st.integers(0, 2**63 - 1))


@given(arrays(np.int64, st.integers(0, 60), elements=KEYS))
def test_equal_keys_come_together_in_their_old_order(keys: np.ndarray) -> None:
    found = Gathered.by(keys)
    assert found.order.tolist() == np.argsort(keys, kind="stable").tolist()
    assert found.keys.tolist() == np.unique(keys).tolist()
    groups = [keys[found.order[a:b]].tolist() for a, b in zip(found.bounds, found.bounds[1:], strict=False)]
    assert groups == [[key] * int((keys == key).sum()) for key in found.keys]
    assert len(found) == len(found.keys) == len(found.bounds) - 1


@given(arrays(np.float32, st.tuples(st.integers(1, 40), st.just(3)), elements=st.floats(-50.0, 50.0, width=32)))
def test_keys_tell_cells_apart_and_layers_first(positions: np.ndarray) -> None:
    layer = (np.arange(len(positions)) % 2).astype(np.int32)
    grid = CellGrid.around(positions, 0.25)
    cells = np.column_stack([layer, np.floor(positions.astype(np.float64) / 0.25)])
    keys = grid.keys(positions, layer)
    assert np.array_equal(keys[:, None] == keys[None, :], (cells[:, None] == cells[None, :]).all(axis=2))
    assert cells[np.argsort(keys, kind="stable")].tolist() == cells[np.lexsort(cells.T[::-1])].tolist()


@given(arrays(np.float32, st.tuples(st.integers(1, 40), st.integers(1, 3)), elements=st.floats(-9.0, 9.0, width=32)))
def test_extent_is_the_least_and_greatest_coordinate_of_each_axis(positions: np.ndarray) -> None:
    low, high = extent(positions)
    assert low.tolist() == positions.min(axis=0).tolist()
    assert high.tolist() == positions.max(axis=0).tolist()


@given(arrays(bool, st.tuples(st.integers(1, 12), st.integers(1, 12))))
def test_rectangles_tile_exactly_the_cells_that_are_true(cells: np.ndarray) -> None:
    covered = np.zeros(cells.shape, int)
    for row, past_row, column, past_column in tile_rectangles(cells):
        covered[row:past_row, column:past_column] += 1
    assert np.array_equal(covered, cells.astype(int))


@given(arrays(np.int32, st.integers(0, 50), elements=st.integers(-1, 6)))
def test_members_of_a_number_are_where_it_stands(numbers: np.ndarray) -> None:
    found = members_of(numbers, 7)
    assert [where.tolist() for where in found] == [np.flatnonzero(numbers == number).tolist() for number in range(7)]


@given(
    arrays(np.float32, st.tuples(st.integers(1, 20), st.just(3)), elements=st.floats(-2.0, 2.0, width=32)),
    arrays(np.float64, st.tuples(st.integers(0, 40), st.just(3)), elements=st.floats(-4.0, 4.0)),
)
def test_a_cell_is_among_others_whether_or_not_it_lies_in_the_box(known: np.ndarray, asked: np.ndarray) -> None:
    grid = CellGrid.around(known, 0.5)
    keys, asked = Gathered.by(grid.keys(known)).keys, np.concatenate([asked, known])
    cells = {tuple(cell) for cell in np.floor(known.astype(np.float64) / 0.5).astype(int).tolist()}
    assert grid.among(keys, asked).tolist() == [tuple(c) in cells for c in np.floor(asked / 0.5).astype(int).tolist()]
