"""Cells of a regular grid packed into one 64-bit key, so that one sort brings together what lies together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enfilade.errors import InputError
from enfilade.parallel import in_slices

from .records import F32, F64, I32, Bool
from .sorting import sort_above

I64 = NDArray[np.int64]
_SORTABLE_BITS: Final = 63


@dataclass(frozen=True, slots=True)
class CellGrid:
    """A box of cubic cells with one empty cell around it, so that neighbours of a cell always have keys.

    Attributes
    ----------
    lowest
        ``(3,) int64`` index of the cell at the low corner.
    shape
        ``(3,) int64`` number of cells along x, y, z.
    cell_m
        Side of a cell, metres.
    """

    lowest: I64
    shape: I64
    cell_m: float

    @classmethod
    def around(cls, positions: F32, cell_m: float) -> CellGrid:
        """Return the grid of cells around ``(n, 3)`` positions."""
        low, high = extent(positions)
        lowest = np.floor(low / cell_m).astype(np.int64) - 1
        highest = np.floor(high / cell_m).astype(np.int64) + 1
        return cls(lowest, highest - lowest + 1, cell_m)

    @property
    def size(self) -> int:
        """Number of cells in the box."""
        return int(self.shape[0]) * int(self.shape[1]) * int(self.shape[2])

    def keys(self, positions: F32, layer: I32 | None = None) -> I64:
        """``(n,) int64`` keys, ordered by layer (if given), x, y, z.

        Raises
        ------
        InputError
            The points are spread so wide that 64 bits cannot count the cells.
        """
        layers = 1 if layer is None or not len(layer) else int(layer.max()) + 1
        if self.size * layers >= 2**63:
            raise InputError("the points are spread too wide for one building: remove stray points, check the units")
        key = np.zeros(len(positions), np.int64) if layer is None else layer.astype(np.int64)
        in_slices(_add_cells, len(key), key, positions, self.lowest, self.shape, self.cell_m)
        return key

    def among(self, keys: I64, positions: F64) -> Bool:
        """``(n,)``: whether the cells of ``(n, 3)`` positions, which may lie outside the box, are among sorted keys."""
        return _are_among(keys, positions, self.lowest, self.shape, self.cell_m)

    def row_offsets(self) -> I64:
        """``(9,) int64``: key differences to the nine z-columns of cells around a cell, each at its lowest cell."""
        steps = np.arange(-1, 2)
        columns = (steps[:, None] * self.shape[1] + steps[None, :]).ravel() * self.shape[2]
        return np.asarray(columns - 1, np.int64)


def extent(positions: F32 | F64) -> tuple[F64, F64]:
    """Least and greatest coordinates ``(k,) float64`` of ``(n, k)`` positions; by axis, ten times as fast."""
    columns = [(column.min(), column.max()) for column in positions.T]
    low, high = np.array(columns, np.float64).T
    return low, high


def tile_rectangles(cells: Bool) -> I64:
    """``(k, 4) int64`` first and past-last row and column of rectangles that tile the cells that are True.

    Runs of cells along a row, then equal runs in successive rows made one: a wall takes few rectangles. They are
    ordered by first and past-last column, then row.
    """
    found = _tiles(cells)
    return np.asarray(found[np.lexsort((found[:, 0], found[:, 3], found[:, 2]))])


@njit(cache=True, nogil=True)
def _tiles(cells: Bool) -> I64:
    """Find rectangles row by row: those that end above a row, and those that a run in it begins or goes on with."""
    rows, columns = cells.shape
    tiles, count = np.empty((rows + 1, 4), np.int64), 0
    begun = np.full(columns, -1, np.int64)  # tile whose run begins in a column of the row before
    for row in range(rows):
        column = 0
        while column < columns:
            before, begun[column] = begun[column], -1
            if not cells[row, column]:
                column += 1
                continue
            past = column + 1
            while past < columns and cells[row, past]:
                begun[past] = -1
                past += 1
            if before < 0 or tiles[before, 3] != past:
                if count == len(tiles):
                    tiles = np.concatenate((tiles, np.empty_like(tiles)))
                before = count
                tiles[count] = row, row, column, past
                count += 1
            tiles[before, 1] = row + 1
            begun[column] = before
            column = past
    return tiles[:count]


@njit(cache=True, nogil=True)
def _add_cells(first: int, past: int, keys: I64, positions: F32, lowest: I64, shape: I64, cell_m: float) -> None:
    """Put the cell of positions `first` to `past` behind what their keys hold already."""
    for i in range(first, past):
        for axis in range(3):
            index = np.int64(np.floor(np.float64(positions[i, axis]) / cell_m))
            keys[i] = keys[i] * shape[axis] + index - lowest[axis]


@njit(cache=True, nogil=True)
def _are_among(keys: I64, positions: F64, lowest: I64, shape: I64, cell_m: float) -> Bool:
    found = np.zeros(len(positions), np.bool_)
    for i in range(len(positions)):
        key, inside = 0, True
        for axis in range(3):
            index = np.int64(np.floor(positions[i, axis] / cell_m)) - lowest[axis]
            inside &= 0 <= index < shape[axis]
            key = key * shape[axis] + index
        if inside:
            at = np.searchsorted(keys, key)
            found[i] = at < len(keys) and keys[at] == key
    return found


@njit(cache=True, nogil=True)
def count_cells(places: F64, cell_m: float) -> int:
    """Count the square cells, from the corner of ``(n, 2)`` places on, that hold one of them."""
    first, second = places[:, 0].min(), places[:, 1].min()
    rows = int((places[:, 0].max() - first) / cell_m) + 1
    columns = int((places[:, 1].max() - second) / cell_m) + 1
    held = np.zeros((rows, columns), np.bool_)
    for i in range(len(places)):
        held[int((places[i, 0] - first) / cell_m), int((places[i, 1] - second) / cell_m)] = True
    return int(held.sum())


@dataclass(frozen=True, slots=True)
class Gathered:
    """What has equal keys, brought together: group g has ``order[bounds[g]:bounds[g + 1]]``, in their old order.

    Attributes
    ----------
    order
        ``(n,) int64``.
    bounds
        ``(groups + 1,) int64``.
    keys
        ``(groups,) int64``, increasing.
    """

    order: I64
    bounds: I64
    keys: I64

    @classmethod
    def by(cls, keys: I64) -> Gathered:
        """Gather by ``(n,) int64`` keys from 0 on.

        Where a key and an index fit into 63 bits together, that is what is sorted: without looking things up by
        index, which is what takes time in an indirect sort.
        """
        bits, key_bits = max(1, len(keys) - 1).bit_length(), int(keys.max(initial=0)).bit_length()
        if key_bits + bits > _SORTABLE_BITS:
            order = np.argsort(keys, kind="stable")
            bounds = np.append(np.flatnonzero(np.diff(keys[order], prepend=-1)), len(keys))
            return cls(order, bounds, keys[order[bounds[:-1]]])
        packed = np.empty(len(keys), np.int64)
        in_slices(_pack, len(keys), packed, keys, bits)
        packed = sort_above(packed, bits, key_bits)
        bounds = _bounds(packed, bits)
        group_keys = packed[bounds[:-1]] >> bits
        in_slices(_mask, len(keys), packed, bits)
        return cls(packed, bounds, group_keys)

    def __len__(self) -> int:
        return len(self.keys)


@njit(cache=True, nogil=True)
def _pack(first: int, past: int, packed: I64, keys: I64, bits: int) -> None:
    """Fill in, for keys `first` to `past`, the key above the lowest `bits` and the index in these."""
    for i in range(first, past):
        packed[i] = keys[i] << bits | i


@njit(cache=True, nogil=True)
def _mask(first: int, past: int, packed: I64, bits: int) -> None:
    """Leave of numbers `first` to `past` only the lowest `bits`."""
    for i in range(first, past):
        packed[i] &= (1 << bits) - 1


@njit(cache=True, nogil=True)
def _bounds(packed: I64, bits: int) -> I64:
    """Where the part above the lowest `bits` changes, both ends included."""
    n = len(packed)
    count = 1 if n else 0
    for i in range(1, n):
        count += packed[i] >> bits != packed[i - 1] >> bits
    bounds = np.empty(count + 1, np.int64)
    bounds[0] = 0
    at = 1
    for i in range(1, n):
        if packed[i] >> bits != packed[i - 1] >> bits:
            bounds[at] = i
            at += 1
    bounds[count] = n
    return bounds


def members_of(numbers: I32, count: int) -> list[I64]:
    """Return, for each number from 0 to `count` - 1, where it stands in ``(n,) int32`` numbers; -1 is left out."""
    order, bounds = _by_number(numbers, count)
    return np.split(order, bounds[1:-1]) if count else []


@njit(cache=True, nogil=True)
def _by_number(numbers: I32, count: int) -> tuple[I64, I64]:
    bounds = np.zeros(count + 1, np.int64)
    for number in numbers:
        if number >= 0:
            bounds[number + 1] += 1
    bounds = np.cumsum(bounds)
    order, free = np.empty(bounds[-1], np.int64), bounds[:-1].copy()
    for i in range(len(numbers)):
        number = numbers[i]
        if number >= 0:
            order[free[number]] = i
            free[number] += 1
    return order, bounds


@njit(cache=True, nogil=True)
def neighbour_rows(keys: I64, offsets: I64) -> I32:
    """For each of the sorted `keys`, where each of its nine columns of neighbour cells begins.

    Returns
    -------
    ``(n, 9) int32`` indices into `keys`: the first key not below ``keys[i] + offsets[k]``. The cells of the
    column are those from there on with keys up to ``keys[i] + offsets[k] + 2``.
    """
    n = len(keys)
    rows = np.empty((n, 9), np.int32)
    for k in range(9):
        at = 0
        for i in range(n):
            while at < n and keys[at] < keys[i] + offsets[k]:
                at += 1
            rows[i, k] = at
    return rows
