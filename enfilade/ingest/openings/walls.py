"""Holes in walls become doors, passages and windows."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np

from enfilade.ingest.openings.confidence import probability
from enfilade.ingest.openings.evidence import FACING, Walls, evidence_of_group
from enfilade.ingest.openings.holes import Hole
from enfilade.ingest.openings.leads import Group, Lead, interval, through
from enfilade.ingest.openings.parameters import OpeningParameters
from enfilade.ingest.openings.rays import Rays
from enfilade.ingest.records import F64, Bool, Neighbour, Opening, Room
from enfilade.ingest.sides import Side

SNAP_M: Final = 0.15
"""A hole that begins this close to the floor begins at the floor."""

FRAME_M: Final = 0.12
"""Widest door frame."""

LEAST_WALL_M: Final = 0.03
"""Holes nearer to each other than this are in one face of a wall."""

LINE_M: Final = 0.05
"""Height of the lines across a hole in which frames are looked for."""


@dataclass(frozen=True, slots=True)
class _Doorway:
    """A group of holes, measured: edges in the axes of its main side, and how far behind it the wall's middle is."""

    edges: F64
    bounded: Bool
    depth: float
    floor: float


def open_walls(
    groups: Iterable[Group],
    rays: Rays,
    rooms: Mapping[int, Room],
    neighbours: tuple[Neighbour, ...],
    walls: Walls,
    parameters: OpeningParameters,
) -> list[Opening]:
    """Turn groups of holes in walls into openings between two rooms.

    Parameters
    ----------
    groups
        Holes that belong together.
    rays
        All rays, with the rooms at their ends.
    rooms
        By number.
    neighbours
        Pairs of rooms with a wall between them, and its thickness.
    walls
        Tell mirrors from holes.
    parameters
        Sizes and thresholds.

    Returns
    -------
    One opening a group, without those that are too small, or beside or above one of the rooms, or mirrors.
    """
    gaps = {(n.room_a, n.room_b): n.gap for n in neighbours}
    found = (
        _opening(group, rays, rooms, gaps.get(group.pair, 0.0), parameters)
        for group in (of_one_wall(group, parameters.max_gap_m) for group in groups)
        if walls.covered(group.main) < parameters.least_pane
    )
    return [opening for opening in found if opening is not None]


def _opening(
    group: Group, rays: Rays, rooms: Mapping[int, Room], gap: float, parameters: OpeningParameters
) -> Opening | None:
    pair = [rooms[number] for number in group.pair]
    doorway = _measure(group, rays, gap, max(room.floor_elevation for room in pair))
    left, bottom, right, top = doorway.edges.tolist()
    kind = _kind(doorway, pair, right - left, parameters)
    ray = through(group, rays)
    if kind is None or len(ray) < parameters.min_rays or not all(_reaches(room, bottom, top) for room in pair):
        return None
    width, height, lintel = right - left, top - bottom, max(lead.hole.lintel for lead in group.leads)
    evidence = evidence_of_group(group, len(ray), doorway.bounded, width)
    glazed = evidence["glazed"] > parameters.least_pane
    if glazed and (lintel < parameters.min_lintel_m or width > parameters.max_leaf_m):
        kind = "window"
    side = group.main.side
    position = side.point((left + right) / 2, (bottom + top) / 2) - doorway.depth * side.normal
    return Opening(
        kind=kind,
        orientation="horizontal",
        room_a=group.pair[0],
        room_b=group.pair[1],
        position=position,
        normal=side.normal,
        width=width,
        height=height,
        sill=bottom - doorway.floor,
        area=width * height,
        ray_count=len(ray),
        state="closed" if glazed or kind == "window" else "open",
        confidence=probability(parameters.confidence.through_wall, evidence),
        lintel=0.0 if kind == "passage" else lintel,
        evidence=evidence,
    )


def of_one_wall(group: Group, max_gap_m: float) -> Group:
    """Leave only the holes of a group that are in the two faces of one wall, the best framed one first.

    What stands in front of a wall, such as the leaf of another door, may have a hole before its hole.
    """
    leads = sorted(group.leads, key=lambda lead: (-_frame(lead), -len(lead.hole.ray)))
    first, second = ([lead for lead in leads if lead.hole.side.room == room] for room in group.pair)
    faces = [pair for pair in product(first, second) if LEAST_WALL_M < _thickness(*pair) < max_gap_m]
    if not faces:
        return Group(group.pair, tuple(leads[:1]))
    best = max(faces, key=lambda pair: (_frame(pair[0]) + _frame(pair[1]), min(len(lead.hole.ray) for lead in pair)))
    return Group(group.pair, tuple(sorted(best, key=leads.index)))


def _frame(lead: Lead) -> int:
    return int(lead.hole.bounded.sum())


def _thickness(a: Lead, b: Lead) -> float:
    """Thickness of the wall whose two faces have these holes; negative if they look the same way or at each other."""
    if a.hole.side.normal @ b.hole.side.normal > FACING:
        return -1.0
    return float(a.hole.side.normal @ (a.hole.centre - b.hole.centre))


def _measure(group: Group, rays: Rays, gap: float, floor: float) -> _Doorway:
    edges, bounded = _merge_edges(group)
    of_surface = len(group.main.side.surfels) > 0
    thickness = _thickness(*group.leads) if len(group.leads) == 2 else gap if of_surface else 0.0
    edges = _within_frame(edges, group, rays, thickness)
    if edges[1] - floor < SNAP_M:
        edges[1], bounded[1] = floor, True
    return _Doorway(edges, bounded, thickness / 2, floor)


def _merge_edges(group: Group) -> tuple[F64, Bool]:
    """Edges of several holes in the axes of the main one: the mean of the bounded ones, else the outermost."""
    frame = group.main.side
    edges, bounded = [], []
    for lead in group.leads:
        hole = lead.hole
        low, high = interval(hole, frame.u)
        flipped = frame.u @ hole.side.u < 0
        edges.append([low, hole.edges[1], high, hole.edges[3]])
        bounded.append(hole.bounded[[2, 1, 0, 3]] if flipped else hole.bounded)
    values, known = np.array(edges), np.array(bounded)
    outermost = np.concatenate([values[:, :2].min(axis=0), values[:, 2:].max(axis=0)])
    count = known.sum(axis=0)
    mean = np.where(known, values, 0.0).sum(axis=0) / np.maximum(count, 1)
    return np.where(count > 0, mean, outermost), count > 0


def _within_frame(edges: F64, group: Group, rays: Rays, thickness: float) -> F64:
    """Narrow a hole to the clear opening: a door frame stands within the thickness of the wall."""
    places = [_in_wall(lead.hole, group.main.side, rays, thickness) for lead in group.leads]
    u, v = np.concatenate(places).T
    left, bottom, right, top = edges.tolist()
    upright = (v > bottom + 0.2) & (v < top - 0.2)
    middle = (u > left + 0.1) & (u < right - 0.1)
    return np.array(
        [
            _inner(left, u[upright], v[upright]),
            bottom,
            -_inner(-right, -u[upright], v[upright]),
            -_inner(-top, -v[middle], u[middle]),
        ]
    )


def _in_wall(hole: Hole, frame: Side, rays: Rays, thickness: float) -> F64:
    """``(k, 2)``: points behind a hole that lie within the wall, along the axes of another side."""
    ray = hole.ray[hole.outbound & (hole.beyond < thickness)]
    return rays.ends(ray) @ np.column_stack([frame.u, frame.v])


def _inner(edge: float, along: F64, across: F64) -> float:
    """Where most lines across a hole have a point a little inside of its edge, that is the edge."""
    near = (along > edge - 0.02) & (along < edge + FRAME_M)
    if not near.any():
        return edge
    line = np.floor((across[near] - across.min()) / LINE_M).astype(int)
    innermost = np.full(int((across.max() - across.min()) / LINE_M) + 1, -np.inf)
    np.maximum.at(innermost, line, along[near])
    seen = np.isfinite(innermost)
    inner = float(np.median(innermost[seen]))
    return inner if seen.mean() > 0.4 and inner > edge + 0.015 else edge


def _reaches(room: Room, bottom: float, top: float) -> bool:
    """Whether the middle of a hole lies between floor and ceiling of a room."""
    ceiling = room.ceiling_elevation if room.ceiling_elevation is not None else room.bounds[5]
    return bool(room.floor_elevation < (bottom + top) / 2 < max(ceiling, room.floor_elevation + 2.0))


def _kind(doorway: _Doorway, pair: list[Room], width: float, parameters: OpeningParameters) -> str | None:
    """Tell what a hole is; None if it is too small, or neither high enough to walk through nor framed by wall."""
    bottom, top = float(doorway.edges[1]), float(doorway.edges[3])
    if width < parameters.min_width_m or top - bottom < parameters.min_height_m:
        return None
    if bottom - doorway.floor > parameters.min_sill_m:
        return "window" if doorway.bounded.all() else None
    if top - bottom < parameters.min_headroom_m:
        return None
    ceilings = [room.ceiling_elevation for room in pair if room.ceiling_elevation is not None]
    reaches_ceiling = bool(ceilings) and top > min(ceilings) - parameters.min_lintel_m
    return "passage" if reaches_ceiling or not doorway.bounded[3] else "door"
