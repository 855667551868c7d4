"""What stands in a room becomes segments and combinations; walls, floors and ceilings do not."""

import numpy as np
import pytest
from box_scene import BoxScene

from enfilade.descriptors import TOTAL, Layout
from enfilade.ingest.objects import ObjectParameters, find_objects
from enfilade.ingest.objects.combinations import combine, find_near
from enfilade.ingest.objects.segments import connect, without_outliers
from enfilade.ingest.records import Opening, Segment

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
    kept = without_outliers(np.concatenate([block, veil]), 8, 2.0)
    assert kept[:800].mean() > 0.95
    assert not kept[803:].any()


def test_components_are_split_at_the_link_distance():
    rng = np.random.default_rng(0)
    block = rng.uniform(0, 0.3, (3000, 3))
    parameters = ObjectParameters()
    near = connect(np.concatenate([block, block + np.array([0.3 + 0.5 * parameters.link_m, 0, 0])]), parameters)
    far = connect(np.concatenate([block, block + np.array([0.3 + 2 * parameters.link_m, 0, 0])]), parameters)
    assert [len(group) for group in near] == [6000]
    assert [len(group) for group in far] == [3000, 3000]


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
