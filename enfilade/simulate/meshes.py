"""Scenes from mesh files: structure only, its rooms unknown."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from enfilade.errors import InputError
from enfilade.native import open3d

from .casting import Caster
from .scene import Scene, SceneParts
from .solids import F64, Mesh
from .stations import Setup

_STEP_DOWN_M = 0.05
MESH_SUFFIXES = (".obj", ".ply", ".stl")


def mesh_scene(
    path: Path,
    *,
    stations: Path | F64 | None = None,
    spacing_m: float = 3.0,
    setup: Setup | None = None,
) -> Scene:
    """Make a scene of a mesh file, in metres, z up.

    Parameters
    ----------
    path
        An OBJ, PLY or STL file.
    stations
        Scanner positions: ``(S, 3)`` metres, or a CSV file with the header ``x,y,z``. Without them the scanner is
        set up on a grid wherever there is a floor below, a ceiling above and nothing near.
    spacing_m
        Step of that grid.
    setup
        Height and clearance of those positions.

    Raises
    ------
    InputError
        If a file cannot be read, the mesh has no triangles, or no position is found.
    """
    mesh = read_mesh(path)
    if stations is None:
        places = _grid_stations(mesh, spacing_m, setup or Setup())
    else:
        places = _read_stations(stations) if isinstance(stations, Path) else np.asarray(stations, dtype=np.float64)
    if not len(places):
        raise InputError(f"{path}: found no place for the scanner between a floor and a ceiling; give positions")
    parts = SceneParts()
    parts.add_structure(mesh)
    return Scene(path.stem, *parts.arrays(), (), (), (), (), places)


def read_mesh(path: Path) -> Mesh:
    """Read an OBJ, PLY or STL file.

    Raises
    ------
    InputError
        If the file is missing, of another kind, or has no triangles.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    if path.suffix.lower() not in MESH_SUFFIXES:
        raise InputError(f"{path}: not a mesh file; {', '.join(MESH_SUFFIXES)} can be read")
    read = open3d().io.read_triangle_mesh(str(path))
    mesh = Mesh(np.asarray(read.vertices, dtype=np.float64), np.asarray(read.triangles, dtype=np.int32))
    if not len(mesh.triangles) or not np.isfinite(mesh.vertices).all():
        raise InputError(f"{path}: holds no triangles that can be used")
    return mesh


def _read_stations(path: Path) -> F64:
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = [[float(row[axis]) for axis in "xyz"] for row in csv.DictReader(file)]
    except (OSError, UnicodeDecodeError, csv.Error, KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path}: not a CSV file of numbers with the header x,y,z ({error})") from error
    if not rows:
        raise InputError(f"{path}: holds no scanner positions; write one a line under the header x,y,z")
    return np.array(rows, dtype=np.float64)


def _grid_stations(mesh: Mesh, spacing_m: float, setup: Setup) -> F64:
    """Places over every floor that has a ceiling, on a plan grid."""
    caster = Caster(mesh)
    low, high = mesh.bounds
    xs, ys = (np.arange(a + spacing_m / 2, b, spacing_m) for a, b in zip(low[:2], high[:2], strict=True))
    plan = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
    level = np.full(len(plan), high[2] + 1.0)
    found = [np.empty((0, 3))]
    while len(plan):
        above = np.column_stack([plan, level])
        drop = caster.cast(above, np.tile([0.0, 0.0, -1.0], (len(plan), 1)))[0]
        below = np.isfinite(drop)
        plan, level = plan[below], (level - drop)[below] - _STEP_DOWN_M
        found.append(np.column_stack([plan, level + _STEP_DOWN_M + setup.height_m]))
    places = np.concatenate(found)
    roofed = np.isfinite(caster.cast(places, np.tile([0.0, 0.0, 1.0], (len(places), 1)))[0])
    drop = caster.cast(places, np.tile([0.0, 0.0, -1.0], (len(places), 1)))[0]
    free = roofed & (np.abs(drop - setup.height_m) < 0.02) & (caster.distance(places) >= setup.clearance_m)
    chosen: F64 = places[free]
    return chosen
