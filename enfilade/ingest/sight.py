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
_LEVEL_STEP_M: Final = 0.1
"""Viewpoints this close in height are equally high."""
_SHORT_OF_WALL: Final = 0.95
_GOLDEN: Final = (np.sqrt(5.0) - 1.0) / 2.0


@dataclass(frozen=True, slots=True)
class SightParameters:
    """How views are compared.

    Attributes
    ----------
    reach_m
        Scans farther apart than this are compared only if they see each other from under the ceiling,
    far_m
        and not at all if they are farther apart than this.
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
    door_head_m
        Doors end less than this above a scanner.
    wide_m
        A hole up to the ceiling that is this wide leaves one room, whatever wall there is beside it.
    """

    reach_m: float = 20.0
    far_m: float = 40.0
    level_m: float = 1.6
    azimuths: int = 180
    places: int = 122
    place_pairs: int = 1220
    least_sight: float = 0.05
    least_walled: float = 0.1
    wall_m: float = 0.6
    piece_m: float = 0.1
    least_wall_m: float = 0.5
    door_head_m: float = 0.65
    wide_m: float = 2.2


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
    places
        ``(S, K, 3) float32`` places spread over the area that each scan overlooks.
    """

    pairs: I64
    openness: F64
    places: F32


@dataclass(frozen=True, slots=True)
class _Lines:
    """Lines between places of two scans, ``(n, ...)``: ends, what stops them, and how thick that is (0: nothing)."""

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
    pairs = _compared(structure, scanners, viewpoints, parameters)
    viewpoints, ends = _levelled(scanners, viewpoints, pairs, parameters.door_head_m)
    places = _free_places(structure, viewpoints, parameters)
    own = _own_places(structure, viewpoints, places) & _roofed(structure, places)
    openness = np.array([_openness(structure, planes, viewpoints, places, own, a, b, parameters) for a, b in ends])
    return Views(pairs, openness.reshape(-1), places[: len(scanners)])


def _compared(structure: Structure, scanners: F32, viewpoints: F32, parameters: SightParameters) -> I64:
    """``(n, 2)`` pairs of scans to compare, the smaller first: those near each other, and those along one corridor."""
    pairs = np.sort(cKDTree(scanners).query_pairs(parameters.far_m, output_type="ndarray"), axis=1)
    apart = scanners[pairs[:, 0]] - scanners[pairs[:, 1]]
    level = np.abs(apart[:, 2]) <= parameters.level_m
    pairs, apart = pairs[level], apart[level]
    compared = np.linalg.norm(apart, axis=1) <= parameters.reach_m
    far = np.flatnonzero(~compared)
    compared[far] = ~structure.blocked(viewpoints[pairs[far, 0]], viewpoints[pairs[far, 1]])
    pairs = pairs[compared]
    return np.asarray(pairs[np.lexsort(pairs.T[::-1])], np.int64)


def _levelled(scanners: F32, viewpoints: F32, pairs: I64, door_head_m: float) -> tuple[F32, I64]:
    """Add viewpoints so that the two of each pair are equally high, under the lower of their ceilings.

    Returns all viewpoints, first those given, and ``(n, 2)`` which of them are compared for each pair. None is let down
    below the scanners of its pair or the head of a door, not even where the other stood under a flight of stairs.
    """
    height, stand = viewpoints[:, 2][pairs], scanners[:, 2][pairs]
    least = np.maximum(stand.max(axis=1, initial=-np.inf), stand.min(axis=1, initial=np.inf) + door_head_m)
    low = np.maximum(height.min(axis=1, initial=np.inf), least)
    pair, end = np.nonzero(height > low[:, None] + _LEVEL_STEP_M)
    level = np.round(low / _LEVEL_STEP_M).astype(np.int64)
    asked, place = np.unique(np.stack([pairs[pair, end], level[pair]], axis=1), axis=0, return_inverse=True)
    more = viewpoints[asked[:, 0]]
    more[:, 2] = asked[:, 1] * _LEVEL_STEP_M
    ends = pairs.copy()
    ends[pair, end] = len(viewpoints) + place.reshape(-1)
    return np.concatenate([viewpoints, more]), ends


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
    blind = seen.sum() < parameters.least_sight * max(len(seen), 1)
    if walled.sum() < parameters.least_walled * (len(seen) if blind else seen.sum() + walled.sum()) or not len(seen):
        return float("nan") if blind else 1.0
    wall = int(np.argmax(np.bincount(lines.plane[walled])))
    normal, offset = planes.normals[wall], float(planes.offsets[wall])
    if np.mean(lines.starts[walled & (lines.plane == wall)] @ normal > offset) < 0.5:
        normal, offset = -normal, -offset
    crosses = _crossing(lines, normal, offset)
    here, there = places[a][places[a] @ normal > offset], places[b][places[b] @ normal < offset]
    if not (len(here) and len(there)):
        return float("nan") if blind else 1.0
    border = _border(structure, viewpoints, (a, b), here, there, normal, offset, parameters)
    if blind:
        short = len(border.along) * parameters.piece_m < parameters.least_wall_m
        return float("nan") if short or border.holes_m().max() >= parameters.wide_m else 0.0
    through = _places_on(lines, crosses & seen, normal, offset)
    if len(through) and border.hole_at(float(np.median(through))) >= parameters.wide_m:
        return 1.0
    # What other walls stop says nothing of how open this one is.
    return 1.0 - float(crosses[seen | (walled & crosses)].mean()) * (1.0 - border.open_share(parameters.least_wall_m))


def _crossing(lines: _Lines, normal: F32, offset: float) -> Bool:
    """``(n,)``: which lines have their ends on two sides of a plane."""
    return np.asarray((lines.starts @ normal - offset) * (lines.ends @ normal - offset) < 0.0)


def _places_on(lines: _Lines, chosen: Bool, normal: F32, offset: float) -> F32:
    """``(k,)``: where along a wall the chosen lines, which cross it, do so, metres."""
    starts, ends = lines.starts[chosen], lines.ends[chosen]
    from_wall = starts @ normal - offset
    share = from_wall / (from_wall - (ends @ normal - offset))
    return np.asarray((starts + share[:, None] * (ends - starts)) @ _along(normal), np.float32)


def _along(normal: F32) -> F32:
    return np.array([-normal[1], normal[0], 0.0], np.float32)


@dataclass(frozen=True, slots=True)
class _Border:
    """The line of a wall between two scans in pieces: ``(n,)`` each, in order.

    Attributes
    ----------
    along
        Where, metres.
    closed
        Whether there is wall.
    seen
        Whether some viewpoint looks at its front, and some at its back.
    theirs
        Whether the one scan looks at its front and the other at its back, and no third from nearer.
    """

    along: F32
    closed: Bool
    seen: Bool
    theirs: Bool
    piece_m: float

    def holes_m(self) -> F64:
        """``(n,)``: width of the hole that each piece is in, metres, 0 where none is."""
        passable = self.seen & ~self.closed
        number = np.cumsum(np.diff(passable, prepend=False) | ~passable)
        return np.where(passable, np.bincount(number)[number] * self.piece_m, 0.0)

    def hole_at(self, place: float) -> float:
        """Return the width of the hole at a place, 0 if there is none, metres."""
        return float(self.holes_m()[np.argmin(np.abs(self.along - place))])

    def open_share(self, least_m: float) -> float:
        """Return the open share of what the two look at alone, or of all if that is too little."""
        enough = self.theirs.sum() * self.piece_m >= least_m
        return float(1.0 - self.closed[self.theirs if enough else slice(None)].mean())


def _border(
    structure: Structure,
    viewpoints: F32,
    pair: tuple[int, int],
    here: F32,
    there: F32,
    normal: F32,
    offset: float,
    parameters: SightParameters,
) -> _Border:
    """Cut the line of a wall in pieces, as far along as places `here` before it and `there` behind it both reach."""
    along = _along(normal)
    first = float(max((here @ along).min(), (there @ along).min()))
    last = float(min((here @ along).max(), (there @ along).max()))
    pieces = np.arange(first, max(first, last) + parameters.piece_m / 2.0, parameters.piece_m, dtype=np.float32)
    on_wall = (pieces[:, None] * along + offset * normal).astype(np.float32)
    on_wall[:, 2] = (here[:, 2].mean() + there[:, 2].mean()) / 2.0
    across = parameters.wall_m * np.array([normal[0], normal[1], 0.0], np.float32)
    front, back = on_wall + across / 2.0, on_wall - across
    seen = _seen_by_any(structure, viewpoints, front) & _seen_by_any(structure, viewpoints, back)
    theirs = _overlooked(structure, viewpoints, front, pair) & _overlooked(structure, viewpoints, back, pair[::-1])
    return _Border(pieces, structure.blocked(front, back), seen, theirs, parameters.piece_m)


def _overlooked(structure: Structure, viewpoints: F32, places: F32, pair: tuple[int, int]) -> Bool:
    """``(n,)``: places that the first of a pair overlooks, and no third viewpoint from nearer than either."""
    first, second = viewpoints[pair[0]], viewpoints[pair[1]]
    nearer = np.where(_distance(places, first) < _distance(places, second), *pair)
    seen = ~structure.blocked(places, np.broadcast_to(first, places.shape))
    return seen & _owned(structure, viewpoints, places, nearer)


def _seen_by_any(structure: Structure, viewpoints: F32, places: F32) -> Bool:
    """``(n,)``: places that one of the nearest viewpoints overlooks."""
    count = min(_RIVALS, len(viewpoints))
    nearest = np.atleast_2d(cKDTree(viewpoints).query(places, k=count)[1].reshape(len(places), count))
    blocked = structure.blocked(np.repeat(places, count, axis=0), viewpoints[nearest.reshape(-1)])
    return np.asarray(~blocked.reshape(len(places), count).all(axis=1))


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
    through = (length - np.minimum(forth.distance, length) - np.minimum(back.distance, length)) * slant
    return _Lines(starts, ends, forth.plane, np.where(blocked, np.maximum(through, 1e-3), 0.0).astype(np.float32))


def _distance(a: F32, b: F32) -> F32:
    return np.asarray(np.linalg.norm(a - b, axis=-1), np.float32)
