"""Stairs and hatches: holes in the floor of a room through which rays join it with a room below."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from enfilade.ingest.openings.leads import Lead, through
from enfilade.ingest.openings.parameters import OpeningParameters
from enfilade.ingest.openings.rays import Rays
from enfilade.ingest.records import Opening, Room
from enfilade.ingest.sides import UP, Side

MAX_HATCH_M: Final = 1.1
"""Longest side of a hatch; a stair needs more."""


def floor_sides(rooms: Mapping[int, Room]) -> list[Side]:
    """Level sides through the floor of every room that has another more than a storey below it."""
    lowest = min((room.floor_elevation for room in rooms.values()), default=0.0)
    return [_floor(room) for _, room in sorted(rooms.items()) if room.floor_elevation > lowest]


def open_slab(
    pair: tuple[int, int], group: list[Lead], rays: Rays, rooms: Mapping[int, Room], parameters: OpeningParameters
) -> Opening | None:
    """Turn the holes that join two rooms through a floor into one opening; None if they are of one storey.

    Parameters
    ----------
    pair
        The two rooms, the lower number first.
    group
        Holes in floors, with the rooms that they lead to.
    rays, rooms, parameters
        As for walls.

    Returns
    -------
    Its width is the shorter side of the hole, its height the longer one.
    """
    a, b = (rooms[number] for number in pair)
    if abs(a.floor_elevation - b.floor_elevation) < parameters.storey_m:
        return None
    hole = max((lead.hole for lead in group), key=lambda h: len(h.ray))
    if hole.width * hole.height * hole.fill < parameters.min_stairs_area_m2:
        return None
    ray = through(group, rays, pair)
    if len(ray) < parameters.min_rays:
        return None
    width, height = sorted((hole.width, hole.height))
    share = max(lead.share for lead in group)
    return Opening(
        kind="hatch" if height <= MAX_HATCH_M else "stairs",
        orientation="vertical",
        room_a=pair[0],
        room_b=pair[1],
        position=hole.centre,
        normal=UP.copy(),
        width=width,
        height=height,
        sill=0.0,
        area=width * height * hole.fill,
        ray_count=len(ray),
        state="open",
        confidence=float(np.mean([len(ray) / (len(ray) + 50), hole.bounded.mean(), hole.fill, share])),
    )


def _floor(room: Room) -> Side:
    u, v = np.eye(3)[:2]
    bounds = room.bounds[[0, 1, 3, 4]].astype(np.float64)
    return Side(room.number, (), UP.copy(), room.floor_elevation, u, v, bounds, np.zeros(0, dtype=np.int32))
