"""Furnished rooms to scan: meshes of furniture where such things stand, hang or lie, with clutter beside them."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import count
from pathlib import Path
from typing import Final

import numpy as np
from shapely import Polygon, box
from shapely.affinity import rotate, translate

from enfilade.descriptors import read_shape
from enfilade.simulate import furniture, plan
from enfilade.simulate.build import build
from enfilade.simulate.casting import Caster
from enfilade.simulate.scene import Scene
from enfilade.simulate.solids import F64, Mesh, block, cylinder

AT_WALL: Final = {
    "armchair": 0.4,
    "bathtub": 0.9,
    "bed": 0.9,
    "bookcase": 0.9,
    "cabinet": 0.9,
    "chair": 0.2,
    "desk": 0.7,
    "lamp": 0.3,
    "radiator": 1.0,
    "sofa": 0.7,
    "stool": 0.2,
    "table": 0.2,
    "toilet": 1.0,
    "washbasin": 1.0,
}
"""Share of a class that stands or hangs at a wall, its back to it; the others stand anywhere, turned anyhow."""

WALL_M: Final = 0.2
TRIES: Final = 60


@dataclass(frozen=True, slots=True)
class Model:
    """A mesh with its class, its origin in the middle of its foot, its back towards +y."""

    kind: str
    name: str
    mesh: Mesh

    @property
    def size(self) -> F64:
        """``(3,)`` metres."""
        low, high = self.mesh.bounds
        return np.asarray(high - low, dtype=np.float64)


@dataclass(slots=True)
class _Room:
    """A room while it is being furnished."""

    size: F64
    rng: np.random.Generator
    pieces: list[plan.Piece] = field(default_factory=list)
    taken: list[tuple[Polygon, float, float]] = field(default_factory=list)
    """Plan, foot and top of what is there."""
    supports: list[plan.Piece] = field(default_factory=list)

    def add(self, piece: plan.Piece, plan_: Polygon) -> None:
        low, high = piece.mesh.bounds
        self.pieces.append(piece)
        self.taken.append((plan_, low[2], high[2]))

    def fits(self, plan_: Polygon, foot: float, top: float, gap: float) -> bool:
        inside = box(0, 0, *self.size).buffer(0.001).contains(plan_)
        wide = plan_.buffer(gap)
        return inside and not any(
            wide.intersects(other) for other, low, high in self.taken if low < top and high > foot
        )


def read_models(folder: Path) -> list[Model]:
    """Read ``CLASS/*.obj``, ordered by class and name."""
    models = []
    for path in sorted(folder.glob("*/*.obj")):
        shape = read_shape(path)
        low, high = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
        foot = [*((low + high) / 2)[:2], low[2]]
        models.append(Model(path.parent.name, path.stem, Mesh(shape.vertices - foot, shape.triangles)))
    return models


def furnished_rooms(models: Sequence[Model], *, copies: int, seed: int, name: str) -> Iterator[Scene]:
    """Furnish rooms until each mesh stands in `copies` of them; every room is a building of its own."""
    rng = np.random.default_rng(seed)
    waiting = deque(model for _ in range(copies) for model in (models[i] for i in rng.permutation(len(models))))
    for number in count():
        if not waiting:
            return
        yield _furnish(waiting, rng, f"{name}-{number:02d}")


def _furnish(waiting: deque[Model], rng: np.random.Generator, name: str) -> Scene:
    """Take from the waiting meshes what the room holds; each mesh at most once."""
    height = rng.uniform(2.55, 3.2)
    room = _Room(np.array([rng.uniform(4.0, 7.0), rng.uniform(3.8, 6.0)]), rng)
    wanted = int(rng.integers(6, 10))
    for _ in range(min(len(waiting), 3 * wanted)):
        model = waiting.popleft()
        full = len(room.pieces) >= wanted
        again = any(piece.name == f"{model.kind}/{model.name}" for piece in room.pieces)
        if full or again or not _place(room, model, height):
            waiting.append(model)
    _clutter(room)
    return replace(_build(room, height, name), stations=_stations(room, height))


def _place(room: _Room, model: Model, height: float) -> bool:
    """Put a mesh where things of its kind are; False if there is no place left."""
    rng, size = room.rng, model.size
    on_table = model.kind in ("lamp", "cabinet") and size[2] < 0.7 and size[:2].max() < 0.56
    if on_table and rng.random() < 0.7:
        return _on_support(room, f"{model.kind}/{model.name}", model.mesh.turned(rng.uniform(0, 360)))
    foot = _usual_foot(model, rng)
    if foot + size[2] > height - 0.05:
        return False
    chance = 1.0 if foot > 0 else AT_WALL.get(model.kind, 0.3)
    at_wall = rng.random() < chance
    for _ in range(TRIES):
        angle, centre = _at_wall(room, size) if at_wall else (rng.uniform(0, 360), rng.uniform(0.3, room.size - 0.3))
        outline = translate(rotate(box(*(-size[:2] / 2), *(size[:2] / 2)), angle, (0, 0)), *centre)
        if room.fits(outline, foot, foot + size[2], rng.uniform(0.04, 0.3)):
            piece = plan.Piece(
                f"{model.kind}/{model.name}", model.mesh.moved([0, 0, foot]), (centre[0], centre[1]), angle
            )
            room.add(piece, outline)
            if model.kind in ("table", "desk"):
                room.supports.append(piece)
            return True
    return False


def _usual_foot(model: Model, rng: np.random.Generator) -> float:
    """Height of the foot of a thing over the floor."""
    high = model.size[2]
    if model.kind == "radiator":
        return float(rng.uniform(1.0, 1.3) if "heater" in model.name else rng.uniform(0.08, 0.2))
    if "pper" in model.name or "glassDoor" in model.name:
        return float(rng.uniform(1.3, 1.5))
    if "urinal" in model.name:
        return float(1.1 - high)
    if model.kind == "washbasin" and high < 0.6:
        return float(0.9 - high)
    if model.kind == "bookcase" and high < 0.8:
        return float(rng.choice([0.0, 1.1]))
    return 0.0


def _at_wall(room: _Room, size: F64) -> tuple[float, F64]:
    """Angle and place of something with its back to a wall, or nearly."""
    rng = room.rng
    angle = int(rng.integers(4)) * 90
    depth = size[1] / 2 + rng.choice([0.005, rng.uniform(0.0, 0.08)])
    length = room.size[0] if angle % 180 == 0 else room.size[1]
    along = rng.uniform(size[0] / 2, max(size[0] / 2 + 0.01, length - size[0] / 2))
    places = {
        0: (along, room.size[1] - depth),
        90: (depth, along),
        180: (along, depth),
        270: (room.size[0] - depth, along),
    }
    return float(angle), np.array(places[angle])


def _on_support(room: _Room, name: str, mesh: Mesh) -> bool:
    """Set something on a table; a plain one is put up if there is none."""
    if not room.supports and not _put_up_table(room):
        return False
    rng = room.rng
    for _ in range(TRIES):
        support = room.supports[int(rng.integers(len(room.supports)))]
        top = support.mesh.turned(support.angle_deg).moved([*support.place, 0.0])
        low, high = top.bounds
        place = rng.uniform(low[:2], high[:2])
        own = mesh.bounds[:, :2] + place
        level = _level(Caster(top), own)
        outline = box(*own[0], *own[1])
        highest = level + float(mesh.bounds[1, 2]) if level is not None else 0.0
        if level is not None and room.fits(outline, level + 0.001, highest, 0.03):
            room.add(plan.Piece(name, mesh.moved([0, 0, level]), (place[0], place[1])), outline)
            return True
    return False


def _put_up_table(room: _Room) -> bool:
    size = np.array([*room.rng.uniform([0.8, 0.5], [1.6, 0.9]), room.rng.uniform(0.42, 0.78)])
    mesh = furniture.table(*size)
    for _ in range(TRIES):
        angle, centre = _at_wall(room, size)
        outline = translate(rotate(box(*(-size[:2] / 2), *(size[:2] / 2)), angle, (0, 0)), *centre)
        if room.fits(outline, 0.0, size[2], 0.1):
            piece = plan.Piece("other/table", mesh, (centre[0], centre[1]), angle)
            room.add(piece, outline)
            room.supports.append(piece)
            return True
    return False


def _level(support: Caster, bounds: F64) -> float | None:
    """Height of a flat top under a rectangle, or None."""
    xs, ys = (np.linspace(bounds[0, k], bounds[1, k], 5) for k in (0, 1))
    plan_ = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
    start = 3.0
    drop = support.cast(np.column_stack([plan_, np.full(25, start)]), np.tile([0.0, 0.0, -1.0], (25, 1)))[0]
    heights = start - drop
    flat = np.isfinite(heights).all() and np.ptp(heights) < 0.01 and heights.min() > 0.3
    return float(heights.max()) if flat else None


def _clutter(room: _Room) -> None:
    """Add furniture that nobody asks for, and boxes and round things on the floor and on tables."""
    rng = room.rng
    others = (
        Model("other", "shelf", furniture.shelf(rng.uniform(0.6, 1.2), 0.3, rng.uniform(0.9, 2.0))),
        Model("other", "cabinet", furniture.cabinet(rng.uniform(0.4, 1.0), 0.45, rng.uniform(0.6, 1.1))),
    )
    for model in others:
        if rng.random() < 0.6:
            _place(room, model, 2.5)
    for number in range(int(rng.integers(4, 10))):
        width, depth = rng.uniform(0.06, 0.35, 2)
        high = rng.uniform(0.04, 0.4)
        thing = (
            cylinder((0.0, 0.0), width / 2, 0.0, high) if number % 3 == 0 else block((0, 0), (width, depth), 0, high)
        )
        thing = thing.turned(rng.uniform(0, 90))
        if number % 2 and room.supports:
            _on_support(room, "clutter/thing", thing)
            continue
        for _ in range(TRIES):
            place = rng.uniform(0.2, room.size - 0.2)
            outline = box(*(thing.bounds[0, :2] + place), *(thing.bounds[1, :2] + place))
            near = any(outline.distance(other) < 0.25 for other, low, _ in room.taken if low < 0.3)
            if near and room.fits(outline, 0.0, high, rng.uniform(0.01, 0.15)):
                room.add(plan.Piece("clutter/thing", thing, (place[0], place[1])), outline)
                break


def _stations(room: _Room, height: float) -> F64:
    """One to three free places for the scanner, apart from one another."""
    rng = room.rng
    merged = [piece.mesh.turned(piece.angle_deg).moved([*piece.place, 0.0]) for piece in room.pieces]
    casters = [Caster(mesh) for mesh in merged]
    wanted = int(rng.choice([1, 2, 3], p=[0.35, 0.4, 0.25]))
    chosen: list[F64] = []
    for _ in range(2000):
        place = np.array([*rng.uniform(0.6, room.size - 0.6), rng.uniform(1.3, 1.8)])
        legs = np.column_stack([np.tile(place[:2], (4, 1)), np.linspace(0.2, place[2], 4)])
        free = all(caster.distance(legs).min() > 0.35 for caster in casters)
        apart = all(np.hypot(*(place - other)[:2]) > 1.5 for other in chosen)
        if free and apart:
            chosen.append(place)
        if len(chosen) == wanted:
            break
    return np.array(chosen) if chosen else np.array([[*(room.size / 2), height - 0.4]])


def _build(room: _Room, height: float, name: str) -> Scene:
    """Build walls with a closed door and a window, floor and ceiling around the furniture."""
    x, y = map(float, room.size)
    half = WALL_M / 2
    door_x, window_y = room.rng.uniform(0.9, x - 0.9) - half, room.rng.uniform(1.0, y - 1.0) - half
    holes = (
        plan.Hole("door", (None, "Room"), (float(door_x), -half), 0.9, 2.05, leaf=plan.Leaf()),
        plan.Hole("window", (None, "Room"), (x + half, float(window_y)), 1.2, 1.2, sill=0.9),
    )
    space = plan.Space("Room", plan.rectangle(0.0, x, 0.0, y), tuple(room.pieces))
    level = plan.Level("Floor", 0.0, float(height), (space,), holes)
    footprint = plan.rectangle(-WALL_M, x + WALL_M, -WALL_M, y + WALL_M)
    return build(plan.Plan(name, footprint, (level,), garden=0.0))
