import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from enfilade.simulate.furniture import basin, bathtub, bed, cabinet, chair, shelf, sofa, table, toilet, wardrobe
from enfilade.simulate.meshes import read_mesh
from enfilade.simulate.solids import (
    Mesh,
    around_holes,
    box,
    cylinder,
    slab,
    unit_normals,
    wall,
    write_obj,
)


def volume(mesh: Mesh) -> float:
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def test_box_is_closed_and_turned_outwards():
    solid = box([1, 2, 3], [2, 4, 6])
    assert volume(solid) == pytest.approx(6.0)
    outwards = solid.vertices[solid.triangles].mean(axis=1) - [1.5, 3, 4.5]
    assert (np.einsum("ij,ij->i", unit_normals(solid), outwards) > 0).all()


def test_turning_and_moving_keep_the_volume():
    assert volume(box([0, 0, 0], [1, 2, 3]).turned(37).moved([5, 6, 7])) == pytest.approx(6.0)


def test_cylinder_is_closed():
    assert volume(cylinder((3, 4), 0.5, 1, 3, sides=200)) == pytest.approx(np.pi * 0.25 * 2, rel=1e-3)


spans = st.tuples(st.integers(0, 40), st.integers(1, 12)).map(lambda s: (s[0] / 4, (s[0] + s[1]) / 4))


@given(st.lists(st.tuples(spans, spans), max_size=6))
def test_what_is_left_around_holes_covers_all_but_the_holes(holes):
    outer = (0.0, 10.0, 0.0, 10.0)
    gaps = [(*u, *v) for u, v in holes]
    pieces = around_holes(outer, gaps)
    centres = np.arange(40) / 4 + 0.125
    u, v = np.meshgrid(centres, centres)

    def covered(rectangles):
        inside = [(r[0] < u) & (u < r[1]) & (r[2] < v) & (v < r[3]) for r in rectangles]
        return np.sum([np.zeros_like(u), *inside], axis=0)

    assert (covered(pieces) == (covered(gaps) == 0)).all()


def test_wall_has_its_hole_and_lintel():
    solid = wall((0, 0), (3, 0), 0.2, (0.0, 2.5), [(1.0, 1.9, 0.0, 2.0)])
    assert volume(solid) == pytest.approx(0.2 * (3 * 2.5 - 0.9 * 2.0))


def test_wall_without_lintel_falls_in_two():
    solid = wall((0, 0), (0, 3), 0.2, (0.0, 2.5), [(1.0, 2.0, 0.0, 2.5)])
    assert len(solid.vertices) == 2 * 8
    assert solid.bounds == pytest.approx(np.array([[-0.1, 0, 0], [0.1, 3, 2.5]]))


def test_slab_leaves_its_well_free():
    assert volume(slab((0, 4, 0, 3), 2.6, 2.9, [(1, 2, 1, 2)])) == pytest.approx(0.3 * 11)


@pytest.mark.parametrize(
    ("make", "size"),
    [
        (basin, (0.6, 0.48, 1.01)),
        (bathtub, (0.75, 1.7, 0.56)),
        (bed, (0.95, 2.05, 0.9)),
        (cabinet, (0.6, 0.58, 0.86)),
        (chair, (0.45, 0.46, 0.92)),
        (shelf, (0.9, 0.32, 1.9)),
        (sofa, (1.9, 0.88, 0.8)),
        (table, (1.4, 0.8, 0.75)),
        (toilet, (0.4, 0.68, 0.8)),
        (wardrobe, (1.5, 0.64, 2.0)),
    ],
)
def test_furniture_stands_on_the_ground_in_its_size(make, size):
    low, high = make().bounds
    assert low[2] == 0.0
    assert high - low == pytest.approx(size, abs=0.011)
    assert abs(low[:2] + high[:2]).max() < 0.06


def test_basin_holds_water():
    mesh = basin()
    centre = np.linalg.norm(mesh.vertices[:, :2], axis=1) < 0.05
    levels = mesh.vertices[centre & (mesh.vertices[:, 2] > 0.5), 2]
    assert 0.6 < levels.max() < 0.85 - 0.1


def test_written_mesh_reads_back(tmp_path):
    mesh = basin()
    read = read_mesh(write_obj(tmp_path / "basin.obj", mesh))
    assert read.vertices[read.triangles] == pytest.approx(mesh.vertices[mesh.triangles], abs=1e-6)
