"""Descriptors: the counts, the bins, and the distance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from enfilade.descriptors import (
    DEFAULT_LAYOUT,
    PAPER_LAYOUT,
    TOTAL,
    Layout,
    best_turn,
    describe,
    describe_votes,
    distances,
    gather_votes,
    quantise,
)

SMALL = Layout(slices=3, slice_height_m=0.5, shells=2, shell_width_m=0.5, sectors=8)

histograms = arrays(np.float64, SMALL.bins, elements=st.floats(0, 1e6)).filter(lambda values: values.sum() > 1e-3)
counts = histograms.map(quantise)


def by_the_book(query, other, shape):
    """Eq. 11 word for word, with *min* for *argmin*."""
    q, o = (np.asarray(d, float).reshape(shape) / TOTAL for d in (query, other))
    least = np.inf
    for shift in range(shape[2]):
        turned = np.roll(o, -shift, axis=2)
        total = q + turned
        terms = np.divide((q - turned) ** 2, total, out=np.zeros(shape), where=total > 0)
        least = min(least, terms.sum())
    return least


def scattered(seed, count=300, spread=0.6):
    """Points in a blob, none close to a border between sectors of 16."""
    rng = np.random.default_rng(seed)
    angle = (rng.integers(0, 16, count) + rng.uniform(0.2, 0.8, count)) * np.pi / 8
    # Each point has its mirror image, so that the mean stays on the axis.
    angle = np.concatenate([angle, angle + np.pi])
    radius = np.tile(rng.uniform(0.05, spread, count), 2)
    height = np.tile(rng.uniform(0, 1.5, count), 2)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])


@given(histograms)
def test_counts_sum_to_the_total_and_stay_within_one_of_the_exact_value(values):
    result = quantise(values)
    assert result.dtype == np.uint16
    assert int(result.sum()) == TOTAL
    assert np.abs(result - values * TOTAL / values.sum()).max() < 1 + 1e-6


@given(counts)
def test_counts_come_back_from_shares(given_counts):
    assert np.array_equal(quantise(given_counts / TOTAL), given_counts)


def test_equal_remainders_are_served_in_order_of_bins():
    assert quantise(np.ones(7)).tolist() == [8778, 8777, 8777, 8777, 8777, 8777, 8777]


@pytest.mark.parametrize("values", [[0.0, 0.0], [1.0, -0.1], [np.nan, 1.0], [np.inf, 1.0], []])
def test_no_histogram_no_counts(values):
    with pytest.raises(ValueError, match="histogram"):
        quantise(np.array(values))


@settings(max_examples=30)
@given(counts, st.lists(counts, min_size=1, max_size=4))
def test_distance_follows_the_equation(query, others):
    found = distances(query, np.stack(others), SMALL.shape)
    expected = [by_the_book(query, other, SMALL.shape) for other in others]
    np.testing.assert_allclose(found, expected, atol=1e-11)


@given(counts, counts)
def test_distance_is_symmetric_and_bounded(a, b):
    there, back = distances(a, b[None], SMALL.shape)[0], distances(b, a[None], SMALL.shape)[0]
    assert there == back
    assert 0 <= there <= 2


@given(counts, st.integers(0, SMALL.sectors - 1))
def test_a_turned_descriptor_is_at_distance_zero(descriptor, shift):
    turned = np.roll(descriptor.reshape(SMALL.shape), shift, axis=2).reshape(1, -1)
    assert distances(descriptor, turned, SMALL.shape)[0] == 0.0


def test_descriptors_that_share_no_bin_are_as_far_apart_as_can_be():
    low, high = np.zeros(SMALL.bins), np.zeros(SMALL.bins)
    low[:8], high[-8:] = 1, 1
    assert distances(quantise(low), quantise(high)[None], SMALL.shape)[0] == 2.0


@given(counts, counts, counts)
def test_of_several_views_the_nearest_counts(a, b, c):
    each = [distances(view, c[None], SMALL.shape)[0] for view in (a, b)]
    assert distances(np.stack([a, b]), c[None], SMALL.shape)[0] == min(each)


def test_a_table_of_many_rows_gives_what_each_row_gives():
    rng = np.random.default_rng(3)
    table = np.stack([quantise(row) for row in rng.random((5000, SMALL.bins))])
    whole = distances(table[0], table, SMALL.shape)
    assert whole[4321] == distances(table[0], table[4321:4322], SMALL.shape)[0]
    assert whole.argmin() == 0


def test_descriptors_of_other_shapes_are_refused():
    with pytest.raises(ValueError, match="do not fit"):
        distances(quantise(np.ones(10)), quantise(np.ones(12))[None], (1, 1, 12))


@settings(max_examples=25)
@given(st.integers(0, 10_000), st.integers(0, 15), st.booleans())
def test_an_object_turned_by_sectors_keeps_its_descriptor(seed, turns, paper):
    layout = Layout(cell_m=0.0, annulus_weight=paper, interpolate=not paper)
    points = scattered(seed)
    angle = turns * np.pi / 8
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    a, b = describe(points, 0.0, layout), describe(points @ turn.T, 0.0, layout)
    # One vote on the border of a shell may fall to either side after the rotation's rounding.
    assert distances(a, b[None], layout.shape)[0] < 0.01


@given(st.integers(0, 10_000), arrays(np.float64, 3, elements=st.integers(-500, 500).map(float)))
@settings(max_examples=25)
def test_a_moved_object_keeps_its_descriptor(seed, way):
    points = scattered(seed)
    here, there = describe(points, 0.0), describe(points + way, way[2])
    assert distances(here, there[None], DEFAULT_LAYOUT.shape)[0] < 0.02


@given(st.integers(0, 1000))
@settings(max_examples=15)
def test_points_beyond_the_bins_count_in_the_nearest(seed):
    points = scattered(seed) * [9, 9, 9] - [0, 0, 5]
    assert int(describe(points, 0.0).sum()) == TOTAL


METRE = Layout(slices=5, slice_height_m=1, shells=4, shell_width_m=1, sectors=8, cell_m=0.0, exponent=1.0)
AROUND = [[1.5, 0, 0], [-0.5, 0.75, 0], [-0.5, -0.75, 0], [-0.5, 0, 0]]


def test_the_box_filter_fills_the_bins_around_a_point():
    layout = replace(METRE, interpolate=False)
    values = describe(np.array([[3.0, 4.0, 2.5]]), 0.0, layout).reshape(layout.shape)
    # The point is its own axis: shell 0, sector 0. Below shell 0 the filter finds shell 0 again.
    assert np.argwhere(values.sum(axis=(1, 2))).ravel().tolist() == [1, 2, 3]
    assert np.argwhere(values.sum(axis=(0, 2))).ravel().tolist() == [0, 1]
    assert np.argwhere(values.sum(axis=(0, 1))).ravel().tolist() == [0, 1, 7]
    ratio = values[2, 0] / np.maximum(values[2, 1], 1)
    assert ratio[[0, 1, 7]] == pytest.approx([2, 2, 2], abs=0.01)


def test_a_vote_is_shared_by_how_near_the_middles_of_bins_are():
    # Four points whose mean is the axis; the first lies in the middle of its shell, on the border of sectors 7 and 0.
    points = np.array(AROUND) * [1, 1, 0] + [7, 8, 1.75]
    values = describe(points, 0.0, METRE).reshape(METRE.shape) * len(points) / TOTAL
    assert values.sum(axis=(1, 2)) == pytest.approx([0, 0.75 * 4, 0.25 * 4, 0, 0], abs=1e-3)
    assert values[1, 1, [7, 0]] == pytest.approx([0.375, 0.375], abs=1e-3)
    assert values[1, 2:].sum() == 0


def test_votes_beyond_the_middles_of_the_outermost_bins_stay_in_them():
    points = np.array(AROUND) * 9 + [0, 0, 40.0]
    values = describe(points, 0.0, METRE).reshape(METRE.shape)
    assert values[-1, -1].sum() == TOTAL


@settings(max_examples=20)
@given(st.integers(0, 1000), st.floats(1e-4, 1e-3))
def test_a_point_that_moves_a_little_changes_little(seed, step):
    points = scattered(seed)
    layout = replace(METRE, slice_height_m=0.1, shell_width_m=0.1)
    here, there = describe(points, 0.0, layout), describe(points, -step, layout)
    assert distances(here, there[None], layout.shape)[0] < 0.01


def test_the_exponent_takes_weight_from_full_bins():
    points = np.concatenate([AROUND, np.repeat(AROUND[:1], 8, axis=0)]) - np.mean(AROUND, axis=0)
    shares = [describe(points, 0.0, replace(METRE, exponent=power)).max() / TOTAL for power in (1.0, 0.5, 0.25)]
    assert shares == sorted(shares, reverse=True)
    assert shares[0] > 1.5 * shares[2]


@settings(max_examples=20)
@given(st.integers(0, 1000), st.integers(1, 599), st.sampled_from([0.0, 0.05, 0.3]))
def test_parts_gathered_apart_make_the_whole(seed, cut, cell_m):
    points = scattered(seed)
    parts = [gather_votes(part, cell_m) for part in (points[:cut], points[cut:])]
    together = gather_votes(
        np.concatenate([votes for votes, _ in parts]), cell_m, np.concatenate([counts for _, counts in parts])
    )
    layout = Layout(cell_m=cell_m)
    described = describe_votes(together[0], (0.0, -0.3), layout)
    assert together[1].sum() == len(points)
    for base, found in zip((0.0, -0.3), described, strict=True):
        assert distances(found, describe(points, base, layout)[None], layout.shape)[0] < 1e-3


def test_points_of_one_cell_vote_once():
    corners = np.array([[0.5, 0.5, 0.1], [-0.5, 0.5, 0.1], [-0.5, -0.5, 0.1], [0.5, -0.5, 0.1]])
    dense = np.concatenate([corners, np.repeat(corners[:1], 500, axis=0)])
    assert np.array_equal(describe(corners, 0.0), describe(dense, 0.0))
    crowded = Layout(cell_m=0.0)
    assert not np.array_equal(describe(corners, 0.0, crowded), describe(dense, 0.0, crowded))


def test_the_annulus_weight_makes_an_even_disc_even():
    side = np.arange(-1.2, 1.2, 0.01)
    x, y = (axis.ravel() for axis in np.meshgrid(side, side))
    disc = np.column_stack([x, y, np.full_like(x, 0.1)])[np.hypot(x, y) < 1.2]
    shells = describe(disc, 0.0, PAPER_LAYOUT).reshape(PAPER_LAYOUT.shape).sum(axis=(0, 2))
    assert shells.max() / shells.min() < 1.05


def test_no_points_no_descriptor():
    with pytest.raises(ValueError, match="at least one point"):
        describe(np.empty((0, 3)), 0.0)
    with pytest.raises(ValueError, match="finite"):
        describe(np.array([[0.0, np.nan, 0.0]]), 0.0)


@given(counts, st.integers(0, SMALL.sectors - 1))
def test_the_best_turn_lays_one_object_as_the_other(descriptor, shift):
    turned = np.roll(descriptor.reshape(SMALL.shape), -shift, axis=2).ravel()
    angle = best_turn(descriptor, turned, SMALL.shape)
    back = np.roll(turned.reshape(SMALL.shape), round(angle * SMALL.sectors / (2 * np.pi)), axis=2)
    assert np.array_equal(back.ravel(), descriptor)
