"""What was seen outside, through a window, is of no room."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely

from .records import Plan, RoomLabels, Surfels


@dataclass(frozen=True, slots=True)
class InsideParameters:
    """What is outside.

    Attributes
    ----------
    reveal_m
        Surfels farther outside their room's plan than this, deeper than any reveal, are of no room.
    """

    reveal_m: float = 0.5


def keep_inside(
    surfels: Surfels, labels: RoomLabels, plans: Sequence[Plan], parameters: InsideParameters = InsideParameters()
) -> RoomLabels:
    """Take the surfels out of the rooms that lie outside their room's plan."""
    order = np.argsort(labels.after, kind="stable")
    ends = np.cumsum(np.bincount(labels.after + 1, minlength=labels.room_count + 1))
    after = labels.after.copy()
    for number, plan in enumerate(plans):
        members = order[ends[number] : ends[number + 1]]
        reach = shapely.Polygon(plan.outline[0]).buffer(parameters.reveal_m, join_style="mitre")
        shapely.prepare(reach)
        inside = shapely.contains_xy(reach, *surfels.positions[members, :2].astype(np.float64).T)
        after[members[~inside]] = -1
    return replace(labels, after=after)
