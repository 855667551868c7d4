"""What is to be seen outside a generated building: other houses, trees, a balcony; and where to scan from there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from shapely import Polygon

from .doors import Spot
from .fittings import tree
from .layouts import Generator
from .solids import F64, Mesh, block, box, merge

GARDEN_M = 14.0
_BALCONY_M = (3.2, 1.3)
_PARAPET_M = (0.1, 0.95)
_CLEAR_M = 2.5


@dataclass(frozen=True, slots=True)
class Grounds:
    """Elevation of the ground, solids on it, and ``(x, y, z)`` scanner positions."""

    elevation: float
    solids: tuple[Mesh, ...]
    stations: tuple[tuple[float, float, float], ...]


def grounds_of(outline: Polygon, elevation: float, stations: int, random: Generator) -> Grounds:
    """Put a house and trees around a building, and so many scanner positions."""
    x0, y0, x1, y1 = outline.bounds
    places = [_beside(outline, 3.0 + float(random.uniform(0, 1)), random) for _ in range(stations)]
    gap, wide, deep = (float(random.uniform(*span)) for span in ((5.0, 9.0), (6.0, 14.0), (5.0, 9.0)))
    near = float(random.uniform(x0, x1))
    house = _house((near, y1 + gap + deep / 2), (wide, deep), elevation, float(random.uniform(5.0, 9.0)))
    trees: list[Mesh] = []
    while len(trees) < 3 + int(random.integers(4)):
        foot = np.array([random.uniform(x0 - GARDEN_M, x1 + GARDEN_M), random.uniform(y0 - GARDEN_M, y1 + gap - 1)])
        far = shapely.Point(foot).distance(outline) > 3.0
        if far and all(np.linalg.norm(foot - place) > _CLEAR_M + 1 for place in places):
            grown = tree(float(random.uniform(3.5, 8.0)), float(random.uniform(1.0, 2.2)))
            trees.append(grown.moved([*foot, elevation]))
    heights = tuple((float(p[0]), float(p[1]), elevation + 1.5) for p in places)
    return Grounds(elevation, (house, *trees), heights)


def _beside(outline: Polygon, distance: float, random: Generator) -> F64:
    """Return a place at a distance from the building."""
    ring = outline.buffer(distance).exterior
    place = ring.interpolate(float(random.random()), normalized=True)
    return np.array([place.x, place.y])


def _house(centre: tuple[float, float], size: tuple[float, float], bottom: float, height: float) -> Mesh:
    """Return a house with windows that stand out a little."""
    body = block(centre, size, bottom, bottom + height)
    front = centre[1] - size[1] / 2
    xs = np.arange(centre[0] - size[0] / 2 + 1.0, centre[0] + size[0] / 2 - 1.0, 2.2)
    frames = [box([x, front - 0.12, z], [x + 1.1, front, z + 1.4]) for x in xs for z in (bottom + 1.0, bottom + 3.8)]
    return merge([body, *frames])


def balcony(spot: Spot, floor: float) -> list[Mesh]:
    """Return a balcony before a door: its slab and its parapets."""
    away = spot.wall.across
    turn = float(np.degrees(np.arctan2(away[1], away[0])))
    face = np.array(spot.place) + away * spot.wall.gap / 2
    (wide, deep), (thick, high) = _BALCONY_M, _PARAPET_M
    slab = box([0.0, -wide / 2, -0.2], [deep, wide / 2, 0.0])
    parapets = [
        box([deep - thick, -wide / 2, 0.0], [deep, wide / 2, high]),
        box([0.0, -wide / 2, 0.0], [deep - thick, -wide / 2 + thick, high]),
        box([0.0, wide / 2 - thick, 0.0], [deep - thick, wide / 2, high]),
    ]
    return [mesh.turned(turn).moved([*face, floor]) for mesh in (slab, *parapets)]
