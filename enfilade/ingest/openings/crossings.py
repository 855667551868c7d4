"""Which laser rays end at which sides, and which go through: every ray is followed once.

A grid of cells knows the sides that pass through them, so that the cost is that of the rays' length in cells, however
many rooms there are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enfilade.ingest.records import F32, F64, I32, Bool
from enfilade.ingest.sides import Side
from enfilade.parallel import at_once, in_slices

I64 = NDArray[np.int64]

CELL_M: Final = 0.5
"""Side of the cells that know their sides."""

BORDER_M: Final = 0.1
"""Width of the border around a side in which points and crossings are looked at."""

PIECE_M: Final = 0.25
"""Sides are put into cells by places on them that are no farther apart than this."""


@dataclass(frozen=True, slots=True)
class Meetings:
    """Where rays meet sides, ordered by side, then ray.

    Attributes
    ----------
    ray
        ``(n,) int32``.
    first
        ``(sides + 1,) int64``: side k is met by ``first[k]:first[k + 1]``.
    place
        ``(n, 2) float32`` where, along the axes of the side, metres.
    depth
        ``(n,) float32`` how far behind the side the ray ends, metres, negative before it; for a ray that comes in
        through the side how far behind it the scanner stands.
    outbound
        ``(n,) bool`` whether the scanner stands in front.
    """

    ray: I32
    first: I64
    place: F32
    depth: F32
    outbound: Bool

    def of(self, side: int) -> slice:
        """Where the meetings with a side are."""
        return slice(int(self.first[side]), int(self.first[side + 1]))


@dataclass(frozen=True, slots=True)
class _Cells:
    """Cell c has the sides ``members[first[c]:first[c + 1]]``; `low` is the grid's corner, `shape` its cells."""

    low: F64
    shape: I64
    first: I64
    members: I32


class SideGrid:
    """Sides, ready to be met by rays.

    Parameters
    ----------
    sides
        Plane rectangles.
    surfaces
        How close to each side points lie on it, metres; a ray goes through only if both its ends are farther away.
    front_m, inset_m
        Points this close before and behind a side are looked at.
    """

    def __init__(self, sides: Sequence[Side], surfaces: Sequence[float], *, front_m: float, inset_m: float) -> None:
        count = len(sides)
        self._planes = np.empty((count, 15), np.float32)
        for row, side, surface_m in zip(self._planes, sides, surfaces, strict=True):
            row[:4] = *side.normal, side.offset
            row[4:10] = *side.u, *side.v
            row[10:14] = side.bounds + np.array([-BORDER_M, -BORDER_M, BORDER_M, BORDER_M])
            row[14] = surface_m
        self._reach = np.float32(front_m), np.float32(inset_m)
        pieces = [_pieces(side) for side in sides]
        places = np.concatenate([np.zeros((0, 3)), *pieces])
        number = np.repeat(np.arange(count), [len(piece) for piece in pieces])
        self._path = _cells(places, number, BORDER_M)
        self._near = _cells(places, number, BORDER_M + max(front_m, inset_m))

    def ends(self, end: F32, start: F32, scan: I32) -> Meetings:
        """Return the rays that end on a side, and those from its front that end a little before or behind it.

        `end` are the ``(n, 3)`` measured points, `start` the ``(S, 3)`` scanners, `scan` is ``(n,)``.
        """
        near, rays = _unpacked(self._near), len(end) if len(self._planes) else 0
        found = in_slices(_find_ends, rays, end, start, self._ahead(start), scan, self._planes, *near, *self._reach)
        return _ordered(found, len(self._planes))

    def crossings(self, end: F32, start: F32, scan: I32) -> Meetings:
        """Return the rays that go through a side, from either side."""
        path, rays = _unpacked(self._path), len(end) if len(self._planes) else 0
        found = in_slices(_find_crossings, rays, end, start, self._ahead(start), scan, self._planes, *path)
        return _ordered(found, len(self._planes))

    def _ahead(self, start: F32) -> F32:
        """``(S, sides)`` distance of each scanner from each side."""
        return np.asarray(start @ self._planes[:, :3].T - self._planes[:, 3], np.float32)


def _ordered(found: list[tuple[I32, F32]], count: int) -> Meetings:
    """Order by side what slices of rays met, themselves in order of rays; each slice is let go when it is done."""
    counts = np.array([np.zeros(count, np.int64), *(np.bincount(n[:, 1] >> 1, minlength=count) for n, _ in found)])
    first = np.append(0, np.cumsum(counts.sum(axis=0)))
    free = first[:-1] + np.cumsum(counts, axis=0)
    many = int(first[-1])
    meetings = Meetings(
        np.empty(many, np.int32),
        first,
        np.empty((many, 2), np.float32),
        np.empty(many, np.float32),
        np.empty(many, bool),
    )

    def put(number: int) -> None:
        numbers, values = found[number]
        found[number] = numbers[:0].copy(), values[:0].copy()
        _put(numbers, values, free[number], meetings.ray, meetings.place, meetings.depth, meetings.outbound)

    at_once(put, ((number,) for number in range(len(found))))
    return meetings


def _pieces(side: Side) -> F64:
    """``(n, 3)`` places spread over a side."""
    u, v = (
        np.linspace(low, high, int(np.ceil((high - low) / PIECE_M)) + 1) for low, high in side.bounds.reshape(2, 2).T
    )
    return side.points(np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2))


def _cells(places: F64, number: I64, reach: float) -> _Cells:
    """List for each cell the sides that have a place within reach of it; the grid is around the places alone."""
    if not len(places):
        return _Cells(np.zeros(3), np.ones(3, np.int64), np.zeros(2, np.int64), np.zeros(0, np.int32))
    reach += PIECE_M / 2
    low = places.min(axis=0) - reach
    shape = np.floor((places.max(axis=0) + reach - low) / CELL_M).astype(np.int64) + 1
    count = int(number.max(initial=0)) + 1
    cell_of, side_of = np.divmod(np.unique(_in_reach(places - low, number, reach, shape, count)), count)
    first = np.searchsorted(cell_of, np.arange(int(shape.prod()) + 1))
    return _Cells(low, shape, first.astype(np.int64), side_of.astype(np.int32))


def _unpacked(cells: _Cells) -> tuple[F64, I64, I64, I32]:
    return cells.low, cells.shape, cells.first, cells.members


@njit(cache=True, nogil=True)
def _in_reach(places: F64, number: I64, reach: float, shape: I64, count: int) -> I64:
    """``cell * count + side`` for every cell that comes within reach of a place along all axes, some of them twice."""
    keys, filled = np.empty(1024, np.int64), 0
    last, seen = np.full(6, -1, np.int64), np.empty(6, np.int64)
    for i in range(len(places)):
        for axis in range(3):
            seen[2 * axis] = int((places[i, axis] - reach) / CELL_M)
            seen[2 * axis + 1] = int((places[i, axis] + reach) / CELL_M)
        if i and number[i] == number[i - 1] and (seen == last).all():
            continue
        last[:] = seen
        for x in range(seen[0], seen[1] + 1):
            for y in range(seen[2], seen[3] + 1):
                for z in range(seen[4], seen[5] + 1):
                    if filled == len(keys):
                        keys = np.concatenate((keys, np.empty_like(keys)))
                    keys[filled] = ((x * shape[1] + y) * shape[2] + z) * count + number[i]
                    filled += 1
    return keys[:filled]


@njit(cache=True, nogil=True)
def _put(numbers, values, free, ray, place, depth, outbound):  # type: ignore[no-untyped-def]
    """Put what rays met behind what is known of the same side, at its `free` place."""
    for i in range(len(numbers)):
        side = numbers[i, 1] >> 1
        at = free[side]
        free[side] += 1
        ray[at], outbound[at] = numbers[i, 0], numbers[i, 1] & 1 == 0
        place[at, 0], place[at, 1], depth[at] = values[i, 0], values[i, 1], values[i, 2]


@njit(cache=True, nogil=True)
def _grown(numbers, values):  # type: ignore[no-untyped-def]
    """Make twice the room for what is found: ray, twice its side and 1 if it is inbound; coordinates and a depth."""
    more, also = np.empty((2 * len(numbers), 2), np.int32), np.empty((2 * len(values), 3), np.float32)
    more[: len(numbers)], also[: len(values)] = numbers, values
    return more, also


@njit(cache=True, nogil=True)
def _at(plane, x, y, z):  # type: ignore[no-untyped-def]
    """Coordinates of a place along the axes of a side, and whether they lie in its bounds."""
    u = plane[4] * x + plane[5] * y + plane[6] * z
    v = plane[7] * x + plane[8] * y + plane[9] * z
    return u, v, plane[10] <= u <= plane[12] and plane[11] <= v <= plane[13]


@njit(cache=True, nogil=True)
def _on_the_way(here, there, t):  # type: ignore[no-untyped-def]
    """Where a share `t` of the way is done."""
    return (
        here[0] + t * (there[0] - here[0]),
        here[1] + t * (there[1] - here[1]),
        here[2] + t * (there[2] - here[2]),
    )


@njit(cache=True, nogil=True)
def _find_ends(first_ray, past_ray, end, start, ahead, scan, planes, low, shape, first, members, front_m, inset_m):  # type: ignore[no-untyped-def]
    """Test each point with the sides near it; of one behind a side the place is where its ray goes through."""
    numbers, values, count = np.empty((1024, 2), np.int32), np.empty((1024, 3), np.float32), 0
    for ray in range(first_ray, past_ray):
        x, y, z = end[ray, 0], end[ray, 1], end[ray, 2]
        i, j, k = (
            int(np.floor((x - low[0]) / CELL_M)),
            int(np.floor((y - low[1]) / CELL_M)),
            int(np.floor((z - low[2]) / CELL_M)),
        )
        if i < 0 or j < 0 or k < 0 or i >= shape[0] or j >= shape[1] or k >= shape[2]:
            continue
        cell = (i * shape[1] + j) * shape[2] + k
        for at in range(first[cell], first[cell + 1]):
            side = members[at]
            height = planes[side, 0] * x + planes[side, 1] * y + planes[side, 2] * z - planes[side, 3]
            if height < -inset_m or height >= front_m:
                continue
            if abs(height) > planes[side, 14] and ahead[scan[ray], side] <= planes[side, 14]:
                continue
            if height < -planes[side, 14]:
                s = ahead[scan[ray], side]
                u, v, inside = _at(planes[side], *_on_the_way(start[scan[ray]], end[ray], s / (s - height)))
            else:
                u, v, inside = _at(planes[side], x, y, z)
            if inside:
                if count == len(numbers):
                    numbers, values = _grown(numbers, values)
                numbers[count, 0], numbers[count, 1] = ray, 2 * side
                values[count, 0], values[count, 1], values[count, 2] = u, v, -height
                count += 1
    return numbers[:count], values[:count]


@njit(cache=True, nogil=True)
def _find_crossings(first_ray, past_ray, end, start, ahead, scan, planes, low, shape, first, members):  # type: ignore[no-untyped-def]
    """Walk every ray cell by cell (Amanatides and Woo 1987) and test the sides of each cell once."""
    numbers, values, count = np.empty((1024, 2), np.int32), np.empty((1024, 3), np.float32), 0
    tested = np.full(len(planes), -1, np.int64)
    at, step, edge, stride = np.empty(3, np.int64), np.empty(3, np.int64), np.empty(3), np.empty(3)
    for ray in range(first_ray, past_ray):
        here = start[scan[ray]]
        left = _set_out(here, end[ray], low, at, step, edge, stride)
        while True:
            if 0 <= at[0] < shape[0] and 0 <= at[1] < shape[1] and 0 <= at[2] < shape[2]:
                cell = (at[0] * shape[1] + at[1]) * shape[2] + at[2]
                for side in members[first[cell] : first[cell + 1]]:
                    if tested[side] == ray:
                        continue
                    tested[side] = ray
                    plane, s = planes[side], ahead[scan[ray], side]
                    e = plane[0] * end[ray, 0] + plane[1] * end[ray, 1] + plane[2] * end[ray, 2] - plane[3]
                    if s * e >= 0.0 or abs(s) <= plane[14] or abs(e) <= plane[14]:
                        continue
                    t = s / (s - e)
                    u, v, inside = _at(plane, *_on_the_way(here, end[ray], t))
                    if inside:
                        if count == len(numbers):
                            numbers, values = _grown(numbers, values)
                        numbers[count, 0], numbers[count, 1] = ray, 2 * side + (s < 0.0)
                        values[count, 0], values[count, 1], values[count, 2] = u, v, -s if s < 0.0 else -e
                        count += 1
            if left == 0:
                break
            left -= 1
            k = 0 if edge[0] <= edge[1] and edge[0] <= edge[2] else 1 if edge[1] <= edge[2] else 2
            at[k] += step[k]
            edge[k] += stride[k]
    return numbers[:count], values[:count]


@njit(cache=True, nogil=True)
def _set_out(here, there, low, at, step, edge, stride):  # type: ignore[no-untyped-def]
    """Stand in the first cell of a ray: cell, direction, where the next cells begin; returns how many follow."""
    left = 0
    for k in range(3):
        a, b = (here[k] - low[k]) / CELL_M, (there[k] - low[k]) / CELL_M
        at[k] = int(np.floor(a))
        left += abs(int(np.floor(b)) - at[k])
        step[k] = 1 if b > a else -1
        stride[k] = 1.0 / abs(b - a) if b != a else np.inf
        edge[k] = (at[k] + 1 - a if b > a else a - at[k]) * stride[k] if b != a else np.inf
    return left
