"""Plan polygons: from meshes, to meshes, and what lies along their boundary."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from shapely import Polygon

from .solids import F64, Mesh, merge, unit_normals

COLUMN_STEP_M = 0.1


@dataclass(frozen=True, slots=True)
class Columns:
    """Points along a polygon's boundary, one about every `COLUMN_STEP_M`.

    Attributes
    ----------
    points, outwards
        ``(C, 2)`` positions, metres, and unit vectors out of the polygon.
    widths
        ``(C,)`` length of boundary that each stands for, metres.
    """

    points: F64
    outwards: F64
    widths: F64


def footprint(mesh: Mesh) -> Polygon:
    """Return the largest polygon of a mesh's projection on the plan, simplified to 5 mm."""
    level = np.abs(unit_normals(mesh)[:, 2]) > 0.2
    corners = mesh.vertices[mesh.triangles[level]][:, :, :2]
    triangles = shapely.polygons(corners)
    return largest_polygon(
        shapely.union_all(shapely.buffer(triangles, 1e-3, join_style="mitre")).buffer(-1e-3, join_style="mitre")
    )


def largest_polygon(shape: shapely.Geometry) -> Polygon:
    """Return the largest part that is a polygon, simplified to 5 mm; an empty one where there is none."""
    parts = [part for part in shapely.get_parts(shapely.simplify(shape, 0.005)) if isinstance(part, Polygon)]
    return max(parts, key=lambda part: part.area, default=Polygon())


def polygon_of(shape: shapely.Geometry) -> Polygon:
    """Return a shape that is known to be one polygon."""
    assert isinstance(shape, Polygon), shape
    return shape


def extrude(polygon: Polygon, bottom: float, top: float) -> Mesh:
    """Return the closed prism over a polygon, holes included."""
    cells = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    caps = [_cap(cell, z, up) for cell in cells for z, up in ((bottom, False), (top, True))]
    outer = shapely.orient_polygons(polygon)
    rings = [np.array(ring.coords)[:, :2] for ring in (outer.exterior, *outer.interiors)]
    return merge([*caps, *(_sides(ring, bottom, top) for ring in rings)])


def _cap(triangle: Polygon, z: float, up: bool) -> Mesh:
    corners = np.array(shapely.orient_polygons(triangle).exterior.coords)[:3, :2]
    order = [0, 1, 2] if up else [0, 2, 1]
    return Mesh(np.column_stack([corners, np.full(3, z)]), np.array([order], dtype=np.int32))


def _sides(ring: F64, bottom: float, top: float) -> Mesh:
    count = len(ring) - 1
    low, high = (np.column_stack([ring[:-1], np.full(count, z)]) for z in (bottom, top))
    here = np.arange(count)
    there = np.roll(here, -1)
    triangles = np.concatenate(
        [np.column_stack([here, there, there + count]), np.column_stack([here, there + count, here + count])]
    )
    return Mesh(np.concatenate([low, high]), triangles.astype(np.int32))


def plan_samples(polygon: Polygon, z: float, step: float = 0.4) -> F64:
    """``(K, 3)`` points of a grid in a polygon, at least one."""
    x0, y0, x1, y1 = polygon.bounds
    plan = np.stack(np.meshgrid(np.arange(x0 + step / 2, x1, step), np.arange(y0 + step / 2, y1, step)), -1).reshape(
        -1, 2
    )
    plan = plan[shapely.contains_xy(polygon, plan)]
    if not len(plan):
        plan = np.array(polygon.representative_point().coords)
    return np.column_stack([plan, np.full(len(plan), z)])


def boundary_columns(polygon: Polygon) -> Columns:
    """Return points along a polygon's boundary; edges shorter than the step have none."""
    points, outwards, widths = [np.empty((0, 2))], [np.empty((0, 2))], [np.empty(0)]
    oriented = shapely.orient_polygons(polygon)
    for ring in (oriented.exterior, *oriented.interiors):
        for start, end in pairwise(np.array(ring.coords)[:, :2]):
            length = float(np.linalg.norm(end - start))
            count = int(length / COLUMN_STEP_M)
            if count:
                along = (end - start) / length
                offsets = (np.arange(count) + 0.5) * length / count
                points.append(start + offsets[:, None] * along)
                outwards.append(np.tile([along[1], -along[0]], (count, 1)))
                widths.append(np.full(count, length / count))
    return Columns(np.concatenate(points), np.concatenate(outwards), np.concatenate(widths))


def distance_along(start: F64, direction: F64, polygon: Polygon, reach: float) -> F64:
    """``(C,)`` distance from each start to where its ray enters a polygon, infinity for none within `reach`."""
    lines = shapely.linestrings(np.stack([start - 0.01 * direction, start + reach * direction], axis=1))
    common = shapely.intersection(lines, polygon)
    distance = shapely.distance(shapely.points(start), common)
    return np.where(shapely.length(common) > 0.05, distance, np.inf)
