"""Scans IFC models with a scanner unlike `enfilade simulate`, ingests and evaluates them, and prints a row a building.

``python bench/other_scanner.py FOLDER MODEL.ifc...`` works in FOLDER. What is good on one's own simulator may be good
on it alone. This scanner shares nothing with it: rays in random directions rather than a grid, one to a few positions
at random places of each space, whether or not there is a good view, no door leaves nor frames, glass opaque or not
there at all, files without rows and columns. With ``--regular`` it is of another kind again: a grid of equal angles,
from the middle of each space and, in larger ones, from places as far from each other as can be; use another FOLDER
for it. Only the truth is taken over: each point has the labels of the nearest point of `enfilade simulate`, none where
none is within 15 cm.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from shutil import copyfile
from typing import Any, Final

import ifcopenshell
import ifcopenshell.geom
import numpy as np
import pye57
from buildings import enfilade, table
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from enfilade.clouds import LABELS, LabelledCloud, read_cloud, write_cloud
from enfilade.evaluate.many import COLUMNS, summary_rows
from enfilade.native import open3d

F64 = NDArray[np.float64]

EYE_M: Final = 1.6
FREE_PLACES: Final = 60
"""Of a space, of which regular scans stand at some."""
LABEL_WITHIN_M: Final = 0.15
LEFT_OUT: Final = ("IfcOpeningElement", "IfcDoor", "IfcAnnotation", "IfcGrid")
LOWEST: Final = -np.sin(np.radians(60.0))
LOST: Final = 0.02
"""Share of rays that send nothing back."""


@dataclass(frozen=True)
class Model:
    """What the scanner meets, and the closed meshes of the spaces that it stands in."""

    scene: Any
    spaces: tuple[tuple[F64, NDArray[np.uint32]], ...]


def read_model(path: Path, *, glass: bool) -> Model:
    """Read the fabric and the spaces of an IFC model; without glass, windows are holes."""
    file = ifcopenshell.open(str(path))
    scene = open3d().t.geometry.RaycastingScene()
    spaces = []
    for product, vertices, triangles in _bodies(file):
        if product.is_a("IfcSpace"):
            spaces.append((vertices, triangles))
        elif not any(product.is_a(name) for name in LEFT_OUT) and (glass or not product.is_a("IfcWindow")):
            scene.add_triangles(vertices.astype(np.float32), triangles)
    return Model(scene, tuple(spaces))


def _bodies(file: Any) -> Iterator[tuple[Any, F64, NDArray[np.uint32]]]:
    geometry: Any = ifcopenshell.geom
    settings = geometry.settings()
    settings.set("use-world-coords", True)
    shapes = geometry.iterator(settings, file, 2)
    going_on = shapes.initialize()
    while going_on:
        shape = shapes.get()
        triangles = np.array(shape.geometry.faces, dtype=np.uint32).reshape(-1, 3)
        if len(triangles):
            yield file.by_id(shape.id), np.array(shape.geometry.verts).reshape(-1, 3), triangles
        going_on = shapes.next()


def positions(model: Model, area_a_scan_m2: float, random: np.random.Generator) -> Iterator[F64]:
    """Yield places at eye level in each space, the more the larger it is, at least 35 cm from all things."""
    for vertices, triangles in model.spaces:
        space = open3d().t.geometry.RaycastingScene()
        space.add_triangles(vertices.astype(np.float32), triangles)
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        wanted = max(1, round(float(np.prod((high - low)[:2])) / area_a_scan_m2))
        for _ in range(400):
            place = random.uniform(low, high)
            place[2] = low[2] + random.uniform(1.3, 1.8)
            asked = place[None].astype(np.float32)
            if space.compute_occupancy(asked).numpy()[0] and model.scene.compute_distance(asked).numpy()[0] > 0.35:
                yield place
                wanted -= 1
            if not wanted:
                break


def regular_positions(model: Model, area_a_scan_m2: float, random: np.random.Generator) -> Iterator[F64]:
    """Yield the place nearest the middle of each space, and as many as its size asks for far from those before."""
    for vertices, triangles in model.spaces:
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        alone = Model(model.scene, ((vertices, triangles),))
        free = np.array(list(positions(alone, float(np.prod((high - low)[:2])) / FREE_PLACES, random)))
        if not len(free):
            continue
        free[:, 2] = low[2] + EYE_M
        chosen = [int(np.argmin(np.linalg.norm(free - (low + high) / 2.0, axis=1)))]
        while len(chosen) < round(float(np.prod((high - low)[:2])) / area_a_scan_m2):
            apart = np.linalg.norm(free[:, None] - free[chosen], axis=2).min(axis=1)
            chosen.append(int(np.argmax(apart)))
        yield from free[chosen]


def random_directions(rays: int, random: np.random.Generator) -> F64:
    """Return ``(rays, 3)`` directions that are equally likely all over the sphere."""
    directions = random.normal(size=(rays, 3))
    return np.asarray(directions / np.linalg.norm(directions, axis=1, keepdims=True))


def regular_directions(rays: int) -> F64:
    """Return about `rays` directions in rows and columns of equal angles."""
    step = np.pi * np.sqrt(2.0 / rays)
    azimuth, elevation = np.meshgrid(np.arange(0.0, 2.0 * np.pi, step), np.arange(-np.pi / 2.0, np.pi / 2.0, step))
    level = np.cos(elevation)
    return np.stack([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)], axis=-1).reshape(-1, 3)


def scan_from(model: Model, place: F64, directions: F64, noise_m: float, random: np.random.Generator) -> F64:
    """Return ``(n, 3)`` what a scanner at a place measures, relative to it."""
    directions = directions[directions[:, 2] > LOWEST]
    cast = np.concatenate([np.broadcast_to(place, directions.shape), directions], axis=1).astype(np.float32)
    distance = model.scene.cast_rays(cast)["t_hit"].numpy().astype(np.float64)
    back = np.isfinite(distance) & (distance > 0.4) & (distance < 60.0) & (random.random(len(distance)) > LOST)
    measured = distance[back] + random.normal(scale=noise_m, size=int(back.sum()))
    return np.asarray(directions[back] * measured[:, None])


def write_scans(
    path: Path, model: Model, *, rays: int, area_a_scan_m2: float, noise_m: float, seed: int, regular: bool
) -> None:
    """Write one E57 with a scan, turned by chance, from each position."""
    random = np.random.default_rng(seed)
    file = pye57.E57(str(path), mode="w")
    for place in (regular_positions if regular else positions)(model, area_a_scan_m2, random):
        directions = regular_directions(rays) if regular else random_directions(rays, random)
        points, turn = scan_from(model, place, directions, noise_m, random), random.uniform(0.0, 2.0 * np.pi)
        back = np.array([[np.cos(turn), -np.sin(turn), 0.0], [np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]])
        columns = dict(
            zip(("cartesianX", "cartesianY", "cartesianZ"), np.ascontiguousarray((points @ back).T), strict=True)
        )
        quaternion = np.array([np.cos(turn / 2.0), 0.0, 0.0, np.sin(turn / 2.0)])
        file.write_scan_raw(columns, rotation=quaternion, translation=place)
    file.close()


def write_truth(folder: Path, cloud: LabelledCloud, labelled: Path) -> None:
    """Give the points of a cloud the labels of the nearest points of a truth."""
    truth = read_cloud(labelled / "cloud.ply")
    distance, nearest = cKDTree(truth.positions).query(cloud.positions, distance_upper_bound=LABEL_WITHIN_M, workers=-1)
    near = np.isfinite(distance)
    place = np.where(near, nearest, 0)
    labels = [np.where(near, getattr(truth, name)[place], -1).astype(np.int32) for name in LABELS]
    folder.mkdir(exist_ok=True)
    copyfile(labelled / "graph.json", folder / "graph.json")
    write_cloud(folder / "cloud.ply", LabelledCloud(cloud.positions, *labels))


def evaluated(path: Path, folder: Path, *, glass: bool, **how: Any) -> dict[str, Any]:
    """Scan, ingest and evaluate one model; what is in FOLDER already is used again."""
    name = f"{path.stem}-{'opaque' if glass else 'open'}"
    labelled = folder / f"{path.stem}.truth"
    if not labelled.exists():
        enfilade("simulate", str(path.resolve()), "-o", f"{path.stem}.e57", folder=folder)
    if not (folder / f"{name}.e57").exists():
        write_scans(folder / f"{name}.e57", read_model(path, glass=glass), **how)
    _, seconds, memory = enfilade("ingest", f"{name}.e57", folder=folder)
    enfilade("export", name, "-o", f"{name}.exported", folder=folder)
    write_truth(folder / f"{name}.truth", read_cloud(folder / f"{name}.exported" / "cloud.ply"), labelled)
    found = json.loads(enfilade("evaluate", f"{name}.exported", f"{name}.truth", "--format", "json", folder=folder)[0])
    return {"cpu_s": seconds, "peak_gb": memory, **found}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("models", type=Path, nargs="+")
    parser.add_argument("--rays", type=int, default=250_000, help="of a scan")
    parser.add_argument(
        "--area", type=float, default=15.0, help="of the box around a space for which there is one scan, m2"
    )
    parser.add_argument("--noise", type=float, default=0.003, help="standard deviation of ranges, m")
    parser.add_argument("--regular", action="store_true", help="equal angles, from the middle of spaces")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    chosen = {
        "rays": options.rays,
        "area_a_scan_m2": options.area,
        "noise_m": options.noise,
        "seed": options.seed,
        "regular": options.regular,
    }
    records = {
        f"{path.stem}, glass {'opaque' if glass else 'left out'}": evaluated(
            path, options.folder, glass=glass, **chosen
        )
        for path in options.models
        for glass in (True, False)
    }
    (options.folder / "other.json").write_text(json.dumps(records, indent=1))
    print(table(COLUMNS, summary_rows(records)))
