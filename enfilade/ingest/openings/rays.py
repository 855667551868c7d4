"""Where laser rays go through the sides of rooms.

A ray leaves a room through one of its walls, or comes into it through one: rays of the scanners that stand in a
room and end behind a wall of it go out, rays that measured a point of the room from behind a wall of it come in.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enfilade.ingest.records import F64, I32, Bool, RoomLabels, Surfels, ThinnedCloud
from enfilade.ingest.sides import Side

CHUNK: Final = 400_000
"""Rays looked at together; keeps the working memory small."""

LEAVES: Final = 1
ENTERS: Final = 2
ON: Final = 3
BEFORE: Final = 4


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
    """

    end: NDArray[np.float32]
    start: NDArray[np.float32]
    scan: I32
    from_room: I32
    to_room: I32

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
    known = surfels.point_surfel >= 0
    to_room = np.full(len(cloud.scan), -1, dtype=np.int32)
    to_room[known] = labels.after[surfels.point_surfel[known]]
    return Rays(cloud.positions, cloud.scanner_positions, cloud.scan, labels.scan_room[cloud.scan], to_room)


class Viewer:
    """Looks at sides: collects the rays that cross each, and the points that lie on it or stand before it.

    Parameters
    ----------
    rays
        All rays.
    surface_m
        Points this close to a side lie on it; a ray crosses only if it goes on for more.
    front_m
        Points this close stand before it.
    """

    def __init__(self, rays: Rays, *, surface_m: float, front_m: float) -> None:
        self._rays = rays
        self._reach = (surface_m, front_m)
        self._by_start = _Groups(rays.from_room)
        self._by_end = _Groups(rays.to_room)

    def views(self, sides: list[Side]) -> Iterator[SideView]:
        """Yield one view a side; the sides must be ordered by room."""
        for room, own in groupby(sides, key=lambda side: side.room):
            measured, sent = self._by_end.of(room), self._by_start.of(room)
            members = np.concatenate([measured, sent[self._rays.to_room[sent] != room]])
            yield from _view_room(self._rays, members, list(own), room, self._reach)


class _Groups:
    """Indices by value, found with one sort, which is linear in short integers."""

    def __init__(self, values: I32) -> None:
        fits = values.max(initial=0) < np.iinfo(np.int16).max
        self._order = np.argsort(values.astype(np.int16) if fits else values, kind="stable").astype(np.int32)
        self._sorted = values[self._order]

    def of(self, value: int) -> I32:
        low, high = np.searchsorted(self._sorted, [value, value + 1])
        return self._order[low:high]


def _view_room(
    rays: Rays, members: I32, sides: list[Side], room: int, reach: tuple[float, float]
) -> Iterator[SideView]:
    """View all sides of a room."""
    normals = np.array([side.normal for side in sides], dtype=np.float32)
    offsets = np.array([side.offset for side in sides], dtype=np.float32)
    ahead = rays.start @ normals.T - offsets
    parts: list[list[tuple[I32, F64, F64, F64, Bool, F64, F64]]] = [[] for _ in sides]
    for first in range(0, len(members), CHUNK):
        chunk = members[first : first + CHUNK]
        own = rays.from_room[chunk] == room
        kind = _classify(rays.end[chunk], rays.scan[chunk], own, normals, offsets, ahead, *reach)
        for row, (part, side) in enumerate(zip(parts, sides, strict=True)):
            leaving, entering, on, before = (chunk[kind[row] == value] for value in (LEAVES, ENTERS, ON, BEFORE))
            crossed = _cross(side, rays, leaving, entering)
            part.append((*crossed, _along(side, rays, on), _along(side, rays, before)))
    for part, side in zip(parts, sides, strict=True):
        yield SideView(side, *(np.concatenate(columns) for columns in zip(*part, strict=True)))


@njit(cache=True)
def _classify(
    end: NDArray[np.float32],
    scan: I32,
    own: Bool,
    normals: NDArray[np.float32],
    offsets: NDArray[np.float32],
    ahead: NDArray[np.float32],
    surface_m: float,
    front_m: float,
) -> NDArray[np.uint8]:
    """Tell for each side (row) and ray (column) whether the ray leaves, enters, or ends on or right before the side.

    `own` are the rays of scanners in the room, `ahead` the distances of all scanners (rows) from all sides (columns).
    """
    kind = np.zeros((len(offsets), len(end)), np.uint8)
    for ray in range(len(end)):
        x, y, z = end[ray]
        for side in range(len(offsets)):
            depth = normals[side, 0] * x + normals[side, 1] * y + normals[side, 2] * z - offsets[side]
            start = ahead[scan[ray], side]
            if abs(depth) < surface_m:
                kind[side, ray] = ON
            elif depth < 0.0:
                if own[ray] and start > surface_m:
                    kind[side, ray] = LEAVES
            elif not own[ray] and start < -surface_m:
                kind[side, ray] = ENTERS
            elif depth < front_m:
                kind[side, ray] = BEFORE
    return kind


def _cross(side: Side, rays: Rays, leaving: I32, entering: I32) -> tuple[I32, F64, F64, F64, Bool]:
    """Find where rays cross a side, leaving out those that cross its plane beside it."""
    ray = np.concatenate([leaving, entering])
    start, end = rays.starts(ray), rays.ends(ray)
    ahead, depth = start @ side.normal - side.offset, end @ side.normal - side.offset
    frame = np.column_stack([side.u, side.v])
    crossing = (start + (ahead / (ahead - depth))[:, None] * (end - start)) @ frame
    outbound = np.arange(len(ray)) < len(leaving)
    beyond = np.where(outbound, -depth, -ahead)
    hit = _within(crossing, side.bounds, 0.1)
    return ray[hit], crossing[hit], end[hit] @ frame, beyond[hit], outbound[hit]


def _along(side: Side, rays: Rays, ray: I32) -> F64:
    """Return where points lie along the axes of a side, leaving out those beside it."""
    wall = rays.ends(ray) @ np.column_stack([side.u, side.v])
    return wall[_within(wall, side.bounds, 0.1)]


def _within(places: F64, bounds: F64, margin: float) -> Bool:
    inside = (places > bounds[:2] - margin) & (places < bounds[2:] + margin)
    return np.asarray(inside.all(axis=1), dtype=np.bool_)
