"""The building's structure as a ray sees it: the occupied cells of all planes, and what a ray hits first."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enfilade.native import open3d

from .cells import tile_rectangles
from .records import F32, I32, Bitmap, Bool, Planes

I64 = NDArray[np.int64]

OCCUPIED = 0.5
"""A cell stops rays where its box-filtered occupancy is greater."""


@dataclass(frozen=True, slots=True)
class Hits:
    """What each ray hit first.

    Attributes
    ----------
    distance
        ``(n,) float32``, metres for unit directions, infinite for none.
    plane
        ``(n,) int32``, -1 for none.
    front
        ``(n,) bool``, whether the ray came from the side that the plane's normal points to.
    """

    distance: F32
    plane: I32
    front: Bool


class Structure:
    """Occupied bitmap cells of planes, ready for ray casting.

    Parameters
    ----------
    planes
        The planes with their bitmaps.
    close_doors_m
        Openings in walls up to this height are closed if there is wall above them; 0 leaves all open.
    """

    def __init__(self, planes: Planes, *, close_doors_m: float = 0.0) -> None:
        o3d = open3d()
        rectangles = [
            tile_rectangles(_doors_closed(bitmap, close_doors_m) if vertical else bitmap.occupancy > OCCUPIED)
            for bitmap, vertical in zip(planes.bitmaps, planes.vertical, strict=True)
        ]
        self._normals = planes.normals
        self._plane = np.repeat(np.arange(len(rectangles), dtype=np.int32), [len(r) for r in rectangles])
        corners = [_corners(b, r) for b, r in zip(planes.bitmaps, rectangles, strict=True) if len(r)]
        vertices = np.concatenate(corners) if corners else np.zeros((0, 3), np.float32)
        self._scene: Any = o3d.t.geometry.RaycastingScene()
        if len(vertices):
            self._scene.add_triangles(o3d.core.Tensor(vertices), o3d.core.Tensor(_triangles(len(vertices) // 4)))

    def cast(self, origins: F32, directions: F32) -> Hits:
        """Cast rays from ``(n, 3)`` origins along ``(n, 3)`` directions."""
        n = len(origins)
        if not n or not len(self._plane):
            return Hits(np.full(n, np.inf, np.float32), np.full(n, -1, np.int32), np.zeros(n, bool))
        rays = np.concatenate([origins, directions], axis=1, dtype=np.float32)
        cast = self._scene.cast_rays(open3d().core.Tensor(rays))
        distance = cast["t_hit"].numpy()
        plane, front = _sides(distance, cast["primitive_ids"].numpy(), self._plane, self._normals, rays)
        return Hits(distance, plane, front)

    def blocked(self, starts: F32, ends: F32) -> Bool:
        """``(n,)``: whether structure of either side lies between ``(n, 3)`` starts and ends."""
        if not len(starts) or not len(self._plane):
            return np.zeros(len(starts), bool)
        rays = np.concatenate([starts, ends - starts], axis=1).astype(np.float32)
        occluded = self._scene.test_occlusions(open3d().core.Tensor(rays), tnear=0.0, tfar=1.0)
        return np.asarray(occluded.numpy(), bool)


@njit(cache=True, nogil=True)
def _sides(distance: F32, triangle: NDArray[np.uint32], plane_of: I32, normals: F32, rays: F32) -> tuple[I32, Bool]:
    """Plane that each ray hit, -1 for none, and whether it came from its front; a rectangle is two triangles."""
    plane, front = np.full(len(distance), -1, np.int32), np.zeros(len(distance), np.bool_)
    for i in range(len(distance)):
        if np.isfinite(distance[i]):
            p = plane_of[triangle[i] // 2]
            plane[i] = p
            towards = normals[p, 0] * rays[i, 3] + normals[p, 1] * rays[i, 4] + normals[p, 2] * rays[i, 5]
            front[i] = towards < 0.0
    return plane, front


def _doors_closed(bitmap: Bitmap, height_m: float) -> Bool:
    """Occupied cells of a wall, with the gaps up to a height filled in each column that goes on above them."""
    occupied = bitmap.occupancy > OCCUPIED
    if height_m <= 0.0 or not occupied.any():
        return occupied
    count = len(occupied)
    row = np.arange(count)[:, None]
    lowest = np.flatnonzero(occupied.any(axis=1))[0]
    below = np.maximum.accumulate(np.where(occupied, row, lowest - 1), axis=0)
    above = np.minimum.accumulate(np.where(occupied, row, count)[::-1], axis=0)[::-1]
    gap = above - below - 1
    filled = (above < count) & (row >= lowest) & (gap * bitmap.cell_m <= height_m)
    return np.asarray(occupied | filled)


def _corners(bitmap: Bitmap, rectangles: I64) -> F32:
    """``(4 k, 3) float32`` corners, four a rectangle, around it."""
    i = rectangles[:, [0, 0, 1, 1]].reshape(-1, 1).astype(np.float32)
    j = rectangles[:, [2, 3, 3, 2]].reshape(-1, 1).astype(np.float32)
    return np.asarray(bitmap.origin + bitmap.cell_m * (j * bitmap.u + i * bitmap.v), np.float32)


def _triangles(count: int) -> NDArray[np.uint32]:
    """``(2 count, 3) uint32`` two triangles a rectangle."""
    first = 4 * np.arange(count, dtype=np.uint32)[:, None, None]
    return (first + np.array([[0, 1, 2], [0, 2, 3]], np.uint32)).reshape(-1, 3)
