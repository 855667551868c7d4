import numpy as np
import pytest
from simulated_scenes import box_room, two_rooms

from enfilade.simulate import Setup, demo_scene
from enfilade.simulate.casting import Caster
from enfilade.simulate.locate import Locator
from enfilade.simulate.plan import Piece
from enfilade.simulate.solids import block
from enfilade.simulate.stations import find_stations


def test_every_room_of_the_demo_building_has_a_scan_and_large_ones_more():
    scene = demo_scene()
    stations = find_stations(scene, Setup())
    rooms = Locator(scene.rooms).rooms_of(stations)
    counts = np.bincount(rooms, minlength=len(scene.rooms))
    assert (rooms >= 0).all()
    assert counts.min() == 1
    assert counts[[r.number for r in scene.rooms if r.area > 37.5]].min() == 2
    assert len(stations) <= 18


def test_scanners_stand_on_tripods_away_from_everything():
    scene = demo_scene()
    stations = find_stations(scene, Setup())
    floors = np.array([scene.rooms[r].floor_elevation for r in Locator(scene.rooms).rooms_of(stations)])
    assert stations[:, 2] - floors == pytest.approx(1.5)
    assert Caster(scene.mesh).distance(stations).min() >= 0.4 - 1e-5


def test_scanners_stand_near_both_ends_of_the_stairs():
    scene = demo_scene()
    stations = find_stations(scene, Setup())
    flight = next(o for o in scene.openings if o.kind == "stairs")
    for end in flight.ends:
        assert np.linalg.norm(stations - end - np.array([0, 0, 1.5]), axis=1).min() < 1.0


def test_no_scanner_stands_on_furniture():
    platform = Piece("platform", block((0, 0), (3.0, 2.4), 0.0, 0.3), (2.0, 1.5))
    free = find_stations(box_room(), Setup())
    assert len(free) == 1
    beside = find_stations(box_room(pieces=(platform,)), Setup())
    assert not len(beside)  # 30 to 50 cm are left around it


def test_position_depends_on_height_asked_for():
    low = find_stations(two_rooms(), Setup(height_m=1.2))
    assert low[:, 2] == pytest.approx(1.2)
