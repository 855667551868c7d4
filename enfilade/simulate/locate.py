"""In which room a point lies, and which room a scanned surface belongs to."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .casting import Caster
from .scene import OUTSIDE, Opening, Room, Scene
from .solids import F64, I32, merge, unit_normals

_OFFSETS_M = (0.01, 0.06, 0.12)
_MARGIN_M = 0.06
_LOOKS = ((0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (0.0129, 0.9998, 0.0151))


class Locator:
    """Finds the room of points by the closed boundary meshes of the rooms.

    A ray from a point leaves the boundary that the point is in: the first boundary it meets from inside is that of
    its room. Where two boundaries coincide a look may fail, so there are three.
    """

    def __init__(self, rooms: Sequence[Room]) -> None:
        mesh = merge(room.boundary for room in rooms)
        counts = [len(room.boundary.triangles) for room in rooms]
        self._rooms = np.repeat(np.array([room.number for room in rooms], dtype=np.int32), counts)
        self._normals = unit_normals(mesh)
        self._caster = Caster(mesh)

    def rooms_of(self, points: NDArray[Any]) -> I32:
        """``(K,) int32`` room of each of ``(K, 3)`` points, -1 where there is none."""
        rooms = np.full(len(points), -1, dtype=np.int32)
        for look in _LOOKS if len(self._rooms) else ():
            left = np.flatnonzero(rooms < 0)
            rooms[left] = self._look(np.asarray(points)[left], np.array(look))
        return rooms

    def _look(self, points: NDArray[Any], direction: F64) -> I32:
        triangle = self._caster.cast(points, np.broadcast_to(direction, points.shape))[1]
        inside = (triangle >= 0) & (self._normals[triangle] @ direction > 0)
        return np.where(inside, self._rooms[triangle], -1).astype(np.int32)


def rooms_of_surfaces(scene: Scene, locator: Locator, hits: NDArray[Any], normals: NDArray[Any]) -> I32:
    """``(K,) int32`` room on the side of each ``(K, 3)`` hit that its normal points to.

    A hit in the reveal of an opening belongs to the nearer of its two rooms.
    """
    rooms = np.full(len(hits), -1, dtype=np.int32)
    for offset in _OFFSETS_M:
        left = np.flatnonzero(rooms < 0)
        rooms[left] = locator.rooms_of(hits[left] + offset * normals[left])
    for opening in scene.openings:
        left = np.flatnonzero(rooms < 0)
        rooms[left] = _nearer_room(opening, hits[left])
    return rooms


def _nearer_room(opening: Opening, points: NDArray[Any]) -> I32:
    """Room on the nearer side for points in an opening's box, -1 for others."""
    relative = points - opening.position
    across = relative @ opening.normal
    along = np.abs(relative @ opening.axis)
    upwards = np.abs(relative @ np.cross(opening.normal, opening.axis))
    inside = (np.abs(across) <= opening.depth / 2 + _MARGIN_M) & (along <= opening.width / 2 + _MARGIN_M)
    inside &= upwards <= opening.height / 2 + _MARGIN_M
    return np.where(inside, np.where(across < 0, *opening.rooms), -1).astype(np.int32)


def commonest(rooms: I32) -> int:
    """Return the room that occurs most often, `OUTSIDE` where there is none."""
    counted = Counter(rooms[rooms >= 0].tolist())
    return counted.most_common(1)[0][0] if counted else OUTSIDE
