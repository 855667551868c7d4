"""Labels that agree with the plans: what lies in another room's plan is that room's, what lies in none is outside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray

from enfilade.parallel import at_once

from .cells import members_of
from .records import F32, F64, I32, Bool, Plan, RoomLabels, Surfels

I64 = NDArray[np.int64]
_LEVEL: Final = 0.7
"""Floors face up by so much."""


@dataclass(frozen=True, slots=True)
class InsideParameters:
    """What agrees with a plan.

    Attributes
    ----------
    face_m
        Surfels this close to the plan of their room are of the room.
    reveal_m
        Surfels in no plan, and farther than this from their room's, deeper than any reveal, are outside.
    height_m
        How far a room reaches below its floor and above its ceiling.
    """

    face_m: float = 0.10
    reveal_m: float = 0.5
    height_m: float = 0.3


def keep_inside(
    surfels: Surfels, labels: RoomLabels, plans: Sequence[Plan], parameters: InsideParameters = InsideParameters()
) -> RoomLabels:
    """Give surfels that lie outside their room's plan to the room that they lie in, or to none.

    Diffusion tells rooms well near the ceiling, from where plans are drawn, and less well on floors near wide doors.
    What was seen outside through a window lies in no plan.
    """
    outlines = np.array([shapely.Polygon(plan.outline[0]) for plan in plans])
    xy = surfels.positions[:, :2].astype(np.float64)
    astray = ~_near_own(xy, labels.after, outlines, parameters.face_m)
    astray &= labels.after >= 0
    suspects = np.flatnonzero(astray)
    after = labels.after.copy()
    near = _near_own(xy[suspects], labels.after[suspects], outlines, parameters.reveal_m)
    after[suspects[~near]] = -1
    upward = surfels.normals[suspects, 2] > _LEVEL
    suspect, room = _containing(surfels.positions[suspects], upward, outlines, plans, parameters.height_m)
    after[suspects[suspect]] = room
    return replace(labels, after=after)


def _near_own(xy: F64, room: I32, outlines: NDArray[np.object_], reach_m: float) -> Bool:
    """``(n,)``: whether positions lie within `reach_m` of their own room's outline, or in it."""
    near = np.zeros(len(xy), bool)

    def look(reach: shapely.Polygon, members: I64) -> None:
        shapely.prepare(reach)
        near[members] = shapely.contains_xy(reach, xy[members, 0], xy[members, 1])

    reaches = shapely.buffer(outlines, reach_m, join_style="mitre")
    at_once(look, zip(reaches, members_of(room, len(outlines)), strict=True))
    return near


def _containing(
    positions: F32, upward: Bool, outlines: NDArray[np.object_], plans: Sequence[Plan], height_m: float
) -> tuple[I64, I64]:
    """Return positions and the room whose plan holds each, as index arrays; where several do, that of highest floor.

    What faces up above a room's ceiling is the floor over it, however thin the slab.
    """
    tree = shapely.STRtree(outlines)
    position, room = tree.query(shapely.points(positions[:, :2].astype(np.float64)), predicate="within")
    floors = np.array([plan.floor_elevation for plan in plans])
    ceilings = np.array([np.inf if plan.ceiling_elevation is None else plan.ceiling_elevation for plan in plans])
    z = positions[position, 2]
    above_m = np.where(upward[position], 0.0, height_m)
    fits = (z > floors[room] - height_m) & (z < ceilings[room] + above_m)
    position, room = position[fits], room[fits]
    best = np.lexsort((room, -floors[room], position))
    first = best[np.unique(position[best], return_index=True)[1]]
    return position[first], room[first]
