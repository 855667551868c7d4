"""Rays against triangles: Embree through Open3D, at any coordinates."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from enfilade.native import open3d

from .solids import F64, Mesh

F32 = NDArray[np.float32]


class Caster:
    """One mesh, ready to be hit. Works in float32 about a whole-metre origin near the mesh."""

    def __init__(self, mesh: Mesh) -> None:
        self.origin: F64 = np.floor(mesh.bounds.mean(axis=0)) if len(mesh.vertices) else np.zeros(3)
        core = open3d().core
        self._scene: Any = open3d().t.geometry.RaycastingScene()
        if len(mesh.triangles):
            self._scene.add_triangles(
                core.Tensor((mesh.vertices - self.origin).astype(np.float32)),
                core.Tensor(np.ascontiguousarray(mesh.triangles, dtype=np.uint32)),
            )
        self._empty = not len(mesh.triangles)

    def cast(self, starts: NDArray[Any], directions: NDArray[Any]) -> tuple[F32, NDArray[np.int32]]:
        """Cast K rays.

        Parameters
        ----------
        starts
            ``(K, 3)`` or ``(3,)``, metres.
        directions
            ``(K, 3)``; ranges are in units of their lengths.

        Returns
        -------
        ranges
            ``(K,) float32``, infinity where nothing is hit.
        triangles
            ``(K,) int32``, -1 where nothing is hit.
        """
        if self._empty or not len(directions):
            return np.full(len(directions), np.inf, dtype=np.float32), np.full(len(directions), -1, dtype=np.int32)
        rays = np.empty((len(directions), 6), dtype=np.float32)
        rays[:, :3] = starts - self.origin
        rays[:, 3:] = directions
        answer = self._scene.cast_rays(open3d().core.Tensor(rays))
        ranges: F32 = answer["t_hit"].numpy()
        triangles = answer["primitive_ids"].numpy().astype(np.int32)
        return ranges, np.where(np.isfinite(ranges), triangles, np.int32(-1))

    def distance(self, points: NDArray[Any]) -> F32:
        """``(K,) float32`` distance of each ``(K, 3)`` point to the mesh, metres."""
        if self._empty or not len(points):
            return np.full(len(points), np.inf, dtype=np.float32)
        query = open3d().core.Tensor((points - self.origin).astype(np.float32))
        distance: F32 = self._scene.compute_distance(query).numpy()
        return distance

    def blocked(self, starts: NDArray[Any], ends: NDArray[Any]) -> NDArray[np.bool_]:
        """``(K,)`` whether something lies between each start and end, ``(K, 3)`` each."""
        return self.cast(starts, ends - starts)[0] < 1.0
