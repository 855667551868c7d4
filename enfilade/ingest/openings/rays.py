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
from numpy.typing import NDArray

from enfilade.ingest.records import F64, I32, Bool, RoomLabels, Surfels, ThinnedCloud
from enfilade.ingest.sides import Side

CHUNK: Final = 400_000
"""Rays looked at together; keeps the working memory small."""


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


def view_sides(rays: Rays, sides: list[Side], *, surface_m: float, front_m: float) -> Iterator[SideView]:
    """Collect the crossings and the surface points of every side, room by room.

    Parameters
    ----------
    rays
        All rays.
    sides
        Ordered by room.
    surface_m
        Points this close to a side lie on it; a ray crosses only if it goes on for more.
    front_m
        Points this close stand before it.

    Yields
    ------
    One view a side, in the order given.
    """
    by_start = _Groups(rays.from_room)
    by_end = _Groups(rays.to_room)
    for room, own in groupby(sides, key=lambda side: side.room):
        measured, sent = by_end.of(room), by_start.of(room)
        members = np.concatenate([measured, sent[rays.to_room[sent] != room]])
        yield from _view_room(rays, members, list(own), room, (surface_m, front_m))


class _Groups:
    """Indices by value, found with one sort."""

    def __init__(self, values: I32) -> None:
        self._order = np.argsort(values, kind="stable").astype(np.int32)
        self._sorted = values[self._order]

    def of(self, value: int) -> I32:
        low, high = np.searchsorted(self._sorted, [value, value + 1])
        return self._order[low:high]


def _view_room(
    rays: Rays, members: I32, sides: list[Side], room: int, reach: tuple[float, float]
) -> Iterator[SideView]:
    """View all sides of a room; distances from the planes are taken for all of them in one product."""
    surface_m, front_m = reach
    normals = np.array([side.normal for side in sides], dtype=np.float32)
    offsets = np.array([[side.offset] for side in sides], dtype=np.float32)
    ahead_of_scanner = normals @ rays.start.T - offsets
    parts: list[list[tuple[I32, F64, F64, F64, Bool, F64, F64]]] = [[] for _ in sides]
    for first in range(0, len(members), CHUNK):
        chunk = members[first : first + CHUNK]
        depth = normals @ rays.end[chunk].T - offsets
        ahead = ahead_of_scanner[:, rays.scan[chunk]]
        leaves = (rays.from_room[chunk] == room) & (ahead > surface_m) & (depth < -surface_m)
        enters = (rays.from_room[chunk] != room) & (ahead < -surface_m) & (depth > surface_m)
        for row, (part, side) in enumerate(zip(parts, sides, strict=True)):
            on = chunk[np.abs(depth[row]) < surface_m]
            front = chunk[(depth[row] >= surface_m) & (depth[row] < front_m)]
            crossed = _cross(side, rays, chunk[leaves[row]], chunk[enters[row]])
            part.append((*crossed, _along(side, rays, on), _along(side, rays, front)))
    for part, side in zip(parts, sides, strict=True):
        yield SideView(side, *(np.concatenate(columns) for columns in zip(*part, strict=True)))


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
