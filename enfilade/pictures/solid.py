"""Shaded views of meshes and of points, seen alike, so that the eye can compare them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.colors import to_rgb
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from enfilade.native import open3d

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]

_LIGHT: Final = np.array([-0.35, 0.55, 0.76])
"""Towards the light, in the camera's right, up and back axes: from the upper left."""
_NEIGHBOURS: Final = 12
_OVERSAMPLING: Final = 2
_MOST_POINTS: Final = 20_000
_EDGE_STRENGTH: Final = 9.0
_DARKEST: Final = 0.4
_PALENESS: Final = 0.2


@dataclass(frozen=True, slots=True)
class Camera:
    """A parallel view of a scene from above one side.

    Attributes
    ----------
    span_m
        Side of the square that the picture shows.
    pixels
        Side of the picture.
    azimuth_deg, elevation_deg
        Direction from which it looks: 0° is from +x, 90° from +y.
    """

    span_m: float
    pixels: int = 420
    azimuth_deg: float = -55.0
    elevation_deg: float = 28.0

    @property
    def axes(self) -> F64:
        """``(3, 3)`` rows: right, up, back (towards the camera)."""
        azimuth, elevation = np.radians(self.azimuth_deg), np.radians(self.elevation_deg)
        back = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
        right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
        return np.stack([right, np.cross(back, right), back])


def render_mesh(vertices: F64, triangles: NDArray[np.int32], camera: Camera, colour: str) -> F32:
    """Render a mesh centred in the view.

    Returns
    -------
    numpy.ndarray
        ``(pixels, pixels, 4) float32`` RGBA in [0, 1], the upper row first.
    """
    o3d = open3d()
    seen = (vertices - _centre(vertices)) @ camera.axes.T
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(o3d.core.Tensor(seen.astype(np.float32)), o3d.core.Tensor(triangles.astype(np.uint32)))
    far = float(seen[:, 2].max()) + 1.0
    size = camera.pixels * _OVERSAMPLING
    x, y = np.meshgrid(_pixel_centres(size, camera.span_m), -_pixel_centres(size, camera.span_m))
    rays = np.zeros((size, size, 6), np.float32)
    rays[..., 0], rays[..., 1], rays[..., 2], rays[..., 5] = x, y, far, -1.0
    hits = scene.cast_rays(o3d.core.Tensor(rays))
    depth = far - hits["t_hit"].numpy().astype(np.float64)
    normals = hits["primitive_normals"].numpy().astype(np.float64)
    return _smaller(_shade(depth, normals, camera, colour))


def render_points(points: F64, camera: Camera, colour: str) -> F32:
    """Render points as small discs, centred in the view, shaded by the surface that they lie on.

    Returns
    -------
    numpy.ndarray
        ``(pixels, pixels, 4) float32`` RGBA in [0, 1], the upper row first.
    """
    points = points[:: 1 + len(points) // _MOST_POINTS]
    seen = (points - _centre(points)) @ camera.axes.T
    nearest = _splat(seen, camera)
    depth = np.where(nearest >= 0, seen[nearest, 2], -np.inf)
    return _smaller(_shade(depth, _normals(seen)[nearest], camera, colour))


def _splat(seen: F64, camera: Camera) -> NDArray[np.int64]:
    """Return the point that each pixel shows, -1 for none, when every point is a disc."""
    size = camera.pixels * _OVERSAMPLING
    scale = size / camera.span_m
    radius = max(1, round(_disc_m(seen) * scale))
    offsets = np.arange(-radius, radius + 1)
    disc = np.stack(np.meshgrid(offsets, offsets), axis=-1).reshape(-1, 2)
    disc = disc[(disc**2).sum(axis=1) <= radius**2 + 1]
    # Far points first, near ones over them: of several writes to a pixel the last one stays.
    order = np.argsort(seen[:, 2], kind="stable")
    centres = np.floor(size / 2 + seen[order, :2] * [scale, -scale]).astype(np.int64)
    column, row = np.moveaxis(centres[:, None] + disc, 2, 0)
    inside = (row >= 0) & (row < size) & (column >= 0) & (column < size)
    nearest = np.full((size, size), -1)
    nearest[row[inside], column[inside]] = np.broadcast_to(order[:, None], row.shape)[inside]
    return nearest


def span_of(*clouds: F64) -> float:
    """Side of the square, in metres, that shows each of some sets of points whole from any side."""
    return max(float(2 * np.linalg.norm(points - _centre(points), axis=1).max()) for points in clouds) * 1.04


def _centre(points: F64) -> F64:
    return np.asarray((points.min(axis=0) + points.max(axis=0)) / 2)


def _pixel_centres(size: int, span_m: float) -> F64:
    return ((np.arange(size) + 0.5) / size - 0.5) * span_m


def _disc_m(points: F64) -> float:
    """Radius of the discs that close the gaps between points: their usual distance."""
    sample = points[:: max(1, len(points) // 2000)]
    distance, _ = cKDTree(points).query(sample, k=min(5, len(points)))
    return float(np.clip(np.median(np.atleast_2d(distance)[:, -1]), 0.004, 0.05)) * 0.8


def _normals(points: F64) -> F64:
    """Return normals of the surface that points lie on, from their neighbours, turned towards the camera."""
    count = min(_NEIGHBOURS, len(points))
    if count < 3:
        return np.tile([0.0, 0.0, 1.0], (len(points), 1))
    _, index = cKDTree(points).query(points, k=count)
    around = points[index] - points[index].mean(axis=1, keepdims=True)
    _, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", around, around))
    normals = vectors[:, :, 0]
    return np.asarray(np.where(normals[:, 2:] < 0, -normals, normals))


def _shade(depth: F64, normals: F64, camera: Camera, colour: str) -> F32:
    """Turn depth and normals, both in the camera's axes, into a picture; edges in depth are darkened."""
    covered = np.isfinite(depth)
    facing = np.where(normals[..., 2:] < 0, -normals, normals)
    light = np.clip(facing @ (_LIGHT / np.linalg.norm(_LIGHT)), 0, 1)
    tone = (0.72 + 0.28 * light) * _eye_dome(depth, covered, camera)
    pale = _PALENESS * (0.3 + light)[..., None]
    image = np.zeros((*depth.shape, 4), np.float32)
    image[..., :3] = tone[..., None] * (np.array(to_rgb(colour)) * (1 - pale) + pale) * covered[..., None]
    image[..., 3] = covered
    return image


def _eye_dome(depth: F64, covered: NDArray[np.bool_], camera: Camera) -> F64:
    """Darken what lies behind its surroundings (eye-dome lighting), which makes shapes readable."""
    filled = np.where(covered, depth, -camera.span_m)
    behind = np.zeros_like(depth)
    for shift in (3, 7):
        for axis in (0, 1):
            for sign in (-1, 1):
                other = np.roll(filled, sign * shift, axis=axis)
                behind += np.clip((other - filled) / camera.span_m, 0, 0.05) / 8
    return np.maximum(np.exp(-_EDGE_STRENGTH * 8 * behind), _DARKEST)


def _smaller(image: F32) -> F32:
    """Average the oversampled pixels, colours weighted by how much they cover."""
    size = image.shape[0] // _OVERSAMPLING
    blocks = image.reshape(size, _OVERSAMPLING, size, _OVERSAMPLING, 4).mean(axis=(1, 3))
    cover = blocks[..., 3:]
    blocks[..., :3] = np.divide(blocks[..., :3], cover, out=np.ones_like(blocks[..., :3]), where=cover > 0)
    return np.asarray(blocks, dtype=np.float32)
