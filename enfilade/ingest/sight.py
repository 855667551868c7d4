"""How far scans look into each other's surroundings, seen from under the ceiling."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from .records import F32, F64, I32, Bool, Planes
from .structure import Structure

I64 = NDArray[np.int64]
_RIVALS: Final = 6
_SHORT_OF_WALL: Final = 0.95
_GOLDEN: Final = (np.sqrt(5.0) - 1.0) / 2.0


@dataclass(frozen=True, slots=True)
class SightParameters:
    """How views are compared.

    Attributes
    ----------
    reach_m
        Scans farther apart than this are not compared.
    level_m
        Nor those farther apart than this in height.
    azimuths
        Directions in which a viewpoint looks around.
    places
        Places sampled in the area that it overlooks.
    place_pairs
        Pairs of places that are tested for each pair of scans.
    least_sight
        Share of them that must see each other for two scans to be open to each other.
    least_walled
        Share of them with one wall between, from which on that says something.
    wall_m
        What is opaque for less than this, straight across what a line meets first, is one wall.
    piece_m
        Width of the pieces of wall that are each found open or closed.
    least_wall_m
        So much wall at least must lie between what two scans overlook to be asked alone.
    """

    reach_m: float = 20.0
    level_m: float = 1.6
    azimuths: int = 180
    places: int = 122
    place_pairs: int = 1220
    least_sight: float = 0.05
    least_walled: float = 0.1
    wall_m: float = 0.6
    piece_m: float = 0.1
    least_wall_m: float = 0.5


@dataclass(frozen=True, slots=True)
class Views:
    """How open scans are to each other.

    Attributes
    ----------
    pairs
        ``(n, 2) int64`` scans, the smaller first.
    openness
        ``(n,) float64`` share of the boundary between the two that no wall closes: 1 in one convex room, 0 through
        walls and doors with lintels; NaN where they lie too far round corners to tell.
    """

    pairs: I64
    openness: F64


@dataclass(frozen=True, slots=True)
class _Lines:
    """Lines between places of two scans, ``(n, ...)``: ends, what stops them, how thick it is straight across (0: nothing)."""

    starts: F32
    ends: F32
    plane: I32
    thickness: F32


def compare_views(
    structure: Structure,
    planes: Planes,
    scanners: F32,
    viewpoints: F32,
    parameters: SightParameters = SightParameters(),
) -> Views:
    """Compare what the viewpoints of all scans near each other overlook.

    Places are sampled evenly over the area that each viewpoint overlooks; those that another viewpoint overlooks
    from nearer are left to that one, so that what is seen through a passage does not count as here.
    """
    pairs = np.sort(cKDTree(scanners).query_pairs(parameters.reach_m, output_type="ndarray"), axis=1)
    pairs = pairs[np.abs(scanners[pairs[:, 0], 2] - scanners[pairs[:, 1], 2]) <= parameters.level_m]
    pairs = pairs[np.lexsort(pairs.T[::-1])]
    places = _free_places(structure, viewpoints, parameters)
    own = _own_places(structure, viewpoints, places) & _roofed(structure, places)
    openness = np.array([_openness(structure, planes, viewpoints, places, own, a, b, parameters) for a, b in pairs])
    return Views(pairs, openness.reshape(-1))


def _free_places(structure: Structure, lifted: F32, parameters: SightParameters) -> F32:
    """``(S, K, 3)``: places spread evenly over the area that each lifted scanner overlooks at its height."""
    azimuth = 2.0 * np.pi * np.arange(parameters.azimuths) / parameters.azimuths
    rays = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros_like(azimuth)], axis=1).astype(np.float32)
    starts = np.repeat(lifted, len(rays), axis=0)
    distance = structure.cast(starts, np.tile(rays, (len(lifted), 1))).distance
    free = np.minimum(distance, parameters.reach_m / 2.0).reshape(len(lifted), len(rays))
    share = (np.arange(parameters.places) + 0.5) / parameters.places
    area = np.cumsum(free**2, axis=1)
    ray = np.array([np.searchsorted(row, share * row[-1]) for row in area])
    ray = np.minimum(ray, len(rays) - 1)
    outwards = np.sqrt((share * _GOLDEN * parameters.places) % 1.0).astype(np.float32)
    reach = np.take_along_axis(free, ray, axis=1) * outwards * _SHORT_OF_WALL
    return np.asarray(lifted[:, None] + rays[ray] * reach[..., None], np.float32)


def _own_places(structure: Structure, lifted: F32, places: F32) -> Bool:
    """``(S, K)``: places of which no other scanner that overlooks them is nearer than their own."""
    count, around = places.shape[:2]
    own = _owned(structure, lifted, places.reshape(-1, 3), np.repeat(np.arange(count), around))
    return own.reshape(count, around)


def _owned(structure: Structure, lifted: F32, places: F32, owner: I64) -> Bool:
    """``(n,)``: places that no scanner nearer than their owner overlooks."""
    count = min(_RIVALS, len(lifted))
    rivals = np.atleast_2d(cKDTree(lifted).query(places, k=count)[1].reshape(len(places), -1))
    distance = _distance(places[:, None], lifted[rivals])
    nearer = distance < _distance(places, lifted[owner])[:, None]
    place, rank = np.nonzero(nearer)
    overlooked = ~structure.blocked(lifted[rivals[place, rank]], places[place])
    own = np.ones(len(places), bool)
    own[place[overlooked]] = False
    return own


def _roofed(structure: Structure, places: F32) -> Bool:
    """``(S, K)``: places under a ceiling; the others were overlooked through a window, or have no ceiling anywhere."""
    flat = places.reshape(-1, 3)
    upwards = np.tile(np.array([[0.02, 0.01, 1.0]], np.float32), (len(flat), 1))
    roofed = structure.cast(flat, upwards).front.reshape(places.shape[:2])
    return np.asarray(roofed | ~roofed.any(axis=1, keepdims=True))


def _openness(
    structure: Structure,
    planes: Planes,
    viewpoints: F32,
    places: F32,
    own: Bool,
    a: int,
    b: int,
    parameters: SightParameters,
) -> float:
    """Share of the boundary between two scans' places that is open, NaN where there is too little to tell."""
    lines = _lines(structure, planes, places[a], places[b], own[a], own[b], parameters)
    seen = lines.thickness == 0.0
    walled = ~seen & (lines.thickness < parameters.wall_m) & planes.vertical[lines.plane]
    if seen.sum() < parameters.least_sight * max(len(seen), 1):
        return 0.0 if walled.sum() >= parameters.least_walled * max(len(seen), 1) and len(seen) else float("nan")
    if walled.sum() < parameters.least_walled * (seen.sum() + walled.sum()):
        return 1.0
    wall = int(np.argmax(np.bincount(lines.plane[walled])))
    normal, offset = planes.normals[wall], float(planes.offsets[wall])
    if np.mean(lines.starts[walled & (lines.plane == wall)] @ normal > offset) < 0.5:
        normal, offset = -normal, -offset
    past = _crossing(lines, normal, offset)[seen | walled].mean()
    here, there = places[a][places[a] @ normal > offset], places[b][places[b] @ normal < offset]
    return 1.0 - float(past) * (1.0 - _open_share(structure, viewpoints, (a, b), here, there, normal, offset, parameters))


def _crossing(lines: _Lines, normal: F32, offset: float) -> Bool:
    """``(n,)``: which lines have their ends on two sides of a plane."""
    return np.asarray((lines.starts @ normal - offset) * (lines.ends @ normal - offset) < 0.0)


def _open_share(
    structure: Structure,
    viewpoints: F32,
    pair: tuple[int, int],
    here: F32,
    there: F32,
    normal: F32,
    offset: float,
    parameters: SightParameters,
) -> float:
    """Share of a wall's line that is open, as far along as one viewpoint looks at its front and the other at its back."""
    if not (len(here) and len(there)):
        return 1.0
    along = np.array([-normal[1], normal[0], 0.0], np.float32)
    first = float(max((here @ along).min(), (there @ along).min()))
    last = float(min((here @ along).max(), (there @ along).max()))
    pieces = np.arange(first, max(first, last) + parameters.piece_m / 2.0, parameters.piece_m)
    on_wall = (pieces[:, None] * along + offset * normal).astype(np.float32)
    on_wall[:, 2] = (here[:, 2].mean() + there[:, 2].mean()) / 2.0
    across = parameters.wall_m * np.array([normal[0], normal[1], 0.0], np.float32)
    front, back = on_wall + across / 2.0, on_wall - across
    between = _overlooked(structure, viewpoints, front, pair) & _overlooked(structure, viewpoints, back, pair[::-1])
    if between.sum() * parameters.piece_m < parameters.least_wall_m:
        between[:] = True
    return float(1.0 - structure.blocked(front[between], back[between]).mean())


def _overlooked(structure: Structure, viewpoints: F32, places: F32, pair: tuple[int, int]) -> Bool:
    """``(n,)``: places that the first of a pair overlooks, and no third viewpoint from nearer than either."""
    first, second = viewpoints[pair[0]], viewpoints[pair[1]]
    nearer = np.where(_distance(places, first) < _distance(places, second), *pair)
    seen = ~structure.blocked(places, np.broadcast_to(first, places.shape))
    return seen & _owned(structure, viewpoints, places, nearer)


def _lines(
    structure: Structure,
    planes: Planes,
    here: F32,
    there: F32,
    own_here: Bool,
    own_there: Bool,
    parameters: SightParameters,
) -> _Lines:
    count = np.arange(parameters.place_pairs)
    a = count % len(here)
    b = (count * 23 + count // len(here) * 7) % len(there)
    both = own_here[a] & own_there[b]
    starts, ends = here[a[both]], there[b[both]]
    length = _distance(starts, ends)
    towards = (ends - starts) / np.maximum(length, 1e-6)[:, None]
    forth, back = structure.cast(starts, towards), structure.cast(ends, -towards)
    blocked = forth.distance < length
    slant = np.abs(np.einsum("ij,ij->i", towards, planes.normals[forth.plane]))
    through = (length - forth.distance - np.minimum(back.distance, length)) * slant
    return _Lines(starts, ends, forth.plane, np.where(blocked, np.maximum(through, 1e-3), 0.0).astype(np.float32))


def _distance(a: F32, b: F32) -> F32:
    return np.asarray(np.linalg.norm(a - b, axis=-1), np.float32)
