"""Makes the scene of a plan: surfaces around spaces, walls outside, holes through walls, stairs, furniture."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from . import scene as scenes
from .joining import joined
from .plan import Hole, Level, Mirror, Piece, Plan, Space, Stairs
from .roofs import Roof
from .shells import Cut, above, level, shell, sides
from .solids import Mesh, box, merge
from .steps import stairs_mesh, stairs_opening
from .tunnels import Tunnel, glazing, leaf_of, lining, reveal, tunnel_of

_GROUND_BELOW_FLOOR_M = 0.2
_MIRROR_M = 0.01


def build(plan: Plan) -> scenes.Scene:
    """Make the scene of a plan; spaces that no wall and no lintel parts are one room in it.

    Raises
    ------
    InputError
        If a hole does not lead from the one of its rooms to the other.
    """
    return _Builder(joined(plan)).scene()


class _Builder:
    """A plan with what has been made of it so far."""

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._parts = scenes.SceneParts()
        self._placed = [(storey, level, space) for storey, level in enumerate(plan.levels) for space in level.spaces]
        self._number = {space.name: k for k, (_, _, space) in enumerate(self._placed)}
        self._floor = {space.name: _floor(level, space) for _, level, space in self._placed}
        self._roof = {space.name: _roof(level, space) for _, level, space in self._placed}
        self._polygon = {space.name: space.polygon for _, _, space in self._placed}
        self._cuts: dict[str | None, list[Cut]] = defaultdict(list)
        self._floor_holes: dict[str, list[Polygon]] = defaultdict(list)
        self._ceiling_holes: dict[str, list[Polygon]] = defaultdict(list)
        self._openings: list[scenes.Opening] = []
        self._furnishings: list[scenes.Furnishing] = []

    def scene(self) -> scenes.Scene:
        """Put everything together."""
        for k, storey in enumerate(self._plan.levels):
            for hole in storey.holes:
                self._add_hole(k, storey, hole)
        for stairs in self._plan.stairs:
            self._add_stairs(stairs)
        for _, _, space in self._placed:
            self._add_space(space)
            self._add_pieces(space)
        self._add_outside()
        storeys = tuple(scenes.Storey(i, level.floor, level.name) for i, level in enumerate(self._plan.levels))
        outdoors = np.array(self._plan.outdoor_stations, dtype=np.float64).reshape(-1, 3)
        return scenes.Scene(
            self._plan.name,
            *self._parts.arrays(),
            storeys,
            self._rooms(),
            tuple(self._openings),
            tuple(self._furnishings),
            outdoors=outdoors,
        )

    def _rooms(self) -> tuple[scenes.Room, ...]:
        return tuple(self._room(k, storey, space) for k, (storey, _, space) in enumerate(self._placed))

    def _room(self, number: int, storey: int, space: Space) -> scenes.Room:
        floor, roof = self._floor[space.name], self._roof[space.name]
        outline = shapely.orient_polygons(space.polygon)
        return scenes.Room(
            number,
            storey,
            space.name,
            tuple(np.array(ring.coords)[:-1, :2] for ring in (outline.exterior, *outline.interiors)),
            shell(space.polygon, floor, roof),
            floor,
            roof.median_height(space.polygon),
            space.scanned,
        )

    def _add_hole(self, storey: int, level: Level, hole: Hole) -> None:
        floor = max([self._floor[name] for name in hole.rooms if name is not None], default=level.floor)
        middle = floor + hole.sill + hole.height / 2
        near = {
            name: polygon
            for name, polygon in self._polygon.items()
            if self._floor[name] < middle < self._roof[name].ceiling
        }
        tunnel = tunnel_of(hole, near, self._footprint(storey), floor)
        beside = [self._footprint(storey).exterior if name is None else near[name].boundary for name in hole.rooms]
        self._parts.add_structure(reveal(tunnel, shapely.union_all(beside)))
        for name in hole.rooms:
            self._cuts[name].append(tunnel.cut)
        self._add_filling(tunnel)
        self._openings.append(self._opening(tunnel))

    def _add_filling(self, tunnel: Tunnel) -> None:
        hole = tunnel.hole
        if hole.lining > 0:
            self._parts.add_structure(lining(tunnel))
        if hole.kind == "window" and not hole.glazed:
            return
        made = glazing(tunnel) if hole.kind == "window" else leaf_of(tunnel, hole.leaf) if hole.leaf else None
        if made is None:
            return
        self._parts.add_structure(made[0])
        if len(made[1].triangles):
            self._parts.add_glass(made[1])

    def _opening(self, tunnel: Tunnel) -> scenes.Opening:
        hole = tunnel.hole
        first, second = (scenes.OUTSIDE if name is None else self._number[name] for name in hole.rooms)
        return scenes.Opening(
            hole.kind,
            hole.state,
            tunnel.middle,
            tunnel.axis,
            tunnel.normal,
            hole.width,
            hole.height,
            tunnel.depth,
            hole.sill,
            (first, second),
        )

    def _add_stairs(self, stairs: Stairs) -> None:
        lower, upper = stairs.rooms
        slab = self._roof[lower].ceiling, self._floor[upper]
        self._ceiling_holes[lower].append(stairs.well)
        self._floor_holes[upper].append(stairs.well)
        for mesh in (*sides(stairs.well, slab[0], Roof(slab[1])), *stairs_mesh(stairs)):
            self._parts.add_structure(mesh)
        self._openings.append(stairs_opening(stairs, (self._number[lower], self._number[upper]), slab))

    def _add_space(self, space: Space) -> None:
        name, polygon = space.name, space.polygon
        ground = polygon.difference(shapely.union_all(self._floor_holes[name]))
        top = polygon.difference(shapely.union_all(self._ceiling_holes[name]))
        around = sides(polygon, self._floor[name], self._roof[name], self._cuts[name])
        self._parts.add_structure(
            merge([level(ground, self._floor[name], up=True), *above(top, self._roof[name]), *around])
        )
        for fixture in space.fixtures:
            self._parts.add_structure(fixture)
        for mirror in space.mirrors:
            self._parts.add_mirror(_mirror(mirror, self._floor[name]))

    def _add_pieces(self, space: Space) -> None:
        for piece in space.pieces:
            number = len(self._furnishings)
            self._parts.add_furnishing(_placed_piece(piece, self._floor[space.name]), number)
            self._furnishings.append(scenes.Furnishing(number, self._number[space.name], piece.name))

    def _footprint(self, storey: int) -> Polygon:
        own = self._plan.levels[storey].footprint
        return self._plan.footprint if own is None else own

    def _add_outside(self) -> None:
        levels, slab = self._plan.levels, self._plan.slab_thickness
        lowest = [min([lv.floor, *(self._floor[s.name] for s in lv.spaces)]) - slab for lv in levels]
        bottoms = [lowest[0], *(lv.ceiling for lv in levels[:-1])]
        outlines = [self._footprint(k) for k in range(len(levels))]
        roofs = [Roof(below) for below in bottoms[1:]] + [self._outer_roof(levels[-1])]
        for outline, bottom, roof in zip(outlines, bottoms, roofs, strict=True):
            self._parts.add_structure(merge(sides(outline, bottom, roof, self._cuts[None])))
        self._parts.add_structure(merge([level(outlines[0], bottoms[0], up=False), *above(outlines[-1], roofs[-1])]))
        for below, over, z in zip(outlines, outlines[1:], bottoms[1:], strict=False):
            self._add_level(below.difference(over), z, up=True)
            self._add_level(over.difference(below), z, up=False)
        self._add_garden(outlines[0])

    def _outer_roof(self, top: Level) -> Roof:
        slopes = {slope for space in top.spaces if space.roof is not None for slope in space.roof.slopes}
        return Roof(top.ceiling, tuple(sorted(slopes))).raised(self._plan.slab_thickness)

    def _add_level(self, area: BaseGeometry, z: float, *, up: bool) -> None:
        if area.area > 1e-6:
            self._parts.add_structure(level(area, z, up=up))

    def _add_garden(self, outline: Polygon) -> None:
        plan = self._plan
        if plan.garden > 0:
            z = plan.levels[0].floor - _GROUND_BELOW_FLOOR_M if plan.ground is None else plan.ground
            around = shapely.box(*outline.buffer(plan.garden, join_style="mitre").bounds)
            self._add_level(around.difference(outline), z, up=True)
        for mesh in plan.surroundings:
            self._parts.add_structure(mesh)


def _floor(level: Level, space: Space) -> float:
    return level.floor if space.floor is None else space.floor


def _roof(level: Level, space: Space) -> Roof:
    return Roof(level.ceiling) if space.roof is None else space.roof


def _placed_piece(piece: Piece, floor: float) -> Mesh:
    return piece.mesh.turned(piece.angle_deg).moved([*piece.place, floor + piece.height])


def _mirror(mirror: Mirror, floor: float) -> Mesh:
    """Return a thin plate whose back is on the wall."""
    half, low = mirror.width / 2, floor + mirror.above_floor
    plate = box([0.0, -half, low], [_MIRROR_M, half, low + mirror.height])
    return plate.turned(mirror.facing_deg).moved([*mirror.place, 0.0])
