"""Bays in the plan of furniture: where pieces meet in a corner, and are cut straight."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, cast

import numpy as np
import shapely
from numba import njit
from numpy.typing import NDArray

from enfilade.ingest.objects.parameters import ObjectParameters
from enfilade.ingest.records import F64, Bool

I64 = NDArray[np.int64]

CUT_M: Final = 0.05
SHORT_M: Final = 0.1
"""A cut may leave so much more hull, in m² a metre, if it is shorter: of two as good, the shorter is right."""
SLIT_CELL_M: Final = 0.01
STRAY: Final = 0.15
"""So much of what is elsewhere may lie in a slit: points in the air between near and far edges."""
LEAST_CELLS: Final = 6
WIDER_M: Final = 0.02
"""Hulls of the cells' centres are made so much wider."""


def cut_bays(points: F64, parameters: ObjectParameters) -> Iterator[I64]:
    """Cut a piece straight where its plan has a bay: in the corner of a kitchen, where a table meets a bed as high.

    Parameters
    ----------
    points
        ``(n, 3)`` metres, one piece after `split`.
    parameters
        Convexity, least width.

    Yields
    ------
    Indices of the points of each part.
    """
    cell, column = columns(points, parameters)
    part = np.zeros(len(cell), dtype=np.int64)
    for number, own in enumerate(parts(cell, parameters, parameters.min_fill * parameters.min_convexity)):
        part[own] = number
    yield from (np.flatnonzero(part[column] == k) for k in range(part.max() + 1))


def cut_slits(points: F64, parameters: ObjectParameters) -> Iterator[I64]:
    """Cut a piece where a straight slit goes through all of its plan, as between a table and what stands close to it.

    The lines in which a scanner sees a top leave gaps as well, of which none is much wider than all others.

    Parameters
    ----------
    points
        ``(n, 3)`` metres, one piece after `split`.
    parameters
        Least width of pieces and of slits.

    Yields
    ------
    Indices of the points of each part.
    """
    waiting = [np.arange(len(points))]
    while waiting:
        own = waiting.pop()
        half = _slit(points[own], parameters)
        if half is None:
            yield own
        else:
            waiting += [own[~half], own[half]]


def _slit(points: F64, parameters: ObjectParameters) -> Bool | None:
    """Which points lie on one side of a slit between two surfaces that were seen, None if there is none."""
    cells, column = columns(points, parameters)
    along, extent = frame(cells)
    margin = parameters.min_board_m
    for axis in np.flatnonzero(extent > 2 * margin):
        place = points[:, :2] @ along[:, axis]
        filled = np.bincount(((place - place.min()) / SLIT_CELL_M).astype(np.int64))
        full = np.flatnonzero(filled > STRAY * np.median(filled[filled > 0]))
        gap = (np.diff(full) - 1) * SLIT_CELL_M
        if len(gap) < 2 or gap.max() < max(parameters.min_slit_m, 2 * np.partition(gap, -2)[-2]):
            continue
        before = int(gap.argmax())
        half: Bool = place < place.min() + (full[before] + full[before + 1] + 1) / 2 * SLIT_CELL_M
        if all(_is_surface(cells[np.unique(column[side])], along, parameters) for side in (half, ~half)):
            return half
    return None


def _is_surface(cells: F64, along: F64, parameters: ObjectParameters) -> bool:
    """Whether cells fill most of their hull, and that is as wide as furniture."""
    wide = len(cells) >= LEAST_CELLS and np.ptp(cells @ along, axis=0).min() >= parameters.min_board_m
    return bool(wide and len(cells) * parameters.plan_cell_m**2 >= parameters.min_fill * area(hull_of(cells)))


def parts(cells: F64, parameters: ObjectParameters, least_covered: float) -> Iterator[I64]:
    """Cut until no part that covers at least so much of its hull has a bay; yields the cells of each part."""
    waiting = [np.arange(len(cells))]
    while waiting:
        own = waiting.pop()
        half = _bay(cells[own], parameters, least_covered)
        if half is None:
            yield own
        else:
            waiting += [own[~half], own[half]]


def _bay(cells: F64, parameters: ObjectParameters, least_covered: float) -> Bool | None:
    """Which cells lie on one side of the straight cut that takes most off the hull, None if none takes much.

    Halves must fill their hulls, but where all is cut that covers however little of its hull.

    Only surfaces that were seen are cut: the edges of a cupboard that hides its top make bays of all kinds.
    """
    hull, margin = hull_of(cells), parameters.min_board_m
    covered = len(cells) * parameters.plan_cell_m**2 / area(hull)
    if len(cells) < 2 * LEAST_CELLS or not least_covered < covered < parameters.min_convexity:
        return None
    along, extent = frame(cells)
    place = cells @ along
    most = parameters.min_convexity * area(hull)
    most_a_cell = parameters.plan_cell_m**2 / parameters.min_fill if least_covered else np.inf
    best, cut = np.inf, None
    for axis in np.flatnonzero(extent > 2 * margin):
        places = place[:, [axis, 1 - axis]]
        places = places[np.lexsort(places.T[::-1])]
        cuts = np.arange(places[0, 0] + margin, places[-1, 0] - margin, CUT_M)
        cost, at = _cheapest_cut(places, cuts, margin, most, most_a_cell, 2 * parameters.plan_cell_m)
        if cost < best:
            best, cut = cost, place[:, axis] < at
    return cut


@njit(cache=True, nogil=True)
def _cheapest_cut(
    places: F64, cuts: F64, margin: float, most: float, most_a_cell: float, beside: float
) -> tuple[float, float]:
    """Find the cut across the first axis that leaves least hull, of those that leave less than `most`, and its cost.

    Places are sorted. Either half has a few cells, is as wide as the margin, and its hull is no larger than
    `most_a_cell` a cell.
    """
    best, best_at = np.inf, 0.0
    for at in cuts:
        count = np.searchsorted(places[:, 0], at)
        area, length, fits = 0.0, np.inf, True
        for first, past in ((0, count), (count, len(places))):
            half = places[first:past]
            if past - first < LEAST_CELLS or half[-1, 0] - half[0, 0] < margin or np.ptp(half[:, 1]) < margin:
                fits = False
                break
            own = hull_area(half)
            fits &= own <= most_a_cell * len(half)
            area += own
            near = half[np.abs(half[:, 0] - at) < beside, 1]
            length = min(length, np.ptp(near) if len(near) else 0.0)
        cost = area + SHORT_M * length
        if fits and area < most and cost < best:
            best, best_at = cost, at
    return best, best_at


@njit(cache=True, nogil=True)
def hull_area(places: F64) -> float:
    """Area of the convex hull of sorted places, as much wider on all sides as `hull_of` makes it."""
    area, around = 0.0, 0.0
    chain = np.empty((len(places), 2))
    for way in (1, -1):
        size = 0
        for here in places[::way]:
            while size > 1 and _turn(chain[size - 2], chain[size - 1], here) <= 0.0:
                size -= 1
            chain[size] = here
            size += 1
        for k in range(size - 1):
            (x, y), (next_x, next_y) = chain[k], chain[k + 1]
            area += (x * next_y - next_x * y) / 2
            around += np.hypot(next_x - x, next_y - y)
    return area + WIDER_M * around + np.pi * WIDER_M**2


@njit(cache=True, nogil=True, inline="always")
def _turn(a: F64, b: F64, c: F64) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def columns(points: F64, parameters: ObjectParameters) -> tuple[F64, I64]:
    """Return the centres of the plan's cells, ``(k, 2)``, and the cell of each point."""
    cell = np.floor(points[:, :2] / parameters.plan_cell_m).astype(np.int64)
    low = cell.min(axis=0)
    width = int(cell[:, 1].max() - low[1]) + 1
    key, column = np.unique((cell[:, 0] - low[0]) * width + cell[:, 1] - low[1], return_inverse=True)
    centres = np.column_stack([key // width, key % width]) + low + 0.5
    return centres * parameters.plan_cell_m, column


def hull_of(places: F64) -> shapely.Geometry:
    """Return the convex hull of the centres of cells, a little wider than that."""
    hull = shapely.convex_hull(shapely.linestrings(np.concatenate([places, places[:1]])))
    return cast(shapely.Geometry, shapely.buffer(hull, WIDER_M))


def area(shape: shapely.Geometry) -> float:
    """Return the area of a shape, m²."""
    return float(shapely.area(shape))


def frame(places: F64) -> tuple[F64, F64]:
    """Return the axes of the smallest rectangle around places, in columns, and its sides along them."""
    corners = shapely.get_coordinates(shapely.minimum_rotated_rectangle(hull_of(places)))
    u = (corners[1] - corners[0]) / np.hypot(*(corners[1] - corners[0]))
    frame = np.column_stack([u, [-u[1], u[0]]])
    return frame, np.ptp(places @ frame, axis=0)
