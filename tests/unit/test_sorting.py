"""Sorting: long arrays come out as NumPy sorts them, whatever their digits."""

from __future__ import annotations

import numpy as np
import pytest

from enfilade.ingest.sorting import sort_above
from enfilade.ingest.voxels import _in_order
from enfilade.parallel import in_slices, slices, taken


@pytest.mark.parametrize("bits", [0, 1, 11, 12, 23, 44])
@pytest.mark.parametrize("count", [0, 1, 1000, 150_000])
def test_numbers_above_an_index_are_sorted(count: int, bits: int) -> None:
    index_bits = 18
    keys = np.random.default_rng(count + bits).integers(0, 1 << bits, count)
    numbers = (keys << index_bits) | np.arange(count)
    assert np.array_equal(sort_above(numbers.copy(), index_bits, bits), np.sort(numbers))


@pytest.mark.parametrize("reach", [3, 5000, 1 << 18])
def test_blocks_around_the_origin_or_far_from_it_are_ordered_by_their_numbers(reach: int) -> None:
    rng = np.random.default_rng(reach)
    index = rng.integers(-reach, reach, (140_000, 3)) + (1 << 19)
    blocks = np.zeros(len(index), np.int64)
    for bit in range(20):
        for axis in range(3):
            blocks |= ((index[:, axis] >> bit) & 1) << (3 * bit + 2 - axis)
    blocks = np.unique(blocks)
    rng.shuffle(blocks)
    assert np.array_equal(_in_order(blocks), np.argsort(blocks))


def test_slices_make_up_the_range() -> None:
    for count in (0, 1, 7, 1000):
        assert [i for first, past in slices(count) for i in range(first, past)] == list(range(count))
        assert sum(in_slices(lambda first, past: past - first, count)) == count


def test_rows_are_taken_by_index_and_minus_one_is_the_last() -> None:
    values = np.arange(12, dtype=np.float32).reshape(4, 3)
    index = np.array([3, 0, -1, 1, 1], np.int32)
    assert np.array_equal(taken(values, index), values[index])
    assert np.array_equal(taken(values[:, 0].copy(), index), values[index, 0])
