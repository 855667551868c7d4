"""A growing set of points, one a voxel, that points may be put into in any order (§8).

Voxels are gathered in blocks of 2 x 2 x 2; a hash table of the blocks finds a voxel without sorting, and as a scanner
measures neighbours one after the other, mostly in what the processor has at hand already.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, TypeVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .cells import Gathered
from .parallel import taken
from .records import F32, F64, I32, U8, Chunk

T = TypeVar("T", bound=np.generic)
I64 = NDArray[np.int64]
U64 = NDArray[np.uint64]

_BITS: Final = 20
"""Bits of a block's index along each axis."""
_BELOW: Final = (1 << (3 * _BITS - 3)) - 1
"""All bits of a block's Morton number but the first of each axis."""
_HALF: Final = 1 << _BITS
"""Voxels from the origin to the end of the grid along each axis."""
_SLOTS: Final = 8
_EMPTY: Final = np.int64(-1)
_FIRST_BLOCKS: Final = 1 << 16
_FULLEST: Final = 0.6
_GROWTH: Final = 1.5
_STRIDE: Final = 65
_SAME_M: Final = 1e-4
"""Points of two scans no farther apart than this along each axis are copies, but for rounding."""


@dataclass(frozen=True, slots=True)
class VoxelPoints:
    """The points of a `VoxelSet`, ordered by voxel.

    Attributes
    ----------
    positions
        ``(n, 3) float32``.
    scan
        ``(n,) int32``.
    intensity
        ``(n,) float32``, NaN where not measured; None where no scan had it.
    colour
        ``(n, 3) uint8``, black where not measured; None where no scan had it.
    """

    positions: F32
    scan: I32
    intensity: F32 | None
    colour: U8 | None


class VoxelSet:
    """Keeps, of each voxel, the point nearest to its scanner, whatever the order in which points come.

    Parameters
    ----------
    voxel_m
        Side of a voxel.
    origin
        ``(3,) float64``, taken off all positions.
    """

    def __init__(self, voxel_m: float, origin: F64) -> None:
        self._voxel_m = voxel_m
        self._origin = origin
        self._table = _empty_table(2 * _FIRST_BLOCKS)
        self._blocks = np.zeros(_FIRST_BLOCKS, np.int64)
        self._slots = np.zeros((_FIRST_BLOCKS, _SLOTS), np.int32)
        self._positions = np.zeros((_FIRST_BLOCKS, 3), np.float32)
        self._scan = np.zeros(_FIRST_BLOCKS, np.int32)
        self._intensity = np.zeros(0, np.float32)
        self._colour = np.zeros((0, 3), np.uint8)
        self._used = np.zeros(2, np.int64)

    @property
    def reach_m(self) -> float:
        """How far from the origin a point may lie along each axis."""
        return _HALF * self._voxel_m

    def add(self, chunk: Chunk, scan: int, scanners: F64, held: I64, copies: I64) -> bool:
        """Put the points of a chunk in; returns False, and stops, where one lies beyond `reach_m`.

        Parameters
        ----------
        chunk
            The points, not yet moved to the origin.
        scan
            Number of their scan.
        scanners
            ``(S, 3) float64`` of all scans so far, relative to the origin.
        held, copies
            ``(S,) int64``, counted on: the points that each scan has in the set, and those of them that another scan
            repeats.
        """
        intensity = np.zeros(0, np.float32) if chunk.intensity is None else chunk.intensity
        colour = np.zeros((0, 3), np.uint8) if chunk.colour is None else chunk.colour
        self._make_columns(len(intensity) > 0, len(colour) > 0)
        start = 0
        while start < len(chunk.positions):
            start = _add(
                chunk.positions,
                intensity,
                colour,
                start,
                scan,
                self._origin,
                self._voxel_m,
                scanners,
                held,
                copies,
                self._used,
                (self._table, self._blocks, self._slots),
                (self._positions, self._scan, self._intensity, self._colour),
            )
            if start < 0:
                return False
            self._grow()
        return True

    def finish(self) -> VoxelPoints:
        """Return the points in the order of their voxels. The set is used up: what is done with is let go at once."""
        self._table = _empty_table(0)
        order = _ordered(self._slots, _in_order(self._blocks[: self._used[0]]), int(self._used[1]))
        self._slots = np.zeros((0, _SLOTS), np.int32)
        self._positions = taken(self._positions, order)
        self._scan = taken(self._scan, order)
        intensity = taken(self._intensity, order) if len(self._intensity) else None
        colour = taken(self._colour, order) if len(self._colour) else None
        return VoxelPoints(self._positions, self._scan, intensity, colour)

    def _make_columns(self, intensity: bool, colour: bool) -> None:
        """Begin to keep intensity or colour with the first chunk that has it."""
        if intensity and not len(self._intensity):
            self._intensity = np.full(len(self._scan), np.nan, np.float32)
        if colour and not len(self._colour):
            self._colour = np.zeros((len(self._scan), 3), np.uint8)

    def _grow(self) -> None:
        """Make room where less than a tenth is free."""
        blocks, points = self._used
        if blocks > 0.9 * len(self._blocks):
            if blocks > 0.8 * _FULLEST * len(self._table):
                self._table = _empty_table(2 * len(self._table))
                _fill(self._table, self._blocks[:blocks])
            capacity = int(min(_GROWTH * len(self._blocks), _FULLEST * len(self._table)))
            self._blocks = _grown(self._blocks, capacity)
            self._slots = _grown(self._slots, capacity)
        if points > 0.9 * len(self._scan):
            capacity = int(_GROWTH * len(self._scan))
            self._positions = _grown(self._positions, capacity)
            self._scan = _grown(self._scan, capacity)
            if len(self._intensity):
                self._intensity = _grown(self._intensity, capacity)
            if len(self._colour):
                self._colour = _grown(self._colour, capacity)


def _grown(values: NDArray[T], capacity: int) -> NDArray[T]:
    """Return an array with room for more rows; a new one, for NumPy asks for huge pages only then.

    What is not written yet takes no memory. With small pages, half of the time goes into finding them.
    """
    grown = np.empty((capacity, *values.shape[1:]), values.dtype)
    grown[: len(values)] = values
    return grown


def _in_order(blocks: I64) -> I64:
    """Order of blocks by their Morton numbers.

    Near the origin all bits but the lowest few of an index are the first one turned round, and need no comparing.
    """
    octant = blocks >> (3 * _BITS - 3)
    turned = (7 ^ octant) * (_BELOW // 7)
    bits = int(((blocks ^ turned) & _BELOW).max(initial=0)).bit_length()
    return Gathered.by((octant << bits) | (blocks & ((1 << bits) - 1))).order


def _empty_table(size: int) -> I64:
    """Return a table of `size` (a power of 2) pairs of a block's key and its number."""
    return np.full((size, 2), _EMPTY, np.int64)


@njit(cache=True, nogil=True)
def _place_of(table: I64, block: int) -> int:
    """Where a block is in the table, or where it belongs.

    The 64 blocks that differ in the last six bits only belong into one stretch of the table, in an order of its own,
    so that floors do not crowd the same places of all stretches; who finds a place taken goes to another stretch.
    """
    mixed = np.uint64(block >> 6) * np.uint64(0x9E3779B97F4A7C15)
    mixed ^= mixed >> np.uint64(29)
    at = np.int64(((mixed << np.uint64(6)) | ((mixed >> np.uint64(40)) & np.uint64(63))) & np.uint64(len(table) - 1))
    at ^= block & 63
    while table[at, 0] != block and table[at, 0] != -1:
        at = (at + _STRIDE) & (len(table) - 1)
    return int(at)


@njit(cache=True, nogil=True)
def _fill(table: I64, blocks: I64) -> None:
    for number in range(len(blocks)):
        at = _place_of(table, blocks[number])
        table[at, 0] = blocks[number]
        table[at, 1] = number


@njit(cache=True, nogil=True)
def _spread(index: int) -> int:
    """Return an index of 20 bits with two zeros before each of them: three such make a Morton number."""
    bits = np.int64(index)
    bits = (bits | (bits << 32)) & 0x1F00000000FFFF
    bits = (bits | (bits << 16)) & 0x1F0000FF0000FF
    bits = (bits | (bits << 8)) & 0x100F00F00F00F00F
    bits = (bits | (bits << 4)) & 0x10C30C30C30C30C3
    return int((bits | (bits << 2)) & 0x1249249249249249)


@njit(cache=True, nogil=True)
def _ordered(slots: I32, blocks: I64, count: int) -> I32:
    """Numbers of the points, block by block, in the order of the voxels in each."""
    order = np.empty(count, np.int32)
    filled = 0
    for block in blocks:
        for slot in range(8):
            if slots[block, slot]:
                order[filled] = slots[block, slot] - 1
                filled += 1
    return order


@njit(cache=True, nogil=True)
def _add(chunk, intensity, colour, start, scan, origin, voxel_m, scanners, held, copies, used, grid, points):  # type: ignore[no-untyped-def]
    """Put points in from `start` on; returns where it stopped for want of room, or -1 at a point out of reach."""
    table, blocks, slots = grid
    positions, scan_of, intensity_of, colour_of = points
    last, number = -1, 0
    here = np.empty(3, np.float32)
    cell = np.empty(3, np.int64)
    for i in range(start, len(chunk)):
        if used[0] >= len(blocks) or used[1] >= len(scan_of):
            return i
        for axis in range(3):
            here[axis] = np.float32(chunk[i, axis] - origin[axis])
            index = np.floor(np.float64(here[axis]) / voxel_m)
            if not -_HALF <= index < _HALF:
                return -1
            cell[axis] = np.int64(index) + _HALF
        block = (_spread(cell[0] >> 1) << 2) | (_spread(cell[1] >> 1) << 1) | _spread(cell[2] >> 1)
        slot = ((cell[0] & 1) << 2) | ((cell[1] & 1) << 1) | (cell[2] & 1)
        if block != last:
            at = _place_of(table, block)
            if table[at, 0] == -1:
                table[at, 0], table[at, 1] = block, used[0]
                blocks[used[0]] = block
                slots[used[0]] = 0
                used[0] += 1
            last, number = block, table[at, 1]
        point = np.int64(slots[number, slot]) - 1
        if point < 0:
            point = used[1]
            used[1] += 1
            slots[number, slot] = point + 1
            held[scan] += 1
        else:
            other = scan_of[point]
            if other != scan and _is_copy(here, positions[point]):
                copies[other] += 1
            if not _is_better(here, scanners[scan], positions[point], scanners[other]):
                continue
            held[other] -= 1
            held[scan] += 1
        positions[point] = here
        scan_of[point] = scan
        if len(intensity_of):
            intensity_of[point] = intensity[i] if len(intensity) else np.float32(np.nan)
        if len(colour_of):
            for channel in range(3):
                colour_of[point, channel] = colour[i, channel] if len(colour) else np.uint8(0)
    return len(chunk)


@njit(cache=True, nogil=True, inline="always")
def _is_copy(here: F32, there: F32) -> bool:
    for axis in range(3):
        if abs(here[axis] - there[axis]) > _SAME_M:
            return False
    return True


@njit(cache=True, nogil=True, inline="always")
def _is_better(here: F32, scanner: F64, there: F32, its_scanner: F64) -> bool:
    """Whether a point is nearer to its scanner than another, of equals the less by x, y, z, then by its scanner's."""
    mine, other = 0.0, 0.0
    for axis in range(3):
        mine += (here[axis] - scanner[axis]) ** 2
        other += (there[axis] - its_scanner[axis]) ** 2
    if mine != other:
        return bool(mine < other)
    for axis in range(3):
        if here[axis] != there[axis]:
            return bool(here[axis] < there[axis])
    for axis in range(3):
        if scanner[axis] != its_scanner[axis]:
            return bool(scanner[axis] < its_scanner[axis])
    return False
