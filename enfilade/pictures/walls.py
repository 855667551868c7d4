"""Walls as poché: what lies between the faces of rooms, and around them as thick as reveals show it to be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from shapely import (
    LineString,
    MultiLineString,
    MultiPolygon,
    Polygon,
    get_coordinates,
    get_parts,
    line_merge,
    segmentize,
    union_all,
)
from shapely.geometry.base import BaseGeometry

from .scene import PlannedOpening, PlannedRoom, PlanScene

F64 = NDArray[np.float64]

USUAL_THICKNESS_M: Final = 0.30
"""Of outer walls of which nothing shows the thickness."""
THICKEST_WALL_M: Final = 0.70
_SHAFT_M2: Final = 1.5
"""Columns and shafts up to this size, enclosed by rooms, are solid."""
_COURT_M2: Final = 15.0
"""What rooms enclose is a court from this size on; smaller, a room that no scan saw, behind usual partitions."""
_PARTITION_M: Final = 0.12
_STRAIGHT_M: Final = 0.015
_NOTCH_M: Final = 1.0
_LEAST_NOTCH_M2: Final = 0.25
_LEAST_SOLID_M2: Final = 0.02
_REACH_M: Final = 1.0
_LEAST_DEPTH_M: Final = 0.04
_SEEN_M: Final = 0.25
_STEP_M: Final = 0.10
_LEAST_UNSEEN_M: Final = 0.40
_MITRE: Final = 3.0
_USUAL_INNER_M: Final = 0.25
_DOORSTEP_M: Final = 0.35
_OVER_M: Final = 0.02
_UNDER_M: Final = 0.03
"""Measured flights reach no closer to walls than so."""


@dataclass(frozen=True, slots=True)
class Gap:
    """Where an opening passes through its wall.

    Attributes
    ----------
    opening
        The opening.
    near, far
        Its two faces, metres along `PlannedOpening.across` from its centre, ``near < far``.
    inward
        Sides, +1 along `across` or -1, by key of each room on this storey.
    """

    opening: PlannedOpening
    near: float
    far: float
    inward: dict[str, int]

    def face(self, side: int) -> float:
        """Offset of the face on a side."""
        return self.far if side > 0 else self.near

    def corners(self, near: float, far: float) -> F64:
        """``(4, 2)`` corners of the opening between two offsets."""
        (a, b), across = self.opening.ends, self.opening.across
        return np.array([a + near * across, b + near * across, b + far * across, a + far * across])


@dataclass(frozen=True, slots=True)
class Walls:
    """The walls of a storey.

    Attributes
    ----------
    solid
        What is cut through.
    unseen
        Where rooms end and no wall was seen.
    """

    solid: MultiPolygon
    unseen: MultiLineString


def gap(scene: PlanScene, opening: PlannedOpening, outer_m: float) -> Gap:
    """Return where an opening begins and ends, from the outlines of its rooms; `outer_m` thick to the outside."""
    found = {key: _face(scene.rooms[key], opening) for key in opening.rooms if key in scene.rooms}
    faces = {key: face for key, face in found.items() if face is not None}
    inward = {key: side for key, (_, side) in faces.items()}
    offsets = [offset for offset, _ in faces.values()]
    if len(opening.rooms) == 1 and len(offsets) == 1:
        offset, side = next(iter(faces.values()))
        offsets.append(offset - side * outer_m)
    near, far = (min(offsets), max(offsets)) if len(offsets) == 2 else (-outer_m / 2, outer_m / 2)
    if len(set(inward.values())) < len(inward):
        inward = dict(zip(inward, (-1, 1), strict=False))
    if far - near < _LEAST_DEPTH_M or far - near > 1.5 * THICKEST_WALL_M:
        middle = (near + far) / 2 if far - near < _LEAST_DEPTH_M else 0.0
        near, far = middle - _LEAST_DEPTH_M, middle + _LEAST_DEPTH_M
    return Gap(opening, near, far, inward)


def _face(room: PlannedRoom, opening: PlannedOpening) -> tuple[float, int] | None:
    """Offset of a room's face at an opening, and on which side of it the room lies; None where it is not near."""
    across = opening.across * _REACH_M
    line = LineString([opening.position - across, opening.position + across])
    inside = [part for part in get_parts(line.intersection(room.polygon)) if isinstance(part, LineString)]
    offsets = [(get_coordinates(part) - opening.position) @ opening.across for part in inside if not part.is_empty]
    stretches = [(float(given.min()), float(given.max())) for given in offsets]
    if not stretches:
        return None
    low, high = min(stretches, key=lambda ends: min(abs(ends[0]), abs(ends[1])))
    # The end at the wall is the one that is not where the line was cut off; of two such the nearer.
    side = 1 if abs(low) < abs(high) else -1
    return (low, 1) if side > 0 else (high, -1)


def build_walls(
    scene: PlanScene,
    gaps: Sequence[Gap],
    outer_m: float,
    wall_points: F64 | None,
    walked: Sequence[Polygon] = (),
) -> Walls:
    """Fill the walls of a storey and cut its openings out.

    Parameters
    ----------
    scene
        The storey; rooms without outline have no walls.
    gaps
        Its openings in walls.
    outer_m
        Thickness of outer walls.
    wall_points
        ``(n, 2)`` points of walls on the page; where there are none along an outer edge, the wall was not seen. With
        None all are taken as seen.
    walked
        Flights of stairs from this storey up, which belong to the rooms whatever their outlines say.
    """
    shapes = [room.polygon for room in scene.rooms.values() if room.outlined]
    if not shapes:
        return Walls(MultiPolygon(), MultiLineString())
    rooms = union_all([*shapes, *(flight.buffer(-_UNDER_M, join_style="mitre") for flight in walked)], grid_size=1e-4)
    house = _without_small_holes(_closed(rooms, THICKEST_WALL_M / 2))
    solid = _outside(house, outer_m).difference(union_all([rooms, _enclosed(house, outer_m)]))
    unseen = MultiLineString()
    if wall_points is not None:
        unseen, seen = _sighted(rooms, gaps, wall_points)
        solid = solid.difference(_beside(unseen, outer_m).difference(_beside(seen, max(outer_m, _USUAL_INNER_M))))
    if gaps:
        solid = solid.difference(union_all([_way_through(one) for one in gaps], grid_size=1e-4))
    return Walls(_polygons_of(solid), unseen)


def _beside(lines: MultiLineString, depth_m: float) -> BaseGeometry:
    """Return what lies beside lines, as far as a wall is thick."""
    if lines.is_empty:
        return Polygon()
    return lines.buffer(1.02 * depth_m, cap_style="flat", join_style="mitre", mitre_limit=_MITRE)


def _way_through(one: Gap) -> Polygon:
    """Return what an opening takes out of walls; before a door the way is free too, whatever the outlines say."""
    ahead = _DOORSTEP_M if one.opening.kind != "window" else _OVER_M
    return Polygon(one.corners(one.near - ahead, one.far + ahead))


def _closed(shape: BaseGeometry, reach_m: float) -> BaseGeometry:
    """Fill what is narrower than twice the reach."""
    grown = shape.buffer(reach_m, join_style="mitre", mitre_limit=_MITRE)
    shrunk = grown.buffer(-reach_m, join_style="mitre", mitre_limit=_MITRE)
    return union_all([shrunk, shape])


def _without_small_holes(shape: BaseGeometry) -> BaseGeometry:
    """Fill enclosed columns and shafts; a court stays open."""
    filled = [
        Polygon(part.exterior, [ring for ring in part.interiors if Polygon(ring).area > _SHAFT_M2])
        for part in get_parts(shape)
        if isinstance(part, Polygon)
    ]
    return union_all(filled)


def _outside(house: BaseGeometry, outer_m: float) -> BaseGeometry:
    """Return the house with its outer walls, courts filled, small notches in its outer faces too."""
    # Of a corner that a tiny edge cuts off the mitre would be cut off as well.
    shells = union_all([Polygon(part.exterior) for part in _polygons_of(house).geoms]).simplify(_STRAIGHT_M)
    walls = shells.buffer(outer_m, join_style="mitre", mitre_limit=_MITRE)
    notches = get_parts(_closed(walls, _NOTCH_M / 2).difference(walls))
    return union_all([walls, *(notch for notch in notches if notch.area <= _LEAST_NOTCH_M2)])


def _enclosed(house: BaseGeometry, outer_m: float) -> BaseGeometry:
    """Return what lies behind walls within the house: courts, and rooms that no scan saw."""
    holes = [Polygon(ring) for part in _polygons_of(house).geoms for ring in part.interiors]
    return union_all(
        [
            hole.buffer(-outer_m if hole.area >= _COURT_M2 else -_PARTITION_M, join_style="mitre", mitre_limit=_MITRE)
            for hole in holes
        ]
    )


def _polygons_of(shape: BaseGeometry) -> MultiPolygon:
    parts = (part for part in get_parts(shape) if isinstance(part, Polygon))
    return MultiPolygon([part for part in parts if part.area > _LEAST_SOLID_M2])


def _sighted(rooms: BaseGeometry, gaps: Sequence[Gap], wall_points: F64) -> tuple[MultiLineString, MultiLineString]:
    """Stretches of the rooms' edges that have neither points of a wall nor an opening beside them, and the others."""
    rings = [ring for part in get_parts(rooms) for ring in (part.exterior, *part.interiors)]
    missing_runs: list[LineString] = []
    seen_runs: list[LineString] = []
    tree = cKDTree(wall_points) if len(wall_points) else None
    for ring in rings:
        corners = get_coordinates(segmentize(ring, _STEP_M))
        middles = (corners[:-1] + corners[1:]) / 2
        far = np.ones(len(middles), bool)
        if tree is not None:
            far = ~np.isfinite(tree.query(middles, distance_upper_bound=_SEEN_M)[0])
        missing_runs += _runs(corners, far)
        seen_runs += _runs(corners, ~far)
    openings = [LineString(one.opening.ends).buffer(THICKEST_WALL_M, cap_style="flat") for one in gaps]
    left = union_all(missing_runs).difference(union_all(openings)) if openings else union_all(missing_runs)
    unseen = [line for line in get_parts(line_merge(left)) if line.length >= _LEAST_UNSEEN_M]
    return MultiLineString(unseen), MultiLineString(seen_runs)


def _runs(corners: F64, missing: NDArray[np.bool_]) -> list[LineString]:
    """Join consecutive missing steps of a ring to lines."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], missing, [False]]).astype(np.int8)))
    return [LineString(corners[a : b + 1]) for a, b in zip(edges[::2], edges[1::2], strict=True)]
