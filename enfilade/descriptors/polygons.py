"""Faces of more than three corners as triangles."""

from __future__ import annotations

from itertools import pairwise


def fan(corners: list[int]) -> list[tuple[int, int, int]]:
    """Return the triangles between the first corner and each edge that it is not on; none for fewer than three."""
    return [(corners[0], second, third) for second, third in pairwise(corners[1:])]
