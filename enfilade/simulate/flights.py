"""Stairs of a building model: the two rooms they join and the hole in the slab above them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from .casting import Caster
from .locate import Locator, commonest
from .scene import OUTSIDE, Opening, Room
from .solids import F64, Mesh, unit_normals

_UP = np.array([0.0, 0.0, 1.0])
_CELL_M = 0.05
_AREA_AT_LEAST_M2 = 0.2


def stairs_between(mesh: Mesh, rooms: Sequence[Room], locator: Locator, fabric: Caster) -> Opening | None:
    """Link the rooms that a flight of stairs stands in and leads to; None where there are no two."""
    treads = _tread_points(mesh)
    foot_points = treads[treads[:, 2] < treads[:, 2].min() + 0.6]
    lower = commonest(locator.rooms_of(_around(foot_points, 0.4)))
    if lower == OUTSIDE:
        return None
    floor = rooms[lower].floor_elevation
    higher = [room for room in rooms if floor + 1.5 < room.floor_elevation < treads[:, 2].max() + 0.4]
    if not higher:
        return None
    level = min(room.floor_elevation for room in higher)
    head_points = treads[np.abs(treads[:, 2] - level) < 0.6]
    found = locator.rooms_of(_around(head_points, 0.4 + np.abs(treads[:, 2] - level).min()))
    upper = commonest(found[np.isin(found, [room.number for room in higher])])
    if upper == OUTSIDE:
        return None
    ends = np.stack([foot_points.mean(axis=0), head_points.mean(axis=0)])
    return _well(mesh, rooms[lower], rooms[upper], ends, fabric)


def _tread_points(mesh: Mesh) -> F64:
    """Centres of the upward triangles that are large enough to step on."""
    corners = mesh.vertices[mesh.triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    level = (np.abs(unit_normals(mesh)[:, 2]) > 0.95) & (area > 0.02)
    centres: F64 = corners.mean(axis=1)
    return centres[level] if level.any() else centres


def _around(points: F64, lift: float) -> F64:
    """Points on rings of up to 0.9 m about each point, lifted."""
    angles = np.arange(8) * np.pi / 4
    rings = np.array([[r * np.cos(a), r * np.sin(a), lift] for r in (0.0, 0.3, 0.6, 0.9) for a in angles])
    around: F64 = (points[:, None] + rings[None]).reshape(-1, 3)
    return around


def _well(mesh: Mesh, lower: Room, upper: Room, ends: F64, fabric: Caster) -> Opening:
    """Measure the hole in the slab above the stairs: cells from which a ray falls through it."""
    bottom, top = lower.ceiling_elevation, upper.floor_elevation
    (x0, y0, _), (x1, y1, _) = mesh.bounds + np.array([[-0.3, -0.3, 0.0], [0.3, 0.3, 0.0]])
    xs, ys = np.arange(x0, x1, _CELL_M), np.arange(y0, y1, _CELL_M)
    plan = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
    plan = plan[shapely.contains_xy(upper.polygon, plan)]
    above = np.column_stack([plan, np.full(len(plan), top + 0.1)])
    below = np.column_stack([plan, np.full(len(plan), min(bottom, top - 0.05) - 0.05)])
    free = plan[~fabric.blocked(above, below)]
    if len(free) * _CELL_M**2 < _AREA_AT_LEAST_M2:
        free = mesh.vertices[:, :2]
    low, high = free.min(axis=0) - _CELL_M / 2, free.max(axis=0) + _CELL_M / 2
    axis = np.argmin(high - low)
    size = np.sort(high - low)
    return Opening(
        "stairs",
        None,
        np.array([*((low + high) / 2), (min(bottom, top) + top) / 2]),
        np.eye(3)[axis],
        _UP,
        float(size[0]),
        float(size[1]),
        max(top - bottom, 0.05),
        None,
        (lower.number, upper.number),
        ends,
    )
