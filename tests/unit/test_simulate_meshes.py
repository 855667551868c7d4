import numpy as np
import pytest
from simulated_scenes import two_rooms

from enfilade.errors import InputError
from enfilade.simulate import mesh_scene, write_obj
from enfilade.simulate.casting import Caster


@pytest.fixture
def model(tmp_path):
    return write_obj(tmp_path / "pair.obj", two_rooms().mesh)


def test_mesh_is_structure_with_positions_on_a_grid(model):
    scene = mesh_scene(model, spacing_m=1.5)
    assert scene.rooms == ()
    assert (scene.furnishing == -1).all()
    inside = ((scene.stations > [0, 0, 1.4]) & (scene.stations < [6.2, 3, 1.6])).all(axis=1)
    assert inside.all()
    assert len(inside) >= 4
    assert Caster(scene.mesh).distance(scene.stations).min() >= 0.4


def test_positions_come_from_a_table(model, tmp_path):
    table = tmp_path / "stations.csv"
    table.write_text("x,y,z\n1.5,1.5,1.4\n4.5,1.0,1.6\n")
    assert mesh_scene(model, stations=table).stations.tolist() == [[1.5, 1.5, 1.4], [4.5, 1.0, 1.6]]


def test_positions_may_be_given(model):
    given = np.array([[1.5, 1.5, 1.4]])
    assert mesh_scene(model, stations=given).stations.tolist() == given.tolist()


@pytest.mark.parametrize("text", ["x,y\n1,2\n", "x,y,z\n1,two,3\n", "x,y,z\n1,2\n", "\x00"])
def test_a_bad_table_is_named(model, tmp_path, text):
    table = tmp_path / "stations.csv"
    table.write_text(text)
    with pytest.raises(InputError, match=r"stations\.csv"):
        mesh_scene(model, stations=table)


@pytest.mark.parametrize(
    ("name", "text"), [("gone.obj", None), ("notes.txt", "v 0 0 0"), ("empty.obj", ""), ("points.obj", "v 0 0 0\n")]
)
def test_a_bad_mesh_is_named(tmp_path, name, text):
    if text is not None:
        (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=name):
        mesh_scene(tmp_path / name)


def test_a_mesh_without_room_for_the_scanner_says_what_to_do(tmp_path):
    model = tmp_path / "sheet.obj"
    model.write_text("v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n")
    with pytest.raises(InputError, match="give positions"):
        mesh_scene(model)
