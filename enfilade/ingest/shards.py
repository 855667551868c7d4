"""A thread's part of a set of voxels: a hash table of blocks, and the points in them.

Voxels are gathered in blocks of 2 x 2 x 2; a hash table of the blocks finds a voxel without sorting, and as a scanner
measures neighbours one after the other, mostly in what the processor has at hand already.
"""

from __future__ import annotations

from typing import Final, TypeVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .records import F32, F64, I32, U8

T = TypeVar("T", bound=np.generic)
I64 = NDArray[np.int64]

SLOTS: Final = 8
"""Voxels of a block."""
_FIRST_ROOM: Final = 1 << 22
"""Blocks and points that there is room for at first; what is not written yet takes no memory."""
_GROWTH: Final = 4
_FIRST_PLACES: Final = 1 << 17
"""Places of a table at first, a power of 2 from 64 on."""
_FULLEST: Final = 0.625
_STRIDE: Final = 65
_SAME_M: Final = 1e-4
"""Points of two scans no farther apart than this along each axis are copies, but for rounding."""


class Shard:
    """The voxels of some of the blocks, a table that finds them, and their points.

    Which shard a block belongs to is told by the cube of 8 x 8 x 8 blocks that it is in: a scanner's neighbours mostly
    go into one shard, while each wall is spread over all.
    """

    def __init__(self) -> None:
        self.table = np.zeros(_FIRST_PLACES, np.int32)
        self.blocks = np.empty(_FIRST_ROOM, np.int64)
        self.slots = np.empty((_FIRST_ROOM, SLOTS), np.int32)
        self.positions = np.empty((_FIRST_ROOM, 3), np.float32)
        self.scan = np.empty(_FIRST_ROOM, np.int32)
        self.intensity = np.zeros(0, np.float32)
        self.colour = np.zeros((0, 3), np.uint8)
        self.used = np.zeros(2, np.int64)

    def add(
        self,
        share: tuple[int, int],
        voxels: I64,
        positions: F32,
        intensity: F32 | None,
        colour: U8 | None,
        scan: int,
        scanners: F64,
        held: I64,
        copies: I64,
    ) -> None:
        """Put in those points of a scan that belong to this shard.

        Parameters
        ----------
        share
            Which shard this is, of how many.
        voxels
            ``(n,) int64`` Morton numbers of the points' voxels.
        positions, intensity, colour
            ``(n, 3)``, ``(n,)``, ``(n, 3)`` of the points; None where they were not measured.
        scan, scanners, held, copies
            As `VoxelSet.add` has them.
        """
        intensity = np.zeros(0, np.float32) if intensity is None else intensity
        colour = np.zeros((0, 3), np.uint8) if colour is None else colour
        self.make_columns(len(intensity) > 0, len(colour) > 0)
        start = 0
        while start < len(voxels):
            start = _add(
                voxels,
                positions,
                intensity,
                colour,
                start,
                share,
                scan,
                scanners,
                held,
                copies,
                self.used,
                (self.table, self.blocks, self.slots),
                (self.positions, self.scan, self.intensity, self.colour),
            )
            self._grow()

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
        if points + SLOTS > len(self.scan):
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
def _add(voxels, here, intensity, colour, start, share, scan, scanners, held, copies, used, grid, points):  # type: ignore[no-untyped-def]
    """Put a shard's points in from `start` on; returns where it stopped for want of room."""
    table, blocks, slots = grid
    positions, scan_of, intensity_of, colour_of = points
    most = min(np.int64(_FULLEST * len(table)), len(blocks))
    own, shards = share
    last, number = -1, 0
    for i in range(start, len(voxels)):
        block, slot = voxels[i] // SLOTS, voxels[i] % SLOTS
        if block != last:
            if _share_of(block, shards) != own:
                continue
            if used[0] >= most or used[1] + SLOTS > len(scan_of):
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
            if other != scan and _is_copy(here[i], positions[point]):
                copies[other] += 1
            if not _is_better(here[i], scanners[scan], positions[point], scanners[other]):
                continue
            held[other] -= 1
            held[scan] += 1
        positions[point] = here[i]
        scan_of[point] = scan
        if len(intensity_of):
            intensity_of[point] = intensity[i] if len(intensity) else np.float32(np.nan)
        if len(colour_of):
            for channel in range(3):
                colour_of[point, channel] = colour[i, channel] if len(colour) else np.uint8(0)
    return len(voxels)


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
