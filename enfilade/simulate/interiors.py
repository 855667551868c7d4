"""Furnishes a space: pieces against walls, in the middle, on one another, on walls and under the ceiling."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import shapely
from shapely import Polygon
from shapely.affinity import rotate, translate
from shapely.geometry.base import BaseGeometry

from .drafting import Draft
from .layouts import Generator
from .plan import Mirror, Piece
from .solids import F64, Mesh

_TRIES = 14
_STATION_M = 0.62
_HUNG_FROM_M = 1.2
_LOW_M = 0.8
"""What is lower stands in front of windows, too."""


class Interior:
    """A space that is being furnished.

    Parameters
    ----------
    draft, floor
        The space and the elevation of its floor.
    clear
        What has to stay free: ways, stairs.
    low_walls
        Where only low pieces may stand: before windows.
    """

    def __init__(
        self, draft: Draft, floor: float, clear: Sequence[Polygon], low_walls: Sequence[Polygon], random: Generator
    ) -> None:
        self._draft, self._floor, self._random = draft, floor, random
        self._beside_ways = draft.polygon.difference(shapely.union_all(list(clear)))
        self._free = self._beside_ways
        self._low_walls = shapely.union_all(list(low_walls))
        self._hung: BaseGeometry = Polygon()
        self.pieces: list[Piece] = []
        self.mirrors: list[Mirror] = []
        self._reserve_station()

    def _reserve_station(self) -> None:
        """Keep a place for the scanner."""
        inner = self._draft.polygon.buffer(-_STATION_M)
        if inner.is_empty:
            return
        x0, y0, x1, y1 = inner.bounds
        places = self._random.uniform([x0, y0], [x1, y1], (30, 2))
        inside = places[shapely.contains_xy(inner, places)]
        place = shapely.Point(inside[0]) if len(inside) else inner.representative_point()
        self._free = self._free.difference(place.buffer(_STATION_M, quad_segs=4))

    def against_wall(self, name: str, mesh: Mesh, height: float = 0.0, gap: float = 0.01) -> Piece | None:
        """Put a piece with its back to a wall; `height` over the floor hangs it there."""
        for start, end in self._edges(float(np.ptp(mesh.bounds[:, 0]))):
            unit = (end - start) / np.linalg.norm(end - start)
            outwards = np.array([unit[1], -unit[0]])
            half = np.ptp(mesh.bounds[:, 0]) / 2
            along = self._random.uniform(half, np.linalg.norm(end - start) - half)
            place = start + along * unit - outwards * (mesh.bounds[1, 1] + gap)
            angle = float(np.degrees(np.arctan2(outwards[1], outwards[0]))) - 90.0
            piece = self._put(name, mesh, place, angle, height)
            if piece is not None:
                return piece
        return None

    def _edges(self, width: float) -> list[tuple[F64, F64]]:
        ring = np.array(shapely.orient_polygons(self._draft.polygon).exterior.coords)[:, :2]
        edges = [(a, b) for a, b in pairwise(ring) if np.linalg.norm(b - a) > width + 0.04]
        if not edges:
            return []
        length = np.array([np.linalg.norm(b - a) for a, b in edges])
        return [edges[k] for k in self._random.choice(len(edges), _TRIES, p=length / length.sum())]

    def anywhere(self, name: str, mesh: Mesh, angle: float | None = None, height: float = 0.0) -> Piece | None:
        """Put a piece somewhere in the room."""
        x0, y0, x1, y1 = self._draft.polygon.bounds
        for place in self._random.uniform([x0, y0], [x1, y1], (_TRIES, 2)):
            turn = float(self._random.choice([0.0, 90.0, 180.0, 270.0])) + float(self._random.normal(0, 3))
            piece = self._put(name, mesh, place, turn if angle is None else angle, height)
            if piece is not None:
                return piece
        return None

    def beside(self, name: str, mesh: Mesh, other: Piece, offset: tuple[float, float], turn: float) -> Piece | None:
        """Put a piece relative to another one, in that one's frame; it may reach under it."""
        angle = np.radians(other.angle_deg)
        shift = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ offset
        jitter = float(self._random.normal(0.0, 6.0))
        return self._put(name, mesh, np.array(other.place) + shift, other.angle_deg + turn + jitter, 0.0)

    def on_top(self, name: str, mesh: Mesh, other: Piece, offset: tuple[float, float] = (0.0, 0.0)) -> None:
        """Put a piece on another one."""
        angle = np.radians(other.angle_deg)
        shift = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ offset
        top = other.height + float(other.mesh.bounds[1, 2])
        place = np.array(other.place) + shift
        outline = _outline(mesh, place, other.angle_deg)
        if self._draft.polygon.contains(outline) and self._fits_under(outline, top + float(mesh.bounds[1, 2])):
            self.pieces.append(Piece(name, mesh, (float(place[0]), float(place[1])), other.angle_deg, top))

    def from_ceiling(self, name: str, mesh: Mesh) -> None:
        """Hang a piece from a level ceiling near the middle of the room."""
        middle = self._draft.polygon.representative_point()
        if not self._draft.roof.slopes and not self._draft.polygon.buffer(-0.5).is_empty:
            height = self._draft.roof.ceiling - self._floor - float(mesh.bounds[1, 2])
            self.pieces.append(Piece(name, mesh, (middle.x, middle.y), 0.0, height))

    def mirror(self, width: float, height: float, above_floor: float) -> bool:
        """Hang a mirror on a wall."""
        for start, end in self._edges(width):
            unit = (end - start) / np.linalg.norm(end - start)
            inwards = np.array([-unit[1], unit[0]])
            along = self._random.uniform(width / 2, np.linalg.norm(end - start) - width / 2)
            place = start + along * unit
            half = unit * width / 2
            strip = Polygon([place - half, place + half, place + half + 0.3 * inwards, place - half + 0.3 * inwards])
            taken = shapely.union_all([_piece_outline(p) for p in self.pieces if p.height < above_floor + height])
            if strip.difference(self._free).area < 0.25 * strip.area and not strip.intersects(taken):
                facing = float(np.degrees(np.arctan2(inwards[1], inwards[0])))
                self.mirrors.append(Mirror((float(place[0]), float(place[1])), facing, width, height, above_floor))
                self._free = self._free.difference(strip)
                return True
        return False

    def _put(self, name: str, mesh: Mesh, place: F64, angle: float, height: float) -> Piece | None:
        outline = _outline(mesh, place, angle)
        top = height + float(mesh.bounds[1, 2])
        hung = height > _HUNG_FROM_M
        allowed = self._beside_ways if hung else self._free
        if not allowed.contains(outline) or not self._fits_under(outline, top):
            return None
        if top > _LOW_M and outline.intersects(self._low_walls):
            return None
        if hung and outline.intersects(self._hung):
            return None
        piece = Piece(name, mesh, (float(place[0]), float(place[1])), angle, height)
        self.pieces.append(piece)
        around = outline.buffer(0.015, join_style="mitre")
        self._hung = self._hung.union(around) if top > _HUNG_FROM_M else self._hung
        if not hung:
            self._free = self._free.difference(around)
        return piece

    def _fits_under(self, outline: Polygon, top: float) -> bool:
        return bool(self._draft.roof.heights(shapely.get_coordinates(outline)).min() > self._floor + top + 0.03)


def _outline(mesh: Mesh, place: F64, angle: float) -> Polygon:
    (x0, y0, _), (x1, y1, _) = mesh.bounds
    turned = rotate(shapely.box(x0, y0, x1, y1), angle, origin=(0.0, 0.0))
    return Polygon(translate(turned, float(place[0]), float(place[1])))


def _piece_outline(piece: Piece) -> Polygon:
    return _outline(piece.mesh, np.array(piece.place), piece.angle_deg)
