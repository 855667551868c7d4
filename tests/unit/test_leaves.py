"""How the leaf of a door stands is told by the surfels along it, however it is hung and whichever way the wall runs."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from enfilade.ingest.openings.leaves import with_leaves
from enfilade.ingest.records import Opening, Surfels

WIDTH, HEIGHT = 0.9, 2.05


def door(turn_deg: float, state: str = "open") -> Opening:
    """A door at (5, 2) in a wall that is turned in plan."""
    turn = np.radians(turn_deg)
    normal = np.array([-np.sin(turn), np.cos(turn), 0.0])
    place = np.array([5.0, 2.0, HEIGHT / 2])
    return Opening("door", "horizontal", 0, 1, place, normal, WIDTH, HEIGHT, 0.0, 1.8, 500, state, 0.9)


def leaf(angle_deg: float, hand: int, swing: int, depth: float, turn_deg: float) -> Surfels:
    """One face of a leaf, every 5 cm."""
    angle, turn = np.radians([angle_deg, turn_deg])
    reach, height = (grid.ravel() for grid in np.meshgrid(np.arange(0.03, 0.86, 0.05), np.arange(0.02, 2.0, 0.05)))
    along = np.array([-hand * np.cos(angle), swing * np.sin(angle)])
    across = np.array([-along[1], along[0]])
    plan = [hand * WIDTH / 2, depth] + reach[:, None] * along
    rotated = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    positions = np.column_stack([plan @ rotated + [5.0, 2.0], height]).astype(np.float32)
    normals = np.tile([*(across @ rotated), 0.0], (len(reach), 1)).astype(np.float32)
    index = np.zeros(len(reach), np.int32)
    return Surfels(positions, normals, index, index)


@given(st.floats(9, 42), st.sampled_from([-1, 1]), st.sampled_from([-1, 1]), st.floats(-0.15, 0.15), st.floats(0, 360))
def test_a_leaf_that_stands_ajar_is_seen_however_it_is_hung(angle, hand, swing, depth, turn):
    (said,) = with_leaves([door(turn)], leaf(angle, hand, swing, depth, turn))
    assert said.state == "ajar"


@pytest.mark.parametrize("angle", [0.0, 2.0, 70.0, 90.0, 175.0])
def test_a_leaf_that_is_shut_or_stands_open_is_not_ajar(angle):
    assert with_leaves([door(0.0)], leaf(angle, 1, 1, 0.05, 0.0))[0].state == "open"


def test_both_faces_of_a_leaf_that_is_shut_are_not_ajar():
    faces = [leaf(0.0, 1, 1, depth, 0.0) for depth in (-0.02, 0.02)]
    fields = [np.concatenate([getattr(face, name) for face in faces]) for name in Surfels.__dataclass_fields__]
    assert with_leaves([door(0.0, "closed")], Surfels(*fields))[0].state == "closed"


def test_half_of_a_plate_is_no_leaf():
    whole = leaf(20.0, 1, 1, 0.05, 0.0)
    half = np.flatnonzero(whole.positions[:, 2] < HEIGHT / 2)
    seen = Surfels(whole.positions[half], whole.normals[half], whole.scan[half], whole.point_surfel[half])
    assert with_leaves([door(0.0)], seen)[0].state == "open"


def test_windows_have_no_leaf():
    window = door(0.0)
    assert with_leaves([window], leaf(20.0, 1, 1, 0.05, 0.0))[0].state == "ajar"
    window = Opening("window", *[getattr(window, name) for name in Opening.__dataclass_fields__][1:])
    assert with_leaves([window], leaf(20.0, 1, 1, 0.05, 0.0))[0].state == "open"
