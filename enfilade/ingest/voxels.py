"""A growing set of points, one a voxel, that points may be put into in any order (§8).

Each thread has voxels of its own, in a `Shard`. At the end all are put in the order of their Morton numbers, in which
the bits of x, y and z take turns: what lies together comes together.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enfilade.parallel import at_once, in_slices, processors, taken

from .records import F32, F64, I32, U8, Chunk
from .shards import SLOTS, Shard
from .sorting import sort_above

I64 = NDArray[np.int64]

_BITS: Final = 20
"""Bits of a block's index along each axis."""
_BELOW: Final = (1 << (3 * _BITS - 3)) - 1
"""All bits of a block's Morton number but the first of each axis."""
_SORTABLE_BITS: Final = 63
_HALF: Final = 1 << _BITS
"""Voxels from the origin to the end of the grid along each axis."""
_OPTIONAL: Final = ("intensity", "colour")
_MOST_SHARDS: Final = 4
"""Each looks at all points, if only to leave them to others."""


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
        self._shards = [Shard() for _ in range(shards)]

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
        positions, voxels = np.empty(chunk.positions.shape, np.float32), np.empty(len(chunk.positions), np.int64)
        within = in_slices(_locate, len(voxels), voxels, positions, chunk.positions, self._origin, self._voxel_m)
        if not all(within):
            return False
        points = voxels, positions, chunk.intensity, chunk.colour
        counts = np.zeros((len(self._shards), 2, len(scanners)), np.int64)
        at_once(
            Shard.add,
            (
                (shard, (k, len(self._shards)), *points, scan, scanners, *counts[k])
                for k, shard in enumerate(self._shards)
            ),
        )
        held += counts[:, 0].sum(axis=0)
        copies += counts[:, 1].sum(axis=0)
        return True

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
            shard.slots = np.zeros((0, SLOTS), np.int32)
        return order

    def _column(self, name: str, order: I32) -> Any:
        """Return what the shards hold under a name, in order, and let go of theirs."""
        whole = np.concatenate([getattr(shard, name)[: shard.used[1]] for shard in self._shards])
        for shard in self._shards:
            setattr(shard, name, whole[:0])
        return taken(whole, order)


@njit(cache=True, nogil=True)
def _locate(first: int, past: int, voxels: I64, positions: F32, given: F64, origin: F64, voxel_m: float) -> bool:
    """Fill in positions from the origin and Morton numbers of voxels; False if one is out of reach."""
    for i in range(first, past):
        voxel = 0
        for axis in range(3):
            positions[i, axis] = np.float32(given[i, axis] - origin[axis])
            index = np.floor(np.float64(positions[i, axis]) / voxel_m)
            if not -_HALF <= index < _HALF:
                return False
            voxel |= _spread(int(index) + _HALF) << (2 - axis)
        voxels[i] = voxel
    return True


@njit(cache=True, nogil=True)
def _spread(index: int) -> int:
    """Return an index of 21 bits with two zeros before each of them: three such make a Morton number."""
    bits = np.int64(index)
    bits = (bits | (bits << 32)) & 0x1F00000000FFFF
    bits = (bits | (bits << 16)) & 0x1F0000FF0000FF
    bits = (bits | (bits << 8)) & 0x100F00F00F00F00F
    bits = (bits | (bits << 4)) & 0x10C30C30C30C30C3
    return int((bits | (bits << 2)) & 0x1249249249249249)


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
def _count(first: int, past: int, counts: I32, slots: I32) -> None:
    """Fill in how many points blocks `first` to `past` hold."""
    for block in range(first, past):
        counts[block] = 0
        for slot in range(SLOTS):
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
        for slot in range(SLOTS):
            if slots[block, slot]:
                order[place] = before + slots[block, slot] - 1
                place += 1
