"""What laser rays tell about the sides of rooms: where they end on a side, and where they go through it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final, TypeVar

import numpy as np
from numba import njit

from enfilade.ingest.openings.crossings import SideGrid
from enfilade.ingest.records import F32, F64, I32, Bool, RoomLabels, Surfels, ThinnedCloud
from enfilade.ingest.sides import Side, in_plane
from enfilade.parallel import at_once, taken

R = TypeVar("R")

NOISE: Final = 3.0
"""Points of a wall scatter about it by so many standard deviations."""


@dataclass(frozen=True, slots=True)
class Rays:
    """Every ray of the thinned cloud.

    Attributes
    ----------
    end, start
        ``(N, 3) float32`` the measured points, ``(S, 3) float32`` the scanners.
    scan
        ``(N,) int32`` the scan of each ray.
    from_room, to_room
        ``(N,) int32`` the room in which the scanner stands, the room of the point; -1 for none.
    surfel
        ``(N,) int32`` the surfel of the point; -1 where points are too sparse for one, and of no room for that alone.
    """

    end: F32
    start: F32
    scan: I32
    from_room: I32
    to_room: I32
    surfel: I32

    def starts(self, ray: I32) -> F64:
        """``(k, 3)`` scanner positions of some rays."""
        return self.start[self.scan[ray]].astype(np.float64)

    def ends(self, ray: I32) -> F64:
        """``(k, 3)`` measured points of some rays."""
        return self.end[ray].astype(np.float64)


@dataclass(frozen=True, slots=True)
class SideView:
    """What is known of one side: the rays that cross it and the points that lie on it.

    Attributes
    ----------
    side
        The side.
    ray
        ``(k,) int32`` the rays that cross it.
    crossing
        ``(k, 2) float64`` where, along its axes, metres.
    end
        ``(k, 2) float64`` where the measured points of these rays are, along the axes, metres.
    beyond
        ``(k,) float64`` how far behind the side the ray ends (going out) or starts (coming in), metres.
    outbound
        ``(k,) bool`` whether the ray goes out of the room.
    wall
        ``(w, 2) float64`` the points on it, along its axes, metres.
    front
        ``(f, 2) float64`` the points that stand a little before it.
    """

    side: Side
    ray: I32
    crossing: F64
    end: F64
    beyond: F64
    outbound: Bool
    wall: F64
    front: F64


def rays_of(cloud: ThinnedCloud, surfels: Surfels, labels: RoomLabels) -> Rays:
    """Give every thinned point its ray and the rooms at both ends."""
    to_room = taken(np.append(labels.after, np.int32(-1)), surfels.point_surfel)
    from_room = taken(labels.scan_room, cloud.scan)
    return Rays(cloud.positions, cloud.scanner_positions, cloud.scan, from_room, to_room, surfels.point_surfel)


class SideViews:
    """What the rays tell about sides: one `SideView` a side, in the order given.

    Parameters
    ----------
    rays
        All rays. Those that stay in one room end at sides; only those that leave one are followed through sides.
    sides
        In any order.
    surfels
        Those that the sides index: what is noisier is thicker.
    surface_m
        Points this close to a side lie on it, however little noise it has.
    front_m
        Points this close stand before it.
    inset_m
        Rays that stay in one room go through a side if they end no farther behind it: in the leaf of a door.
    """

    def __init__(
        self, rays: Rays, sides: Sequence[Side], surfels: Surfels, *, surface_m: float, front_m: float, inset_m: float
    ) -> None:
        self._rays, self._sides = rays, sides
        measured = any(len(side.surfels) for side in sides)
        points = rays.end if measured else rays.end[:0]
        noise = _noise(points, surfels.point_surfel, surfels.positions, surfels.normals)
        self._surfaces = [max(surface_m, NOISE * _middle(noise[side.surfels])) for side in sides]
        grid = SideGrid(sides, self._surfaces, front_m=front_m, inset_m=inset_m)
        self._leaves = (rays.from_room != rays.to_room) | (rays.to_room < 0)
        self._leaving = np.flatnonzero(self._leaves).astype(np.int32)
        self._through = grid.crossings(rays.end[self._leaving], rays.start, rays.scan[self._leaving])
        self._at = grid.ends(rays.end, rays.start, rays.scan)

    def __len__(self) -> int:
        return len(self._sides)

    def __getitem__(self, number: int) -> SideView:
        side, at, through = self._sides[number], self._at, self._through
        ends, crossings = at.of(number), through.of(number)
        surface_m = self._surfaces[number]
        behind, before = at.depth[ends] > surface_m, at.depth[ends] < -surface_m
        inset = behind & ~self._leaves[at.ray[ends]]
        ray = np.concatenate([self._leaving[through.ray[crossings]], at.ray[ends][inset]])
        return SideView(
            side,
            ray,
            np.concatenate([through.place[crossings], at.place[ends][inset]]).astype(np.float64),
            in_plane(self._rays.end, ray, side.u, side.v),
            np.concatenate([through.depth[crossings], at.depth[ends][inset]]).astype(np.float64),
            np.concatenate([through.outbound[crossings], at.outbound[ends][inset]]),
            at.place[ends][~behind & ~before].astype(np.float64),
            at.place[ends][before].astype(np.float64),
        )

    def each(self, function: Callable[[SideView], R]) -> list[R]:
        """Return what a function, which may be called for several views at once, says of every view."""
        return at_once(lambda number: function(self[number]), ((number,) for number in range(len(self))))

    @property
    def unhindered(self) -> Bool:
        """``(N,)``: rays to places of no room, or of another, that go through no side at all."""
        free: Bool = self._leaves.copy()
        free[self._leaving[self._through.ray]] = False
        return free


def told_by_sight(rays: Rays, surfels: Surfels, unhindered: Bool) -> Rays:
    """Take what belongs to no room for a part of the room that looks at it without looking through any wall.

    The far end of a long corridor is such a part: seen, but not well enough to be labelled.

    Parameters
    ----------
    rays
        All rays.
    surfels
        What the rays of one surfel tell counts for all its points.
    unhindered
        From `SideViews`.
    """
    surfel = surfels.point_surfel
    untold = (rays.to_room < 0) & (surfel >= 0)
    told = np.flatnonzero(untold & unhindered & (rays.from_room >= 0))
    count = int(rays.from_room.max(initial=0)) + 1
    key, votes = np.unique(surfel[told].astype(np.int64) * count + rays.from_room[told], return_counts=True)
    order = np.lexsort((-key, votes))  # the most votes last, of equals the lowest room
    room = np.full(len(surfels.positions), -1, dtype=np.int32)
    room[key[order] // count] = key[order] % count
    to_room = rays.to_room.copy()
    to_room[untold] = room[surfel[untold]]
    return replace(rays, to_room=to_room)


@njit(cache=True, nogil=True)
def _noise(points, point_surfel, positions, normals):  # type: ignore[no-untyped-def]
    """``(M,)`` standard deviation of the points of each surfel about it, metres.

    It tells the noise of a wall better than how its surfels lie about one plane: a leaf a little behind is no noise.
    """
    square, count = np.zeros(len(positions), np.float32), np.zeros(len(positions), np.int32)
    for point in range(len(points)):
        k = point_surfel[point]
        if k >= 0:
            height = np.float32(0.0)
            for axis in range(3):
                height += (points[point, axis] - positions[k, axis]) * normals[k, axis]
            square[k] += height * height
            count[k] += 1
    return np.sqrt(square / np.maximum(count, 1).astype(np.float32))


def _middle(noise: F32) -> float:
    return float(np.median(noise)) if len(noise) else 0.0
