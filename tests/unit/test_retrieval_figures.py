"""The figures of the retrieval bench, on lists short enough to count by hand."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "bench"))

from ranking import Answer, average_precision, discounted_gain, figures, tier
from retrieval import Question, answer
from scanned import Pool, Target


def listed(text: str, wanted: int, kind: str = "chair") -> Answer:
    return Answer(kind, np.array([letter == "x" for letter in text]), wanted)


def test_average_precision_counts_what_is_not_listed_as_never_found():
    assert average_precision(listed("x.x.", 2)) == pytest.approx((1 / 1 + 2 / 3) / 2)
    assert average_precision(listed("x.x.", 4)) == pytest.approx((1 / 1 + 2 / 3) / 4)
    assert average_precision(listed("....", 1)) == 0


def test_tiers_are_as_long_as_there_is_to_find():
    assert tier(listed("x..xx.", 3), 1) == pytest.approx(1 / 3)
    assert tier(listed("x..xx.", 3), 2) == 1


def test_the_discounted_gain_of_a_perfect_list_is_one():
    assert discounted_gain(listed("xxx..", 3)) == pytest.approx(1)
    assert discounted_gain(listed(".x...", 1)) == pytest.approx(1)  # second place counts as the first
    assert discounted_gain(listed("..x..", 1)) == pytest.approx(1 / np.log2(3))
    assert discounted_gain(listed("x", 3)) == pytest.approx(1 / (2 + 1 / np.log2(3)))


def test_macro_means_count_every_class_the_same():
    some = [listed("x", 1), listed("x", 1), listed(".x", 1, "table")]
    found = figures(some)
    assert found["mAP micro"] == pytest.approx(2.5 / 3)
    assert found["mAP macro"] == pytest.approx(0.75)
    assert found["nearest neighbour"] == pytest.approx(2 / 3)


def object_of(furnishing: int, mesh: str, parts: tuple[int, ...], mostly: str = "") -> Target:
    return Target(np.zeros((1, 3)), 0.0, furnishing, mesh, mostly or mesh, parts)


POOL = Pool(
    (
        object_of(0, "chair/a", (0,)),
        object_of(-1, "", (1,), mostly="chair/b"),
        object_of(1, "chair/b", (1, 2)),
        object_of(2, "table/c", (3,)),
        object_of(3, "chair/d", (4,)),
    ),
    {0: "chair/a", 1: "chair/b", 2: "table/c", 3: "chair/d"},
)


def relevant(question: Question, apart: list[float], *, own: bool) -> tuple[list[bool], int]:
    found = answer(question, np.array(apart), POOL, own=own)
    assert found is not None
    return found.relevant.tolist(), found.wanted


def test_of_objects_that_share_segments_the_best_is_listed():
    chair = Question("chair/a")
    assert relevant(chair, [0, 0.1, 0.2, 0.3, 0.4], own=True) == ([True, False, False, True], 3)
    assert relevant(chair, [0, 0.2, 0.1, 0.3, 0.4], own=True) == ([True, True, False, True], 3)


def test_own_scans_and_their_parts_are_left_out():
    assert relevant(Question("chair/b"), [0.3, 0.1, 0.2, 0, 0.4], own=False) == ([False, True, True], 2)


def test_an_object_that_asks_is_not_in_its_own_list():
    assert relevant(Question("chair/b", 2), [0.3, 0.1, 0, 0.2, 0.4], own=True) == ([False, True, True], 2)


def test_a_class_of_one_mesh_asks_for_nothing():
    assert answer(Question("table/c"), np.zeros(5), POOL, own=False) is None
