"""Rooms that no scan stands in."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scanned_boxes import DOOR, LEFT, RIGHT, Box, scan

from enfilade.ingest.glimpses import GlimpseParameters, add_glimpsed_rooms
from enfilade.ingest.groups import group_scans
from enfilade.ingest.inside import keep_inside
from enfilade.ingest.planes import Planes, find_planes
from enfilade.ingest.plans import draw_plans
from enfilade.ingest.records import Plan, RoomLabels, Scan, Surfels
from enfilade.ingest.rooms import label_rooms
from enfilade.ingest.surfels import make_surfels
from enfilade.ingest.thinning import thin

# The door of LEFT shows it from one end to the other.
BEHIND = replace(RIGHT, low=(4.15, 0.5, 0.0), high=(7.0, 2.4, 2.5))


def labelled(parts: list[Scan]) -> tuple[Surfels, Planes, RoomLabels, tuple[Plan, ...], np.ndarray]:
    """Labels before rooms are made of glimpses."""
    cloud = thin(parts)
    surfels = make_surfels(cloud)
    planes = find_planes(surfels)
    labels = label_rooms(surfels, planes, group_scans(planes, cloud.scanner_positions))
    drafts = draw_plans(cloud, surfels, planes, labels, by_floors=False)
    return surfels, planes, keep_inside(surfels, labels, drafts), drafts, cloud.scanner_positions


def well_inside(surfels: Surfels, box: Box) -> np.ndarray:
    return (surfels.positions[:, 0] > box.low[0] + 0.6) & (surfels.positions[:, 0] < box.high[0] + 0.05)


def test_what_an_open_door_shows_is_a_room_though_no_scan_stands_in_it() -> None:
    surfels, planes, labels, plans, scanners = labelled([scan(LEFT, [LEFT, BEHIND], DOOR)])
    found = add_glimpsed_rooms(surfels, planes, labels, plans, scanners)
    assert (labels.room_count, found.room_count) == (1, 2)
    assert (found.after[well_inside(surfels, BEHIND)] == 1).mean() > 0.9
    assert np.array_equal(found.after[labels.after == 0], labels.after[labels.after == 0])
    assert 0.2 < found.agreement[found.after == 1].max() <= 0.5
    assert found.scan_room.tolist() == [0]


def points_of(part: Scan) -> np.ndarray:
    return np.concatenate([chunk.positions for chunk in part.chunks])


def made_of(points: np.ndarray, part: Scan) -> Scan:
    return Scan.of_points(part.name, part.source, points, part.scanner_position)


def test_ground_seen_through_a_door_is_no_room_for_it_has_neither_roof_nor_walls() -> None:
    seen = scan(LEFT, [LEFT, BEHIND], DOOR)
    points = points_of(seen)
    ground_only = made_of(points[(points[:, 0] < 4.3) | (points[:, 2] < 0.1)], seen)
    surfels, planes, labels, plans, scanners = labelled([ground_only])
    assert add_glimpsed_rooms(surfels, planes, labels, plans, scanners).room_count == 1


def test_a_roof_alone_makes_no_room() -> None:
    seen = scan(LEFT, [LEFT, BEHIND], DOOR)
    points = points_of(seen)
    roof = np.stack(np.meshgrid(np.arange(4.2, 9.0, 0.02), np.arange(-1.0, 4.0, 0.02), [2.6]), -1).reshape(-1, 3)
    kept = points[(points[:, 0] < 4.3) | (points[:, 2] < 0.1)]
    canopy = made_of(np.concatenate([kept, roof]), seen)
    surfels, planes, labels, plans, scanners = labelled([canopy])
    assert add_glimpsed_rooms(surfels, planes, labels, plans, scanners).room_count == 1


def test_the_top_of_a_table_is_no_room_over_the_room() -> None:
    seen = scan(LEFT, [LEFT, BEHIND], DOOR)
    top = np.stack(np.meshgrid(np.arange(5.0, 6.4, 0.02), np.arange(1.0, 2.2, 0.02), [0.75]), -1).reshape(-1, 3)
    surfels, planes, labels, plans, scanners = labelled([made_of(np.concatenate([points_of(seen), top]), seen)])
    found = add_glimpsed_rooms(surfels, planes, labels, plans, scanners)
    assert found.room_count == 2
    assert (found.after[np.abs(surfels.positions[:, 2] - 0.75) < 0.02][-200:] == 1).any()


def test_the_space_under_a_flight_of_stairs_is_no_room() -> None:
    seen = scan(LEFT, [LEFT, BEHIND], DOOR)
    flight = np.stack(np.meshgrid(np.arange(4.6, 7.0, 0.02), np.arange(0.5, 2.4, 0.02), [1.5]), -1).reshape(-1, 3)
    points = points_of(seen)
    under = points[(points[:, 0] < 4.6) | (points[:, 2] < 1.45)]
    surfels, planes, labels, plans, scanners = labelled([made_of(np.concatenate([under, flight]), seen)])
    assert add_glimpsed_rooms(surfels, planes, labels, plans, scanners).room_count == 1


def test_too_little_floor_makes_no_room() -> None:
    surfels, planes, labels, plans, scanners = labelled([scan(LEFT, [LEFT, BEHIND], DOOR)])
    assert add_glimpsed_rooms(surfels, planes, labels, plans, scanners, GlimpseParameters(least_floor_m2=6.0)) is labels


def test_a_small_floor_between_two_storeys_is_a_landing_and_no_room() -> None:
    surfels, planes, labels, (plan,), scanners = labelled([scan(LEFT, [LEFT, BEHIND], DOOR)])
    below, above = replace(plan, floor_elevation=-1.4), replace(plan, floor_elevation=1.4)
    small = GlimpseParameters(least_between_m2=6.0)
    assert add_glimpsed_rooms(surfels, planes, labels, [below, above], scanners, small).room_count == 1
    assert add_glimpsed_rooms(surfels, planes, labels, [below], scanners, small).room_count == 2
    large = GlimpseParameters(least_between_m2=1.5)
    assert add_glimpsed_rooms(surfels, planes, labels, [below, above], scanners, large).room_count == 2


def test_the_floor_of_the_next_storey_is_not_of_the_room_below_whose_cupboard_comes_near_it() -> None:
    """Of the slab between, the room below does not see the part over the cupboard."""
    below = scan(LEFT, [LEFT], None)
    points = points_of(below)
    over = (points[:, 2] > 2.4) & (points[:, 0] > 2.0)
    top = np.stack(np.meshgrid(np.arange(2.6, 3.9, 0.02), np.arange(0.3, 2.7, 0.02), [2.1]), -1).reshape(-1, 3)
    above = scan(RIGHT, [LEFT, RIGHT], DOOR)
    seen = points_of(above)
    up = np.array([0.0, 0.0, 2.8])
    seen = seen[(seen[:, 0] > 4.0) | (seen[:, 2] < 0.05)] + up
    upper = Scan.of_points("upper", "boxes.e57", seen, above.scanner_position + up)
    surfels, planes, labels, plans, scanners = labelled([made_of(np.concatenate([points[~over], top]), below), upper])
    found = add_glimpsed_rooms(surfels, planes, labels, plans, scanners)
    upper_floor = (np.abs(surfels.positions[:, 2] - 2.8) < 0.03) & (surfels.positions[:, 0] < 3.5)
    assert upper_floor.sum() > 100
    assert (found.after[upper_floor] != 0).all()
