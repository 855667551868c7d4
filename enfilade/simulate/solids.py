"""Triangle meshes and the few solids that buildings and furniture are made of. Metres, z up."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

F64 = NDArray[np.float64]
I32 = NDArray[np.int32]
Rectangle = tuple[float, float, float, float]
"""Low and high along the first axis, low and high along the second: u0, u1, v0, v1."""

_BOX_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=np.float64)
_BOX_QUADS = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])


@dataclass(frozen=True, slots=True)
class Mesh:
    """A triangle mesh.

    Attributes
    ----------
    vertices
        ``(V, 3) float64``, metres.
    triangles
        ``(T, 3) int32``, indices into `vertices`; of a closed solid they turn anticlockwise seen from outside.
    """

    vertices: F64
    triangles: I32

    def moved(self, offset: ArrayLike) -> Mesh:
        """Return the mesh shifted by ``(3,)`` metres."""
        return Mesh(self.vertices + np.asarray(offset, dtype=np.float64), self.triangles)

    def turned(self, angle_deg: float) -> Mesh:
        """Return the mesh turned anticlockwise about the z axis through the origin."""
        cosine, sine = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
        rotation = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        return Mesh(self.vertices @ rotation.T, self.triangles)

    def scaled(self, factors: ArrayLike) -> Mesh:
        """Return the mesh scaled along x, y, z about the origin by positive factors."""
        return Mesh(self.vertices * np.asarray(factors, dtype=np.float64), self.triangles)

    @property
    def bounds(self) -> F64:
        """``(2, 3)``: least and greatest corner."""
        return np.stack([self.vertices.min(axis=0), self.vertices.max(axis=0)])


def merge(meshes: Iterable[Mesh]) -> Mesh:
    """Put meshes into one, vertices kept apart."""
    parts = list(meshes)
    if not parts:
        return Mesh(np.empty((0, 3)), np.empty((0, 3), dtype=np.int32))
    starts = np.cumsum([0, *(len(part.vertices) for part in parts[:-1])])
    triangles = [part.triangles + start for part, start in zip(parts, starts, strict=True)]
    return Mesh(np.concatenate([p.vertices for p in parts]), np.concatenate(triangles).astype(np.int32))


def box(low: ArrayLike, high: ArrayLike) -> Mesh:
    """Return the axis-parallel box between two corners."""
    start, end = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
    return Mesh(start + _BOX_CORNERS * (end - start), _quads_to_triangles(_BOX_QUADS))


def block(centre: tuple[float, float], size: tuple[float, float], bottom: float, top: float) -> Mesh:
    """Return a box by its plan centre and size."""
    half = np.array(size) / 2
    return box([*(np.array(centre) - half), bottom], [*(np.array(centre) + half), top])


def hexahedron(corners: ArrayLike) -> Mesh:
    """Return the solid with eight ``(8, 3)`` corners, in the order x, y, z (z fastest) of a box."""
    return Mesh(np.asarray(corners, dtype=np.float64), _quads_to_triangles(_BOX_QUADS))


def lathe(profile: Sequence[tuple[float, float]], sides: int = 24) -> Mesh:
    """Turn a profile of (radius, height) points about the z axis, from bottom outside to top inside."""
    outline = np.asarray(profile, dtype=np.float64)
    angles = 2 * np.pi * np.arange(sides) / sides
    rings = np.stack([np.outer(outline[:, 0], np.cos(angles)), np.outer(outline[:, 0], np.sin(angles))], axis=-1)
    heights = np.broadcast_to(outline[:, 1, None, None], (*rings.shape[:2], 1))
    index = np.arange(len(outline) * sides).reshape(len(outline), sides)
    along = np.roll(index, -1, axis=1)
    quads = np.stack([index[:-1], along[:-1], along[1:], index[1:]], axis=-1).reshape(-1, 4)
    return Mesh(np.concatenate([rings, heights], axis=-1).reshape(-1, 3), _quads_to_triangles(quads))


def cylinder(centre: tuple[float, float], radius: float, bottom: float, top: float, sides: int = 16) -> Mesh:
    """Return an upright cylinder with both ends closed."""
    profile = [(0.0, bottom), (radius, bottom), (radius, top), (0.0, top)]
    return lathe(profile, sides).moved([*centre, 0.0])


def around_holes(outer: Rectangle, holes: Sequence[Rectangle]) -> list[Rectangle]:
    """Cut a rectangle into rectangles that leave the holes free, by vertical strips between hole edges."""
    u0, u1, v0, v1 = outer
    edges = sorted({u0, u1, *(min(max(u, u0), u1) for hole in holes for u in hole[:2])})
    pieces: list[Rectangle] = []
    for left, right in pairwise(edges):
        middle = (left + right) / 2
        gaps = sorted((hole[2], hole[3]) for hole in holes if hole[0] < middle < hole[1])
        level = v0
        for low, high in [*gaps, (v1, v1)]:
            if low > level:
                pieces.append((left, right, level, low))
            level = max(level, high)
    return pieces


def upright(start: tuple[float, float], end: tuple[float, float], thickness: float, rectangle: Rectangle) -> Mesh:
    """Return a box in a vertical plane: `rectangle` is metres along start-end and absolute heights.

    `thickness` lies half on either side of the line from start to end.
    """
    u0, u1, z0, z1 = rectangle
    direction = np.subtract(end, start)
    angle = np.degrees(np.arctan2(direction[1], direction[0]))
    return box([u0, -thickness / 2, z0], [u1, thickness / 2, z1]).turned(angle).moved([*start, 0.0])


def wall(
    start: tuple[float, float],
    end: tuple[float, float],
    thickness: float,
    heights: tuple[float, float],
    holes: Sequence[Rectangle] = (),
) -> Mesh:
    """Return a wall as boxes around its holes; holes are metres along the wall and absolute heights."""
    length = float(np.hypot(*np.subtract(end, start)))
    pieces = around_holes((0.0, length, *heights), holes)
    return merge(upright(start, end, thickness, piece) for piece in pieces)


def slab(outer: Rectangle, bottom: float, top: float, holes: Sequence[Rectangle] = ()) -> Mesh:
    """Return a level slab as boxes around its holes; rectangles are x0, x1, y0, y1."""
    return merge(box([x0, y0, bottom], [x1, y1, top]) for x0, x1, y0, y1 in around_holes(outer, holes))


def unit_normals(mesh: Mesh) -> F64:
    """``(T, 3)`` unit normals; zero for triangles without area."""
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    normals: F64 = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    unit: F64 = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
    return unit


def write_obj(path: Path, mesh: Mesh) -> Path:
    """Write a mesh as a Wavefront OBJ file, metres, z up, and return the path."""
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in mesh.vertices.tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in mesh.triangles.tolist()]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
    return path


def _quads_to_triangles(quads: NDArray[np.intp]) -> I32:
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]).astype(np.int32)
