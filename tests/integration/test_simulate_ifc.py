"""Scenes from real building models; skipped where these are not at hand."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from enfilade.errors import InputError
from enfilade.schema.exchange import read_graph
from enfilade.simulate import Parameters, Scanner, Scene, ifc_scene, simulate
from enfilade.simulate.casting import Caster

MODELS = Path(__file__).parents[2].parent / "shared" / "data" / "ifc"
HAUS = MODELS / "AC11-FZK-Haus-IFC.ifc"
DUPLEX = MODELS / "Duplex_A_20110907.ifc"
needs_models = pytest.mark.skipif(not HAUS.exists(), reason="needs the IFC models in ../shared/data/ifc")


@pytest.fixture(scope="module")
def haus() -> Scene:
    return ifc_scene(HAUS, closed_share=0.0)


@pytest.fixture(scope="module")
def duplex() -> Scene:
    return ifc_scene(DUPLEX, closed_share=0.0)


def named(scene: Scene, name: str):
    return next(room for room in scene.rooms if room.name == name)


def pair(scene: Scene, first: str, second: str):
    rooms = {named(scene, first).number, named(scene, second).number}
    return [o for o in scene.openings if set(o.rooms) == rooms]


@needs_models
def test_rooms_of_the_house_are_its_spaces_and_kitchen_and_living_room_are_one(haus):
    areas = {room.name: round(room.area, 1) for room in haus.rooms}
    assert areas["Bad"] == 12.5
    assert areas["Schlafzimmer"] == 22.1
    assert {"Küche + Wohnen", "Wohnen + Küche"} & set(areas)
    assert Counter(room.storey for room in haus.rooms) == {0: 5, 1: 1}
    assert [round(storey.elevation, 2) for storey in haus.storeys] == [0.0, 2.7]


@needs_models
def test_doors_of_the_house_have_their_clear_width_and_rooms(haus):
    (door,) = pair(haus, "Flur", "Bad")
    assert (door.kind, door.state) == ("door", "open")
    assert door.width == pytest.approx(0.885 - 2 * 0.05, abs=0.01)
    assert door.height == pytest.approx(1.96, abs=0.01)
    assert door.depth == pytest.approx(0.24, abs=0.01)
    assert door.position[:2] == pytest.approx([5.66, 5.87], abs=0.01)
    outer = [o for o in haus.openings if o.kind == "door" and -1 in o.rooms]
    assert {o.state for o in outer} == {"closed"}


@needs_models
def test_the_hall_opens_to_the_living_room_under_a_beam(haus):
    (doorway,) = pair(haus, "Flur", named(haus, "Küche + Wohnen").name)
    assert doorway.kind == "door"
    assert doorway.width == pytest.approx(3.6, abs=0.1)
    assert doorway.height == pytest.approx(2.26, abs=0.02)


@needs_models
def test_a_spiral_stair_joins_living_room_and_gallery(haus):
    (stairs,) = pair(haus, "Küche + Wohnen", "Galerie")
    assert stairs.kind == "stairs"
    assert stairs.rooms == (named(haus, "Küche + Wohnen").number, named(haus, "Galerie").number)


@needs_models
def test_open_doors_let_light_through_and_closed_ones_do_not(haus):
    shut = ifc_scene(HAUS, closed_share=1.0)
    inner = [o for o in haus.openings if o.kind == "door" and o.state == "open" and o.width < 1]
    starts, ends = (np.array([o.position + s * 0.4 * o.normal for o in inner]) for s in (-1, 1))
    assert len(inner) == 3
    assert not Caster(haus.mesh).blocked(starts, ends).any()
    assert Caster(shut.mesh).blocked(starts, ends).all()


@needs_models
def test_windows_are_glass_and_furniture_stands_in_rooms(haus):
    assert haus.glass.any()
    assert Counter(o.kind for o in haus.openings)["window"] == 11
    standing = Counter(haus.rooms[f.room].name for f in haus.furnishings if f.room >= 0)
    assert standing["Bad"] == 6
    assert standing["Küche + Wohnen"] == 11


@needs_models
def test_duplex_has_no_roof_room_and_joins_what_no_wall_parts(duplex):
    names = [room.name for room in duplex.rooms]
    assert not any("Roof" in name for name in names)
    ground = [room for room in duplex.rooms if "Foyer" in room.name]
    assert len(ground) == 2
    for room in ground:
        assert {"Living Room", "Kitchen", "Foyer"} <= set(room.name.split(" + "))
    assert len(duplex.rooms) == 14


@needs_models
def test_each_flat_of_the_duplex_has_its_own_stairs(duplex):
    stairs = [o.rooms for o in duplex.openings if o.kind == "stairs"]
    assert len(stairs) == 2
    assert all(duplex.rooms[low].storey == 0 and duplex.rooms[high].storey == 1 for low, high in stairs)
    assert len({room for ends in stairs for room in ends}) == 4


@needs_models
def test_share_of_closed_doors_is_kept_by_seed():
    states = [
        [o.state for o in ifc_scene(DUPLEX, closed_share=0.5, seed=seed).openings if o.kind == "door"]
        for seed in (1, 1, 2)
    ]
    assert states[0] == states[1]
    assert states[0] != states[2]


@needs_models
def test_a_coarse_scan_of_the_house_gives_files(haus, tmp_path):
    out = simulate(haus, tmp_path / "haus.e57", parameters=Parameters(Scanner(angular_step_deg=3.0)))
    graph = read_graph(out.with_suffix(".truth") / "graph.json")
    rooms = list(graph.of_label("Room"))
    assert len(rooms) == 6
    assert all(room.properties["scans"] for room in rooms)
    assert min(room.properties["point_count"] for room in rooms) > 1000


@needs_models
def test_a_truncated_model_is_named(tmp_path):
    model = tmp_path / "half.ifc"
    model.write_bytes(HAUS.read_bytes()[:400_000])
    with pytest.raises(InputError, match=r"half\.ifc"):
        ifc_scene(model)


@pytest.mark.parametrize(
    ("name", "text"), [("gone.ifc", None), ("broken.ifc", "ISO-10303-21;\nHEADER;"), ("empty.ifc", "")]
)
def test_a_bad_model_is_named(tmp_path, name, text):
    if text is not None:
        (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=name):
        ifc_scene(tmp_path / name)
