"""What is left of structure when its planes are gone: such segments are no objects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import shapely

from enfilade.ingest.cells import count_cells
from enfilade.ingest.objects.parameters import ObjectParameters
from enfilade.ingest.objects.stairs import Flight
from enfilade.ingest.objects.structure import CeilingMap
from enfilade.ingest.records import F64, Bool, Opening, Room

CELL_M: Final = 0.05
ENOUGH: Final = 2000
"""So many points tell of a segment what there is to know."""
MOST: Final = 0.8
"""A segment is what this share of its points are."""


@dataclass(frozen=True, slots=True)
class Remains:
    """Tells what is left of one room's structure.

    Attributes
    ----------
    room
        The room.
    openings
        Of the room.
    flights
        Stairs of the building.
    ceiling
        Of the room.
    parameters
        Sizes.
    """

    room: Room
    openings: Sequence[Opening]
    flights: Sequence[Flight]
    ceiling: CeilingMap
    parameters: ObjectParameters

    def on_stairs(self, points: F64) -> Bool:
        """``(n,) bool``: which points belong to a stair, from its underside to its handrail."""
        found = np.zeros(len(points), dtype=bool)
        for flight in self.flights:
            found |= flight.near(points, 0.0, self.parameters.max_riser_m, self.parameters.handrail_m)
        return found

    def is_remain(self, points: F64, standing_off: F64) -> bool:
        """Whether a segment is a remain of walls, floor, ceiling or stairs, or lies outside the room.

        Parameters
        ----------
        points
            ``(n, 3)`` metres.
        standing_off
            ``(n,)`` how far they stand off the nearest side.
        """
        step = max(len(points) // ENOUGH, 1)
        points, standing_off = points[::step], standing_off[::step]
        return (
            self._clings(points, standing_off)
            or not self._inside(points)
            or self._in_well(points)
            or self._beside_stairs(points)
            or self._is_railing(points)
            or self._is_line(points)
            or self._is_leaf(points)
            or self._is_soffit(points)
        )

    def _clings(self, points: F64, standing_off: F64) -> bool:
        """Whether it keeps close to the structure and is not as compact and large as a board on a wall."""
        close = standing_off < self.parameters.max_relief_m
        if self.room.outline:
            edge = shapely.Polygon(self.room.outline[0], self.room.outline[1:]).boundary
            close |= shapely.dwithin(edge, shapely.points(points[:, :2]), self.parameters.outline_reach_m)
        return bool(close.mean() >= MOST) and not self._is_board(points)

    def _is_board(self, points: F64) -> bool:
        """Whether points fill an upright rectangle that is as large as furniture."""
        place = np.column_stack([_along(points)[:, 0], points[:, 2]])
        cells = count_cells(place, CELL_M)
        extent = np.ptp(place, axis=0)
        filled = cells * CELL_M**2 / max(float(np.prod(extent + CELL_M)), CELL_M**2)
        return bool(extent.min() >= self.parameters.min_board_m and filled >= self.parameters.min_fill)

    def _is_railing(self, points: F64) -> bool:
        """Whether it is a long thin thing that stands on the floor, or on less: a railing, a parapet, a low wall.

        One of laths or the like that goes up to the ceiling is a wall, too, and one as deep as a reveal and no higher
        than a step is a sill.
        """
        along = _along(points)
        length, thickness = np.ptp(np.quantile(along, (0.02, 0.98), axis=0), axis=0)
        bottom, top = np.quantile(points[:, 2], (0.02, 0.98)) - self.room.floor_elevation
        sill = bottom < 2 * self.parameters.floor_reach_m and top < self.parameters.max_sill_m
        most = self.parameters.max_reveal_m if sill else self.parameters.max_railing_m
        if length < self.parameters.min_railing_m or thickness > most:
            return False
        low = bottom < 2 * self.parameters.floor_reach_m and top < self.parameters.handrail_m
        return bool(low or (bottom < self.parameters.max_hinge_m and self._reaches_ceiling(points, along[:, 0])))

    def _reaches_ceiling(self, points: F64, along: F64) -> bool:
        """Whether at least half of its columns end just under the ceiling, even where that slopes."""
        column = np.floor((along - along.min()) / (2 * CELL_M)).astype(np.int64)
        least = np.full(column.max() + 1, np.inf)
        np.minimum.at(least, column, self.ceiling.over(points) - points[:, 2])
        return bool((least[np.isfinite(least)] < 2 * self.parameters.ceiling_reach_m).mean() > 0.5)

    def _is_leaf(self, points: F64) -> bool:
        """Whether it is the leaf of a door that stands open: thin, as high as the door, hung on one of its jambs.

        What lies in the reveal went with the door, so that the leaf begins as far from its hinges as that is deep.
        """
        bottom, top = np.quantile(points[:, 2], (0.02, 0.98)) - self.room.floor_elevation
        along = _along(points)
        (first, left), (last, right) = np.quantile(along, (0.02, 0.98), axis=0)
        if right - left > self.parameters.max_leaf_thickness_m or top - bottom < self.parameters.min_leaf_m / 2:
            return False
        centre, axes = points[:, :2].mean(axis=0), _axes(points)
        ends = np.array([first, last])
        for opening in self.openings:
            high = abs(top - opening.sill - opening.height) < self.parameters.max_hinge_m
            if opening.kind in ("door", "passage") and opening.orientation == "horizontal" and high:
                sideways = np.array([-opening.normal[1], opening.normal[0]]) * opening.width / 2
                jambs = (opening.position[:2] + np.array([sideways, -sideways]) - centre) @ axes
                if any(self._hangs_on(jamb, ends, opening.width) for jamb in jambs):
                    return True
        return False

    def _hangs_on(self, jamb: F64, ends: F64, width_m: float) -> bool:
        """Whether a leaf from one end to the other goes out from a jamb, ``(2,)`` along and across it."""
        near, far = np.sort(np.abs(ends - jamb[0]))
        outside = not ends[0] + self.parameters.frame_m < jamb[0] < ends[1] - self.parameters.frame_m
        hung = near < self.parameters.max_reveal_m and abs(jamb[1]) < self.parameters.max_hinge_m
        longest = width_m + self.parameters.max_reveal_m / 2 + self.parameters.frame_m
        return bool(outside and hung and far < longest)

    def _is_line(self, points: F64) -> bool:
        """Whether it is a mere line: the edge of something that was seen along its face."""
        place = (points - points.mean(axis=0)) @ np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2].T
        return bool(np.ptp(place[:, 1]) < self.parameters.link_m)

    def _is_soffit(self, points: F64) -> bool:
        """Whether it is a flat piece overhead that is not upright: a strip of a roof, a boxed-in duct."""
        if float(points[:, 2].min()) < self.room.floor_elevation + self.parameters.min_soffit_m:
            return False
        centred = points - points.mean(axis=0)
        values, axes = np.linalg.eigh(centred.T @ centred / len(points))
        return bool(values[0] < self.parameters.clearance_m**2 and abs(axes[2, 0]) > 0.3)

    def _in_well(self, points: F64) -> bool:
        """Whether it reaches so far below the floor that it can only hang in a stair well."""
        return float(points[:, 2].min()) < self.room.floor_elevation - self.parameters.max_sunk_m

    def _inside(self, points: F64) -> bool:
        """Whether most of the points lie in the room's outline; what is outside was seen through a window."""
        if not self.room.outline:
            return True
        outline = shapely.Polygon(self.room.outline[0]).buffer(self.parameters.outline_reach_m)
        shapely.prepare(outline)
        return bool(shapely.contains_xy(outline, points[:, 0], points[:, 1]).mean() >= 0.5)

    def _beside_stairs(self, points: F64) -> bool:
        """Whether most of the points lie so close to a flight that they are its strings, rails and balusters.

        In the room that a flight leads up to, a railing stands along the well, all over the flight.
        """
        chosen = self.parameters
        for flight in self.flights:
            low, high = flight.treads[[0, -1], 2]
            leads_here = abs(high - self.room.floor_elevation) < chosen.max_riser_m
            above = chosen.handrail_m + (high - low if leads_here else 0.0)
            near = flight.near(points, chosen.outline_reach_m, chosen.max_riser_m, above)
            if (near & (points[:, 2] < high + chosen.handrail_m)).mean() > 0.5:
                return True
        return False


def _axes(points: F64) -> F64:
    """``(2, 2)`` directions on the plan in which points extend most and least, in columns."""
    level = points[:, :2] - points[:, :2].mean(axis=0)
    return np.asarray(np.linalg.eigh(level.T @ level)[1][:, ::-1], dtype=np.float64)


def _along(points: F64) -> F64:
    """``(n, 2)`` places on the plan along and across the direction in which points extend most."""
    return np.asarray((points[:, :2] - points[:, :2].mean(axis=0)) @ _axes(points), dtype=np.float64)
