"""A growing set of points, one a voxel, that points may be put into in any order (§8).

Voxels are gathered in blocks of 2 x 2 x 2; a hash table of the blocks finds a voxel without sorting, and as a scanner
measures neighbours one after the other, mostly in what the processor has at hand already. Each thread has blocks, and a
table, of its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, TypeVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .parallel import at_once, in_slices, processors, taken
from .records import F32, F64, I32, U8, Chunk
from .sorting import sort_above

T = TypeVar("T", bound=np.generic)
I64 = NDArray[np.int64]
U64 = NDArray[np.uint64]

_BITS: Final = 20
"""Bits of a block's index along each axis."""
_BELOW: Final = (1 << (3 * _BITS - 3)) - 1
"""All bits of a block's Morton number but the first of each axis."""
_SORTABLE_BITS: Final = 63
_HALF: Final = 1 << _BITS
"""Voxels from the origin to the end of the grid along each axis."""
_SLOTS: Final = 8
_FIRST_ROOM: Final = 1 << 22
"""Blocks and points that there is room for at first; what is not written yet takes no memory."""
_GROWTH: Final = 4
_FIRST_PLACES: Final = 1 << 17
"""Places of a table at first, a power of 2 from 64 on."""
_FULLEST: Final = 0.625
_STRIDE: Final = 65
_OPTIONAL: Final = ("intensity", "colour")
_MOST_SHARDS: Final = 4
"""Each looks at all points, if only to leave them to others."""
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
    shards
        Threads that put points in at the same time; what is kept does not depend on it.
    """

    def __init__(self, voxel_m: float, origin: F64, shards: int = min(processors(), _MOST_SHARDS)) -> None:
        self._voxel_m = voxel_m
        self._origin = origin
        self._shards = [_Shard() for _ in range(shards)]

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
        counts = np.zeros((len(self._shards), 2, len(scanners)), np.int64)
        fixed = chunk, scan, scanners, self._origin, self._voxel_m
        done = at_once(
            _Shard.add, ((shard, (k, len(self._shards)), *fixed, *counts[k]) for k, shard in enumerate(self._shards))
        )
        held += counts[:, 0].sum(axis=0)
        copies += counts[:, 1].sum(axis=0)
        return all(done)

    def finish(self) -> VoxelPoints:
        """Return the points in the order of their voxels. The set is used up: what is done with is let go at once."""
        order = self._order()
        positions = self._column("positions", order)
        scan = self._column("scan", order)
        with_intensity, with_colour = (any(len(getattr(s, name)) for s in self._shards) for name in _OPTIONAL)
        for shard in self._shards:
            shard.make_columns(with_intensity, with_colour)
        intensity = self._column("intensity", order) if with_intensity else None
        colour = self._column("colour", order) if with_colour else None
        return VoxelPoints(positions, scan, intensity, colour)

    def _order(self) -> I32:
        """Order the points, shard after shard, by their voxels; let go of tables, blocks and slots."""
        first_block = np.cumsum([0, *(shard.used[0] for shard in self._shards)])
        first_point = np.cumsum([0, *(shard.used[1] for shard in self._shards)])
        blocks = np.concatenate([shard.blocks[: shard.used[0]] for shard in self._shards])
        for shard in self._shards:
            shard.table, shard.blocks = np.zeros(0, np.int32), np.zeros(0, np.int64)
        by_number = _in_order(blocks)
        counts = np.empty(len(blocks), np.int32)
        del blocks
        for shard, first in zip(self._shards, first_block, strict=False):
            in_slices(_count, int(shard.used[0]), counts[first:], shard.slots)
        places = _places(by_number, counts)
        del by_number
        order = np.empty(first_point[-1], np.int32)
        for shard, first, before in zip(self._shards, first_block, first_point, strict=False):
            in_slices(_number, int(shard.used[0]), order, places[first:], shard.slots, before)
            shard.slots = np.zeros((0, _SLOTS), np.int32)
        return order

    def _column(self, name: str, order: I32) -> Any:
        """Return what the shards hold under a name, in order, and let go of theirs."""
        whole = np.concatenate([getattr(shard, name)[: shard.used[1]] for shard in self._shards])
        for shard in self._shards:
            setattr(shard, name, whole[:0])
        return taken(whole, order)


class _Shard:
    """The voxels of some of the blocks, a table that finds them, and their points.

    Which shard a block belongs to is told by the cube of 8 x 8 x 8 blocks that it is in: a scanner's neighbours mostly
    go into one shard, while each wall is spread over all.
    """

    def __init__(self) -> None:
        self.table = np.zeros(_FIRST_PLACES, np.int32)
        self.blocks = np.empty(_FIRST_ROOM, np.int64)
        self.slots = np.empty((_FIRST_ROOM, _SLOTS), np.int32)
        self.positions = np.empty((_FIRST_ROOM, 3), np.float32)
        self.scan = np.empty(_FIRST_ROOM, np.int32)
        self.intensity = np.zeros(0, np.float32)
        self.colour = np.zeros((0, 3), np.uint8)
        self.used = np.zeros(2, np.int64)

    def add(
        self,
        share: tuple[int, int],
        chunk: Chunk,
        scan: int,
        scanners: F64,
        origin: F64,
        voxel_m: float,
        held: I64,
        copies: I64,
    ) -> bool:
        """Put in the points of a chunk that belong to this shard, the first of `share`, of so many; else as the set."""
        intensity = np.zeros(0, np.float32) if chunk.intensity is None else chunk.intensity
        colour = np.zeros((0, 3), np.uint8) if chunk.colour is None else chunk.colour
        self.make_columns(len(intensity) > 0, len(colour) > 0)
        start = 0
        while start < len(chunk.positions):
            start = _add(
                chunk.positions,
                intensity,
                colour,
                start,
                share,
                scan,
                origin,
                voxel_m,
                scanners,
                held,
                copies,
                self.used,
                (self.table, self.blocks, self.slots),
                (self.positions, self.scan, self.intensity, self.colour),
            )
            if start < 0:
                return False
            self._grow()
        return True

    def make_columns(self, intensity: bool, colour: bool) -> None:
        """Begin to keep intensity or colour with the first chunk that has it."""
        if intensity and not len(self.intensity):
            self.intensity = np.empty(len(self.scan), np.float32)
            self.intensity[: self.used[1]] = np.nan
        if colour and not len(self.colour):
            self.colour = np.empty((len(self.scan), 3), np.uint8)
            self.colour[: self.used[1]] = 0

    def _grow(self) -> None:
        """Make room where there is none."""
        blocks, points = self.used
        if blocks >= _FULLEST * len(self.table):
            self.table = np.zeros(2 * len(self.table), np.int32)
            _fill(self.table, self.blocks[:blocks])
        if blocks == len(self.blocks):
            self.blocks, self.slots = _grown(self.blocks), _grown(self.slots)
        if points + _SLOTS > len(self.scan):
            self.positions, self.scan = _grown(self.positions), _grown(self.scan)
            if len(self.intensity):
                self.intensity = _grown(self.intensity)
            if len(self.colour):
                self.colour = _grown(self.colour)


def _grown(values: NDArray[T]) -> NDArray[T]:
    """Return a full array with room for more rows; a new one, for NumPy asks for huge pages only then.

    With small pages, half of the time goes into finding them.
    """
    grown = np.empty((_GROWTH * len(values), *values.shape[1:]), values.dtype)
    grown[: len(values)] = values
    return grown


def _in_order(blocks: I64) -> I64:
    """Order of blocks by their Morton numbers.

    Near the origin all bits but the lowest few of an index are the first one turned round, and need no comparing.
    """
    index_bits = max(1, len(blocks) - 1).bit_length()
    bits = max((part.bit_length() for part in in_slices(_differing, len(blocks), blocks)), default=0)
    if 3 + bits + index_bits > _SORTABLE_BITS:
        return np.argsort(blocks)
    packed = np.empty(len(blocks), np.int64)
    in_slices(_pack, len(blocks), packed, blocks, bits, index_bits)
    packed = sort_above(packed, index_bits, 3 + bits)
    packed &= (1 << index_bits) - 1
    return packed


@njit(cache=True, nogil=True)
def _differing(first: int, past: int, blocks: I64) -> int:
    """Which bits of blocks `first` to `past` are not the first one of their axis turned round."""
    bits = 0
    for i in range(first, past):
        bits |= (blocks[i] ^ ((7 ^ (blocks[i] >> (3 * _BITS - 3))) * (_BELOW // 7))) & _BELOW
    return bits


@njit(cache=True, nogil=True)
def _pack(first: int, past: int, packed: I64, blocks: I64, bits: int, index_bits: int) -> None:
    """Fill in what is sorted for blocks `first` to `past`: the first bit of each axis, the lowest bits, the index."""
    for i in range(first, past):
        octant = blocks[i] >> (3 * _BITS - 3)
        packed[i] = ((octant << bits | blocks[i] & ((1 << bits) - 1)) << index_bits) | i


@njit(cache=True, nogil=True)
def _place_of(table: I32, blocks: I64, block: int) -> int:
    """Where the number of a block, plus 1, is in the table, or where it belongs.

    The 64 blocks that differ in the last six bits only belong into one stretch of the table, in an order of its own,
    so that floors do not crowd the same places of all stretches; who finds a place taken goes to another stretch.
    """
    mixed = np.uint64(block >> 6) * np.uint64(0x9E3779B97F4A7C15)
    mixed ^= mixed >> np.uint64(29)
    at = np.int64(((mixed << np.uint64(6)) | ((mixed >> np.uint64(40)) & np.uint64(63))) & np.uint64(len(table) - 1))
    at ^= block & 63
    while table[at] != 0 and blocks[table[at] - 1] != block:
        at = (at + _STRIDE) & (len(table) - 1)
    return int(at)


@njit(cache=True, nogil=True, inline="always")
def _share_of(block: int, shards: int) -> int:
    """Which of so many shards a block belongs to, the same for the 512 blocks of a cube."""
    mixed = (np.uint64(block >> 9) * np.uint64(0x9E3779B97F4A7C15)) >> np.uint64(32)
    return int((mixed * np.uint64(shards)) >> np.uint64(32))


@njit(cache=True, nogil=True)
def _fill(table: I32, blocks: I64) -> None:
    for number in range(len(blocks)):
        table[_place_of(table, blocks, blocks[number])] = number + 1


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
def _count(first: int, past: int, counts: I32, slots: I32) -> None:
    """Fill in how many points blocks `first` to `past` hold."""
    for block in range(first, past):
        counts[block] = 0
        for slot in range(_SLOTS):
            counts[block] += slots[block, slot] > 0


@njit(cache=True, nogil=True)
def _places(order: I64, counts: I32) -> I32:
    """Place of the first point of each block, when blocks come in that order."""
    places = np.empty(len(counts), np.int32)
    filled = 0
    for block in order:
        places[block] = filled
        filled += counts[block]
    return places


@njit(cache=True, nogil=True)
def _number(first: int, past: int, order: I32, places: I32, slots: I32, before: int) -> None:
    """Put the points of blocks `first` to `past` in their places, in the order of the voxels in each."""
    for block in range(first, past):
        place = places[block]
        for slot in range(_SLOTS):
            if slots[block, slot]:
                order[place] = before + slots[block, slot] - 1
                place += 1


@njit(cache=True, nogil=True)
def _add(chunk, intensity, colour, start, share, scan, origin, voxel_m, scanners, held, copies, used, grid, points):  # type: ignore[no-untyped-def]
    """Put a shard's points in from `start` on; returns where it stopped for want of room, or -1 at one out of reach."""
    table, blocks, slots = grid
    positions, scan_of, intensity_of, colour_of = points
    most = min(np.int64(_FULLEST * len(table)), len(blocks))
    own, shards = share
    last, number = -1, 0
    here = np.empty(3, np.float32)
    cell = np.empty(3, np.int64)
    for i in range(start, len(chunk)):
        for axis in range(3):
            here[axis] = np.float32(chunk[i, axis] - origin[axis])
            index = np.floor(np.float64(here[axis]) / voxel_m)
            if not -_HALF <= index < _HALF:
                return -1
            cell[axis] = np.int64(index) + _HALF
        block = (_spread(cell[0] >> 1) << 2) | (_spread(cell[1] >> 1) << 1) | _spread(cell[2] >> 1)
        slot = ((cell[0] & 1) << 2) | ((cell[1] & 1) << 1) | (cell[2] & 1)
        if block != last:
            if _share_of(block, shards) != own:
                continue
            if used[0] >= most or used[1] + _SLOTS > len(scan_of):
                return i
            at = _place_of(table, blocks, block)
            if table[at] == 0:
                blocks[used[0]] = block
                slots[used[0]] = 0
                used[0] += 1
                table[at] = used[0]
            last, number = block, table[at] - 1
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
    for axis in range(3):  # noqa: SIM110 (a generator is not compiled)
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
