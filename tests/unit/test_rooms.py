"""Groups and label diffusion on two box rooms with a door."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scanned_boxes import DOOR, LEFT, RIGHT, Box, Door, scan, scans

from enfilade.ingest.groups import group_scans
from enfilade.ingest.inside import keep_inside
from enfilade.ingest.measures import measure_rooms
from enfilade.ingest.planes import find_planes
from enfilade.ingest.plans import draw_plans
from enfilade.ingest.records import Groups, Planes, RoomLabels, Scan, Surfels, ThinnedCloud
from enfilade.ingest.rooms import RoomParameters, gather_nodes, label_rooms, ray_starts, trace_transitions
from enfilade.ingest.sight import compare_views
from enfilade.ingest.structure import Structure
from enfilade.ingest.surfels import make_surfels
from enfilade.ingest.thinning import thin


@dataclass(frozen=True)
class Building:
    cloud: ThinnedCloud
    surfels: Surfels
    planes: Planes
    groups: Groups
    labels: RoomLabels


def build(parts: list[Scan]) -> Building:
    cloud = thin(parts)
    surfels = make_surfels(cloud)
    planes = find_planes(surfels)
    groups = group_scans(planes, cloud.scanner_positions)
    return Building(cloud, surfels, planes, groups, label_rooms(surfels, planes, groups))


@pytest.fixture(scope="module")
def two_rooms() -> Building:
    return build(scans(DOOR))


def in_room(building: Building, box: Box) -> np.ndarray:
    """Surfels well inside one of the boxes."""
    x = building.surfels.positions[:, 0]
    return (x > box.low[0] - 0.05) & (x < box.high[0] + 0.05)


def test_scans_that_a_door_joins_are_two_rooms(two_rooms: Building) -> None:
    assert two_rooms.groups.scan_room.tolist() == [0, 1]
    assert two_rooms.groups.votes.all()
    assert two_rooms.groups.floors == pytest.approx([0.0, 0.0], abs=0.02)


def test_two_scans_of_a_room_are_one_room() -> None:
    second = replace(LEFT, scanner=(3.0, 2.0, 1.5), name="second")
    building = build([scan(LEFT, [LEFT], None), scan(second, [second], None)])
    assert building.groups.scan_room.tolist() == [0, 0]


@pytest.mark.parametrize(
    ("start", "end", "rooms"),
    [(0.3, 2.95, 1), (0.1, 2.1, 1), (0.5, 2.5, 1), (1.0, 2.0, 2), (0.15, 1.4, 2), (1.6, 2.8, 2)],
)
def test_a_passage_up_to_the_ceiling_over_most_of_the_wall_leaves_one_room(
    start: float, end: float, rooms: int
) -> None:
    """Of 3 m of wall; the scanners stand off the middle."""
    assert len(set(build(scans(Door(4.075, (start, end), 2.6))).groups.scan_room.tolist())) == rooms


@pytest.mark.parametrize(("end", "rooms"), [(2.2, 2), (3.2, 1)])
def test_a_hole_wider_than_any_door_leaves_one_room_beside_a_long_wall(end: float, rooms: int) -> None:
    left = Box((0.0, 0.0, 0.0), (4.0, 8.0, 2.5), (1.5, 3.2, 1.5), "left")
    right = Box((4.15, 0.0, 0.0), (8.0, 8.0, 2.5), (6.5, 3.8, 1.5), "right")
    parts = [scan(box, [left, right], Door(4.075, (0.6, end), 2.6), spacing=0.03) for box in (left, right)]
    assert len(set(build(parts).groups.scan_room.tolist())) == rooms


@pytest.mark.parametrize("stand", [1.5, 1.6, 1.75])
@pytest.mark.parametrize(("top", "rooms"), [(2.1, 2), (2.6, 1)])
def test_a_high_part_of_a_room_and_a_low_one_are_one_room(top: float, rooms: int, stand: float) -> None:
    """They are looked at under the lower ceiling, where only a lintel parts them, however high the tripod."""
    low = Box((0.0, 0.0, 0.0), (4.0, 3.0, 2.5), (1.5, 1.2, stand), "low")
    high = Box((4.02, 0.0, 0.0), (8.0, 3.0, 4.5), (6.5, 1.8, 2.2), "high")
    hole = Door(4.01, (-0.1, 3.1) if rooms == 1 else (1.0, 1.9), top)
    parts = [scan(box, [low, high], hole) for box in (low, high)]
    assert len(set(build(parts).groups.scan_room.tolist())) == rooms


def test_a_scan_under_a_low_ceiling_does_not_look_through_the_door_for_others() -> None:
    low = Box((0.0, 0.0, 0.0), (4.0, 3.0, 2.0), (1.5, 1.2, 1.5), "low")
    high = Box((4.15, 0.0, 0.0), (8.0, 3.0, 2.5), (6.5, 1.8, 1.5), "high")
    wide = Door(4.075, (0.3, 2.6), 1.95)
    parts = [scan(box, [low, high], wide, spacing=0.03) for box in (low, high)]
    building = build(parts)
    assert building.cloud.scan_names == ("high", "low")
    assert building.groups.scan_room.tolist() == [1, 0]


def test_a_scanner_in_a_doorway_is_of_the_room_that_no_other_looks_into() -> None:
    """From under the head of the wide door it would look into both."""
    door = Door(4.1, (0.4, 2.6), 2.1)
    left = Box((0.0, 0.0, 0.0), (4.0, 3.0, 2.5), (1.5, 1.2, 1.5), "left")
    right = Box((4.2, 0.0, 0.0), (8.0, 3.0, 2.5), (6.5, 1.8, 1.5), "right")
    x, y = np.meshgrid(np.arange(4.0, 4.2, 0.01), np.arange(0.4, 2.6, 0.02))
    soffit = np.stack([x, y, np.full_like(x, door.top)], axis=-1).reshape(-1, 3)
    seen = [chunk.positions for box in (left, right) for chunk in scan(box, [box], door).chunks]
    threshold = Scan.of_points("threshold", "boxes.e57", np.concatenate([*seen, soffit]), np.array([4.12, 1.5, 1.5]))
    groups = build([scan(left, [left, right], door), threshold]).groups
    assert groups.scan_room.tolist() == [0, 1]
    assert groups.viewpoints[1, 0] > 4.5
    assert groups.viewpoints[1, 2] == pytest.approx(2.35, abs=0.03)


def test_a_room_far_along_a_corridor_is_not_joined_to_it_by_what_is_seen_at_a_slant() -> None:
    corridor = Box((0.0, 0.0, 0.0), (1.6, 16.0, 2.5), (0.6, 2.0, 1.5), "corridor")
    room = Box((1.75, 11.0, 0.0), (5.5, 15.0, 2.5), (3.6, 13.6, 1.5), "room")
    hole = Door(1.675, (11.4, 12.7), 2.6)
    parts = [scan(box, [corridor, room], hole, spacing=0.03) for box in (corridor, room)]
    assert build(parts).groups.scan_room.tolist() == [0, 1]


def test_scans_far_apart_along_one_corridor_are_one_room() -> None:
    corridor = Box((0.0, 0.0, 0.0), (1.6, 30.0, 2.5), (0.7, 2.0, 1.5), "corridor")
    end = replace(corridor, scanner=(0.9, 27.0, 1.5), name="end")
    building = build([scan(box, [box], None, spacing=0.04) for box in (corridor, end)])
    assert building.groups.scan_room.tolist() == [0, 0]


@pytest.mark.parametrize(("mate", "votes"), [(4.5, False), (27.0, True)])
def test_a_scan_before_a_wide_passage_votes_where_no_other_overlooks_what_it_does(mate: float, votes: bool) -> None:
    corridor = Box((0.0, 0.0, 0.0), (2.5, 30.0, 2.5), (1.2, 1.2, 1.5), "corridor")
    other = replace(corridor, scanner=(1.0, mate, 1.5), name="mate")
    room = Box((2.65, 0.0, 0.0), (6.0, 3.0, 2.5), (4.5, 1.6, 1.5), "room")
    hole = Door(2.575, (0.2, 1.7), 2.6)
    parts = [scan(box, [box, room], hole, spacing=0.04) for box in (corridor, other)]
    groups = build([*parts, scan(room, [corridor, room], hole, spacing=0.04)]).groups
    assert groups.scan_room.tolist() == [0, 0, 1]
    assert groups.votes.tolist() == [votes, True, True]


def test_numbers_do_not_depend_on_the_order_of_scans() -> None:
    cloud = thin(scans(DOOR)[::-1])
    groups = group_scans(find_planes(make_surfels(cloud)), cloud.scanner_positions)
    assert cloud.scan_names == ("left", "right")
    assert groups.scan_room.tolist() == [0, 1]


def test_a_scanner_on_a_landing_stands_on_it_though_it_sees_more_of_the_floor_below() -> None:
    """Under the tripod nothing is seen, before it and behind it a strip of the landing."""
    levels = [level((-1.2, -0.9), 2.8), level((0.9, 1.2), 2.8), level((-4.0, 4.0), 0.0), level((-4.0, 4.0), 5.3)]
    cloud = thin([Scan.of_points("landing", "stairs.e57", np.concatenate(levels), np.array([1.2, 0.0, 4.3]))])
    groups = group_scans(find_planes(make_surfels(cloud)), cloud.scanner_positions)
    assert groups.floors.tolist() == pytest.approx([2.8], abs=0.02)


def level(span: tuple[float, float], z: float) -> np.ndarray:
    """Points of a floor 2.4 m wide."""
    grid = np.meshgrid(np.arange(0.0, 2.4, 0.02), np.arange(*span, 0.02), [z], indexing="ij")
    return np.stack(grid, axis=-1).reshape(-1, 3)


def test_given_rooms_override_the_automatic_groups(two_rooms: Building) -> None:
    scanners = two_rooms.cloud.scanner_positions
    joined = group_scans(two_rooms.planes, scanners, {0: "suite", 1: "suite"})
    assert joined.scan_room.tolist() == [0, 0]


def test_a_scan_that_is_not_given_follows_its_automatic_group() -> None:
    second = replace(LEFT, scanner=(3.0, 2.0, 1.5), name="second")
    building = build([scan(LEFT, [LEFT], None), scan(second, [second], None), scan(RIGHT, [RIGHT], None)])
    groups = group_scans(building.planes, building.cloud.scanner_positions, {0: "a", 1: "a"})
    assert groups.scan_room.tolist() == [0, 0, 0]


def test_before_is_the_room_of_the_scan_and_the_door_lets_it_see_the_other(two_rooms: Building) -> None:
    labels = two_rooms.labels
    assert (labels.before == labels.scan_room[two_rooms.surfels.scan]).all()
    beyond = in_room(two_rooms, RIGHT) & (labels.before == 0)
    assert beyond.sum() > 50


def test_diffusion_gives_what_was_seen_through_the_door_to_its_own_room(two_rooms: Building) -> None:
    for number, box in enumerate((LEFT, RIGHT)):
        assert (two_rooms.labels.after[in_room(two_rooms, box)] == number).mean() > 0.99


def test_transitions_are_row_stochastic_and_stay_in_closed_rooms() -> None:
    building = build(scans(None))
    nodes = gather_nodes(building.surfels, building.planes, 0.2)
    starts, normals = ray_starts(building.surfels, building.planes)
    structure = Structure(building.planes)
    matrix = trace_transitions(structure, starts, normals, building.planes, nodes, RoomParameters())
    assert np.allclose(matrix.sum(axis=1), 1.0, atol=1e-5)
    assert (matrix.diagonal() > 0.0).all()
    right = np.zeros(len(nodes), bool)
    right[nodes.of_surfel[building.surfels.positions[:, 0] > 4.1]] = True
    assert matrix[right][:, ~right].sum() < 1e-3 * right.sum()


def test_each_node_holds_the_surfels_of_one_cell_of_one_plane(two_rooms: Building) -> None:
    nodes = gather_nodes(two_rooms.surfels, two_rooms.planes, 0.2)
    assert np.array_equal(np.sort(nodes.members), np.arange(len(two_rooms.surfels.positions)))
    for node in range(0, len(nodes), 97):
        members = nodes.members[nodes.starts[node] : nodes.starts[node + 1]]
        assert (nodes.of_surfel[members] == node).all()
        assert len(np.unique(two_rooms.planes.surfel_plane[members])) == 1
        assert np.ptp(two_rooms.surfels.positions[members], axis=0).max() < 0.3


def test_the_same_scans_give_the_same_labels(two_rooms: Building) -> None:
    again = build(scans(DOOR))
    assert np.array_equal(again.labels.after, two_rooms.labels.after)
    assert np.array_equal(again.planes.surfel_plane, two_rooms.planes.surfel_plane)


def test_areas_levels_and_outlines_are_those_of_the_boxes(two_rooms: Building) -> None:
    plans = draw_plans(two_rooms.cloud, two_rooms.surfels, two_rooms.planes, two_rooms.labels)
    rooms = measure_rooms(two_rooms.cloud, two_rooms.surfels, two_rooms.labels, plans)
    for room, box in zip(rooms, (LEFT, RIGHT), strict=True):
        width, depth = box.high[0] - box.low[0], box.high[1] - box.low[1]
        assert room.area == pytest.approx(width * depth, rel=0.01)
        assert room.floor_elevation == pytest.approx(0.0, abs=0.01)
        assert room.ceiling_elevation == pytest.approx(2.5, abs=0.01)
        assert room.centroid == pytest.approx([(box.low[0] + box.high[0]) / 2, 1.5, 0.0], abs=0.03)
        assert np.abs(room.outline[0].min(axis=0) - box.low[:2]).max() < 0.05
        assert np.abs(room.outline[0].max(axis=0) - box.high[:2]).max() < 0.05
        assert room.confidence > 0.8
    assert [room.scans for room in rooms] == [("left",), ("right",)]


def test_what_lies_outside_the_plan_is_of_no_room(two_rooms: Building) -> None:
    plans = draw_plans(two_rooms.cloud, two_rooms.surfels, two_rooms.planes, two_rooms.labels)
    moved = replace(two_rooms.labels, after=1 - two_rooms.labels.after)
    kept = keep_inside(two_rooms.surfels, moved, plans)
    middle_of_left = two_rooms.surfels.positions[:, 0] < 3.0
    assert (kept.after[middle_of_left] != 1).all()
    assert (keep_inside(two_rooms.surfels, two_rooms.labels, plans).after >= 0).mean() > 0.999


def test_what_faces_up_above_a_ceiling_is_the_floor_over_it_and_not_of_the_room(two_rooms: Building) -> None:
    surfels, labels = two_rooms.surfels, two_rooms.labels
    plans = draw_plans(two_rooms.cloud, surfels, two_rooms.planes, labels)
    moved = (surfels.positions[:, 0] < 3.0) & (np.abs(surfels.normals[:, 2]) > 0.9)
    positions = surfels.positions.copy()
    positions[moved, 2] = 2.7
    kept = keep_inside(replace(surfels, positions=positions), replace(labels, after=1 - labels.after), plans)
    upward = surfels.normals[:, 2] > 0.9
    assert (kept.after[moved & upward] == -1).all()
    assert (kept.after[moved & ~upward] == 0).all()


def grid(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> np.ndarray:
    """Points every 2 cm on a rectangle: one of the three ranges is a single value."""
    steps = [np.arange(low, high, 0.02) if high > low else np.array([low]) for low, high in (x, y, z)]
    points = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)
    return points + np.random.default_rng(5).normal(0.0, 1e-3, points.shape)


def test_a_scan_that_stood_outside_has_no_room_and_its_facade_and_ground_are_of_none() -> None:
    facade = grid((-0.35, -0.35), (-1.0, 4.0), (0.0, 3.0))
    ground = grid((-6.0, -0.4), (-1.0, 4.0), (-0.2, -0.2))
    garden = Scan.of_points("garden", "boxes.e57", np.concatenate([facade, ground]), np.array([-3.0, 1.5, 1.4]))
    building = build([*scans(DOOR), garden])
    assert building.cloud.scan_names == ("garden", "left", "right")
    assert building.groups.scan_room.tolist() == [-1, 0, 1]
    assert building.labels.room_count == 2
    outside = building.surfels.positions[:, 0] < -0.2
    assert (building.labels.after[outside] == -1).all()
    assert (building.labels.after[~outside] >= 0).mean() > 0.99


def test_a_scan_outside_is_of_a_room_when_the_user_says_so() -> None:
    ground = grid((-6.0, -0.4), (-1.0, 4.0), (-0.2, -0.2))
    cloud = thin([*scans(DOOR), Scan.of_points("terrace", "boxes.e57", ground, np.array([-3.0, 1.5, 1.4]))])
    planes = find_planes(make_surfels(cloud))
    assert group_scans(planes, cloud.scanner_positions).scan_room.tolist() == [0, 1, -1]
    assert (group_scans(planes, cloud.scanner_positions, {2: "terrace"}).scan_room >= 0).all()


def test_scans_that_never_looked_up_are_all_inside() -> None:
    low = [
        Scan.of_points(s.name, s.source, points[points[:, 2] < 2.3], s.scanner_position)
        for s in scans(DOOR)
        for points in [np.concatenate([chunk.positions for chunk in s.chunks])]
    ]
    cloud = thin(low)
    assert (group_scans(find_planes(make_surfels(cloud)), cloud.scanner_positions).scan_room >= 0).all()


def test_a_bed_that_hides_most_of_the_floor_is_not_the_floor() -> None:
    own = scan(LEFT, [LEFT], None)
    points = np.concatenate([chunk.positions for chunk in own.chunks])
    under = (points[:, 2] < 0.05) & (np.abs(points[:, 0] - 1.9) < 1.5) & (np.abs(points[:, 1] - 1.55) < 1.15)
    bed = grid((0.4, 3.4), (0.4, 2.7), (0.5, 0.5))
    building = build(
        [Scan.of_points(own.name, own.source, np.concatenate([points[~under], bed]), own.scanner_position)]
    )
    plan = draw_plans(building.cloud, building.surfels, building.planes, building.labels)[0]
    assert plan.floor_elevation == pytest.approx(0.0, abs=0.01)


def test_a_table_that_hides_all_but_one_side_of_the_floor_is_not_the_floor() -> None:
    """A scanner stands higher over its floor than .8 m, over the top of the table .7 m."""
    own = scan(LEFT, [LEFT], None)
    points = np.concatenate([chunk.positions for chunk in own.chunks])
    under = (points[:, 2] < 0.05) & (points[:, 0] > 0.7)
    top = grid((0.9, 3.9), (0.1, 2.9), (0.8, 0.8))
    building = build(
        [Scan.of_points(own.name, own.source, np.concatenate([points[~under], top]), own.scanner_position)]
    )
    plan = draw_plans(building.cloud, building.surfels, building.planes, building.labels)[0]
    assert plan.floor_elevation == pytest.approx(0.0, abs=0.01)


def test_walls_between_other_parts_of_two_rooms_do_not_make_the_one_that_has_a_hole_more_open() -> None:
    """A corridor runs along two sides of a room; of the 7.35 m of wall along the longer one 2 m are open (or glass)."""
    high = (0.0, 2.6)
    corridor = [grid((12.5, 12.5), (5.7, 9.0), high), grid((14.0, 14.0), (4.4, 9.0), high)]
    corridor += [grid((0.0, 14.0), (4.4, 4.4), high), grid((0.0, 0.0), (4.4, 5.7), high)]
    corridor += [grid((0.0, 6.0), (5.7, 5.7), high), grid((8.0, 12.5), (5.7, 5.7), high)]
    room = [grid((x, x), (5.85, 10.9), high) for x in (5.0, 12.35)]
    room += [grid((5.0, 12.35), (10.9, 10.9), high)]
    room += [grid((5.0, 6.0), (5.85, 5.85), high), grid((8.0, 12.35), (5.85, 5.85), high)]
    for z in high:
        corridor += [grid((0.0, 14.0), (4.4, 5.7), (z, z)), grid((12.5, 14.0), (5.7, 9.0), (z, z))]
        room.append(grid((5.0, 12.35), (5.85, 10.9), (z, z)))
    stands = np.array([[12.9, 5.2, 1.5], [7.7, 7.4, 1.5]])
    scenes = zip(("corridor", "room"), (corridor, room), stands, strict=True)
    building = build([Scan.of_points(name, "l.e57", np.concatenate(seen), at) for name, seen, at in scenes])
    structure, viewpoints = Structure(building.planes), building.groups.viewpoints
    views = compare_views(structure, building.planes, building.cloud.scanner_positions, viewpoints)
    assert views.openness == pytest.approx([2.0 / 7.35], abs=0.1)


def slope(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> np.ndarray:
    """Points every 2 cm on a plane that rises along y."""
    points = grid(x, y, (0.0, 0.0))
    points[:, 2] += z[0] + (points[:, 1] - y[0]) / (y[1] - y[0]) * (z[1] - z[0])
    return points


def test_a_room_under_a_roof_reaches_up_to_its_low_walls() -> None:
    parts = [
        grid((0.0, 4.0), (0.0, 6.0), (0.0, 0.0)),
        grid((0.0, 4.0), (1.5, 4.5), (2.5, 2.5)),
        slope((0.0, 4.0), (0.0, 1.5), (1.0, 2.5)),
        slope((0.0, 4.0), (4.5, 6.0), (2.5, 1.0)),
        grid((0.0, 4.0), (0.0, 0.0), (0.0, 1.0)),
        grid((0.0, 4.0), (6.0, 6.0), (0.0, 1.0)),
    ]
    gables = np.concatenate([grid((x, x), (0.0, 6.0), (0.0, 2.5)) for x in (0.0, 4.0)])
    parts.append(gables[gables[:, 2] < 1.0 + np.minimum(gables[:, 1], 6.0 - gables[:, 1])])
    attic = build([Scan.of_points("attic", "boxes.e57", np.concatenate(parts), np.array([2.0, 3.0, 1.5]))])
    (draft,) = draw_plans(attic.cloud, attic.surfels, attic.planes, attic.labels, by_floors=False)
    assert draft.area == pytest.approx(24.0, rel=0.01)
    assert (keep_inside(attic.surfels, attic.labels, [draft]).after >= 0).mean() > 0.999
    (plan,) = draw_plans(attic.cloud, attic.surfels, attic.planes, attic.labels)
    assert plan.area == pytest.approx(24.0, rel=0.005)
    assert plan.ceiling_elevation == pytest.approx(2.5, abs=0.01)
