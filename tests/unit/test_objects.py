"""What stands in a room becomes segments and combinations; walls, floors and ceilings do not."""

from dataclasses import replace

import numpy as np
import pytest
from box_scene import BoxScene
from shapely import box

from enfilade.descriptors import TOTAL, Layout
from enfilade.ingest.objects import ObjectParameters, find_objects
from enfilade.ingest.objects.bays import area, cut_slits, hull_area, hull_of
from enfilade.ingest.objects.combinations import combine, find_near
from enfilade.ingest.objects.masks import Face, Mask
from enfilade.ingest.objects.people import is_person
from enfilade.ingest.objects.remains import Remains
from enfilade.ingest.objects.segments import connect, without_outliers
from enfilade.ingest.objects.sightlines import Suspect, find_ghosts
from enfilade.ingest.objects.stairs import Flight
from enfilade.ingest.objects.structure import CeilingMap, find_structure, in_openings
from enfilade.ingest.records import Opening, Planes, Room, Segment, Surfels, ThinnedCloud
from enfilade.ingest.sides import Side

LAYOUT = Layout()


def furnished():
    """A room of 4 x 4 x 2.5 m."""
    scene = BoxScene()
    scene.room(0, (0, 0, 0), (4, 4, 2.5))
    scene.scanners = [((2.0, 2.0, 1.6), 0), ((1.2, 3.2, 1.6), 0)]
    return scene


def table(scene, x, y):
    """A top of 1.2 x 0.8 m at 0.74 m, which makes a plane of its own, and four legs."""
    scene.block((x, y, 0.70), (x + 1.2, y + 0.8, 0.74), 0, plane=True)
    for dx in (0.0, 1.14):
        for dy in (0.0, 0.74):
            scene.block((x + dx, y + dy, 0.0), (x + dx + 0.06, y + dy + 0.06, 0.70), 0)


def chair(scene, x, y):
    scene.block((x, y, 0.0), (x + 0.4, y + 0.4, 0.45), 0)
    scene.block((x, y, 0.45), (x + 0.05, y + 0.4, 0.9), 0)


def objects_of(scene, parameters=None):
    cloud, surfels, planes, labels, rooms = scene.scan()
    return find_objects(cloud, surfels, planes, labels, rooms, parameters, LAYOUT), cloud


def test_an_empty_room_has_no_objects():
    found, _ = objects_of(furnished())
    assert (found.segments, found.combinations, found.near) == ((), (), ())


def test_table_and_chair_are_segments_with_size_and_place():
    scene = furnished()
    table(scene, 2.5, 0.3)
    chair(scene, 0.5, 1.0)
    found, _ = objects_of(scene)
    chair_found, table_found = found.segments
    np.testing.assert_allclose(table_found.size, [1.2, 0.8, 0.7], atol=0.06)
    np.testing.assert_allclose(table_found.position[:2], [3.1, 0.7], atol=0.2)
    np.testing.assert_allclose(chair_found.size, [0.4, 0.4, 0.87], atol=0.06)
    assert [segment.number for segment in found.segments] == [0, 1]
    assert table_found.floor_offset == pytest.approx(0.04, abs=0.03)


def test_a_table_top_is_no_structure():
    scene = furnished()
    table(scene, 2.5, 0.3)
    found, cloud = objects_of(scene)
    (segment,) = found.segments
    top = np.abs(cloud.positions[segment.points, 2] - 0.74) < 0.01
    assert top.sum() > 0.5 * len(segment.points)


def test_a_cupboard_front_is_no_wall_and_a_partition_is():
    cupboard, partition = furnished(), furnished()
    cupboard.block((3.4, 1.0, 0.0), (3.99, 2.0, 2.0), 0, plane=True)
    partition.block((3.4, 1.0, 0.0), (3.99, 2.0, 2.5), 0, plane=True)
    assert len(objects_of(cupboard)[0].segments) == 1
    assert len(objects_of(partition)[0].segments) == 0


def test_what_hangs_knows_its_height():
    scene = furnished()
    scene.block((1.8, 0.1, 1.2), (2.4, 0.4, 1.6), 0)
    (segment,) = objects_of(scene)[0].segments
    assert segment.floor_offset == pytest.approx(1.2, abs=0.03)


def test_descriptors_sum_up_and_differ_by_their_base():
    scene = furnished()
    scene.block((1.8, 0.1, 1.2), (2.4, 0.4, 1.6), 0)
    (single,) = objects_of(scene)[0].combinations
    assert single.descriptor.sum() == single.foot_descriptor.sum() == TOTAL
    assert single.descriptor.shape == (LAYOUT.bins,)
    by_slice = single.descriptor.reshape(LAYOUT.shape).sum(axis=(1, 2))
    assert by_slice.argmax() >= 7 > single.foot_descriptor.reshape(LAYOUT.shape).sum(axis=(1, 2)).argmax()


def test_near_segments_are_combined_and_far_ones_not():
    scene = furnished()
    scene.block((0.3, 0.3, 0.0), (0.8, 0.8, 0.5), 0)
    scene.block((1.0, 0.3, 0.0), (1.5, 0.8, 0.5), 0)
    scene.block((3.2, 3.2, 0.0), (3.7, 3.7, 0.5), 0)
    found, _ = objects_of(scene)
    assert [c.segments for c in found.combinations] == [(0,), (1,), (2,), (0, 1)]
    ((a, b, distance),) = found.near
    assert (a, b) == (0, 1)
    assert distance == pytest.approx(0.2, abs=0.03)
    assert found.combinations[3].point_count == sum(len(s.points) for s in found.segments[:2])
    assert found.combinations[3].size[0] == pytest.approx(1.2, abs=0.03)


def row_of_segments(count, step=0.5, room=0):
    """Cubes of 0.3 m in a row, as points and segments."""
    rng = np.random.default_rng(3)
    points = rng.uniform(0, 0.3, (count, 60, 3)) + np.arange(count)[:, None, None] * [step, 0, 0]
    segments = [
        Segment(i, room, np.arange(60, dtype=np.int32) + 60 * i, np.full(3, 0.3), own.mean(axis=0), 0.0)
        for i, own in enumerate(points)
    ]
    return segments, points.reshape(-1, 3).astype(np.float32)


def test_combinations_grow_with_the_segments():
    parameters = ObjectParameters()
    sizes = []
    for count in (20, 40, 80):
        segments, positions = row_of_segments(count, step=0.12)
        sizes.append(len(combine(find_near(segments, positions, parameters), segments, parameters)))
    assert sizes[2] < 2.5 * sizes[1] < 6.5 * sizes[0]


def test_combinations_hang_together_and_are_ordered():
    segments, positions = row_of_segments(4)
    parameters = ObjectParameters(gap_m=0.35)
    groups = combine(find_near(segments, positions, parameters), segments, parameters)
    assert groups == [(0,), (1,), (2,), (3,), (0, 1), (1, 2), (2, 3), (0, 1, 2), (1, 2, 3)]


def test_a_combination_is_no_longer_than_allowed():
    segments, positions = row_of_segments(3)
    parameters = ObjectParameters(gap_m=0.35, max_combination_m=1.0)
    assert (0, 1, 2) not in combine(find_near(segments, positions, parameters), segments, parameters)


def test_segments_of_two_rooms_are_never_near():
    segments, positions = row_of_segments(2)
    other = Segment(1, 1, segments[1].points, segments[1].size, segments[1].position, 0.0)
    assert find_near([segments[0], other], positions, ObjectParameters()) == []


def test_lone_points_are_outliers():
    rng = np.random.default_rng(0)
    block = rng.uniform(0, 0.3, (800, 3))
    veil = np.column_stack([np.linspace(0.4, 3, 20), np.zeros(20), np.zeros(20)])
    kept = without_outliers(np.concatenate([block, veil]), ObjectParameters())
    assert kept[:800].mean() > 0.95
    assert not kept[803:].any()


def test_what_is_sparse_is_no_outlier_where_all_else_is_dense():
    rng = np.random.default_rng(0)
    dense = rng.uniform(0, 0.3, (3000, 3))
    sparse = np.stack(np.meshgrid(np.arange(2, 3, 0.06), np.arange(0, 1, 0.06), [0.7]), axis=-1).reshape(-1, 3)
    assert without_outliers(np.concatenate([dense, sparse]), ObjectParameters())[3000:].all()


def test_components_are_split_at_the_link_distance():
    rng = np.random.default_rng(0)
    block = rng.uniform(0, 0.3, (3000, 3))
    parameters, sparse = ObjectParameters(), np.zeros(6000, dtype=bool)
    near = connect(np.concatenate([block, block + np.array([0.3 + 0.5 * parameters.link_m, 0, 0])]), sparse, parameters)
    far = connect(np.concatenate([block, block + np.array([0.3 + 2 * parameters.link_m, 0, 0])]), sparse, parameters)
    assert [len(group) for group in near] == [6000]
    assert [len(group) for group in far] == [3000, 3000]


def test_sparse_points_join_what_is_beside_them_and_link_nothing():
    rng = np.random.default_rng(0)
    block = rng.uniform(0, 0.3, (3000, 3))
    bridge = np.column_stack([np.arange(0.3, 0.7, 0.02), np.full(20, 0.15), np.full(20, 0.15)])
    points = np.concatenate([block, block + np.array([0.4, 0, 0]), bridge])
    sparse = np.arange(len(points)) >= 6000
    assert len(connect(points, np.zeros(len(points), dtype=bool), ObjectParameters())) == 1
    groups = connect(points, sparse, ObjectParameters())
    assert len(groups) == 2
    assert sum(len(group) for group in groups) > 6000


def test_a_chair_at_a_table_is_a_piece_of_its_own():
    scene = furnished()
    table(scene, 2.5, 0.3)
    scene.block((2.9, 0.85, 0.0), (3.3, 1.25, 0.45), 0)
    scene.block((2.9, 1.2, 0.45), (3.3, 1.25, 0.9), 0)
    scene.scanners += [((3.7, 1.4, 1.6), 0)]
    found, _ = objects_of(scene)
    heights = sorted(segment.size[2] for segment in found.segments)
    np.testing.assert_allclose(heights, [0.72, 0.87], atol=0.06)


def test_a_night_table_as_high_as_the_bed_is_a_piece_of_its_own():
    scene = furnished()
    scene.block((0.5, 0.05, 0.0), (2.0, 2.05, 0.5), 0)
    scene.block((2.0, 0.05, 0.0), (2.5, 0.55, 0.5), 0)
    found, _ = objects_of(scene)
    np.testing.assert_allclose(sorted(segment.size[0] for segment in found.segments), [0.5, 1.5], atol=0.12)


def test_a_seat_and_its_back_and_arms_are_one_piece():
    scene = furnished()
    scene.block((1.0, 0.1, 0.0), (2.8, 0.9, 0.43), 0)
    scene.block((1.0, 0.1, 0.43), (2.8, 0.32, 0.8), 0)
    for x in (1.0, 2.62):
        scene.block((x, 0.1, 0.43), (x + 0.18, 0.9, 0.6), 0)
    assert len(objects_of(scene)[0].segments) == 1


def test_a_thing_on_a_table_is_a_piece_of_its_own():
    scene = furnished()
    table(scene, 2.5, 0.3)
    scene.block((3.0, 0.6, 0.74), (3.3, 0.85, 1.1), 0)
    scene.scanners += [((0.7, 0.5, 1.6), 0), ((3.5, 3.0, 1.6), 0)]
    found, _ = objects_of(scene)
    thing = max(found.segments, key=lambda segment: segment.floor_offset)
    assert len(found.segments) == 2
    assert thing.floor_offset == pytest.approx(0.76, abs=0.04)
    np.testing.assert_allclose(thing.size, [0.3, 0.25, 0.35], atol=0.06)


def test_a_row_of_kitchen_units_is_cut_in_modules_that_make_a_unit_again():
    scene = furnished()
    scene.block((0.5, 0.02, 0.0), (3.5, 0.6, 0.86), 0, plane=True)
    found, _ = objects_of(scene)
    widths = [segment.size[0] for segment in found.segments if segment.size[2] > 0.5]
    np.testing.assert_allclose(widths, 0.6, atol=0.05)
    assert len(widths) == 5
    assert max(len(combination.segments) for combination in found.combinations) == 3


def test_two_cupboards_side_by_side_are_cut_and_put_together_again():
    scene = furnished()
    scene.block((0.5, 0.02, 0.0), (2.1, 0.6, 1.9), 0, plane=True)
    found, _ = objects_of(scene)
    assert len(found.segments) == 3
    whole = found.combinations[-1]
    assert len(whole.segments) == 3
    np.testing.assert_allclose(whole.size[0], 1.6, atol=0.05)


@pytest.mark.parametrize(
    ("low", "high"), [((0.5, 0.02, 1.0), (2.5, 0.05, 2.0)), ((0.5, 0.02, 0.0), (2.1, 0.7, 0.5))], ids=["board", "bench"]
)
def test_what_is_long_and_no_cupboard_is_not_cut(low, high):
    scene = furnished()
    scene.block(low, high, 0, plane=True)
    assert len(objects_of(scene)[0].segments) == 1


def test_tables_put_together_around_a_bay_are_parted_and_so_is_a_chair_among_them():
    scene = BoxScene()
    scene.room(0, (0, 0, 0), (7, 7, 2.5))
    scene.scanners = [((3.5, 6.0, 1.6), 0), ((3.5, 3.5, 1.9), 0)]
    for low, high in (((1.0, 1.0), (5.8, 1.8)), ((1.0, 1.8), (1.8, 5.0)), ((5.0, 1.8), (5.8, 5.0))):
        scene.block((*low, 0.0), (*high, 0.8), 0, plane=True)
    scene.block((3.2, 1.82, 0.0), (3.6, 2.2, 0.45), 0)
    found, cloud = objects_of(scene)
    seats = [segment for segment in found.segments if cloud.positions[segment.points, 2].max() < 0.5]
    assert len(seats) == 1
    np.testing.assert_allclose(seats[0].size[:2], [0.4, 0.38], atol=0.06)
    assert all(min(segment.size[:2]) < 0.9 and max(segment.size[:2]) < 0.9 for segment in found.segments)


def test_many_tables_put_together_are_no_floor():
    scene = BoxScene()
    scene.room(0, (0, 0, 0), (7, 7, 2.5))
    scene.scanners = [((1.0, 1.0, 1.6), 0), ((6.0, 6.0, 1.6), 0)]
    scene.block((2.0, 2.0, 0.0), (5.0, 5.2, 0.75), 0, plane=True)
    found, cloud = objects_of(scene)
    on_top = sum((abs(cloud.positions[segment.points, 2] - 0.75) < 0.02).sum() for segment in found.segments)
    assert on_top > 1000


def test_a_long_sofa_as_deep_as_a_table_is_one_piece():
    scene = furnished()
    scene.block((0.8, 0.1, 0.0), (3.2, 0.9, 0.4), 0, plane=True)
    scene.block((0.8, 0.1, 0.4), (3.2, 0.32, 0.8), 0, plane=True)
    assert len(objects_of(scene)[0].segments) == 1


def test_a_cupboard_built_into_a_wall_is_an_object_and_a_door_there_is_none():
    cupboard, leaf = (BoxScene(), BoxScene())
    for scene, width in ((cupboard, 1.2), (leaf, 0.9)):
        hole = ((1.0, 0.0), (1.0 + width, 2.0))
        scene.room(0, (0, 0, 0), (4, 4, 2.5), holes={"x1": [hole]})
        scene.scanners = [((2.0, 2.0, 1.6), 0)]
        scene.add(0, 4.02, *hole, -1, 0)
    assert len(_as_one_plane(cupboard).segments) == 1
    assert len(_as_one_plane(leaf).segments) == 0


def _as_one_plane(scene):
    """Objects where the plane at x = 4.02 is taken for part of the wall, as by growing."""
    cloud, surfels, planes, labels, rooms = scene.scan()
    wall, front = (int(np.argmin(np.abs(planes.offsets + at) + (planes.normals[:, 0] > -1))) for at in (4.0, 4.02))
    surfel_plane = np.where(planes.surfel_plane == front, wall, planes.surfel_plane).astype(np.int32)
    grown = Planes(planes.normals, planes.offsets, surfel_plane, ())
    return find_objects(cloud, surfels, grown, labels, rooms, layout=LAYOUT)


def test_a_board_on_a_wall_is_an_object_and_a_skirting_board_is_none():
    board, skirting = furnished(), furnished()
    board.block((3.97, 1.0, 1.0), (3.99, 2.5, 2.0), 0)
    skirting.block((3.97, 0.5, 0.05), (3.99, 3.5, 0.15), 0)
    assert len(objects_of(board)[0].segments) == 1
    assert len(objects_of(skirting)[0].segments) == 0


def seen_twice(first, second):
    """One cloud of two scans of one room, as it was at two times."""
    clouds = [scene.scan()[0] for scene in (first, second)]
    return ThinnedCloud(
        np.concatenate([cloud.positions for cloud in clouds]),
        np.repeat(np.arange(2, dtype=np.int32), [len(cloud.positions) for cloud in clouds]),
        np.concatenate([cloud.scanner_positions for cloud in clouds]),
        ("0", "1"),
        np.zeros(3),
        1,
    )


def test_what_another_scan_looks_through_is_a_ghost():
    """A person, who has left when the second scan is made, and a pillar, which stands before both."""
    times = []
    for place, thing in (((1.0, 1.0, 1.6), (2.0, 2.6)), ((3.0, 1.0, 1.6), None)):
        scene = BoxScene()
        scene.room(0, (0, 0, 0), (4, 4, 2.5))
        scene.block((3.2, 2.4, 0.0), (3.6, 2.8, 2.0), 0)
        if thing:
            scene.block((*thing, 0.0), (thing[0] + 0.4, thing[1] + 0.3, 1.75), 0)
        scene.scanners = [(place, 0)]
        times.append(scene)
    cloud = seen_twice(*times)
    x, y, z = cloud.positions.T
    upright = (z > 0.1) & (z < 1.7)
    person = np.flatnonzero(upright & (x > 1.9) & (x < 2.5) & (y > 2.5) & (y < 3.0))
    pillar = np.flatnonzero(upright & (x > 3.1) & (x < 3.7) & (y > 2.3) & (y < 2.9))
    suspects = [Suspect(members.astype(np.int32)) for members in (person, pillar, pillar[cloud.scan[pillar] == 0])]
    assert find_ghosts(cloud, suspects, ObjectParameters()).tolist() == [True, False, False]


def test_a_mirror_in_the_next_room_makes_no_ghosts():
    """A scan in the next room meets in a mirror what it shows behind the wall, beyond a cupboard that stands there."""
    y, z = (axis.ravel() for axis in np.meshgrid(np.arange(-1, 1, 0.02), np.arange(0.2, 1.8, 0.02)))
    cupboard = np.column_stack([np.full(len(y), 1.0), y / 2, z])
    image = np.column_stack([np.full(len(y), 4.0), 4 * y, 1.5 + 4 * (z - 1.5)])
    cloud = ThinnedCloud(
        np.concatenate([cupboard, image]).astype(np.float32),
        np.repeat(np.arange(2, dtype=np.int32), len(y)),
        np.array([[3.0, 0.0, 1.5], [-1.0, 0.0, 1.5]], dtype=np.float32),
        ("0", "1"),
        np.zeros(3),
        1,
    )
    surfels = Surfels(np.zeros((1, 3), np.float32), np.zeros((1, 3), np.float32), np.zeros(1, np.int32), np.zeros(1))
    axes, bounds = np.eye(3), np.array([-3.0, 0.0, 3.0, 2.5])
    wall = Side(0, (0,), axes[0], 0.5, axes[1], axes[2], bounds, np.zeros(1, dtype=np.int32))
    face = Face(wall, 0.5, Mask(wall, surfels))
    position, normal = np.array([0.5, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    door = Opening("door", "horizontal", 0, 1, position, normal, 3.0, 2.0, 0.0, 6.0, 0, "open", 0.9)
    members = np.arange(len(y), dtype=np.int32)
    suspects = [Suspect(members, [face]), Suspect(members, [face], [door])]
    assert find_ghosts(cloud, suspects, ObjectParameters()).tolist() == [False, True]


def test_the_area_of_a_compiled_hull_is_that_of_shapely():
    for places in (np.random.default_rng(1).normal(size=(50, 2)), np.array([[0.0, 0.0], [0.5, 0.0], [1.0, 0.0]])):
        in_order = places[np.lexsort(places.T[::-1])]
        assert hull_area(in_order) == pytest.approx(area(hull_of(places)), abs=1e-5)


def test_a_person_is_round_and_a_cupboard_as_high_is_flat():
    angle, z = (axis.ravel() for axis in np.meshgrid(np.linspace(0.0, np.pi, 30), np.linspace(0.05, 1.75, 80)))
    normals = np.column_stack([np.cos(angle), np.sin(angle), 0 * z]).astype(np.float32)
    person = np.column_stack([0.25 * np.cos(angle), 0.15 * np.sin(angle), z])
    assert is_person(person, normals, 0.0)
    assert not is_person(person * [1.0, 1.0, 0.5], normals, 0.0)
    front = np.column_stack([0.25 * np.cos(angle), 0 * z, z])
    assert not is_person(front, np.tile(np.float32([0, 1, 0]), (len(z), 1)), 0.0)


def test_an_image_in_a_mirror_is_outside_of_the_room():
    scene = furnished()
    scene.block((1.5, 4.8, 0.0), (2.1, 5.4, 1.0), 0)
    mirror = ((1.0, 0.2), (3.0, 2.2))
    scene.rectangles = [r for r in scene.rectangles if not (r.axis == 1 and r.at == 4)]
    scene.add(1, 4.0, (0, 0), (4, 2.5), -1, 0, holes=[mirror])
    cloud, surfels, planes, labels, (room,) = scene.scan()
    outline = (np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]),)
    assert len(find_objects(cloud, surfels, planes, labels, (room,)).segments) == 1
    assert find_objects(cloud, surfels, planes, labels, (replace(room, outline=outline),)).segments == ()


def test_the_leaf_of_an_open_door_is_no_object():
    scene = BoxScene()
    scene.room(0, (0, 0, 0), (4, 4, 2.5), holes={"x1": [((1.0, 0.0), (1.9, 2.0))]})
    scene.block((3.1, 1.9, 0.01), (3.97, 1.94, 1.98), 0)
    scene.scanners = [((1.5, 1.0, 1.6), 0), ((1.5, 3.0, 1.6), 0)]
    cloud, surfels, planes, labels, rooms = scene.scan()
    position, normal = np.array([4.0, 1.45, 1.0]), np.array([-1.0, 0.0, 0.0])
    door = Opening("door", "horizontal", 0, None, position, normal, 0.9, 2.0, 0.0, 1.8, 0, "open", 0.9)
    assert len(find_objects(cloud, surfels, planes, labels, rooms).segments) == 1
    assert find_objects(cloud, surfels, planes, labels, rooms, openings=[door]).segments == ()


@pytest.mark.parametrize(("low", "high"), [((2.85, 1.9), (3.68, 1.94)), ((2.85, 2.05), (3.6, 2.09))])
def test_the_leaf_of_a_door_in_a_thick_wall_hangs_where_its_reveal_ends(low, high):
    scene = BoxScene()
    scene.room(0, (0, 0, 0), (4, 4, 2.5), holes={"x1": [((1.0, 0.0), (1.9, 2.0))]})
    scene.block((*low, 0.01), (*high, 1.98), 0)
    scene.scanners = [((1.5, 1.0, 1.6), 0), ((1.5, 3.0, 1.6), 0)]
    cloud, surfels, planes, labels, rooms = scene.scan()
    position, normal = np.array([4.0, 1.45, 1.0]), np.array([-1.0, 0.0, 0.0])
    door = Opening("door", "horizontal", 0, 1, position, normal, 0.9, 2.0, 0.0, 1.8, 0, "open", 0.9)
    far = replace(door, position=np.array([4.0, 3.05, 1.0]))
    assert find_objects(cloud, surfels, planes, labels, rooms, openings=[door]).segments == ()
    assert len(find_objects(cloud, surfels, planes, labels, rooms, openings=[far]).segments) == 1


def test_a_railing_is_no_object():
    scene = furnished()
    scene.block((1.0, 3.0, 0.0), (3.5, 3.1, 1.0), 0, plane=True)
    assert objects_of(scene)[0].segments == ()


def test_a_wall_of_laths_is_no_object():
    scene = furnished()
    for lath in range(5):
        scene.block((1.0, 3.0, 0.2 + 0.45 * lath), (3.5, 3.08, 0.4 + 0.45 * lath), 0)
    for post in (1.0, 2.2, 3.4):
        scene.block((post, 3.02, 0.2), (post + 0.1, 3.06, 2.3), 0)
    assert objects_of(scene)[0].segments == ()


def test_a_stair_seen_from_below_is_no_object():
    """Nine treads of 5 cm without risers, most of them over the scanner, and a landing at their end."""
    scene = furnished()
    for step in range(9):
        x, top = 0.2 + 0.27 * step, 0.2 * (step + 1)
        scene.block((x, 2.6, top - 0.05), (x + 0.27, 3.6, top), 0)
    scene.block((2.63, 2.6, 1.95), (3.6, 3.6, 2.0), 0)
    scene.scanners = [((1.2, 1.0, 0.7), 0), ((3.4, 1.4, 0.7), 0)]
    assert objects_of(scene)[0].segments == ()


def test_a_stair_is_no_object():
    """Six steps of 1 m, each 18 cm higher and 27 cm further on, with their risers."""
    scene = furnished()
    for step in range(6):
        x, top = 0.6 + 0.27 * step, 0.18 * (step + 1)
        scene.add(2, top, (x, 2.6), (x + 0.27, 3.6), 1, 0)
        scene.add(0, x, (2.6, top - 0.18), (3.6, top), -1, 0, plane=False)
    scene.scanners = [((1.2, 1.0, 1.8), 0), ((3.4, 1.4, 1.8), 0)]
    assert objects_of(scene)[0].segments == ()


def test_shelves_one_over_the_other_are_no_stair():
    scene = furnished()
    for board in range(6):
        scene.block((1.0, 0.1, 0.3 + 0.2 * board), (2.0, 0.4, 0.32 + 0.2 * board), 0, plane=True)
    scene.block((1.0, 0.1, 0.3), (1.02, 0.4, 1.4), 0)
    found, _ = objects_of(scene)
    assert sum(len(segment.points) for segment in found.segments) > 1000


def test_the_leaf_of_a_closed_door_is_no_object():
    scene = BoxScene()
    scene.room(0, (0, 0, 0), (4, 4, 2.5), holes={"x1": [((1.0, 0.0), (1.9, 2.0))]})
    scene.add(0, 4.06, (1.0, 0.0), (1.9, 2.0), -1, 0, plane=False)
    scene.scanners = [((2.0, 2.0, 1.6), 0)]
    cloud, surfels, planes, labels, rooms = scene.scan()
    position, normal = np.array([4.0, 1.45, 1.0]), np.array([-1.0, 0.0, 0.0])
    door = Opening("door", "horizontal", 0, None, position, normal, 0.9, 2.0, 0.0, 1.8, 0, "closed", 0.5)
    assert len(find_objects(cloud, surfels, planes, labels, rooms).segments) == 1
    assert find_objects(cloud, surfels, planes, labels, rooms, openings=[door]).segments == ()


def test_a_worktop_is_parted_from_the_units_below_it():
    scene = furnished()
    scene.block((0.5, 3.38, 0.0), (3.5, 3.98, 0.9), 0)
    found, _ = objects_of(scene)
    tops = [segment for segment in found.segments if segment.floor_offset > 0.7]
    units = [segment for segment in found.segments if segment.floor_offset < 0.1]
    assert (len(tops), len(units)) == (3, 5)
    assert all(segment.size[2] < 0.1 for segment in tops)
    assert tuple(segment.number for segment in tops) in {each.segments for each in found.combinations}


def test_the_end_of_a_cupboard_is_no_wall_though_it_lies_in_the_plane_of_one():
    scene = BoxScene()
    scene.room(0, (0, 0, 0), (4, 6, 2.5))
    scene.add(0, 2.0, (0.0, 0.0), (0.6, 2.5), -1, 0)
    scene.block((2.0, 5.4, 0.0), (3.0, 5.98, 2.0), 0, plane=True)
    scene.rectangles = [replace(r, plane=r.plane and not (r.axis == 1 and r.at == 5.4)) for r in scene.rectangles]
    scene.scanners = [((0.8, 3.0, 1.6), 0), ((1.2, 4.4, 1.6), 0)]
    found, cloud = objects_of(scene)
    x, y, z = cloud.positions[np.concatenate([segment.points for segment in found.segments])].T
    assert ((x < 2.02) & (y > 5.4) & (z > 0.1)).sum() > 1000
    assert (x > 2.02).sum() > 1000


def test_a_low_sill_as_deep_as_a_reveal_is_no_object():
    scene = furnished()
    scene.block((0.5, 3.6, 0.0), (3.5, 3.98, 0.12), 0)
    assert objects_of(scene)[0].segments == ()


def test_a_slit_parts_what_is_as_high_and_lines_of_a_scan_do_not():
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(0.0, 1.2, 0.01), np.arange(0.0, 0.8, 0.01)))
    top = np.column_stack([x, y, np.full(len(x), 0.45)])
    slit = top[(x < 0.7) | (x > 0.77) | ((x > 0.73) & (x < 0.74) & (y < 0.1))]
    lines = top[(100 * x).round() % 5 == 0]
    assert sorted(len(part) for part in cut_slits(slit, ObjectParameters())) == sorted(
        [int((slit[:, 0] < 0.735).sum()), int((slit[:, 0] > 0.735).sum())]
    )
    assert [len(part) for part in cut_slits(lines, ObjectParameters())] == [len(lines)]


def test_what_stands_in_a_passage_is_in_the_room_and_the_end_of_the_wall_is_not():
    position, normal = np.array([0.0, 0.0, 1.25]), np.array([1.0, 0.0, 0.0])
    given = ("horizontal", 0, 1, position, normal, 3.0, 2.5, 0.0, 2.5, 7.5, "open", 0.9)
    places = np.array([[0.1, 0.0, 0.5], [0.1, 1.5, 0.5]])
    assert in_openings(places, [Opening("passage", *given)], ObjectParameters()).tolist() == [False, True]
    assert in_openings(places, [Opening("door", *given)], ObjectParameters()).tolist() == [True, True]


def test_the_upper_treads_of_a_stair_are_no_ceiling():
    """All that one sees of the stair are the undersides of its treads, the upper ones overhead and each a plane."""
    scene = BoxScene()
    scene.room(0, (0, 0, 0), (6, 4, 4.0))
    for step in range(6):
        x, under = 1.0 + 0.27 * step, 1.3 + 0.19 * step
        scene.add(2, under, (x, 2.6), (x + 0.27, 3.6), -1, 0, plane=under > 1.9)
    scene.scanners = [((1.2, 1.0, 1.6), 0), ((4.4, 1.4, 1.6), 0)]
    _, surfels, planes, labels, rooms = scene.scan()
    known = {room.number: room for room in rooms}
    assert len(find_structure(surfels, planes, labels, known, ObjectParameters()).flights) == 1


def test_a_railing_along_the_well_of_the_room_above_is_a_remain_and_a_picture_on_the_stairs_is_none():
    treads = np.array([[0.27 * step, 0.5, 0.18 * (step + 1)] for step in range(15)])
    flight = Flight(treads, box(0.0, 0.0, 4.0, 1.0))
    y, z = (axis.ravel() for axis in np.meshgrid(np.arange(0.3, 0.9, 0.02), np.arange(2.75, 3.6, 0.02)))
    post = np.column_stack([np.full(len(y), 0.02) + 0.3 * y, np.full(len(y), 1.05), z])

    def is_remain(floor_m):
        bounds = np.array([-3.0, -3.0, floor_m, 6.0, 6.0, floor_m + 2.5])
        room = Room(0, 9.0, floor_m, floor_m + 2.5, np.zeros(3), bounds, (), 0, (), 1.0, 0)
        ceiling = CeilingMap([], room, Surfels(*[np.zeros((0, 3), np.float32)] * 2, np.zeros(0, np.int32), np.zeros(0)))
        remains = Remains(room, (), [flight], ceiling, ObjectParameters())
        return remains.is_remain(post, np.full(len(post), np.inf))

    assert is_remain(2.7)
    assert not is_remain(1.2)
