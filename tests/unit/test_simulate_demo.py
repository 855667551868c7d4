import numpy as np
import pytest

from enfilade.simulate import basin_mesh, demo_scene
from enfilade.simulate.casting import Caster
from enfilade.simulate.locate import Locator
from enfilade.simulate.solids import unit_normals


@pytest.fixture(scope="module")
def scene():
    return demo_scene()


def rooms_named(scene, *names):
    numbers = {room.name: room.number for room in scene.rooms}
    return tuple(numbers[name] for name in names)


def doors(scene, **properties):
    found = (o for o in scene.openings if o.kind == "door")
    return [o for o in found if all(getattr(o, name) == value for name, value in properties.items())]


def test_two_storeys_and_at_least_nine_rooms_of_different_sizes(scene):
    assert [storey.elevation for storey in scene.storeys] == [0.0, 2.9]
    areas = [room.area for room in scene.rooms]
    assert len(areas) >= 9
    assert len({round(area) for area in areas}) >= 9
    assert {room.storey for room in scene.rooms} == {0, 1}


def test_rooms_do_not_overlap(scene):
    for a in scene.rooms:
        for b in scene.rooms[a.number + 1 :]:
            assert a.storey != b.storey or a.polygon.distance(b.polygon) >= 0.12 - 1e-9


def test_there_is_a_corridor(scene):
    corridor = scene.rooms[rooms_named(scene, "Corridor")[0]]
    x0, y0, x1, y1 = corridor.polygon.bounds
    assert (x1 - x0) / (y1 - y0) > 4


def test_doors_have_several_widths_lintels_and_one_inside_is_closed(scene):
    assert len({door.width for door in doors(scene)}) >= 4
    for door in doors(scene):
        assert door.position[2] + door.height / 2 < 2.2 or door.position[2] > 2.9
    inner = [door for door in doors(scene, state="closed") if -1 not in door.rooms]
    assert len(inner) == 1


def test_kitchen_and_living_room_are_joined_by_a_passage_up_to_the_ceiling(scene):
    passage = next(o for o in scene.openings if o.kind == "passage")
    assert set(passage.rooms) == set(rooms_named(scene, "Kitchen", "Living room"))
    assert passage.width == pytest.approx(1.5)
    assert passage.position[2] + passage.height / 2 == pytest.approx(scene.rooms[passage.rooms[0]].ceiling_elevation)


def test_stairs_lead_up_through_a_hole_in_the_slab(scene):
    flight = next(o for o in scene.openings if o.kind == "stairs")
    assert [scene.rooms[room].storey for room in flight.rooms] == [0, 1]
    falling = flight.position + np.array([[-1.2, 0.0, 1.0], [0.0, -1.0, 1.0]])
    ranges, _ = Caster(scene.mesh).cast(falling, np.array([[0.0, 0.0, -1.0]] * 2))
    through, beside = falling[:, 2] - ranges
    assert through < 2.5
    assert beside == pytest.approx(2.9, abs=1e-5)


def test_openings_lie_between_their_rooms(scene):
    locator = Locator(scene.rooms)
    for opening in scene.openings:
        reach = opening.depth / 2 + 0.1
        sides = opening.position + np.outer([-reach, reach], opening.normal)
        assert locator.rooms_of(sides).tolist() == list(opening.rooms)


def test_the_papers_question_has_answers_that_rank(scene):
    """Two rooms of 10 to 20 m², one with stairs, joined by a door, the other holding a basin."""
    with_stairs = {room for o in scene.openings if o.kind == "stairs" for room in o.rooms}
    with_basin = {piece.room for piece in scene.furnishings if piece.name == "basin"}
    fitting = {room.number for room in scene.rooms if 10 <= room.area <= 20}
    pairs = {frozenset(o.rooms) for o in doors(scene) if set(o.rooms) <= fitting}
    matches = [p for p in pairs if p & with_stairs and (p - with_stairs) & with_basin]
    assert len(matches) == 2


def test_basins_differ_from_one_another_and_from_the_one_to_ask_with(scene):
    basins = [piece.number for piece in scene.furnishings if piece.name == "basin"]
    heights = [
        np.ptp(scene.mesh.vertices[scene.mesh.triangles[scene.furnishing == number]].reshape(-1, 3)[:, 2])
        for number in basins
    ]
    heights.append(np.ptp(basin_mesh().vertices[:, 2]))
    assert len(basins) == 3
    assert len({round(height, 3) for height in heights}) == 4


def test_furniture_stands_in_its_room_and_not_in_a_wall(scene):
    for piece in scene.furnishings:
        vertices = scene.mesh.vertices[scene.mesh.triangles[scene.furnishing == piece.number]].reshape(-1, 3)
        low, high = scene.rooms[piece.room].boundary.bounds
        assert (vertices >= low - 0.001).all(), piece
        assert (vertices <= high + 0.001).all(), piece
        assert vertices[:, 2].min() == pytest.approx(low[2], abs=1e-6)


def test_pieces_of_a_room_stand_apart(scene):
    boxes = []
    for piece in scene.furnishings:
        vertices = scene.mesh.vertices[scene.mesh.triangles[scene.furnishing == piece.number]].reshape(-1, 3)
        boxes.append((piece, vertices.min(axis=0), vertices.max(axis=0)))
    for k, (a, low_a, high_a) in enumerate(boxes):
        for b, low_b, high_b in boxes[k + 1 :]:
            overlap = np.minimum(high_a, high_b) - np.maximum(low_a, low_b)
            tucked_in = {a.name, b.name} == {"table", "chair"}
            assert a.room != b.room or tucked_in or (overlap <= 1e-9).any(), (a, b)


def test_surfaces_of_structure_are_flat(scene):
    corners = scene.mesh.vertices[scene.mesh.triangles]
    normals = unit_normals(scene.mesh)
    for number in np.unique(scene.surface[scene.surface >= 0])[::7]:
        members = scene.surface == number
        normal = normals[members][0]
        assert np.ptp(corners[members].reshape(-1, 3) @ normal) < 0.015


def test_every_triangle_is_structure_glass_or_furniture(scene):
    kinds = (scene.surface >= 0).astype(int) + scene.glass + (scene.furnishing >= 0)
    assert (kinds == 1).all()
    assert scene.glass.any()
