"""Stairs and hatches: holes in the floor of a room through which rays join it with a room below."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np
import shapely

from enfilade.ingest.openings.confidence import probability
from enfilade.ingest.openings.evidence import evidence_of_group
from enfilade.ingest.openings.holes import Hole
from enfilade.ingest.openings.leads import Group, through
from enfilade.ingest.openings.parameters import OpeningParameters
from enfilade.ingest.openings.rays import Rays
from enfilade.ingest.records import F64, Opening, Room, Surfels
from enfilade.ingest.sides import UP, Side

MAX_HATCH_M: Final = 1.1
"""Longest side of a hatch; a stair needs more."""

MAX_WELL_M2: Final = 8.0
"""A hole in a floor larger than this is a void beside the stairs, too."""

LEAST_SURFELS: Final = 50
"""Fewest surfels on treads that tell where the stairs are."""

HULL_M: Final = 0.2
"""How far the middle of a hole may lie outside of the plan of its room."""


def floor_sides(rooms: Mapping[int, Room]) -> list[Side]:
    """Level sides through the floor of every room that has another more than a storey below it."""
    lowest = min((room.floor_elevation for room in rooms.values()), default=0.0)
    return [_floor(room) for _, room in sorted(rooms.items()) if room.floor_elevation > lowest]


def open_slab(
    group: Group, rays: Rays, rooms: Mapping[int, Room], surfels: Surfels, parameters: OpeningParameters
) -> Opening | None:
    """Turn the holes that join two rooms through a floor into one opening.

    Parameters
    ----------
    group
        Holes in floors, with the rooms that they lead to.
    rays, rooms, parameters
        As for walls.
    surfels
        In a void larger than stairs need, the treads among them tell where the stairs are.

    Returns
    -------
    Its width is the shorter side of the hole, its height the longer one. None if the rooms are of one storey, or the
    hole lies outside of the upper one, where rays come from the ground outside.
    """
    lower, upper = sorted((rooms[number] for number in group.pair), key=lambda room: room.floor_elevation)
    hole = group.main
    if upper.floor_elevation - lower.floor_elevation < parameters.storey_m or not _over(hole.centre, upper):
        return None
    ray = through(group, rays)
    if hole.width * hole.height * hole.fill < parameters.min_stairs_area_m2 or len(ray) < parameters.min_rays:
        return None
    (left, bottom), (right, top) = _stairwell(hole, lower, upper, surfels)
    width, height = sorted((right - left, top - bottom))
    evidence = evidence_of_group(group, len(ray), hole.bounded, width)
    return Opening(
        kind="hatch" if max(hole.width, hole.height) <= MAX_HATCH_M else "stairs",
        orientation="vertical",
        room_a=group.pair[0],
        room_b=group.pair[1],
        position=hole.side.point((left + right) / 2, (bottom + top) / 2),
        normal=UP.copy(),
        width=width,
        height=height,
        sill=0.0,
        area=width * height * hole.fill,
        ray_count=len(ray),
        state="open",
        confidence=probability(parameters.confidence.through_floor, evidence),
        evidence=evidence,
    )


def _stairwell(
    hole: Hole, lower: Room, upper: Room, surfels: Surfels
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the corners of a hole, or of the treads in the upper half of it if it is a larger void."""
    low, high = hole.edges[:2], hole.edges[2:]
    if hole.width * hole.height > MAX_WELL_M2:
        half_way = (lower.floor_elevation + upper.floor_elevation) / 2
        level, place = surfels.positions[:, 2], surfels.positions[:, :2].astype(np.float64)
        tread = (level > half_way) & (level < upper.floor_elevation - 0.1) & (surfels.normals[:, 2] > 0.9)
        tread &= ((place > low + 0.1) & (place < high - 0.1)).all(axis=1)
        if np.count_nonzero(tread) > LEAST_SURFELS:
            low, high = np.percentile(place[tread], [1, 99], axis=0)
    return (float(low[0]), float(low[1])), (float(high[0]), float(high[1]))


def _over(place: F64, room: Room) -> bool:
    """Whether a place lies over the convex hull of a room's plan."""
    if not room.outline:
        return True
    hull = shapely.MultiPoint(room.outline[0]).convex_hull.buffer(HULL_M)
    return bool(shapely.contains_xy(hull, place[0], place[1]))


def _floor(room: Room) -> Side:
    u, v = np.eye(3)[:2]
    bounds = room.bounds[[0, 1, 3, 4]].astype(np.float64)
    return Side(room.number, (), UP.copy(), room.floor_elevation, u, v, bounds, np.zeros(0, dtype=np.int32))
