"""Meshes and clouds that a question shows as an example."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from enfilade.errors import InputError
from enfilade.native import open3d

from .wavefront import read_obj

MESH_SUFFIXES: Final = (".obj", ".ply", ".stl", ".off", ".gltf", ".glb")
CLOUD_SUFFIXES: Final = (".ply", ".pcd", ".xyz", ".xyzn", ".xyzrgb", ".pts")
_Y_UP: Final = (".gltf", ".glb")


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
    suffix = path.suffix.lower()
    if not path.is_file():
        raise InputError(f"There is no file {path}; give a mesh or a point cloud.")
    if suffix not in (*MESH_SUFFIXES, *CLOUD_SUFFIXES):
        known = ", ".join(dict.fromkeys((*MESH_SUFFIXES, *CLOUD_SUFFIXES)))
        raise InputError(f"{path} is neither a mesh nor a point cloud that can be read; use one of {known}.")
    if suffix == ".ply":
        _check_ply(path)
    shape = _read_mesh(path, suffix)
    if suffix in CLOUD_SUFFIXES and not shape.is_mesh:
        shape = _read_cloud(path)
    _check(shape, path)
    return _without_loose_vertices(shape) if shape.is_mesh else shape


def _read_mesh(path: Path, suffix: str) -> Shape:
    """Read a surface; an empty one where the file has none."""
    if suffix == ".obj":
        return Shape(path.stem, *read_obj(path))
    if suffix not in MESH_SUFFIXES:
        return Shape(path.stem, np.empty((0, 3)), np.empty((0, 3), np.int32))
    mesh = _quietly("read_triangle_mesh", path)
    vertices = np.asarray(mesh.vertices, dtype=np.float64).reshape(-1, 3)
    if suffix in _Y_UP:
        vertices = vertices[:, [0, 2, 1]] * [1.0, -1.0, 1.0]
    return Shape(path.stem, vertices, np.asarray(mesh.triangles, dtype=np.int32).reshape(-1, 3))


def _read_cloud(path: Path) -> Shape:
    cloud = _quietly("read_point_cloud", path)
    return Shape(path.stem, np.asarray(cloud.points, dtype=np.float64).reshape(-1, 3), np.empty((0, 3), np.int32))


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


def _check_ply(path: Path) -> None:
    """Refuse what Open3D's PLY reader would complain about on standard error."""
    with path.open("rb") as file:
        if file.read(3) != b"ply":
            raise InputError(f"{path} is no PLY file: it does not begin with 'ply'.")


def _check(shape: Shape, path: Path) -> None:
    if len(shape.vertices) == 0:
        raise InputError(f"{path} holds no points: it is empty, damaged or not what its suffix says.")
    if path.suffix.lower() not in CLOUD_SUFFIXES and not shape.is_mesh:
        raise InputError(f"{path} holds no surface: only points; give a mesh, or the points as .ply or .xyz.")
    if not np.isfinite(shape.vertices).all():
        raise InputError(f"{path} has coordinates that are not numbers; export it again.")
    if shape.is_mesh and not 0 <= shape.triangles.min() <= shape.triangles.max() < len(shape.vertices):
        raise InputError(f"{path} has faces that name points which are not there; it is damaged.")
