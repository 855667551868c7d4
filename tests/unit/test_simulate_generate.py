"""Generated buildings: is the truth about them true?"""

from functools import cache

import numpy as np
import pytest

from enfilade.simulate import Setup, generate
from enfilade.simulate.casting import Caster
from enfilade.simulate.generate import name_of
from enfilade.simulate.locate import Locator
from enfilade.simulate.polygons import plan_samples
from enfilade.simulate.recipes import CORPUS, FEATURES, RECIPES, half_of, recipe_of
from enfilade.simulate.scene import OUTSIDE
from enfilade.simulate.stations import find_stations

SEEDS = (2, 8, 19, 44, 58)
"""A flat with mirrors; a villa with a round room and raised floors; a tall room; an attic; rooms without scans."""


@cache
def scene_of(seed):
    return generate(seed).scene


def walls(scene):
    return Caster(scene.submesh((scene.furnishing < 0) & ~scene.glass))


def passes(opening, starts, ends):
    """Whether the ways from starts to ends go through an opening's box."""
    axes = np.stack([opening.axis, opening.normal, np.cross(opening.normal, opening.axis)])
    half = np.array([opening.width, opening.depth, opening.height]) / 2 + 0.1
    first, way = (starts - opening.position) @ axes.T, (ends - starts) @ axes.T
    bounds = np.sort(np.stack([(-half - first) / way, (half - first) / way]), axis=0)
    entry, leave = bounds[0].max(axis=1), bounds[1].min(axis=1)
    return (entry < leave) & (leave > 0) & (entry < 1)


@pytest.mark.parametrize("seed", SEEDS)
def test_what_is_seen_from_a_room_is_in_it_or_behind_one_of_its_openings(seed):
    scene = scene_of(seed)
    locator, caster, random = Locator(scene.rooms), walls(scene), np.random.default_rng(seed)
    for room in scene.rooms:
        places = plan_samples(room.polygon, room.floor_elevation, 0.5)
        starts = places[random.integers(len(places), size=300)] + [0, 0, 1] * random.uniform(0.1, 1.8, (300, 1))
        starts = starts[locator.rooms_of(starts) == room.number]
        directions = random.normal(size=starts.shape)
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        ranges = np.minimum(caster.cast(starts, directions)[0], 100.0)
        ends = starts + directions * (ranges - 0.02)[:, None]
        explained = locator.rooms_of(ends) == room.number
        for opening in scene.openings:
            if room.number in opening.rooms:
                explained |= passes(opening, starts, ends)
        assert len(starts) > 100
        assert explained.all(), room.name


@pytest.mark.parametrize("seed", SEEDS)
def test_openings_lie_between_their_rooms_and_are_open_or_shut_as_they_say(seed):
    scene = scene_of(seed)
    locator, solids = Locator(scene.rooms), Caster(scene.submesh(~scene.glass))
    for opening in (o for o in scene.openings if o.horizontal):
        reach = opening.depth / 2 + 0.1
        sides = opening.position + np.outer([-reach, reach], opening.normal)
        assert locator.rooms_of(sides).tolist() == list(opening.rooms)
        up = np.outer(np.linspace(-0.35, 0.4, 5) * opening.height, [0, 0, 1])
        shut = solids.blocked(sides[0] + 0.05 * opening.normal + up, sides[1] - 0.05 * opening.normal + up)
        if opening.kind == "passage" or opening.state == "open":
            assert not shut.any()
        elif opening.kind == "door" and opening.state == "closed" and OUTSIDE not in opening.rooms:
            assert shut.all()


@pytest.mark.parametrize("seed", SEEDS)
def test_stairs_lead_from_the_lower_to_the_upper_room(seed):
    scene = scene_of(seed)
    locator = Locator(scene.rooms)
    for stairs in (o for o in scene.openings if o.kind == "stairs"):
        assert stairs.ends is not None
        assert locator.rooms_of(stairs.ends + np.array([0, 0, 0.5])).tolist() == list(stairs.rooms)
        low, high = (scene.rooms[room] for room in stairs.rooms)
        assert low.storey + 1 == high.storey
    assert sum(o.kind == "stairs" for o in scene.openings) == len(scene.storeys) - 1


@pytest.mark.parametrize("seed", SEEDS)
def test_scanners_stand_in_the_rooms_that_are_to_be_scanned(seed):
    scene = scene_of(seed)
    rooms = Locator(scene.rooms).rooms_of(find_stations(scene, Setup()))
    assert set(rooms.tolist()) <= {room.number for room in scene.rooms if room.scanned}
    assert len(set(rooms.tolist())) >= 0.8 * sum(room.scanned for room in scene.rooms)


@pytest.mark.parametrize("seed", SEEDS)
def test_furniture_stands_in_its_room(seed):
    scene = scene_of(seed)
    locator = Locator(scene.rooms)
    for piece in scene.furnishings:
        corners = scene.mesh.vertices[scene.mesh.triangles[scene.furnishing == piece.number]].reshape(-1, 3)
        middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
        inwards = corners + 0.02 * (middle - corners) / np.linalg.norm(middle - corners, axis=1, keepdims=True)
        assert (locator.rooms_of(inwards) == piece.room).mean() > 0.95, piece


def test_the_same_seed_makes_the_same_building_and_another_seed_another():
    first, again, other = generate(2), generate(2), generate(1)
    assert first.scene.mesh.vertices.tobytes() == again.scene.mesh.vertices.tobytes()
    assert first.description == again.description
    assert first.scene.mesh.vertices.shape != other.scene.mesh.vertices.shape


def test_faults_can_be_chosen_without_another_plan():
    worse = generate(2, faults="heavy")
    assert worse.parameters.scanner.range_noise_m > generate(2).parameters.scanner.range_noise_m
    assert len(worse.scene.rooms) == len(scene_of(2).rooms)


def test_both_halves_have_what_is_hard_alike():
    assert len(CORPUS) >= 60
    assert len({name_of(seed) for seed in CORPUS}) == len(CORPUS)
    halves = {half: [recipe_of(s).name for s in CORPUS if half_of(s) == half] for half in ("develop", "check")}
    assert halves["develop"] == halves["check"]
    used = set().union(*(recipe.features for recipe in RECIPES))
    assert used == set(FEATURES)
    assert {recipe.faults for recipe in RECIPES} == {"light", "medium", "heavy"}


def test_a_turned_building_is_the_same_building():
    scene = scene_of(58)
    assert all(room.polygon.is_valid for room in scene.rooms)
    turned = generate(4).scene
    assert abs(np.mean(turned.mesh.vertices[:, :2])) > 10
    assert {round(float(abs(o.axis[0])), 3) for o in turned.openings} != {0.0, 1.0}


def test_a_building_that_should_have_them_has_closets_columns_mirrors_and_rooms_without_scans():
    assert any(room.name.startswith("Closet") for room in generate(9).scene.rooms)
    assert any(len(room.outline) > 1 for room in generate(15).scene.rooms)
    assert scene_of(2).mirror.any()
    assert not all(room.scanned for room in scene_of(58).rooms)
