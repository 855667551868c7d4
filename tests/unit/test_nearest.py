"""The nearest objects by bounds are those that measuring all gives, on random and on adversarial descriptors."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from enfilade.descriptors import TOTAL, distances, quantise
from enfilade.descriptors.bounds import (
    blocks_of,
    envelope_bounds,
    envelope_bounds_of,
    envelope_of,
    rings_of,
    view_bounds_of,
)
from enfilade.descriptors.nearest import DescriptorTable, Nearest

SHAPES = ((1, 1, 1), (1, 2, 4), (3, 2, 3), (2, 3, 5), (5, 1, 2))


@st.composite
def descriptors(draw: st.DrawFn, bins: int) -> np.ndarray:
    """One bin, a few, all alike, or anything."""
    kind = draw(st.sampled_from(["one", "few", "even", "any"]))
    if kind == "one":
        values = np.zeros(bins)
        values[draw(st.integers(0, bins - 1))] = 1
        return quantise(values)
    if kind == "even":
        return quantise(np.ones(bins))
    largest = 3 if kind == "few" else 10_000
    values = draw(st.lists(st.integers(0, largest), min_size=bins, max_size=bins).filter(any))
    return quantise(values)


@st.composite
def searches(draw: st.DrawFn) -> tuple[tuple[int, int, int], np.ndarray, np.ndarray]:
    """A shape, some views, and objects, many of which are copies or turns of one another or of the views."""
    shape = draw(st.sampled_from(SHAPES))
    bins = int(np.prod(shape))
    kinds = [draw(descriptors(bins)) for _ in range(draw(st.integers(1, 5)))]
    turned = st.builds(
        lambda counts, turn: np.roll(counts.reshape(shape), turn, axis=2).ravel(),
        st.sampled_from(kinds) | descriptors(bins),
        st.integers(0, shape[2] - 1),
    )
    views = draw(st.lists(turned, min_size=1, max_size=4))
    objects = draw(st.lists(turned, min_size=1, max_size=30))
    return shape, np.stack(views), np.stack(objects)


def brute_force(views: np.ndarray, objects: np.ndarray, shape: tuple[int, int, int]) -> np.ndarray:
    return np.round(distances(views, objects, shape), 12)


@given(searches())
def test_no_bound_exceeds_the_distance(search: tuple) -> None:
    shape, views, objects = search
    found = brute_force(views, objects, shape)
    rings, rows = rings_of(objects, shape), np.arange(len(objects))
    view_rings = rings_of(views, shape)

    by_blocks = envelope_bounds(envelope_of(blocks_of(view_rings, shape)), blocks_of(rings, shape))
    by_rings = envelope_bounds_of(envelope_of(view_rings), rings, rows)
    by_views = view_bounds_of(view_rings.astype(np.float32), rings, rows)

    for bounds in (by_blocks, by_rings, by_views):
        assert (bounds <= found).all()
    assert (by_rings <= by_views + 1e-5).all()


@given(searches(), st.lists(st.integers(0, 35), min_size=1, max_size=3))
def test_the_best_are_those_of_brute_force(search: tuple, counts: list[int]) -> None:
    shape, views, objects = search
    found = brute_force(views, objects, shape)
    nearest = Nearest(views, DescriptorTable.of(objects, shape))

    for count in counts:
        rows, apart = nearest.best(count)

        last = -1.0 if count == 0 else np.sort(found)[min(count, len(found)) - 1]
        order = np.argsort(found, kind="stable")
        expected = order[found[order] <= last]
        assert rows.tolist() == expected.tolist()
        assert apart.tolist() == found[expected].tolist()


@given(searches(), st.data())
def test_all_within_a_distance_are_found_the_limit_included(search: tuple, data: st.DataObject) -> None:
    shape, views, objects = search
    found = brute_force(views, objects, shape)
    nearest = Nearest(views[0] if len(views) == 1 else views, DescriptorTable.of(objects, shape))
    limit = data.draw(st.sampled_from(found.tolist()) | st.floats(0, 2))

    rows, apart = nearest.within(limit)

    assert sorted(rows.tolist()) == np.flatnonzero(found <= limit).tolist()
    assert apart.tolist() == sorted(found[found <= limit].tolist())


@given(searches(), st.data())
def test_what_was_measured_before_changes_nothing(search: tuple, data: st.DataObject) -> None:
    shape, views, objects = search
    found = brute_force(views, objects, shape)
    nearest = Nearest(views, DescriptorTable.of(objects, shape))
    asked = np.array(data.draw(st.lists(st.integers(0, len(objects) - 1), max_size=8)), dtype=np.int64)

    assert nearest.of(asked).tolist() == found[asked].tolist()
    rows, _ = nearest.best(3)
    again, apart = nearest.within(2.0)

    assert set(rows) <= set(again)
    assert apart.tolist() == np.sort(found).tolist()
    assert nearest.effort.distances == len(objects)
    assert nearest.effort.pruned == 0


@given(searches(), st.data())
def test_rows_of_no_object_are_left_alone(search: tuple, data: st.DataObject) -> None:
    shape, views, objects = search
    valid = np.array(data.draw(st.lists(st.booleans(), min_size=len(objects), max_size=len(objects))))
    objects[~valid] = 0
    rings = rings_of(objects, shape)
    nearest = Nearest(views, DescriptorTable(shape, objects, rings, blocks_of(rings, shape), valid))

    rows, _ = nearest.best(data.draw(st.integers(0, 40)))
    everything, _ = nearest.within(2.0)

    assert valid[rows].all()
    assert sorted(everything.tolist()) == np.flatnonzero(valid).tolist()
    assert np.isnan(nearest.of(np.arange(len(objects)))).tolist() == (~valid).tolist()


def test_many_rows_of_no_object_hide_none_that_is_one() -> None:
    shape = (1, 2, 4)
    example = quantise(np.array([4, 2, 0, 0, 2, 0, 0, 0]))
    objects = np.stack([example] * 300)
    valid = np.zeros(300, dtype=bool)
    valid[[7, 200, 299]] = True
    objects[200] = quantise(np.ones(8))
    rings = rings_of(objects, shape)
    nearest = Nearest(example[None], DescriptorTable(shape, objects, rings, blocks_of(rings, shape), valid))

    for count, found in ((1, [7, 299]), (2, [7, 299]), (3, [7, 299, 200]), (64, [7, 299, 200])):
        assert nearest.best(count)[0].tolist() == found
    assert nearest.within(np.inf)[0].tolist() == [7, 299, 200]
    assert nearest.effort.distances <= 3


@pytest.mark.parametrize("views", [1, 5])
def test_few_of_many_are_measured(views: int) -> None:
    rng = np.random.default_rng(0)
    shape = (4, 4, 8)
    kinds = [quantise(rng.gamma(0.3, size=128)) for _ in range(40)]
    objects = np.stack([quantise(kinds[i] * rng.lognormal(0, 0.3, 128)) for i in rng.integers(40, size=70_000)])
    asked = np.stack([quantise(kinds[i] * rng.lognormal(0, 0.3, 128)) for i in range(views)])
    nearest = Nearest(asked, DescriptorTable.of(objects, shape))

    rows, apart = nearest.best(10)

    found = brute_force(asked, objects, shape)
    assert apart.tolist() == np.sort(found)[: len(apart)].tolist()
    assert found[rows].tolist() == apart.tolist()
    assert nearest.effort.distances < 0.15 * len(objects)


def test_a_bound_of_the_same_sums_is_hardly_below_zero() -> None:
    counts = quantise(np.arange(1, 13))[None]
    assert counts.sum() == TOTAL
    rings = rings_of(counts, (2, 2, 3))
    assert -1e-5 < envelope_bounds(envelope_of(rings), rings)[0] < 0
