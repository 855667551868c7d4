"""Outlines: the area of what is covered, up to the walls, whatever lies behind a door or window."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from enfilade.faces import WallFaces
from enfilade.ingest.outlines import OutlineParameters, draw_outline

SCANNER = np.array([[1.0, 1.0]], np.float32)
NOTHING = np.zeros((0, 2), np.float32)


def floor(x: tuple[float, float], y: tuple[float, float], step: float = 0.05) -> np.ndarray:
    grid = np.meshgrid(np.arange(x[0] + step / 2, x[1], step), np.arange(y[0] + step / 2, y[1], step))
    return np.stack([axis.ravel() for axis in grid], axis=1).astype(np.float32)


def walls(width: float, depth: float) -> np.ndarray:
    x, y = np.arange(0.0, width, 0.04), np.arange(0.0, depth, 0.04)
    sides = [(x, 0.0 * x), (x, 0.0 * x + depth), (0.0 * y, y), (0.0 * y + width, y)]
    return np.concatenate([np.stack(side, axis=1) for side in sides]).astype(np.float32)


@given(st.floats(1.5, 8.0), st.floats(1.5, 8.0))
def test_the_area_of_a_rectangle_is_right_within_a_centimetre_a_side(width: float, depth: float) -> None:
    outline = draw_outline(floor((0.0, width), (0.0, depth)), walls(width, depth), SCANNER, SCANNER)
    assert outline.area == pytest.approx(width * depth, abs=2 * (width + depth) * 0.03)
    assert outline.centre == pytest.approx([width / 2, depth / 2], abs=0.04)


def test_what_lies_behind_a_wall_does_not_count() -> None:
    covered = np.concatenate([floor((0.0, 4.0), (0.0, 3.0)), floor((4.3, 6.0), (0.0, 3.0))])
    sights = np.array([[5.9, 1.0]], np.float32)
    outline = draw_outline(covered, walls(4.0, 3.0), SCANNER, sights)
    assert outline.area == pytest.approx(12.0, rel=0.02)
    assert outline.rings[0][:, 0].max() < 4.1


def test_rays_cover_what_is_hit_sparsely() -> None:
    border = walls(4.0, 3.0)
    scanners = np.tile(SCANNER, (len(border), 1))
    outline = draw_outline(floor((0.5, 1.5), (0.5, 1.5)), border, scanners, border)
    assert outline.area == pytest.approx(12.0, rel=0.03)


def test_small_holes_are_filled_and_large_ones_stay() -> None:
    everywhere = floor((0.0, 6.0), (0.0, 6.0))
    shadow = (np.abs(everywhere - [3.0, 3.0]) < 0.4).all(axis=1)
    court = (np.abs(everywhere - [3.0, 3.0]) < 1.0).all(axis=1)
    assert draw_outline(everywhere[~shadow], walls(6.0, 6.0), SCANNER, SCANNER).area == pytest.approx(36.0, rel=0.02)
    around = draw_outline(everywhere[~court], walls(6.0, 6.0), SCANNER, SCANNER)
    assert around.area == pytest.approx(32.0, rel=0.02)
    assert len(around.rings) == 2


def test_the_outline_of_a_rectangle_has_few_corners_and_its_area() -> None:
    outline = draw_outline(floor((0.0, 5.0), (0.0, 4.0)), walls(5.0, 4.0), SCANNER, SCANNER, OutlineParameters())
    (ring,) = outline.rings
    x, y = ring.T
    assert len(ring) <= 9
    assert abs(np.dot(x[:-1], y[1:]) - np.dot(x[1:], y[:-1])) / 2 == pytest.approx(20.0, rel=0.03)


def test_a_room_without_walls_is_what_is_covered() -> None:
    assert draw_outline(floor((0.0, 4.0), (0.0, 3.0)), NOTHING, SCANNER, SCANNER).area == pytest.approx(12.0, rel=0.02)


def faces_of(corners: np.ndarray) -> WallFaces:
    """Faces along the edges of a polygon."""
    ends = np.roll(corners, -1, axis=0)
    length = np.hypot(*(ends - corners).T)
    half = np.column_stack([-length, length]) / 2
    return WallFaces((corners + ends) / 2, (ends - corners) / length[:, None], half)


def along(corners: np.ndarray, *, gap: tuple[float, float] | None = None) -> np.ndarray:
    """Points every 4 cm along the edges of a polygon; of the first edge none from one place to another."""
    points = []
    for edge, (a, b) in enumerate(zip(corners, np.roll(corners, -1, axis=0), strict=True)):
        place = np.arange(0.0, np.hypot(*(b - a)), 0.04)
        if gap is not None and edge == 0:
            place = place[(place < gap[0]) | (place > gap[1])]
        points.append(a + (b - a) / np.hypot(*(b - a)) * place[:, None])
    return np.concatenate(points).astype(np.float32)


@given(st.floats(1.5, 8.0), st.floats(1.5, 8.0), st.floats(0.0, 1.5), st.floats(-0.2, 0.2))
def test_along_faces_an_outline_is_exact_however_the_room_lies(w: float, d: float, angle: float, shift: float) -> None:
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    corners = np.array([[0.0, 0.0], [w, 0.0], [w, d], [0.0, d]]) @ turn + shift
    covered = (floor((0.0, w), (0.0, d)) @ turn + shift).astype(np.float32)
    scanner = np.array([[0.7, 0.7]], np.float32) @ turn.astype(np.float32) + np.float32(shift)
    outline = draw_outline(covered, along(corners), scanner, scanner, faces=faces_of(corners))
    assert outline.area == pytest.approx(w * d, rel=1e-3)
    assert outline.centre == pytest.approx(corners.mean(axis=0), abs=2e-3)
    assert len(outline.rings[0]) == 5


def test_what_is_seen_through_a_window_up_to_the_ceiling_does_not_count_but_a_niche_and_a_leg_do() -> None:
    corners = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
    inside, through = floor((0.0, 4.0), (0.0, 3.0)), floor((1.5, 2.6), (-2.0, 0.0))
    wall, faces = along(corners, gap=(1.4, 2.7)), faces_of(corners)
    seen = draw_outline(np.concatenate([inside, through]), wall, SCANNER, SCANNER, faces=faces, ceiling=inside)
    assert seen.area == pytest.approx(12.0, rel=0.005)
    under_ceiling = np.concatenate([inside, floor((1.4, 2.7), (-4.0, 0.0))])
    leg = draw_outline(under_ceiling, wall, SCANNER, SCANNER, faces=faces, ceiling=under_ceiling)
    assert leg.area == pytest.approx(12.0 + 1.3 * 4.0, rel=0.02)
    niche = along(np.array([[1.4, -1.0], [2.7, -1.0], [2.7, 0.0], [1.4, 0.0]]))
    both = np.concatenate([wall, niche[niche[:, 1] < -0.03]])
    covered = np.concatenate([inside, floor((1.4, 2.7), (-1.0, 0.0))])
    around = draw_outline(covered, both, SCANNER, SCANNER, faces=faces, ceiling=inside)
    assert around.area == pytest.approx(13.3, rel=0.02)
    reveal = along(np.array([[1.4, -0.3], [2.7, -0.3], [2.7, 0.0], [1.4, 0.0]]))
    both = np.concatenate([wall, reveal[reveal[:, 1] < -0.03]])
    covered = np.concatenate([inside, floor((1.4, 2.7), (-0.3, 0.0))])
    shallow = draw_outline(covered, both, SCANNER, SCANNER, faces=faces, ceiling=inside)
    assert shallow.area == pytest.approx(12.0, rel=0.005)
