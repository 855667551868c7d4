"""Holes through walls: where the wall is, what lines the hole, and what hangs in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from enfilade.errors import InputError

from .plan import Hole, Leaf
from .roofs import Roof
from .shells import Cut, level, sides
from .solids import F64, Mesh, Rectangle, box, merge

LEAF_THICKNESS_M = 0.04
LEAF_INSET_M = 0.03
FRAME_M = 0.06
PANE_M = 0.006
_CASING_M = (0.07, 0.015)
"""Width and thickness of the boards around a lined door."""
_REACH_M = 1.5
_TOUCH_M = 1e-6


@dataclass(frozen=True, slots=True)
class Tunnel:
    """A hole as it goes through its wall.

    Attributes
    ----------
    hole
        What it is.
    plan
        What it takes of the wall, in plan, the lining included.
    middle
        ``(3,)`` centre of the clear hole.
    axis, normal
        ``(3,)`` unit vectors along the wall, and across it from the first room to the second.
    depth
        Thickness of the wall, metres.
    low, high
        Elevations between which the wall is cut.
    """

    hole: Hole
    plan: Polygon
    middle: F64
    axis: F64
    normal: F64
    depth: float
    low: float
    high: float

    @property
    def cut(self) -> Cut:
        """What it takes of the sides of the spaces beside."""
        return self.plan, self.low, self.high

    @property
    def clear(self) -> Rectangle:
        """The clear hole, metres along the axis from its middle, and absolute heights."""
        half = self.hole.width / 2
        return -half, half, self.low, self.low + self.hole.height

    def solid(self, u: tuple[float, float], v: tuple[float, float], z: tuple[float, float]) -> Mesh:
        """Return a box by its spans along the axis, along the normal and upwards."""
        made = box([u[0], v[0], 0.0], [u[1], v[1], z[1] - z[0]])
        return self._placed(made, z[0])

    def _placed(self, mesh: Mesh, z: float) -> Mesh:
        axes = np.stack([self.axis, self.normal, np.array([0.0, 0.0, 1.0])])
        return Mesh(mesh.vertices @ axes + np.array([*self.middle[:2], z]), mesh.triangles)

    def swung(self, leaf: Leaf, solid: Mesh, z: float) -> Mesh:
        """Return a leaf, made closed in (along, across from its face into the room, up), turned about its hinge."""
        side = 1.0 if leaf.into == 1 else -1.0
        hinge = np.array([leaf.hinge * self.hole.width / 2, 0.0, 0.0])
        turned = solid.moved(-hinge).turned(-leaf.hinge * leaf.angle_deg).moved(hinge)
        mirrored = Mesh(turned.vertices * [1.0, side, 1.0], turned.triangles[:, :: int(side)])
        face = side * self.depth / 2
        return self._placed(mirrored.moved([0.0, face, 0.0]), z)


def tunnel_of(hole: Hole, spaces: dict[str, Polygon], footprint: Polygon, floor: float) -> Tunnel:
    """Find the wall that a hole goes through.

    Parameters
    ----------
    hole
        The hole.
    spaces
        Plans of all spaces at its height, by name.
    footprint
        Outline of the building at its height.
    floor
        Elevation that its sill counts from.

    Raises
    ------
    InputError
        If it does not lead from the one room to the other.
    """
    direction = _wall_direction(hole, spaces, footprint)
    width = hole.width + 2 * hole.lining
    half = np.array([direction * width / 2, np.array([-direction[1], direction[0]]) * _REACH_M])
    around = Polygon([hole.place + half.T @ sign for sign in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
    mass = footprint.intersection(around).difference(shapely.union_all(list(spaces.values())))
    parts = [p for p in shapely.get_parts(mass) if isinstance(p, Polygon)]
    plan = min(parts, key=lambda part: part.distance(shapely.Point(hole.place)), default=Polygon())
    beside = [_beside(name, spaces, footprint) for name in hole.rooms]
    if plan.is_empty or any(_contact(plan, region) < 0.9 * width for region in beside):
        raise InputError(f"The {hole.kind} at {hole.place} does not lead from {hole.rooms[0]} to {hole.rooms[1]}")
    return _tunnel(hole, plan, direction, beside, floor)


def _tunnel(hole: Hole, plan: Polygon, direction: F64, beside: Sequence[BaseGeometry], floor: float) -> Tunnel:
    across = np.array([-direction[1], direction[0]])
    offsets = (shapely.get_coordinates(plan) - hole.place) @ across
    contacts = [
        float(np.mean((shapely.get_coordinates(_contact_line(plan, region)) - hole.place) @ across))
        for region in beside
    ]
    if contacts[0] > contacts[1]:
        across, direction, offsets = -across, -direction, -offsets
    low = floor + hole.sill
    middle = np.array(hole.place) + across * (offsets.min() + offsets.max()) / 2
    return Tunnel(
        hole,
        plan,
        np.array([*middle, low + hole.height / 2]),
        np.array([*direction, 0.0]),
        np.array([*across, 0.0]),
        float(np.ptp(offsets)),
        low,
        low + hole.height + hole.lining,
    )


def _wall_direction(hole: Hole, spaces: dict[str, Polygon], footprint: Polygon) -> F64:
    """Return the unit vector along the side nearest to the hole: of the room with fewer corners, the straighter one."""
    polygons = [spaces[name] for name in hole.rooms if name is not None]
    polygon = min(polygons, key=lambda p: len(p.exterior.coords)) if polygons else footprint
    ends = np.concatenate([_edges(ring) for ring in (polygon.exterior, *polygon.interiors)])
    distance = shapely.distance(shapely.linestrings(ends), shapely.Point(hole.place))
    start, end = ends[int(np.argmin(distance))]
    unit: F64 = (end - start) / np.linalg.norm(end - start)
    return unit


def _edges(ring: BaseGeometry) -> F64:
    corners = shapely.get_coordinates(ring)
    return np.stack([corners[:-1], corners[1:]], axis=1)


def _beside(name: str | None, spaces: dict[str, Polygon], footprint: Polygon) -> BaseGeometry:
    return footprint.exterior if name is None else spaces[name].boundary


def _contact_line(plan: Polygon, region: BaseGeometry) -> BaseGeometry:
    return shapely.intersection(plan.exterior, shapely.buffer(region, _TOUCH_M))


def _contact(plan: Polygon, region: BaseGeometry) -> float:
    """Length of boundary that the hole shares with what is beside."""
    return float(_contact_line(plan, region).length)


def reveal(tunnel: Tunnel, beside: BaseGeometry) -> Mesh:
    """Return jambs, head and threshold; `beside` is the boundary of everything that the hole opens to."""
    roof = Roof(tunnel.high)
    jambs = sides(
        tunnel.plan, tunnel.low, roof, [(_contact_line(tunnel.plan, beside), tunnel.low - 1, tunnel.high + 1)]
    )
    return merge([*jambs, level(tunnel.plan, tunnel.low, up=True), level(tunnel.plan, tunnel.high, up=False)])


def lining(tunnel: Tunnel) -> Mesh:
    """Return the frame of a lined door, with the boards around it on both sides of the wall."""
    thickness, (u0, u1, z0, z1) = tunnel.hole.lining, tunnel.clear
    half = tunnel.depth / 2
    spans = [
        ((u0 - thickness, u0), (z0, z1 + thickness)),
        ((u1, u1 + thickness), (z0, z1 + thickness)),
        ((u0, u1), (z1, z1 + thickness)),
    ]
    inside = [tunnel.solid(u, (-half, half), z) for u, z in spans]
    wide, proud = _CASING_M
    boards = [((u0 - wide, u0), (z0, z1 + wide)), ((u1, u1 + wide), (z0, z1 + wide)), ((u0, u1), (z1, z1 + wide))]
    faces = [(-half - proud, -half), (half, half + proud)]
    return merge([*inside, *(tunnel.solid(u, v, z) for u, z in boards for v in faces)])


def leaf_of(tunnel: Tunnel, leaf: Leaf) -> tuple[Mesh, Mesh]:
    """Return what is solid and what is glass of a leaf; it hangs near the face of the room that it opens into."""
    u0, u1, z0, z1 = tunnel.clear
    inset = LEAF_INSET_M if leaf.angle_deg == 0 else 0.0
    across = (-inset - LEAF_THICKNESS_M, -inset)
    if not leaf.glass:
        return tunnel.swung(leaf, _board((u0, u1), across, z1 - z0), z0), merge([])
    inner = (u0 + FRAME_M, u1 - FRAME_M, FRAME_M, z1 - z0 - FRAME_M)
    frame = merge(_board(r[:2], across, r[3], r[2]) for r in _around((u0, u1, 0.0, z1 - z0), inner))
    middle = (across[0] + across[1]) / 2
    pane = _board(inner[:2], (middle - PANE_M / 2, middle + PANE_M / 2), inner[3], inner[2])
    return tunnel.swung(leaf, frame, z0), tunnel.swung(leaf, pane, z0)


def _board(u: tuple[float, float], v: tuple[float, float], top: float, bottom: float = 0.0) -> Mesh:
    return box([u[0], v[0], bottom], [u[1], v[1], top])


def glazing(tunnel: Tunnel) -> tuple[Mesh, Mesh]:
    """Return frame with mullions, and pane, of a window in the middle of its wall."""
    u0, u1, z0, z1 = tunnel.clear
    inner = (u0 + FRAME_M, u1 - FRAME_M, z0 + FRAME_M, z1 - FRAME_M)
    frame = _around(tunnel.clear, inner)
    for u in np.linspace(u0, u1, tunnel.hole.mullions + 2)[1:-1]:
        frame.append((u - FRAME_M / 2, u + FRAME_M / 2, inner[2], inner[3]))
    bars = merge(tunnel.solid(r[:2], (-FRAME_M / 2, FRAME_M / 2), r[2:]) for r in frame)
    return bars, tunnel.solid(inner[:2], (-PANE_M / 2, PANE_M / 2), inner[2:])


def _around(outer: Rectangle, inner: Rectangle) -> list[Rectangle]:
    u0, u1, z0, z1 = outer
    return [
        (u0, inner[0], z0, z1),
        (inner[1], u1, z0, z1),
        (inner[0], inner[1], z0, inner[2]),
        (inner[0], inner[1], inner[3], z1),
    ]
