"""Spaces of a plan that neither a wall nor a lintel parts are one room, as those of a building model are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import shapely
from shapely import Polygon

from .linking import stretches
from .plan import Hole, Level, Plan, Space
from .polygons import polygon_of
from .spaces import WALL_LESS_M, WALL_LESS_SHARE
from .tunnels import tunnel_of

_GRID_M = 1e-4


def joined(plan: Plan) -> Plan:
    """Make one space of those that a wide passage joins, or one that takes more than half of the wall between them.

    They must have floor and roof in common: a space has one of each.
    """
    name_of = {space.name: space.name for level in plan.levels for space in level.spaces}
    for first, second in (hole.rooms for level in plan.levels for hole in level.holes if _joins(hole, level)):
        both = name_of[str(first)], name_of[str(second)]
        name_of |= {name: " + ".join(dict.fromkeys(both)) for name, now in name_of.items() if now in both}
    return replace(
        plan,
        levels=tuple(_level_joined(level, plan, name_of) for level in plan.levels),
        stairs=tuple(replace(s, rooms=(name_of[s.rooms[0]], name_of[s.rooms[1]])) for s in plan.stairs),
    )


def open_share(hole: Hole, spaces: Sequence[Space]) -> float:
    """Share that a hole takes of the wall between its two spaces, at most 1."""
    first, second = (space.polygon for name in hole.rooms for space in spaces if space.name == name)
    others = [space.polygon for space in spaces if space.name not in hole.rooms]
    length = max(sum(s.length for s in stretches(a, b, others)) for a, b in ((first, second), (second, first)))
    return min(hole.width / length, 1.0) if length > 0.0 else 1.0


def _joins(hole: Hole, level: Level) -> bool:
    if hole.kind != "passage" or None in hole.rooms:
        return False
    first, second = (space for name in hole.rooms for space in level.spaces if space.name == name)
    alike = (first.floor, first.roof) == (second.floor, second.roof)
    return alike and (hole.width >= WALL_LESS_M or open_share(hole, level.spaces) > WALL_LESS_SHARE)


def _level_joined(level: Level, plan: Plan, name_of: dict[str, str]) -> Level:
    members: dict[str, list[Space]] = {}
    for space in level.spaces:
        members.setdefault(name_of[space.name], []).append(space)
    gone = [hole for hole in level.holes if _joins(hole, level)]
    spaces = []
    for name, group in members.items():
        gaps = [_gap(hole, level, plan) for hole in gone if name_of[str(hole.rooms[0])] == name]
        spaces.append(_united(name, group, gaps))
    holes = [replace(hole, rooms=_named(hole, name_of)) for hole in level.holes if hole not in gone]
    return replace(level, spaces=tuple(spaces), holes=tuple(holes))


def _named(hole: Hole, name_of: dict[str, str]) -> tuple[str | None, str | None]:
    first, second = (None if name is None else name_of[name] for name in hole.rooms)
    return first, second


def _gap(hole: Hole, level: Level, plan: Plan) -> Polygon:
    """Return what a passage takes of its wall, in plan."""
    footprint = plan.footprint if level.footprint is None else level.footprint
    return tunnel_of(hole, {space.name: space.polygon for space in level.spaces}, footprint, level.floor).plan


def _united(name: str, spaces: Sequence[Space], gaps: Sequence[Polygon]) -> Space:
    """Return one space of several and of the gaps between them."""
    if len(spaces) == 1:
        return spaces[0]
    wide = [gap.buffer(_GRID_M, join_style="mitre") for gap in gaps]
    return replace(
        spaces[0],
        name=name,
        polygon=polygon_of(shapely.union_all([*(space.polygon for space in spaces), *wide], grid_size=_GRID_M)),
        pieces=tuple(piece for space in spaces for piece in space.pieces),
        mirrors=tuple(mirror for space in spaces for mirror in space.mirrors),
        fixtures=tuple(fixture for space in spaces for fixture in space.fixtures),
        scanned=any(space.scanned for space in spaces),
    )
