"""Outlines of rooms drawn true to the straight faces of their walls, as found in plan."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString, Polygon

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]

_ASIDE_M: Final = 0.30
_SLANT_COS: Final = float(np.cos(np.radians(15)))
_CORNER_M: Final = (0.4, 1.0, 2.0)
"""So far from where two faces meet, edges that follow none are a corner cut off: if none, one or both of the faces
were seen up to the corner, so that only the outline misses it."""
_SEEN_M: Final = 0.25
_ALONG_M: Final = 0.25
"""So close to the two faces between which they lie, edges that follow none are furniture along the wall."""
_BUMP_M: Final = 0.45
"""So far from a face that goes on, edges that follow none are a bump."""
_SAME_LINE_M: Final = 0.08
_LEAST_EDGE_M: Final = 0.12
_PARALLEL_SIN: Final = float(np.sin(np.radians(20)))
_STRAIGHT_M: Final = 1e-4
_STRAY_M: Final = 1.5
_SPUR_M: Final = 0.40
"""Narrower parts of an outline are what was seen through a gap, no floor to stand on."""
_LEAST_SPUR_M2: Final = 0.01
_LEAST_LOBE_M2: Final = 0.5


@dataclass(frozen=True, slots=True)
class WallFaces:
    """The straight faces around one room.

    Attributes
    ----------
    centre, along
        ``(n, 2)`` a point on each line and its unit direction.
    span
        ``(n, 2)`` where it begins and ends, metres from the point.
    """

    centre: F64
    along: F64
    span: F64


def true_polygon(polygon: Polygon, faces: WallFaces) -> Polygon:
    """Draw a room's polygon along the faces of its walls; as it was where that would change its shape."""
    polygon = without_spurs(polygon)
    rings = [_true_ring(np.asarray(ring.coords)[:-1, :2], faces) for ring in (polygon.exterior, *polygon.interiors)]
    drawn = whole(Polygon(rings[0], rings[1:]))
    drawn = None if drawn is None else without_spurs(drawn)
    if drawn is None or abs(drawn.area - polygon.area) > 0.1 * polygon.area + 0.5:
        return polygon
    return drawn if drawn.hausdorff_distance(polygon) <= _STRAY_M else polygon


def without_spurs(polygon: Polygon) -> Polygon:
    """Cut off what is too narrow to be part of a room; a room that is narrow itself stays as it is."""
    half = _SPUR_M / 2
    broad = polygon.buffer(-half, join_style="mitre").buffer(half, join_style="mitre").intersection(polygon)
    parts = sorted(shapely.get_parts(broad), key=lambda part: float(part.area))
    if broad.is_empty or parts[-1].geom_type != "Polygon" or any(part.area > _LEAST_LOBE_M2 for part in parts[:-1]):
        return polygon
    return parts[-1] if polygon.area - parts[-1].area > _LEAST_SPUR_M2 else polygon


def whole(polygon: Polygon) -> Polygon | None:
    """Return a polygon that crosses itself as the largest of its parts; None where it has no area."""
    if polygon.is_valid:
        return polygon if polygon.area > 0 else None
    parts = [part for part in shapely.get_parts(shapely.make_valid(polygon)) if isinstance(part, Polygon)]
    return max(parts, key=lambda part: float(part.area), default=None)


def _true_ring(ring: F64, faces: WallFaces) -> F64:
    """Return the corners where the lines that a ring's edges follow meet."""
    starts, ends = ring, np.roll(ring, -1, axis=0)
    length = np.hypot(*(ends - starts).T)
    starts, ends, length = starts[length > 1e-6], ends[length > 1e-6], length[length > 1e-6]
    if len(starts) < 3:
        return ring
    face = _followed(starts, ends, length, faces)
    sides = _without_odd_runs(_sides(starts, ends, face), faces)
    if len(sides) < 3 or all(side.face < 0 for side in sides):
        return ring
    corners = [_corner(one, other, faces) for one, other in zip(sides, [*sides[1:], sides[0]], strict=True)]
    return _without_straight_corners(np.concatenate(corners))


def _without_straight_corners(ring: F64) -> F64:
    """Leave out corners on the line between those beside them."""
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    turn = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    bent = np.abs(turn) > _STRAIGHT_M * np.maximum(np.hypot(*(before + after).T), 1e-9)
    return ring[bent] if bent.sum() >= 3 else ring


@dataclass(frozen=True, slots=True)
class _Side:
    """A run of edges that follow one face, or one edge that follows none (-1)."""

    start: F64
    end: F64
    face: int

    def line(self, faces: WallFaces) -> tuple[F64, F64]:
        """Point and unit direction."""
        if self.face >= 0:
            along = faces.along[self.face]
            return faces.centre[self.face], along if along @ (self.end - self.start) >= 0 else -along
        way = self.end - self.start
        return self.start, way / max(float(np.hypot(*way)), 1e-9)

    @property
    def length(self) -> float:
        return float(np.hypot(*(self.end - self.start)))


def _followed(starts: F64, ends: F64, length: F64, faces: WallFaces) -> I64:
    """``(e,)`` face that each edge follows: nearly parallel, close by, beside it for a good part; -1 for none."""
    direction = (ends - starts) / length[:, None]
    across = np.column_stack([-faces.along[:, 1], faces.along[:, 0]])
    place = np.einsum("nd,nd->n", faces.centre, faces.along)
    a, b = starts @ faces.along.T - place, ends @ faces.along.T - place
    shared = np.minimum(np.maximum(a, b), faces.span[:, 1]) - np.maximum(np.minimum(a, b), faces.span[:, 0])
    aside = np.abs((starts + ends) / 2 @ across.T - np.einsum("nd,nd->n", faces.centre, across))
    fits = (np.abs(direction @ faces.along.T) > _SLANT_COS) & (aside < _ASIDE_M) & (shared > 0.3 * length[:, None])
    fits &= length[:, None] > _LEAST_EDGE_M
    worth = np.where(fits, shared - 2 * aside, -np.inf)
    best = np.argmax(worth, axis=1) if worth.shape[1] else np.zeros(len(starts), np.int64)
    return np.where(fits.any(axis=1), best, -1)


def _sides(starts: F64, ends: F64, face: I64) -> list[_Side]:
    """Join neighbouring edges that follow the same face, around the ring."""
    sides: list[_Side] = []
    for start, end, number in zip(starts, ends, face.tolist(), strict=True):
        if sides and number >= 0 and sides[-1].face == number:
            sides[-1] = _Side(sides[-1].start, end, number)
        else:
            sides.append(_Side(start, end, number))
    if len(sides) > 1 and sides[0].face >= 0 and sides[0].face == sides[-1].face:
        sides[0] = _Side(sides.pop().start, sides[0].end, sides[0].face)
    return sides


def _without_odd_runs(sides: list[_Side], faces: WallFaces) -> list[_Side]:
    """Leave out runs of edges that follow no face between two that meet or go on close by.

    Such a run is a corner that the raster cut off or furniture hid, or the outline's way into a doorway.
    """
    known = [place for place, side in enumerate(sides) if side.face >= 0]
    if len(known) < 2:
        return sides
    kept: list[_Side] = []
    for place, after in zip(known, [*known[1:], known[0] + len(sides)], strict=True):
        run = [sides[n % len(sides)] for n in range(place + 1, after)]
        kept.append(sides[place])
        if run and not _odd(sides[place], run, sides[after % len(sides)], faces):
            kept += run
    return kept


def _odd(before: _Side, run: Sequence[_Side], after: _Side, faces: WallFaces) -> bool:
    """Whether a run of edges between two faces is no shape of the room's."""
    one, other = before.line(faces), after.line(faces)
    corners = np.array([run[0].start, *(side.end for side in run)])
    meeting = _meeting(one, other)
    if meeting is None:
        goes_on = one[1] @ other[1] > 0 and abs(_across(other[0], one)) < _SAME_LINE_M
        return bool(goes_on and np.abs(_across(corners, one)).max() <= _BUMP_M)
    path = LineString([_foot(before.start, one), meeting, _foot(after.end, other)])
    if shapely.distance(path, shapely.points(corners)).max() <= _ALONG_M:
        return True
    seen = sum(_beyond(meeting, side.face, faces) <= _SEEN_M for side in (before, after))
    return bool(np.hypot(*(corners - meeting).T).max() <= _CORNER_M[seen])


def _across(points: F64, line: tuple[F64, F64]) -> F64:
    """Signed distance of points from a line."""
    return np.asarray((points - line[0]) @ np.array([-line[1][1], line[1][0]]))


def _beyond(point: F64, face: int, faces: WallFaces) -> float:
    """How far a point on the line of a face lies beyond what was seen of it."""
    place = float((point - faces.centre[face]) @ faces.along[face])
    first, last = (float(end) for end in faces.span[face])
    return max(first - place, place - last, 0.0)


def _corner(one: _Side, other: _Side, faces: WallFaces) -> F64:
    """``(1 or 2, 2)`` where two sides meet; parallel ones are joined by a step."""
    if one.face < 0 and other.face < 0:
        return one.end[None]
    first, second = one.line(faces), other.line(faces)
    meeting = _meeting(first, second)
    if meeting is not None and np.hypot(*(meeting - (one.end + other.start) / 2)) <= _CORNER_M[2]:
        return meeting[None]
    return np.array([_foot(one.end, first), _foot(other.start, second)])


def _meeting(one: tuple[F64, F64], other: tuple[F64, F64]) -> F64 | None:
    """Return where two lines meet, None where they are nearly parallel."""
    (p, u), (q, v) = one, other
    sine = u[0] * v[1] - u[1] * v[0]
    if abs(sine) < _PARALLEL_SIN:
        return None
    away = q - p
    return np.asarray(p + u * (away[0] * v[1] - away[1] * v[0]) / sine)


def _foot(point: F64, line: tuple[F64, F64]) -> F64:
    return np.asarray(line[0] + line[1] * ((point - line[0]) @ line[1]))
