"""Rooms from spaces: those without a wall between them together, measured where the model's surfaces are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from .casting import Caster
from .polygons import extrude, largest_polygon, plan_samples
from .scene import Room, Storey, places_of
from .solids import F64, Mesh, merge
from .spaces import Border, Space, borders_of, sound_spaces, space_of, unite

_LOOK_HEIGHT_M = 0.8
_LEVEL_TOLERANCE_M = 0.6
_TOUCHING_M = 0.05
_SHORT_M = 0.8


@dataclass(frozen=True, slots=True)
class Units:
    """Rooms, their storeys, and the spaces they are made of.

    `unit` is ``(spaces,) int32``, the room of each space; `borders` are between spaces.
    """

    rooms: tuple[Room, ...]
    storeys: tuple[Storey, ...]
    spaces: tuple[Space, ...]
    borders: tuple[Border, ...]
    unit: NDArray[np.int32]


def units_of(bodies: Sequence[tuple[str, Mesh]], levels: Sequence[tuple[float, str]], walls: Caster) -> Units:
    """Make rooms of spaces.

    Parameters
    ----------
    bodies
        Name and closed mesh of each space.
    levels
        Elevation and name of each storey of the model, from the lowest.
    walls
        Everything that parts rooms: walls, slabs, window panes; no door leaves, stairs, furniture.
    """
    found = [space for name, mesh in bodies if (space := space_of(name, mesh)) is not None]
    spaces = sound_spaces(found, [z for z, _ in levels], walls)
    borders = borders_of(spaces, walls)
    unit = unite(spaces, borders)
    members = [[spaces[k] for k in places] for places in places_of(unit, unit.max(initial=-1) + 1)]
    floors = [_floor(group, walls) for group in members]
    storeys, storey = _storeys(floors, levels)
    gap = max((float(b.gap.max()) for b in borders if b.wall_less), default=0.0)
    rooms = tuple(
        _room(number, int(storey[number]), group, floors[number], gap, walls) for number, group in enumerate(members)
    )
    return Units(rooms, storeys, tuple(spaces), tuple(borders), unit)


def _room(number: int, storey: int, group: Sequence[Space], floor: float, gap: float, walls: Caster) -> Room:
    polygon = _united([space.polygon for space in group], gap)
    rings = (polygon.exterior, *polygon.interiors)
    return Room(
        number,
        storey,
        " + ".join(dict.fromkeys(space.name for space in group)),
        tuple(np.array(ring.coords)[:-1, :2] for ring in rings),
        merge(mesh for space in group for mesh in _bodies(space, walls)),
        floor,
        _level(group, walls, 1.0, max(space.top for space in group)),
    )


def _bodies(space: Space, walls: Caster) -> list[Mesh]:
    """Return a space's body, and what lies between it and the slabs where the model has drawn it too low."""
    floor, ceiling = _floor([space], walls), _level([space], walls, 1.0, space.top)
    low, high = space.bottom - floor, ceiling - space.top
    if max(low, high) < _TOUCHING_M or max(low, high) > _SHORT_M:
        return [space.boundary]
    return [space.boundary, extrude(space.polygon, min(space.bottom, floor), max(space.top, ceiling))]


def _united(polygons: Sequence[Polygon], gap: float) -> Polygon:
    if len(polygons) == 1:
        return polygons[0]
    reach = gap / 2 + 0.02
    wide = shapely.union_all(shapely.buffer(np.array(polygons), reach, join_style="mitre"))
    return largest_polygon(shapely.buffer(wide, -reach, join_style="mitre"))


def _floor(group: Sequence[Space], walls: Caster) -> float:
    return _level(group, walls, -1.0, min(space.bottom for space in group))


def _level(group: Sequence[Space], walls: Caster, direction: float, otherwise: float) -> float:
    """Median height of what lies above (1) or below (-1) the spaces; `otherwise` where nothing does."""
    looks = np.concatenate([plan_samples(space.polygon, space.bottom + _LOOK_HEIGHT_M) for space in group])
    ranges, _ = walls.cast(looks, np.tile([0.0, 0.0, direction], (len(looks), 1)))
    hit = np.isfinite(ranges) & (ranges < 20.0)
    heights: F64 = looks[hit, 2] + direction * ranges[hit]
    return float(np.median(heights)) if hit.any() else otherwise


def _storeys(
    floors: Sequence[float], levels: Sequence[tuple[float, str]]
) -> tuple[tuple[Storey, ...], NDArray[np.int64]]:
    """Storeys that have rooms, at the median level of their floors; and the storey of each room."""
    elevations = np.array([z for z, _ in levels] or [0.0])
    place = np.searchsorted(elevations, np.array(floors) + _LEVEL_TOLERANCE_M, side="right") - 1
    used, storey = np.unique(np.maximum(place, 0), return_inverse=True)
    names = [name for _, name in levels] or [""]
    heights = [float(np.median(np.array(floors)[members])) for members in places_of(storey, len(used))]
    return tuple(Storey(k, heights[k], names[u] or f"Storey {k}") for k, u in enumerate(used)), storey
