"""Meshes and clouds that a question shows as an example."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from enfilade.errors import InputError
from enfilade.native import open3d

from .pcd import read_pcd
from .stanford import read_ply
from .wavefront import read_obj

Surface = tuple[NDArray[np.float64], NDArray[np.int32]]
"""Vertices and triangles."""

_NO_TRIANGLES: Final = np.empty((0, 3), np.int32)
_LARGEST_M: Final = 100.0


@dataclass(frozen=True, slots=True)
class Shape:
    """A mesh, or a cloud of points if there are no triangles; metres, z up.

    Attributes
    ----------
    name
        File name without its suffix.
    vertices
        ``(n, 3) float64``, metres.
    triangles
        ``(m, 3) int32`` indices of vertices; m is 0 for a cloud.
    """

    name: str
    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]

    @property
    def is_mesh(self) -> bool:
        """Whether it has a surface."""
        return len(self.triangles) > 0

    @property
    def foot(self) -> float:
        """Height of its lowest point, metres."""
        return float(self.vertices[:, 2].min())


def read_shape(path: str | Path) -> Shape:
    """Read a mesh (obj, ply, stl, off, gltf, glb) or a cloud (ply, pcd, xyz, pts).

    glTF has y up, and is turned; everything else is taken to have z up.

    Raises
    ------
    InputError
        If the file is missing, of an unknown kind, damaged, or holds neither a surface nor points.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"There is no file {path}; give a mesh or a point cloud.")
    suffix = path.suffix.lower()
    if suffix not in _READERS:
        raise InputError(
            f"{path} is neither a mesh nor a point cloud that can be read; use one of {', '.join(_READERS)}."
        )
    try:
        shape = Shape(path.stem, *_READERS[suffix](path))
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror or error}.") from error
    _check(shape, path)
    return _without_loose_vertices(shape) if shape.is_mesh else shape


def _read_mesh(path: Path) -> Surface:
    mesh = _quietly("read_triangle_mesh", path)
    vertices = np.asarray(mesh.vertices, dtype=np.float64).reshape(-1, 3)
    return vertices, np.asarray(mesh.triangles, dtype=np.int32).reshape(-1, 3)


def _read_gltf(path: Path) -> Surface:
    """Read a mesh and turn it: glTF has y up."""
    vertices, triangles = _read_mesh(path)
    return vertices[:, [0, 2, 1]] * [1.0, -1.0, 1.0], triangles


def _read_points(path: Path) -> Surface:
    cloud = _quietly("read_point_cloud", path)
    return np.asarray(cloud.points, dtype=np.float64).reshape(-1, 3), _NO_TRIANGLES


def _read_pcd(path: Path) -> Surface:
    return read_pcd(path), _NO_TRIANGLES


_READERS: Final[Mapping[str, Callable[[Path], Surface]]] = {
    **dict.fromkeys((".stl", ".off"), _read_mesh),
    **dict.fromkeys((".gltf", ".glb"), _read_gltf),
    **dict.fromkeys((".xyz", ".xyzn", ".xyzrgb", ".pts"), _read_points),
    ".obj": read_obj,
    ".ply": read_ply,
    ".pcd": _read_pcd,
}
_CLOUDS: Final = (".ply", ".pcd", ".xyz", ".xyzn", ".xyzrgb", ".pts")


def _without_loose_vertices(shape: Shape) -> Shape:
    """Leave out the vertices of no face: they are not part of the surface, and must not move its foot."""
    used, triangles = np.unique(shape.triangles, return_inverse=True)
    return Shape(shape.name, shape.vertices[used], triangles.reshape(-1, 3).astype(np.int32))


def _quietly(reader: str, path: Path) -> Any:
    """Call one of Open3D's readers, which report faults by an empty result; its own words stay unsaid."""
    o3d = open3d()
    with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
        try:
            return getattr(o3d.io, reader)(str(path))
        except RuntimeError as error:
            raise InputError(f"{path} cannot be read: it is damaged or not what its suffix says.") from error


def _check(shape: Shape, path: Path) -> None:
    if len(shape.vertices) == 0:
        raise InputError(f"{path} holds no points: it is empty, damaged or not what its suffix says.")
    if path.suffix.lower() not in _CLOUDS and not shape.is_mesh:
        raise InputError(f"{path} holds no surface: only points; give a mesh, or the points as .ply or .xyz.")
    if not np.isfinite(shape.vertices).all():
        raise InputError(f"{path} has coordinates that are not numbers; export it again.")
    across = float(np.ptp(shape.vertices, axis=0).max())
    if across > _LARGEST_M:
        raise InputError(
            f"{path} is {across:,.0f} m across, if its unit is the metre as it should be; scale it to metres."
        )
    if shape.is_mesh and not 0 <= shape.triangles.min() <= shape.triangles.max() < len(shape.vertices):
        raise InputError(f"{path} has faces that name points which are not there; it is damaged.")
