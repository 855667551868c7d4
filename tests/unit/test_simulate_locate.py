import numpy as np
from simulated_scenes import two_rooms

from enfilade.simulate.locate import Locator, rooms_of_surfaces


def test_points_are_in_the_room_whose_boundary_holds_them():
    points = np.array([[1.5, 1.5, 1.0], [4.0, 1.0, 2.4], [3.1, 1.5, 1.0], [1.5, 1.5, 2.6], [-1.0, 1.0, 1.0]])
    assert Locator(two_rooms().rooms).rooms_of(points).tolist() == [0, 1, -1, -1, -1]


def test_locator_agrees_with_the_boxes_of_the_rooms():
    scene = two_rooms()
    points = np.random.default_rng(3).uniform([-1, -1, -0.5], [7, 4, 3], (20_000, 3))
    expected = np.full(len(points), -1)
    for room in scene.rooms:
        low, high = room.boundary.bounds
        expected[((points > low) & (points < high)).all(axis=1)] = room.number
    assert (Locator(scene.rooms).rooms_of(points) == expected).all()


def test_without_rooms_nothing_is_in_one():
    assert Locator(()).rooms_of(np.zeros((2, 3))).tolist() == [-1, -1]


def test_each_side_of_a_wall_belongs_to_its_room():
    scene = two_rooms()
    hits = np.array([[3.0, 0.5, 1.0], [3.2, 0.5, 1.0]])
    normals = np.array([[-1.0, 0, 0], [1.0, 0, 0]])
    assert rooms_of_surfaces(scene, Locator(scene.rooms), hits, normals).tolist() == [0, 1]


def test_reveals_belong_to_the_nearer_room():
    scene = two_rooms()
    hits = np.array([[3.05, 1.05, 1.0], [3.15, 1.05, 1.0], [3.05, 1.5, 2.0], [3.15, 1.5, 2.0]])
    normals = np.array([[0, 1.0, 0], [0, 1.0, 0], [0, 0, -1.0], [0, 0, -1.0]])
    assert rooms_of_surfaces(scene, Locator(scene.rooms), hits, normals).tolist() == [0, 1, 0, 1]


def test_outer_faces_belong_to_no_room():
    scene = two_rooms()
    hits, normals = np.array([[-0.2, 1.0, 1.0]]), np.array([[-1.0, 0, 0]])
    assert rooms_of_surfaces(scene, Locator(scene.rooms), hits, normals).tolist() == [-1]
