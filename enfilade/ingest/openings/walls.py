"""Holes in walls become doors, passages and windows: where each leads, and which belong together."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from enfilade.ingest.openings.holes import Hole
from enfilade.ingest.openings.leads import Lead, group_holes, interval, through
from enfilade.ingest.openings.parameters import OpeningParameters
from enfilade.ingest.openings.rays import Rays
from enfilade.ingest.records import F64, Bool, Neighbour, Opening, Room


def open_walls(
    holes: Iterable[Hole],
    rays: Rays,
    rooms: Mapping[int, Room],
    neighbours: tuple[Neighbour, ...],
    parameters: OpeningParameters,
) -> list[Opening]:
    """Turn holes in walls into openings between two rooms.

    Parameters
    ----------
    holes
        Of all walls.
    rays
        All rays, with the rooms at their ends.
    rooms
        By number.
    neighbours
        Pairs of rooms with a wall between them, and its thickness.
    parameters
        Sizes and thresholds.

    Returns
    -------
    One opening for all holes of a pair of rooms that lie in front of one another.
    """
    gaps = {(n.room_a, n.room_b): n.gap for n in neighbours}
    found = (
        _opening(pair, group, rays, rooms, gaps.get(pair), parameters)
        for pair, group in group_holes(holes, rays, rooms, parameters)
    )
    return [opening for opening in found if opening is not None]


def _merge_edges(group: list[Lead]) -> tuple[F64, Bool]:
    """Edges of several holes in the axes of the first: the mean of the bounded ones, else the outermost."""
    frame = group[0].hole.side
    edges, bounded = [], []
    for lead in group:
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


def _opening(
    pair: tuple[int, int],
    group: list[Lead],
    rays: Rays,
    rooms: Mapping[int, Room],
    gap: float | None,
    parameters: OpeningParameters,
) -> Opening | None:
    group = sorted(group, key=lambda lead: -len(lead.hole.ray))
    edges, bounded = _merge_edges(group)
    floor = max(rooms[number].floor_elevation for number in pair)
    if edges[1] - floor < 0.15:
        edges[1], bounded[1] = floor, True
    side = group[0].hole.side
    ray = through(group, rays, pair)
    width, height = (edges[2:] - edges[:2]).tolist()
    if len(ray) < parameters.min_rays or width < parameters.min_width_m or height < parameters.min_height_m:
        return None
    centres = [lead.hole.side.offset * (lead.hole.side.normal @ side.normal) for lead in group]
    offset = (min(centres) + max(centres)) / 2 if len(group) > 1 else side.offset - (gap or 0.0) / 2
    middle = (edges[:2] + edges[2:]) / 2
    position = middle[0] * side.u + middle[1] * side.v + offset * side.normal
    kind = _kind(edges, bounded, [rooms[number] for number in pair], parameters)
    return Opening(
        kind=kind,
        orientation="horizontal",
        room_a=pair[0],
        room_b=pair[1],
        position=position,
        normal=side.normal,
        width=width,
        height=height,
        sill=float(edges[1] - floor),
        area=width * height,
        ray_count=len(ray),
        state="open",
        confidence=_confidence(group, len(ray), bounded),
    )


def _kind(edges: F64, bounded: Bool, pair: list[Room], parameters: OpeningParameters) -> str:
    floor = max(room.floor_elevation for room in pair)
    if edges[1] - floor > parameters.min_sill_m:
        return "window"
    ceilings = [room.ceiling_elevation for room in pair if room.ceiling_elevation is not None]
    reaches_ceiling = bool(ceilings) and edges[3] > min(ceilings) - parameters.min_lintel_m
    return "passage" if reaches_ceiling or not bounded[3] else "door"


def _confidence(group: list[Lead], rays: int, bounded: Bool) -> float:
    """Mean of four shares: rays (half at 50), edges with wall beside them, hole filled by rays, votes agreed."""
    fill = max(lead.hole.fill for lead in group)
    share = max(lead.share for lead in group)
    return float(np.mean([rays / (rays + 50), bounded.mean(), fill, share]))
