"""Furniture that touches, told apart by what each piece covers on the plan and how high it stands there.

Seen from above, a piece of furniture is a terrace or a few: the seat and the back of a chair, the mattress and the
pillow of a bed. Those of one piece make a convex figure together, or one is narrow beside the other, as backs and arms
are. Where a chair stands at a table, or a night table at a bed, the figure has a bay, and there it is cut.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from enfilade.ingest.cells import count_cells
from enfilade.ingest.objects.bays import LEAST_CELLS, area, columns, frame, hull_of, parts
from enfilade.ingest.objects.parameters import ObjectParameters
from enfilade.ingest.records import F64, Bool

I64 = NDArray[np.int64]

NEXT: Final = ((0, 1), (1, 0), (1, 1), (1, -1), (0, 2), (2, 0))
"""Steps to the cells that count as neighbours, one of each pair; two cells far for the gaps between scan lines."""
LEVEL: Final = 0.8
WHOLE_AGAIN: Final = 3
"""So many pieces make a combination."""
INSIDE_M: Final = 0.12
"""What stands on a table is so far from the table's edge, in the middle."""


@dataclass(frozen=True, slots=True)
class _Terrace:
    """A part of the plan: its hull, its area, width and height, and whether it is a surface that was seen.

    Of what is taller than the scanner only edges are seen from above, and these tell little about its plan.
    """

    hull: shapely.Geometry
    area: float
    width: float
    height: float
    surface: bool


def split(points: F64, parameters: ObjectParameters) -> I64:
    """Split what hangs together into pieces of furniture.

    Parameters
    ----------
    points
        ``(n, 3)`` metres.
    parameters
        Cells, steps, widths.

    Returns
    -------
    ``(n,) int64`` number of the piece of each point, from 0.
    """
    places, column = columns(points, parameters)
    cell = np.floor(places / parameters.plan_cell_m).astype(np.int64)
    height = np.full(len(cell), -np.inf)
    np.maximum.at(height, column, points[:, 2])
    a, b = _neighbours(cell)
    terrace = _terraces(cell, height, a, b, parameters.max_step_m)
    terrace = _cut_tops(terrace, cell, places, parameters)
    if terrace.max() == 0:
        return np.zeros(len(points), dtype=np.int64)
    pairs = np.unique(np.sort(np.column_stack([terrace[a], terrace[b]]), axis=1), axis=0, return_counts=True)
    piece, below = _merge(terrace, places, height, pairs, parameters)
    own = piece[terrace[column]]
    under = below[terrace[column]]
    lower = (under[:, 0] >= 0) & (points[:, 2] < under[:, 1])
    own[lower] = piece[under[lower, 0].astype(np.int64)]
    return np.unique(own, return_inverse=True)[1].astype(np.int64)


def _neighbours(cell: I64) -> tuple[I64, I64]:
    """Pairs of cells, by index, that lie beside one another."""
    low = cell.min(axis=0) - 2
    width = int(np.ptp(cell[:, 1])) + 5
    key = (cell[:, 0] - low[0]) * width + cell[:, 1] - low[1]
    first, second = [], []
    for step in NEXT:
        at = np.minimum(np.searchsorted(key, key + step[0] * width + step[1]), len(key) - 1)
        found = np.flatnonzero(key[at] == key + step[0] * width + step[1])
        first.append(found)
        second.append(at[found])
    return np.concatenate(first), np.concatenate(second)


def _terraces(cell: I64, height: F64, a: I64, b: I64, step_m: float) -> I64:
    """``(k,)`` terrace of each cell; those of few cells go with the next large one."""
    level = np.abs(height[a] - height[b]) < step_m
    graph = coo_array((np.ones(level.sum(), dtype=bool), (a[level], b[level])), shape=(len(cell), len(cell)))
    terrace = connected_components(graph, directed=False)[1]
    size = np.bincount(terrace)
    large = size[terrace] >= min(LEAST_CELLS, size.max())
    nearest = cKDTree(cell[large]).query(cell[~large])[1]
    terrace[~large] = terrace[large][nearest]
    return np.unique(terrace, return_inverse=True)[1].astype(np.int64)


def _cut_tops(terrace: I64, cell: I64, places: F64, parameters: ObjectParameters) -> I64:
    """Cut tops that were seen, longer than any single one and not convex: tables put together around a bay."""
    order = np.argsort(terrace, kind="stable")
    groups = np.split(order, np.cumsum(np.bincount(terrace))[:-1])
    cut, count = terrace.copy(), len(groups)
    for own in groups:
        if np.ptp(places[own], axis=0).max() > parameters.max_single_m and _is_top(cell[own]):
            for part in list(parts(places[own], parameters, 0.0))[1:]:
                cut[own[part]] = count
                count += 1
    return cut


def _is_top(cell: I64) -> bool:
    """Whether most cells have all their neighbours: a surface, and no edges of one."""
    low = cell.min(axis=0)
    grid = np.zeros(np.ptp(cell, axis=0) + 1, dtype=bool)
    grid[tuple((cell - low).T)] = True
    square = np.ones((3, 3), dtype=bool)
    closed = ndimage.binary_closing(np.pad(grid, 2), square)
    return bool(ndimage.binary_erosion(closed, square).sum() > 0.5 * len(cell))


def _merge(
    terrace: I64, places: F64, height: F64, pairs: tuple[I64, I64], parameters: ObjectParameters
) -> tuple[I64, F64]:
    """Join terraces of one piece, along the longest borders first.

    Returns
    -------
    Piece of each terrace; and for those that stand on another, that other and its height, else -1.
    """
    order = np.argsort(terrace, kind="stable")
    groups = np.split(order, np.cumsum(np.bincount(terrace))[:-1])
    known = [_terrace(places[own], height[own], parameters) for own in groups]
    piece = np.arange(len(known))
    below = np.full((len(known), 2), -1.0)
    changed = True
    while changed:
        changed = False
        for a, b in pairs[0][np.lexsort((pairs[0][:, 1], pairs[0][:, 0], -pairs[1]))]:
            first, second = piece[a], piece[b]
            if first == second:
                continue
            low, high = (first, second) if known[first].height <= known[second].height else (second, first)
            if _stands_on(known[high], known[low], parameters):
                below[piece == high] = low, known[low].height + parameters.clearance_m
            elif _is_one(known[first], known[second], parameters):
                piece[piece == second] = first
                own = np.flatnonzero(piece[terrace] == first)
                known[first] = _terrace(places[own], height[own], parameters)
                changed = True
    return piece, below


def _terrace(places: F64, height: F64, parameters: ObjectParameters) -> _Terrace:
    hull = hull_of(places)
    width = min(_sides(hull))
    surface = width > parameters.min_surface_m and _is_filled(places, hull, parameters)
    return _Terrace(hull, area(hull), width, float(np.median(height)), surface)


def _is_filled(places: F64, hull: shapely.Geometry, parameters: ObjectParameters) -> bool:
    """Whether places fill most of their hull."""
    return bool(len(places) * parameters.plan_cell_m**2 >= parameters.min_fill * area(hull))


def _sides(hull: shapely.Geometry) -> tuple[float, float]:
    corners = shapely.get_coordinates(shapely.minimum_rotated_rectangle(hull))
    a, b = np.hypot(*(corners[1] - corners[0])), np.hypot(*(corners[2] - corners[1]))
    return float(a), float(b)


def _is_one(first: _Terrace, second: _Terrace, parameters: ObjectParameters) -> bool:
    """Whether two terraces side by side are of one piece."""
    low, high = (first, second) if first.height <= second.height else (second, first)
    arm = high.width < parameters.max_arm_m
    if high.height - low.height > (parameters.max_back_m if arm else parameters.max_stage_m):
        return False
    both = shapely.union(first.hull, second.hull)
    bay = area(shapely.convex_hull(both)) - area(both)
    if not arm and bay > min(first.area, second.area):
        return False
    strict = not arm and first.surface and second.surface
    least = parameters.min_convexity if strict else parameters.min_arm_convexity
    return area(both) >= least * area(shapely.convex_hull(both))


def _stands_on(high: _Terrace, low: _Terrace, parameters: ObjectParameters) -> bool:
    """Whether one stands in the middle of the other, as a thing on a table."""
    raised = high.height - low.height > parameters.min_thing_m
    small = high.area < 0.5 * low.area and low.area > parameters.min_table_m2
    return raised and small and bool(shapely.contains(shapely.buffer(low.hull, -INSIDE_M), shapely.centroid(high.hull)))


def cut_row(points: F64, floor_m: float, parameters: ObjectParameters) -> Iterator[I64]:
    """Cut what is longer than any one piece of furniture, or one cupboard, into modules.

    Rows of kitchen units, cupboards and shelves show neither gaps nor steps where one ends. Up to three modules
    make a unit again, and one that is no row after all.

    Parameters
    ----------
    points
        ``(n, 3)`` metres, one part after `cut_bays`.
    floor_m
        Height of the floor: boards and pictures hang on the wall over it.
    parameters
        Longest single piece, widest cupboard, module, depth of a row.

    Yields
    ------
    Indices of the points of each module.
    """
    places, column = columns(points, parameters)
    axes, extent = frame(places)
    length = float(extent.max())
    along = points[:, :2] @ axes[:, int(extent.argmax())]
    count = round(length / parameters.module_m)
    if length <= parameters.max_single_m:
        hangs = points[:, 2].min() > floor_m + parameters.min_board_m and extent.min() < parameters.min_board_m
        front = length > parameters.max_unit_m and not hangs and _is_front(along, points[:, 2], parameters)
        count = min(count, WHOLE_AGAIN) if front else 1
    deepest = parameters.max_row_depth_m
    if count > 1 and extent.min() > deepest and _is_level(points, column, parameters):
        deepest = parameters.max_table_depth_m
    if count == 1 or extent.min() > deepest:
        yield np.arange(len(points))
        return
    share = (along - along.min()) / length
    module = np.minimum(share * count, count - 1).astype(np.int64)
    if length > parameters.max_single_m and extent.min() <= parameters.max_row_depth_m:
        upon = _is_upon_worktop(points, along, column, floor_m, parameters)
        module[upon] = count + np.minimum(share[upon] * WHOLE_AGAIN, WHOLE_AGAIN - 1).astype(np.int64)
    yield from (np.flatnonzero(module == k) for k in np.unique(module))


def _is_upon_worktop(points: F64, along: F64, column: I64, floor_m: float, parameters: ObjectParameters) -> Bool:
    """``(n,) bool``: which points of a row are the worktop that lies on closed units, or stand on it."""
    height = np.full(column.max() + 1, -np.inf)
    np.maximum.at(height, column, points[:, 2])
    level = float(np.median(height))
    upon = points[:, 2] > level - parameters.max_step_m
    as_high = parameters.min_top_m < level - floor_m < parameters.max_top_m
    flat = (np.abs(height - level) < parameters.max_step_m).mean() > parameters.min_fill
    if as_high and flat and not upon.all() and _is_front(along[~upon], points[~upon, 2], parameters):
        return upon
    return np.zeros(len(points), dtype=bool)


def _is_level(points: F64, column: I64, parameters: ObjectParameters) -> bool:
    """Whether a piece is as high everywhere: a table, and no sofa."""
    height = np.full(column.max() + 1, -np.inf)
    np.maximum.at(height, column, points[:, 2])
    return bool((np.abs(height - np.median(height)) < parameters.max_step_m).mean() > LEVEL)


def _is_front(along: F64, height: F64, parameters: ObjectParameters) -> bool:
    """Whether points fill an upright rectangle as high as a cupboard: none of tables, beds, radiators and shelves."""
    places = np.column_stack([along, height])
    extent = np.ptp(places, axis=0)
    cells = count_cells(places, parameters.plan_cell_m)
    filled = cells * parameters.plan_cell_m**2 / float(np.prod(extent + parameters.plan_cell_m))
    return bool(extent[1] > parameters.min_cupboard_m and filled > parameters.min_front_fill)
