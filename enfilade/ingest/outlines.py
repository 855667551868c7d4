"""The outline of one room: what its ceiling and floor and the rays of its scanners cover, up to its walls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numba import njit
from numpy.typing import NDArray
from scipy import ndimage
from shapely import Polygon

from enfilade.faces import WallFaces, true_polygon

from .cells import extent, tile_rectangles
from .records import F32, F64, I32, Bool

I64 = NDArray[np.int64]
UInt8 = NDArray[np.uint8]

_FREE, _COVERED, _WALL = 0, 1, 2
_CROSS = ndimage.generate_binary_structure(2, 1)
_SQUARE = ndimage.generate_binary_structure(2, 2)


@dataclass(frozen=True, slots=True)
class OutlineParameters:
    """How an outline is drawn.

    Attributes
    ----------
    cell_m
        Side of the grid's cells (c of §4).
    gap_m
        Gaps in what is covered are closed up to this width.
    hole_m2
        Holes in what is covered are filled up to this area: what stands in the shadow of furniture.
    tolerance_m
        How far the simplified outline may stray, where it follows no wall.
    reach_m, least_face_m
        Widest gap in a wall, or between a wall and one across it, through which a room may be seen to go on, and
        the shortest wall that is looked at.
    least_enclosed
        Behind such a gap the room goes on if walls are around so much of what was seen there,
    least_roofed, least_leg_m2
        or if its ceiling is over so much of it and it is as large as that: less is what a ceiling's labels stray.
    reveal_m
        What is no deeper and has no such ceiling is the reveal of a window or a door.
    """

    cell_m: float = 0.05
    gap_m: float = 0.30
    hole_m2: float = 1.0
    tolerance_m: float = 0.06
    reach_m: float = 6.0
    least_face_m: float = 0.5
    least_enclosed: float = 0.5
    least_roofed: float = 0.5
    least_leg_m2: float = 2.0
    reveal_m: float = 0.6


@dataclass(frozen=True, slots=True)
class Outline:
    """What is covered: m², centre ``(2,)`` and rings ``(K, 2)``, the outer one first, metres."""

    area: float
    centre: F64
    rings: tuple[F64, ...]


def draw_outline(
    level: F32,
    walls: F32,
    scanners: F32,
    sights: F32,
    parameters: OutlineParameters = OutlineParameters(),
    *,
    faces: WallFaces | None = None,
    ceiling: F32 | None = None,
) -> Outline:
    """Draw the outline of a room.

    Cells count that hold a horizontal surfel, as in §4, or that a ray to the room's own surfels crosses, for far
    floors are hit sparsely. Rays and cells end at the walls, of which only the strip under the ceiling is looked at:
    there, lintels close the doors and windows. Where a window or a passage reaches up to the ceiling, what lies
    behind the face of the wall counts only if walls enclose it, as they do a niche, or the ceiling goes on over it.
    Along faces the outline is as exact as they are. Without, a wall runs through its cells, so half of these count.

    Parameters
    ----------
    level
        ``(n, 2)`` horizontal surfels of the room.
    walls
        ``(w, 2)`` surfels of its walls under the ceiling.
    scanners, sights
        ``(r, 2)`` scanners and the room's surfels that they measured, pair by pair.
    faces
        Straight faces of its walls.
    ceiling
        ``(c, 2)`` surfels of its ceiling; None where it is not known, and then the room ends at nothing but walls.
    """
    cell_m = parameters.cell_m
    margin = int(np.ceil(parameters.gap_m / cell_m)) + 2
    least, greatest = extent(np.concatenate([level, walls, sights, *([] if ceiling is None else [ceiling])]))
    low = np.floor(least / cell_m).astype(np.int64) - margin
    shape = np.floor(greatest / cell_m).astype(np.int64) - low + margin + 1
    wall = _closed(_drawn(walls, low, shape, cell_m), 1)
    cells = np.where(wall, _WALL, np.where(_drawn(level, low, shape, cell_m), _COVERED, _FREE)).astype(np.uint8)
    _sweep(cells, scanners, sights, low, cell_m)
    stood = _in_cells(scanners, low, cell_m).astype(np.int64)
    inside = _inside(cells, stood, parameters)
    if faces is not None and ceiling is not None:
        bridges = _bridges(wall, faces, low, parameters)
        inside = _up_to_faces(inside, wall, bridges, _drawn(ceiling, low, shape, cell_m), stood, parameters)
    edge = wall & ndimage.binary_dilation(inside, _CROSS, iterations=2)
    polygon = _polygon(_closed(inside | edge, 1), low, parameters)
    if faces is not None and len(faces.centre):
        polygon = true_polygon(polygon, faces)
        centre = np.array(polygon.centroid.coords[0])
        return Outline(float(polygon.area), centre, _rings(polygon))
    weight = inside + 0.5 * edge
    centre = (np.array(ndimage.center_of_mass(weight)) + low + 0.5) * cell_m
    return Outline(float(weight.sum()) * cell_m**2, centre, _rings(polygon))


def _drawn(positions: F32, low: I64, shape: I64, cell_m: float) -> Bool:
    grid = np.zeros(shape, bool)
    grid[tuple(_in_cells(positions, low, cell_m).astype(np.int64).T)] = True
    return grid


def _in_cells(positions: F32, low: I64, cell_m: float) -> F64:
    return np.asarray(positions.astype(np.float64) / cell_m - low)


def _closed(grid: Bool, cells: int) -> Bool:
    return np.asarray(ndimage.binary_closing(grid, _SQUARE, iterations=cells))


@njit(cache=True, nogil=True)
def _sweep(cells: UInt8, starts: F32, ends: F32, low: I64, cell_m: float) -> None:
    """Cover the free cells along each ray, up to its end or the first wall; no cell twice running from one scanner."""
    last = np.full(cells.shape, -1, np.int64)
    for ray in range(len(starts)):
        x, y = np.float64(starts[ray, 0]) / cell_m - low[0], np.float64(starts[ray, 1]) / cell_m - low[1]
        dx = np.float64(ends[ray, 0]) / cell_m - low[0] - x
        dy = np.float64(ends[ray, 1]) / cell_m - low[1] - y
        end = (int(x + dx), int(y + dy))
        before, last[end] = last[end], ray
        if before >= 0 and starts[before, 0] == starts[ray, 0] and starts[before, 1] == starts[ray, 1]:
            continue
        steps = int(max(abs(dx), abs(dy))) + 1
        for step in range(steps):
            share = step / steps
            i, j = int(x + share * dx), int(y + share * dy)
            if i < 0 or j < 0 or i >= cells.shape[0] or j >= cells.shape[1]:
                continue
            if cells[i, j] == _WALL:
                break
            cells[i, j] = _COVERED


def _inside(cells: UInt8, scanners: I64, parameters: OutlineParameters) -> Bool:
    """Covered cells, gaps closed, of the pieces that a scanner stands in; of the largest where none does."""
    closing = int(np.ceil(parameters.gap_m / parameters.cell_m / 2.0))
    wall = cells == _WALL
    pieces, count = ndimage.label(_closed(cells == _COVERED, closing) & ~wall)
    if count == 0:
        return np.asarray(wall)
    on_grid = ((scanners >= 0) & (scanners < cells.shape)).all(axis=1)
    kept = np.unique(pieces[tuple(scanners[on_grid].T)])
    kept = kept[kept > 0]
    if not len(kept):
        kept = np.array([1 + np.argmax(np.bincount(pieces.ravel())[1:])])
    return _holes_filled(np.isin(pieces, kept), wall, parameters.hole_m2 / parameters.cell_m**2)


def _holes_filled(inside: Bool, wall: Bool, most_cells: float) -> Bool:
    holes, _ = ndimage.label(ndimage.binary_fill_holes(inside) & ~inside & ~wall)
    small = np.bincount(holes.ravel()) <= most_cells
    small[0] = False
    return np.asarray(inside | small[holes])


def _bridges(wall: Bool, faces: WallFaces, low: I64, parameters: OutlineParameters) -> Bool:
    """Cells along the lines of faces where these are open: between their parts, and on to the next wall across."""
    bridges = np.zeros(wall.shape, bool)
    near = ndimage.binary_dilation(wall, _CROSS)
    long = faces.span[:, 1] - faces.span[:, 0] >= parameters.least_face_m
    centre = faces.centre[long] / parameters.cell_m - low
    span, reach = faces.span[long] / parameters.cell_m, parameters.reach_m / parameters.cell_m
    _draw_bridges(bridges, near, centre, faces.along[long], span, reach, parameters.gap_m / parameters.cell_m)
    return np.asarray(bridges & ~wall)


@njit(cache=True, nogil=True)
def _draw_bridges(bridges: Bool, near: Bool, centre: F64, along: F64, span: F64, reach: float, slack: float) -> None:
    """Mark the gaps along each line, no wider than `reach`, within its span and on from wall to wall; all in cells."""
    for face in range(len(centre)):
        for way in (1.0, -1.0):
            first, last = (span[face, 0], span[face, 1]) if way > 0 else (-span[face, 1], -span[face, 0])
            step = way * along[face]
            place, opened = first - slack, -np.inf
            while place <= last + reach:
                i, j = (
                    int(np.floor(centre[face, 0] + place * step[0])),
                    int(np.floor(centre[face, 1] + place * step[1])),
                )
                if i < 0 or j < 0 or i >= near.shape[0] or j >= near.shape[1]:
                    if place > last:
                        break
                elif near[i, j]:
                    if 0.5 < place - opened <= reach and opened <= last + slack:
                        _draw_line(bridges, centre[face], step, opened, place)
                        last = max(last, place)
                    opened = place
                place += 0.5


@njit(cache=True, nogil=True)
def _draw_line(grid: Bool, centre: F64, along: F64, first: float, last: float) -> None:
    place = first
    while place <= last:
        grid[int(np.floor(centre[0] + place * along[0])), int(np.floor(centre[1] + place * along[1]))] = True
        place += 0.5


def _up_to_faces(
    inside: Bool, wall: Bool, bridges: Bool, ceiling: Bool, scanners: I64, parameters: OutlineParameters
) -> Bool:
    """Leave out what lies behind bridges where no scanner stands, unless walls enclose it or the ceiling goes on."""
    pieces, count = ndimage.label(inside & ~bridges)
    if count < 2:
        return inside
    size = np.bincount(pieces.ravel(), minlength=count + 1)
    near_wall = ndimage.binary_dilation(wall, _SQUARE)
    around, walled, bridged = _around(np.asarray(pieces, np.int32), bridges, near_wall, count)
    reach = int(np.ceil(parameters.gap_m / parameters.cell_m / 2.0))
    over = np.bincount(pieces[ndimage.binary_dilation(ceiling, _SQUARE, iterations=reach)], minlength=count + 1)
    roofed = over >= parameters.least_roofed * size
    deep = size * parameters.cell_m > parameters.reveal_m * bridged
    kept = roofed & (size * parameters.cell_m**2 >= parameters.least_leg_m2)
    kept |= (roofed | deep) & (walled >= parameters.least_enclosed * around)
    kept[np.argmax(size[1:]) + 1] = True
    on_grid = ((scanners >= 0) & (scanners < inside.shape)).all(axis=1)
    kept[pieces[tuple(scanners[on_grid].T)]] = True
    kept[0] = False
    left = kept[pieces]
    return np.asarray(left | (inside & bridges & ndimage.binary_dilation(left, _SQUARE)))


@njit(cache=True, nogil=True)
def _around(pieces: I32, bridges: Bool, walled: Bool, count: int) -> tuple[I64, I64, I64]:
    """Count sides of cells at the rim of each piece where no bridge ends it: those at walls, and the others."""
    rim, at_wall, at_bridge = (
        np.zeros(count + 1, np.int64),
        np.zeros(count + 1, np.int64),
        np.zeros(count + 1, np.int64),
    )
    for i in range(1, pieces.shape[0] - 1):
        for j in range(1, pieces.shape[1] - 1):
            piece = pieces[i, j]
            if piece == 0:
                continue
            for di, dj in ((1, 0), (-1, 0), (0, 1), (0, -1)):
                k, m = i + di, j + dj
                if bridges[k, m]:
                    at_bridge[piece] += 1
                elif pieces[k, m] != piece:
                    rim[piece] += 1
                    at_wall[piece] += walled[k, m]
    return rim, at_wall, at_bridge


def _polygon(grid: Bool, low: I64, parameters: OutlineParameters) -> Polygon:
    """Polygon around the largest piece of the grid, drawn in by half a cell, simplified."""
    cell_m = parameters.cell_m
    tiles = tile_rectangles(grid) + low[[0, 0, 1, 1]]
    runs = shapely.box(*(cell_m * tiles[:, [0, 2, 1, 3]].T))
    union = shapely.union_all(runs, grid_size=cell_m / 100.0)
    drawn_in = union.buffer(-cell_m / 2.0, join_style="mitre")
    parts = shapely.get_parts(union if drawn_in.is_empty else drawn_in)
    largest = max(parts, key=lambda part: float(part.area)).simplify(parameters.tolerance_m)
    return Polygon(largest.exterior, largest.interiors)


def _rings(polygon: Polygon) -> tuple[F64, ...]:
    return tuple(np.asarray(ring.coords, np.float64) for ring in (polygon.exterior, *polygon.interiors))
