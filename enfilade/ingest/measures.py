"""The rooms as the graph will have them: plan, bounds, points, scans, confidence (§4)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .records import Plan, Room, RoomLabels, Surfels, ThinnedCloud


def measure_rooms(cloud: ThinnedCloud, surfels: Surfels, labels: RoomLabels, plans: Sequence[Plan]) -> tuple[Room, ...]:
    """Measure every room, in order of number."""
    order = np.argsort(labels.after, kind="stable")
    ends = np.cumsum(np.bincount(labels.after + 1, minlength=labels.room_count + 1))
    point_room = np.append(labels.after, np.int32(-1))[surfels.point_surfel]
    counts = np.bincount(point_room[point_room >= 0], minlength=labels.room_count)
    rooms = []
    for number, plan in enumerate(plans):
        members = order[ends[number] : ends[number + 1]]
        positions = surfels.positions[members].astype(np.float64)
        rooms.append(
            Room(
                number=number,
                area=plan.area,
                floor_elevation=plan.floor_elevation,
                ceiling_elevation=plan.ceiling_elevation,
                centroid=np.append(plan.centre, plan.floor_elevation),
                bounds=np.concatenate([positions.min(axis=0), positions.max(axis=0)]),
                outline=plan.outline,
                point_count=int(counts[number]),
                scans=tuple(cloud.scan_names[scan] for scan in np.flatnonzero(labels.scan_room == number)),
                confidence=float(labels.agreement[members].mean(dtype=np.float64)),
                floor_plane=plan.floor_plane,
            )
        )
    return tuple(rooms)
