"""What a scanner would see of a mesh: the descriptors that a mesh asks with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from enfilade.errors import InputError
from enfilade.native import open3d

from .histogram import describe
from .layout import DEFAULT_LAYOUT, Layout
from .shapes import Shape

F64 = NDArray[np.float64]

_GOLDEN: Final = 1.32471795724474602596
"""The plastic number, which spreads points evenly over a square (the R2 sequence)."""


@dataclass(frozen=True, slots=True)
class Viewing:
    """From where a mesh is looked at, and how densely.

    Attributes
    ----------
    sides
        Scanner positions on a circle around the mesh.
    scanner_height_m
        Height of the scanner over the floor.
    distance_m
        From the scanner to the smallest upright cylinder around the mesh.
    spacing_m
        Mean distance of samples on the surface.
    least_samples, most_samples
        Bounds of the number of samples.
    tolerance_m
        A sample counts as seen if what hides it is not farther than this in front of it.
    """

    sides: int = 8
    scanner_height_m: float = 1.5
    distance_m: float = 2.0
    spacing_m: float = 0.02
    least_samples: int = 5_000
    most_samples: int = 100_000
    tolerance_m: float = 0.005


def mesh_views(
    shape: Shape,
    layout: Layout = DEFAULT_LAYOUT,
    *,
    floor_offset_m: float = 0.0,
    base_offset_m: float = 0.0,
    viewing: Viewing = Viewing(),
) -> NDArray[np.uint16]:
    """Describe what a scanner would see of a mesh: each side, and the whole.

    The whole is the mesh sampled uniformly, as in §8. A cloud was seen by a scanner already: it has one view, itself.

    Parameters
    ----------
    shape
        A mesh or a cloud.
    layout
        The bins.
    floor_offset_m
        Height of the shape's foot over the floor that the scanner stands on.
    base_offset_m
        Height of the shape's foot over the base of the descriptor: 0 compares foot on foot, the same as
        `floor_offset_m` compares with descriptors based at the floor.
    viewing
        Scanner positions and samples.

    Returns
    -------
    numpy.ndarray
        ``(V, bins) uint16``: ``sides + 1`` descriptors of a mesh, fewer where a side shows nothing.

    Raises
    ------
    InputError
        If the surface has no area.
    """
    base = shape.foot - base_offset_m
    return np.stack([describe(view, base, layout) for view in seen_of(shape, floor_offset_m, viewing)])


def seen_of(shape: Shape, floor_offset_m: float = 0.0, viewing: Viewing = Viewing()) -> list[F64]:
    """Sample what a scanner would see of a mesh from each side, and the whole; of a cloud, itself.

    Parameters
    ----------
    shape
        A mesh or a cloud.
    floor_offset_m
        Height of the shape's foot over the floor that the scanner stands on.
    viewing
        Scanner positions and samples.

    Returns
    -------
    ``(n, 3)`` points of each side that shows something, and of the whole at the end.

    Raises
    ------
    InputError
        If the surface has no area.
    """
    if not shape.is_mesh:
        return [shape.vertices]
    samples = sample_surface(shape, viewing)
    seen = _seen(shape, samples, _scanners(shape, floor_offset_m, viewing), viewing.tolerance_m)
    return [*(samples[mask] for mask in seen if mask.any()), samples]


def sample_surface(shape: Shape, viewing: Viewing = Viewing()) -> F64:
    """Sample a mesh uniformly (§8), the same samples every time.

    Returns
    -------
    numpy.ndarray
        ``(n, 3) float64``, metres.

    Raises
    ------
    InputError
        If the surface has no area.
    """
    corners = shape.vertices[shape.triangles]
    edge1, edge2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = np.cumsum(np.linalg.norm(np.cross(edge1, edge2), axis=1) / 2)
    if area[-1] <= 0:
        raise InputError(f"The mesh {shape.name} has no area; give one whose faces span a surface.")
    count = int(np.clip(area[-1] / viewing.spacing_m**2, viewing.least_samples, viewing.most_samples))
    order = np.arange(count)
    triangle = np.searchsorted(area, (order + 0.5) / count * area[-1])
    u, v = (order / _GOLDEN) % 1.0, (order / _GOLDEN**2) % 1.0
    outside = u + v > 1
    u, v = np.where(outside, 1 - u, u), np.where(outside, 1 - v, v)
    return np.asarray(corners[triangle, 0] + u[:, None] * edge1[triangle] + v[:, None] * edge2[triangle])


def _scanners(shape: Shape, floor_offset_m: float, viewing: Viewing) -> F64:
    """Scanner positions around the mesh, ``(sides, 3)``."""
    low, high = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
    centre = (low + high) / 2
    radius = float(np.hypot(*(high - low)[:2])) / 2 + viewing.distance_m
    angle = 2 * np.pi * np.arange(viewing.sides) / viewing.sides
    height = np.full(viewing.sides, low[2] - floor_offset_m + viewing.scanner_height_m)
    return np.column_stack([centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle), height])


def _seen(shape: Shape, samples: F64, scanners: F64, tolerance_m: float) -> NDArray[np.bool_]:
    """Which samples each scanner sees, ``(scanners, samples)``: those that nothing stands in front of."""
    o3d = open3d()
    centre = samples.mean(axis=0)
    scene = o3d.t.geometry.RaycastingScene()
    vertices = (shape.vertices - centre).astype(np.float32)
    scene.add_triangles(o3d.core.Tensor(vertices), o3d.core.Tensor(shape.triangles.astype(np.uint32)))
    ways = samples[None] - scanners[:, None]
    length = np.linalg.norm(ways, axis=2, keepdims=True)
    origins = np.broadcast_to((scanners - centre)[:, None], ways.shape)
    rays = np.concatenate([origins, ways / length], axis=2).astype(np.float32)
    hit = scene.cast_rays(o3d.core.Tensor(rays.reshape(-1, 6)))["t_hit"].numpy().reshape(length.shape[:2])
    return np.asarray(hit >= length[..., 0] - tolerance_m)
