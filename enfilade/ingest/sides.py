"""Sides: what one room sees of a wall, a floor or a ceiling.

A plane may run through several rooms (the wall of a corridor), and one wall of a room may come in several
patches (left of a door, right of it, the lintel). Here planes are first cut by room, as the paper does before it
looks for neighbours (§5.1), and then patches of a room that lie in one plane are joined to a side.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from typing import Final

import numpy as np
from numba import njit

from enfilade.ingest.cells import Gathered
from enfilade.ingest.records import F32, F64, I32, Planes, RoomLabels, Surfels
from enfilade.parallel import at_once

UP: Final = np.array([0.0, 0.0, 1.0])

FIT_M: Final = 0.015
"""A surfel so far from the plane of its side does not count when it is fitted: it may be on the leaf of a door."""

FIT_ROUNDS: Final = 5
"""Rounds in which a side finds its plane."""

FIT_STARTS: Final = 3
"""So many patches of a side are tried as its plane."""

FIT_SAMPLE: Final = 1000
"""So many of its surfels are asked at first."""


@dataclass(frozen=True, slots=True)
class Patch:
    """The part of one plane that lies in one room.

    Attributes
    ----------
    room, plane
        Their numbers.
    normal, offset
        Unit vector into the room; ``normal · x = offset``, the offset being the median over `surfels`.
    surfels
        ``(n,) int32``.
    """

    room: int
    plane: int
    normal: F64
    offset: float
    surfels: I32


@dataclass(frozen=True, slots=True)
class Side:
    """Patches of one room that lie in one plane, with axes in that plane.

    Attributes
    ----------
    room
        Number of the room that it faces.
    planes
        Numbers of the planes that it consists of.
    normal, offset
        Unit vector into the room; ``normal · x = offset``.
    u, v
        Unit axes; on a wall `v` is straight up, however the wall leans, and `u` is level, so that heights on all
        walls mean the same, far from the origin too.
    bounds
        ``(u_min, v_min, u_max, v_max)`` metres, along the axes.
    surfels
        ``(n,) int32``.
    """

    room: int
    planes: tuple[int, ...]
    normal: F64
    offset: float
    u: F64
    v: F64
    bounds: F64
    surfels: I32

    @property
    def vertical(self) -> bool:
        """Whether it is a wall (within 15°)."""
        return bool(abs(self.normal[2]) < np.sin(np.radians(15.0)))

    @property
    def horizontal(self) -> bool:
        """Whether it is a floor, a ceiling or a table top (within 15°)."""
        return bool(abs(self.normal[2]) > np.cos(np.radians(15.0)))

    def point(self, u: float, v: float) -> F64:
        """Return the point of the plane at those coordinates."""
        return np.asarray(self.points(np.array([[u, v]]))[0], dtype=np.float64)

    def points(self, places: F64) -> F64:
        """Return the ``(n, 3)`` points of the plane at ``(n, 2)`` coordinates."""
        across = _cross(self.u, self.v)
        axes = np.array([self.u, self.v])
        depth = (self.offset - places @ (axes @ self.normal)) / (across @ self.normal)
        return np.asarray(places @ axes + depth[:, None] * across, dtype=np.float64)


def cut_by_room(surfels: Surfels, planes: Planes, labels: RoomLabels, min_surfels: int) -> list[Patch]:
    """Cut every plane into the parts that belong to one room each, leaving out parts of few surfels.

    Parameters
    ----------
    surfels, planes, labels
        What the stages before found.
    min_surfels
        Least number of surfels of a patch.

    Returns
    -------
    Patches ordered by room, then plane.
    """
    usable = np.flatnonzero((planes.surfel_plane >= 0) & (labels.after >= 0))
    plane_count = max(len(planes.offsets), 1)
    key = labels.after[usable].astype(np.int64) * plane_count + planes.surfel_plane[usable]
    gathered = Gathered.by(key)
    groups = np.split(usable[gathered.order], gathered.bounds[1:-1]) if len(gathered) else []
    return [
        _patch(int(k // plane_count), int(k % plane_count), group.astype(np.int32), surfels, planes)
        for k, group in zip(gathered.keys, groups, strict=True)
        if len(group) >= min_surfels
    ]


def join_patches(patches: list[Patch], surfels: Surfels, *, max_angle_deg: float, max_offset_m: float) -> list[Side]:
    """Join patches of one room that lie in one plane, the largest first.

    Parameters
    ----------
    patches
        From `cut_by_room`.
    surfels
        The surfels that they index.
    max_angle_deg, max_offset_m
        How far a patch may turn and stand off from the side that it joins.

    Returns
    -------
    Sides ordered by room, then size.
    """
    min_cosine = float(np.cos(np.radians(max_angle_deg)))
    groups: list[list[Patch]] = []
    for _, own in groupby(sorted(patches, key=lambda p: (p.room, -len(p.surfels), p.plane)), key=lambda p: p.room):
        groups.extend(_coplanar(list(own), surfels, min_cosine, max_offset_m))
    return at_once(_side, ((group, surfels) for group in groups))


def axes(normal: F64) -> tuple[F64, F64]:
    """Return unit axes u, v of a plane: in it where it is level, else u level in it and v straight up."""
    if abs(normal[2]) > np.cos(np.radians(15.0)):
        u = np.array([1.0, 0.0, 0.0])
        u -= (u @ normal) * normal
        u /= np.linalg.norm(u)
        return u, _cross(np.sign(normal[2]) * normal, u)
    u = np.array([-normal[1], normal[0], 0.0])
    u /= np.linalg.norm(u)
    return u, UP.copy()


def _cross(one: F64, other: F64) -> F64:
    """Cross product of two vectors ``(3,)``; NumPy's takes twenty times as long."""
    (a, b, c), (d, e, f) = one.tolist(), other.tolist()
    return np.array([b * f - c * e, c * d - a * f, a * e - b * d])


@njit(cache=True, nogil=True)
def in_plane(positions: F32, members: I32, u: F64, v: F64) -> F64:
    """``(n, 2)`` where some of the positions are along the axes of a plane."""
    places = np.zeros((len(members), 2))
    for i in range(len(members)):
        for axis in range(3):
            places[i, 0] += positions[members[i], axis] * u[axis]
            places[i, 1] += positions[members[i], axis] * v[axis]
    return places


def _patch(room: int, plane: int, group: I32, surfels: Surfels, planes: Planes) -> Patch:
    normal = planes.normals[plane].astype(np.float64)
    normal /= np.linalg.norm(normal)
    offset = float(np.median(surfels.positions[group] @ normal))
    return Patch(room, plane, normal, offset, group)


def _coplanar(patches: list[Patch], surfels: Surfels, min_cosine: float, max_offset_m: float) -> list[list[Patch]]:
    """Group patches, sorted by size, with the first group whose largest patch lies in the same plane."""
    groups: list[list[Patch]] = []
    for patch in patches:
        centre = surfels.positions[patch.surfels].mean(axis=0)
        for group in groups:
            first = group[0]
            if first.normal @ patch.normal > min_cosine and abs(first.normal @ centre - first.offset) < max_offset_m:
                group.append(patch)
                break
        else:
            groups.append([patch])
    return groups


def _fitted(positions: F64, patches: list[Patch]) -> tuple[F64, float]:
    """Return the plane through most of the positions, as unit normal and offset.

    What lies a little before or behind, such as the leaf of a door, must not tilt the wall: a position counts the less
    the farther it is from the plane of the round before. Of the planes that one comes to from that of each of the
    largest patches, and from that through all, the one with most positions on it is taken.
    """
    few = positions[:: len(positions) // FIT_SAMPLE + 1]
    starts = [_weight(few @ patch.normal - patch.offset) for patch in patches[:FIT_STARTS]]
    found = [_refitted(few, weight, FIT_ROUNDS) for weight in (*starts, np.ones(len(few)))]
    normal, offset = max(found, key=lambda plane: float(_weight(few @ plane[0] - plane[1]).sum()))
    normal, offset = _refitted(positions, _weight(positions @ normal - offset), 2)
    turn = float(np.sign(normal @ patches[0].normal))
    return normal * turn, offset * turn


def _side(group: list[Patch], surfels: Surfels) -> Side:
    members = np.sort(np.concatenate([patch.surfels for patch in group]))
    positions = surfels.positions[members].astype(np.float64)
    normal, offset = _fitted(positions, group)
    u, v = axes(normal)
    in_plane = positions @ np.column_stack([u, v])
    bounds = np.concatenate([in_plane.min(axis=0), in_plane.max(axis=0)])
    planes = tuple(sorted({patch.plane for patch in group}))
    return Side(group[0].room, planes, normal, offset, u, v, bounds, members)


@njit(cache=True, nogil=True)
def _refitted(positions: F64, weight: F64, rounds: int) -> tuple[F64, float]:
    """Fit a plane to weighted positions, weigh them by it, and so on."""
    for _ in range(rounds):
        centre = np.zeros(3)
        for i in range(len(positions)):
            centre += weight[i] * positions[i]
        centre /= weight.sum()
        spread = np.zeros((3, 3))
        for i in range(len(positions)):
            for j in range(3):
                for k in range(3):
                    spread[j, k] += weight[i] * (positions[i, j] - centre[j]) * (positions[i, k] - centre[k])
        normal = np.linalg.eigh(spread)[1][:, 0].copy()
        weight = _weight((positions - centre) @ normal)
    return normal, centre @ normal


@njit(cache=True, nogil=True)
def _weight(height: F64) -> F64:
    """How much positions count that are so far from a plane (Tukey's biweight)."""
    return np.maximum(1.0 - np.square(height / FIT_M), 0.0) ** 2 + 1e-6
