"""The objects nearest to an example, exactly, without measuring most of them.

Every object gets the cheapest lower bound of its distance; those that could still be among the nearest get better
ones, and are measured best first, until the next bound exceeds the distance of the last object asked for. What comes
out is what measuring them all gives.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enfilade.parallel import in_slices

from .bounds import (
    blocks_of,
    chi_square,
    envelope_bounds,
    envelope_bounds_of,
    envelope_of,
    rings_of,
    slack,
    view_bounds_of,
)
from .distance import prepared, rings_and_sectors, view_distance

U16 = NDArray[np.uint16]
Rows = NDArray[np.int64]
F64 = NDArray[np.float64]

DECIMALS: Final = 12
"""Distances are exact to this many decimals; what lies beyond is noise of the summing."""

_FIRST_MEASURED: Final = 256
"""So many of the open objects are measured at once at first, then twice as many each time."""
_SAMPLE: Final = 1 << 15
_ROWS_A_THREAD: Final = 64
_ROWS_BETWEEN_CHECKS: Final = 1 << 15
"""Objects that are measured, in a fraction of a second, before the clock is looked at."""

_FARTHEST: Final = 2.0
"""No distance is greater."""

_BY_BLOCKS, _BY_RINGS, _BY_VIEWS = range(3)


@dataclass(frozen=True)
class DescriptorTable:
    """Descriptors of one kind and shape, one row an object.

    Attributes
    ----------
    shape
        Slices, shells, sectors.
    counts
        ``(n, bins) uint16``, each row sums to `enfilade.descriptors.TOTAL`.
    rings, blocks
        The same with bins merged, as `rings_of` and `blocks_of` give them.
    valid
        ``(n,) bool``: rows that are of no object are left alone.
    """

    shape: tuple[int, int, int]
    counts: U16
    rings: U16
    blocks: U16
    valid: NDArray[np.bool_]

    def __post_init__(self) -> None:
        """Compiled functions tell arrays that may be written from those that may not; here none may."""
        for name in ("counts", "rings", "blocks"):
            array = np.asarray(getattr(self, name)).view()
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    @classmethod
    def of(cls, counts: U16, shape: tuple[int, int, int]) -> DescriptorTable:
        """Return a table of descriptors, all of them valid."""
        rings = rings_of(counts, shape)
        return cls(shape, counts, rings, blocks_of(rings, shape), np.ones(len(counts), dtype=np.bool_))


@dataclass(slots=True)
class Effort:
    """What it took: objects there are, bounds computed (an object may get three), distances computed."""

    candidates: int = 0
    bounds: int = 0
    distances: int = 0

    @property
    def pruned(self) -> int:
        """Objects whose bounds were enough."""
        return self.candidates - self.distances

    def __add__(self, other: Effort) -> Effort:
        """Return both together."""
        sums = (getattr(self, name) + getattr(other, name) for name in self.__slots__)
        return Effort(*sums)


class Nearest:
    """Ranks the objects of a table by their distance to an example, as far as it is asked to.

    Parameters
    ----------
    views
        ``(bins,)`` counts, or ``(V, bins)`` of V views, of which the nearest counts.
    table
        The objects.
    check
        Called now and then while objects are measured; what it raises breaks that off.
    """

    def __init__(self, views: U16, table: DescriptorTable, check: Callable[[], None] = lambda: None) -> None:
        views = np.atleast_2d(views)
        self._check = check
        self._table = table
        self._views = prepared(views, table.shape)
        rings = rings_of(views, table.shape)
        self._rings = rings.astype(np.float32)
        self._ring_envelope = envelope_of(rings)
        self._block_envelope = envelope_of(blocks_of(rings, table.shape))
        self._bounds: NDArray[np.float32] | None = None
        self._stage = np.zeros(len(table.valid), dtype=np.uint8)
        self._distance = np.full(len(table.valid), np.nan)
        self._measured: list[Rows] = []
        self.effort = Effort(int(np.count_nonzero(table.valid)))

    @property
    def rows(self) -> Rows:
        """All objects."""
        return np.flatnonzero(self._table.valid)

    def best(self, count: int) -> tuple[Rows, F64]:
        """Return the nearest objects and their distances, nearest first; all that are tied with the last are there.

        Returns
        -------
        rows, distances
            At least `count` of each, or all there are.
        """
        count = min(count, self.effort.candidates)
        if count == 0:
            return np.empty(0, np.int64), np.empty(0)
        limit = self._first_limit(count)
        while len(rows := self._open(limit)):
            done = 0
            size = _FIRST_MEASURED
            while done < len(rows) and self._lower(rows[done]) <= limit:
                self._measure(rows[done : done + size])
                done, size = done + size, 2 * size
                limit = self._limit(count)
        return self._within(limit)

    def within(self, limit: float) -> tuple[Rows, F64]:
        """Return all objects within a distance, the limit included, nearest first."""
        self._measure(self._open(limit))
        return self._within(limit)

    def of(self, rows: Rows) -> F64:
        """Return the distances of some objects; NaN where there is none."""
        wanted = rows[self._table.valid[rows] & np.isnan(self._distance[rows])]
        self._measure(np.unique(wanted))
        return self._distance[rows]

    def _lower(self, row: int) -> float:
        assert self._bounds is not None
        return float(self._bounds[row])

    def _all_bounds(self) -> NDArray[np.float32]:
        """Bounds of all objects by blocks; those that are measured or none at all have an infinite one."""
        if self._bounds is None:
            self._bounds = envelope_bounds(self._block_envelope, self._table.blocks)
            self._bounds[~self._table.valid] = np.inf
            self._bounds[~np.isnan(self._distance)] = np.inf
            self.effort.bounds += self.effort.candidates
        return self._bounds

    def _first_limit(self, count: int) -> float:
        """Return a distance within which there are so many objects, by measuring some that look near."""
        known = sum(map(len, self._measured))
        if known < count:
            rows = self._promising(max(2 * count, _FIRST_MEASURED))
            rows = self._raised(rows, np.inf)
            order = np.argsort(self._all_bounds()[rows], kind="stable")
            self._measure(rows[order[: max(count, _FIRST_MEASURED // 4)]])
            if sum(map(len, self._measured)) < count:  # what looked near had been measured before
                return np.inf
        return self._limit(count)

    def _promising(self, count: int) -> Rows:
        """Return objects with small bounds by blocks, at least so many if there are; a sample tells where to cut."""
        bounds = self._all_bounds()
        step = max(1, len(bounds) // _SAMPLE)
        sample = np.sort(bounds[::step])
        place = -(-count // step)
        while place < len(sample):
            rows = np.flatnonzero(bounds <= _up(sample[place]))
            if len(rows) >= count:
                return rows
            place *= 2
        return np.flatnonzero(np.isfinite(bounds))

    def _limit(self, count: int) -> float:
        """Return the distance of the last of so many measured objects."""
        measured = np.concatenate(self._measured)
        return float(np.partition(self._distance[measured], count - 1)[count - 1])

    def _open(self, limit: float) -> Rows:
        """Return the objects whose best bounds do not exceed a limit and that are not measured, best first."""
        rows = np.flatnonzero(self._all_bounds() <= _up(limit))
        rows = self._raised(rows, limit)
        return rows[np.argsort(self._all_bounds()[rows], kind="stable")]

    def _raised(self, rows: Rows, limit: float) -> Rows:
        """Give objects better bounds, one kind after the other; returns those that do not exceed the limit."""
        bounds, table = self._all_bounds(), self._table
        for stage in (_BY_RINGS, _BY_VIEWS):
            lower = rows[self._stage[rows] < stage]
            if stage == _BY_RINGS:
                better = envelope_bounds_of(self._ring_envelope, table.rings, lower)
            elif len(self._rings) > 1:
                better = view_bounds_of(self._rings, table.rings, lower)
            else:
                break
            bounds[lower] = np.maximum(bounds[lower], better)
            self._stage[lower] = stage
            self.effort.bounds += len(lower)
            rows = rows[bounds[rows] <= _up(limit)]
        return rows

    def _measure(self, rows: Rows) -> None:
        for first in range(0, len(rows), _ROWS_BETWEEN_CHECKS):
            self._check()
            self._measure_some(rows[first : first + _ROWS_BETWEEN_CHECKS])

    def _measure_some(self, rows: Rows) -> None:
        found = np.empty(len(rows))
        table = self._table
        counts = rings_and_sectors(table.counts, table.shape)
        less = np.float32(slack(table.rings.shape[1]))
        told = (*self._views, self._rings, counts, table.rings, rows, less, found)
        in_slices(_measure, len(rows), *told, least=_ROWS_A_THREAD)
        self._distance[rows] = np.round(found, DECIMALS)
        if self._bounds is not None:
            self._bounds[rows] = np.inf
        self._measured.append(rows)
        self.effort.distances += len(rows)

    def _within(self, limit: float) -> tuple[Rows, F64]:
        rows = np.sort(np.concatenate([np.empty(0, np.int64), *self._measured]))
        distances = self._distance[rows]
        order = np.argsort(distances, kind="stable")
        order = order[distances[order] <= limit]
        return rows[order], distances[order]


def _up(limit: float) -> np.float32:
    """Return the limit in float32, never less than it, but finite: what has an infinite bound is not looked for."""
    return np.float32(np.nextafter(np.float32(min(limit, _FARTHEST)), np.float32(np.inf)))


def _measured_rows(
    first: int,
    past: int,
    views: F64,
    filled: NDArray[np.bool_],
    view_rings: NDArray[np.float32],
    counts: U16,
    rings: U16,
    rows: Rows,
    less: np.float32,
    found: F64,
) -> None:
    """Distance of some rows from their nearest view; a view whose bound exceeds the least so far is left out."""
    overlap = np.empty(counts.shape[2])
    bounds = np.empty(views.shape[0], dtype=np.float32)
    for k in range(first, past):
        row = rows[k]
        for v in range(views.shape[0]):
            bounds[v] = chi_square(view_rings[v], view_rings[v], rings[row]) - less
        least = 2.0
        for v in np.argsort(bounds):
            if bounds[v] <= least:
                least = min(least, view_distance(views[v], filled[v], counts[row], overlap))
        found[k] = least


_measure = njit(cache=True, nogil=True, error_model="numpy")(_measured_rows)
