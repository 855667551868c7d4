"""The rooms as the graph will have them: plan, bounds, points, scans, confidence (§4)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numba import njit

from .cells import members_of
from .records import I32, Plan, Room, RoomLabels, Surfels, ThinnedCloud


def measure_rooms(cloud: ThinnedCloud, surfels: Surfels, labels: RoomLabels, plans: Sequence[Plan]) -> tuple[Room, ...]:
    """Measure every room, in order of number."""
    members_of_room = members_of(labels.after, labels.room_count)
    point_counts = _counted(surfels.point_surfel, len(labels.after))
    counts = np.bincount(labels.after + 1, point_counts, labels.room_count + 1)[1:]
    rooms = []
    for number, (plan, members) in enumerate(zip(plans, members_of_room, strict=True)):
        columns = surfels.positions[members].T.astype(np.float64, order="C")
        rooms.append(
            Room(
                number=number,
                area=plan.area,
                floor_elevation=plan.floor_elevation,
                ceiling_elevation=plan.ceiling_elevation,
                centroid=np.append(plan.centre, plan.floor_elevation),
                bounds=np.concatenate([columns.min(axis=1), columns.max(axis=1)]),
                outline=plan.outline,
                point_count=int(counts[number]),
                scans=tuple(cloud.scan_names[scan] for scan in np.flatnonzero(labels.scan_room == number)),
                confidence=float(labels.agreement[members].mean(dtype=np.float64)),
                floor_plane=plan.floor_plane,
                scan_positions=cloud.scanner_positions[labels.scan_room == number].astype(np.float64),
            )
        )
    return tuple(rooms)


@njit(cache=True, nogil=True)
def _counted(numbers: I32, count: int) -> I32:
    """``(count,)`` how often each number from 0 on is there."""
    counts = np.zeros(count, np.int32)
    for number in numbers:
        if number >= 0:
            counts[number] += 1
    return counts
