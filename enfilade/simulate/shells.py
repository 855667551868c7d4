"""The surfaces around a space: floor, what is above, and sides, with holes in them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from .roofs import Plane, Roof
from .solids import F64, Mesh, merge

Cut = tuple[BaseGeometry, float, float]
"""A hole in sides: where it touches the plan, and from which to which elevation."""
_TOUCH_M = 1e-6


def shell(polygon: Polygon, floor: float, roof: Roof) -> Mesh:
    """Return the closed boundary of a space, turned outwards."""
    return merge([level(polygon, floor, up=False), *above(polygon, roof), *sides(polygon, floor, roof)])


def level(polygon: BaseGeometry, z: float, *, up: bool) -> Mesh:
    """Return a level surface at elevation `z`, its normal up or down."""
    return _surface(polygon, (0.0, 0.0, z), up=up)


def above(polygon: BaseGeometry, roof: Roof) -> list[Mesh]:
    """Return what is above a polygon, one mesh a plane, turned upwards."""
    parts = [part for part in shapely.get_parts(polygon) if isinstance(part, Polygon)]
    return [_surface(piece, plane, up=True) for part in parts for piece, plane in roof.regions(part)]


def sides(polygon: Polygon, floor: float, roof: Roof, cuts: Sequence[Cut] = ()) -> list[Mesh]:
    """Return the upright sides over a polygon's rings, one mesh an edge, turned outwards."""
    outer = shapely.orient_polygons(polygon)
    found = []
    for ring in (outer.exterior, *outer.interiors):
        for start, end in pairwise(np.array(ring.coords)[:, :2]):
            profile = roof.profile(start, end)
            face = Polygon([(0.0, floor), (profile[-1][0], floor), *reversed(profile)])
            found.append(_upright(start, end, face.difference(_holes(start, end, cuts))))
    return [mesh for mesh in found if len(mesh.triangles)]


def _holes(start: F64, end: F64, cuts: Sequence[Cut]) -> BaseGeometry:
    """Return what cuts take away from the side over one edge, as (metres from start, elevation)."""
    edge = shapely.linestrings([start, end])
    boxes = []
    for place, low, high in cuts:
        common = shapely.intersection(edge, shapely.buffer(place, _TOUCH_M))
        for part in shapely.get_parts(common):
            if part.length > 1e-4:
                along = np.linalg.norm(shapely.get_coordinates(part)[[0, -1]] - start, axis=1)
                boxes.append(shapely.box(along.min(), low, along.max(), high))
    return shapely.union_all(boxes)


def _upright(start: F64, end: F64, face: BaseGeometry) -> Mesh:
    direction = (end - start) / np.linalg.norm(end - start)
    corners = triangles_of(face)
    plan = start + corners[..., :1] * direction
    return _soup(np.concatenate([plan, corners[..., 1:]], axis=-1))


def _surface(polygon: BaseGeometry, plane: Plane, *, up: bool) -> Mesh:
    corners = triangles_of(polygon)
    z = corners @ np.array(plane[:2]) + plane[2]
    return _soup(np.concatenate([corners, z[..., None]], axis=-1)[:, :: 1 if up else -1])


def triangles_of(polygon: BaseGeometry) -> F64:
    """``(T, 3, 2)`` triangles that cover a polygon or several, anticlockwise."""
    cells = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    if not len(cells):
        return np.empty((0, 3, 2))
    return shapely.get_coordinates(shapely.orient_polygons(cells)).reshape(-1, 4, 2)[:, :3]


def _soup(corners: F64) -> Mesh:
    """Return a mesh of ``(T, 3, 3)`` triangles, each with vertices of its own."""
    return Mesh(corners.reshape(-1, 3), np.arange(3 * len(corners), dtype=np.int32).reshape(-1, 3))
