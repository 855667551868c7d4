from dataclasses import replace

import numpy as np
import pytest
from simulated_scenes import box_room

from enfilade.simulate import FAULTS, Scanner
from enfilade.simulate.build import build
from enfilade.simulate.casting import Caster
from enfilade.simulate.crowd import Crowd, person
from enfilade.simulate.plan import Hole, Level, Mirror, Piece, Plan, Space, rectangle
from enfilade.simulate.scanner import Pose, Tracer, ray_grid, rotation_about_z
from enfilade.simulate.solids import block

STATION = np.array([1.5, 1.2, 1.4])
EXACT = Scanner(
    angular_step_deg=1.0,
    range_noise_m=0.0,
    mixed_share=0.0,
    grazing_from_deg=89.99,
    dropout=0.0,
    registration_m=0.0,
    registration_deg=0.0,
)
COLUMN = Piece("column", block((0, 0), (0.4, 0.4), 0.0, 2.4), (3.0, 2.0))


def scan(scene, scanner, seed=7):
    return Tracer(scene, scanner).scan("Scan 001", STATION, np.random.default_rng(seed))


def distance_to_room(points):
    """Distance to the nearest of the six sides of the box room."""
    return np.min([np.abs(points - [0, 0, 0]), np.abs(points - [4, 3, 2.5])], axis=(0, 2))


def test_rays_cover_the_field_of_view_in_equal_steps():
    grid = ray_grid(Scanner(angular_step_deg=2.0))
    assert grid.shape == (180, 76, 3)
    assert np.linalg.norm(grid, axis=2) == pytest.approx(1.0, abs=1e-6)
    elevation = np.degrees(np.arcsin(grid[0, :, 2]))
    assert elevation == pytest.approx(np.arange(-60, 91, 2), abs=0.05)


def test_exact_scan_of_a_box_lies_on_its_sides():
    seen = scan(box_room(), EXACT)
    assert len(seen.local) == ray_grid(EXACT)[..., 0].size
    assert distance_to_room(seen.pose.apply(seen.local)).max() < 1e-5
    assert seen.pose.apply(seen.local) == pytest.approx(seen.hit, abs=1e-5)


def test_normals_point_to_the_scanner():
    seen = scan(box_room(), EXACT)
    assert (np.einsum("ij,ij->i", seen.normal, STATION - seen.hit) > 0).all()


def test_range_noise_has_its_deviation_and_no_bias():
    seen = scan(box_room(), replace(EXACT, range_noise_m=0.004))
    error = np.linalg.norm(seen.local, axis=1) - np.linalg.norm(seen.hit - STATION, axis=1)
    count = len(error)
    assert error.std() == pytest.approx(0.004, rel=5 / np.sqrt(2 * count))
    assert abs(error.mean()) < 5 * 0.004 / np.sqrt(count)


def test_same_seed_gives_the_same_points_and_another_seed_others():
    scanner = Scanner(angular_step_deg=2.0)
    first, second, third = (scan(box_room(), scanner, seed) for seed in (1, 1, 2))
    assert first.local.tobytes() == second.local.tobytes()
    assert first.pose.translation.tobytes() == second.pose.translation.tobytes()
    assert first.local.tobytes() != third.local.tobytes()


def test_panes_send_some_rays_back_and_let_the_others_through():
    scene = box_room(Hole("window", (None, "Room"), (2.0, -0.1), 1.6, 1.4, sill=0.7), garden=20.0)
    scanner = replace(EXACT, angular_step_deg=0.5, glass_return=0.25, glass_loss=0.0)
    seen = scan(scene, scanner)
    on_pane = scene.glass[seen.triangle]
    beyond = seen.hit[:, 1] < -0.21
    assert on_pane.sum() / (on_pane.sum() + beyond.sum()) > 0.25  # some rays that pass see only the sky
    whole = scan(scene, replace(scanner, glass_return=1.0))
    share = on_pane.sum() / scene.glass[whole.triangle].sum()
    assert share == pytest.approx(0.25, abs=0.03)


def test_glass_loss_takes_rays_away():
    scene = box_room(Hole("window", (None, "Room"), (2.0, -0.1), 1.6, 1.4, sill=0.7), garden=20.0)
    whole = scan(scene, replace(EXACT, glass_return=0.0, glass_loss=0.0))
    dimmed = scan(scene, replace(EXACT, glass_return=0.0, glass_loss=0.5))
    beyond = [(s.hit[:, 1] < -0.21).sum() for s in (whole, dimmed)]
    assert beyond[1] == pytest.approx(beyond[0] / 2, rel=0.25)


def test_mixed_pixels_lie_between_an_edge_and_what_is_behind_it():
    scene = box_room(pieces=(COLUMN,))
    seen = scan(scene, replace(EXACT, mixed_share=0.5))
    ranges = np.linalg.norm(seen.local, axis=1)
    true = np.linalg.norm(seen.hit - STATION, axis=1)
    assert seen.mixed.any()
    assert ranges[~seen.mixed] == pytest.approx(true[~seen.mixed], abs=1e-5)
    assert (np.abs(ranges - true)[seen.mixed] > 0.01).mean() > 0.9
    inside = seen.pose.apply(seen.local[seen.mixed])
    assert (inside > -0.01).all()
    assert (inside < [4.01, 3.01, 2.51]).all()


def test_no_pixel_is_mixed_along_a_plane():
    """At a coarse step neighbours on the floor are decimetres apart, and still no edge lies between them."""
    seen = scan(box_room(), replace(EXACT, angular_step_deg=3.0, mixed_share=1.0, mixed_jump_m=0.05))
    on_floor = seen.hit[:, 2] < 1e-5
    midst = on_floor & ((seen.hit > [0.8, 0.8, -1]) & (seen.hit < [3.2, 2.2, 1])).all(axis=1)
    assert midst.sum() > 200
    assert not seen.mixed[midst].any()


def test_grazing_rays_get_lost():
    seen = scan(box_room(), replace(EXACT, grazing_from_deg=30.0))
    towards = STATION - seen.hit
    cosine = np.einsum("ij,ij->i", seen.normal, towards) / np.linalg.norm(towards, axis=1)
    angles = np.degrees(np.arccos(cosine))
    whole = scan(box_room(), EXACT)
    assert len(seen.local) < 0.9 * len(whole.local)
    assert (angles > 80).mean() < 0.01


def test_dropouts_take_their_share():
    seen = scan(box_room(), replace(EXACT, dropout=0.3))
    assert len(seen.local) / ray_grid(EXACT)[..., 0].size == pytest.approx(0.7, abs=0.01)


def test_range_limits_hold():
    seen = scan(box_room(), replace(EXACT, range_from_m=1.3, range_to_m=2.0))
    ranges = np.linalg.norm(seen.local, axis=1)
    assert len(ranges)
    assert ranges.min() >= 1.3
    assert ranges.max() <= 2.0


def test_registration_moves_and_turns_the_whole_scan():
    tracer = Tracer(box_room(), replace(EXACT, angular_step_deg=5.0, registration_m=0.02, registration_deg=0.5))
    poses = [tracer.scan("Scan", STATION, np.random.default_rng(seed)).pose for seed in range(40)]
    shifts = np.array([pose.translation - STATION for pose in poses])
    assert shifts.std() == pytest.approx(0.02, rel=0.25)
    tilts = np.degrees([np.arccos(pose.rotation[2, 2]) for pose in poses])
    assert np.sqrt(np.mean(tilts**2) / 2) == pytest.approx(0.5, rel=0.3)


@pytest.mark.parametrize("angle", [-170.0, -90.0, 0.0, 45.0, 170.0])
def test_quaternion_is_that_of_the_rotation(angle):
    pose = Pose(rotation_about_z(angle), np.zeros(3))
    w, x, y, z = pose.quaternion
    turned = [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)]
    assert turned == pytest.approx(pose.rotation[:, 0])


def test_intensity_lies_in_zero_to_one():
    seen = scan(box_room(), EXACT)
    assert seen.intensity.min() >= 0.0
    assert 0.3 < seen.intensity.max() <= 1.0


def mirror_room():
    """Return the box room with a mirror 1 m wide and 1.5 m high in the middle of its wall x = 4."""
    mirror = Mirror((4.0, 1.5), 180.0, 1.0, 1.5, 0.5)
    level = Level("Ground", 0.0, 2.5, (Space("Room", rectangle(0, 4, 0, 3), mirrors=(mirror,)),))
    return build(Plan("mirrors", rectangle(-0.2, 4.2, -0.2, 3.2), (level,), garden=0.0))


def test_a_mirror_shows_the_room_behind_itself_and_that_is_stray():
    seen = scan(mirror_room(), EXACT)
    behind = seen.pose.apply(seen.local)[:, 0] > 4.01
    assert behind.sum() > 500
    assert (seen.stray == behind).all()
    true = seen.hit[seen.stray]
    shown = seen.pose.apply(seen.local[seen.stray])
    assert distance_to_room(true).max() < 1e-4
    reflected = true * [-1, 1, 1] + [2 * 3.99, 0, 0]
    assert shown == pytest.approx(reflected, abs=1e-3)


def test_people_stand_in_the_way_and_are_stray():
    people = person(1.8).moved([2.8, 1.2, 0.0])
    seen = Tracer(box_room(), EXACT).scan("Scan", STATION, np.random.default_rng(7), people)
    assert seen.stray.sum() > 300
    assert (seen.triangle[seen.stray] == -1).all()
    assert Caster(people).distance(seen.hit[seen.stray]).max() < 1e-4
    assert distance_to_room(seen.hit[~seen.stray]).max() < 1e-4


def test_a_crowd_stands_elsewhere_in_each_scan_but_on_the_floor():
    crowd = Crowd(box_room().mesh)
    assert crowd.about(STATION, 0.0, np.random.default_rng(1)) is None
    bodies = [crowd.about(STATION, 3.0, np.random.default_rng(seed)) for seed in range(5)]
    bodies = [body for body in bodies if len(body.vertices)]
    assert len({float(body.vertices[0, 0]) for body in bodies}) == len(bodies) > 1
    for body in bodies:
        low, high = body.bounds
        assert low[2] == pytest.approx(0.0, abs=1e-5)
        assert (low[:2] > 0).all()
        assert (high < [4, 3, 2.5]).all()


def test_dark_surfaces_lose_rays_and_the_others_do_not():
    scene = box_room()
    bright, dim = (scan(scene, replace(EXACT, dark_share=share, dark_loss=0.9)) for share in (0.0, 0.5))
    before, after = (np.bincount(scene.surface[s.triangle], minlength=scene.surface.max() + 1) for s in (bright, dim))
    share = after[before > 300] / before[before > 300]
    assert (share > 0.99).any()
    assert (share < 0.2).any()
    assert not ((share > 0.2) & (share < 0.99)).any()


def test_faults_grow_from_light_to_heavy():
    for name in (
        "range_noise_m",
        "mixed_share",
        "glass_return",
        "dropout",
        "people",
        "registration_m",
        "registration_deg",
    ):
        light, medium, heavy = (getattr(FAULTS[level], name) for level in ("light", "medium", "heavy"))
        assert light < heavy
        assert light <= medium <= heavy
