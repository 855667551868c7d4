"""What stands between scanners and a hole: furniture hides walls, and what it hides is no window."""

from __future__ import annotations

from typing import Final

import numpy as np

from enfilade.ingest.cells import CellGrid, Gathered
from enfilade.ingest.openings.holes import Hole
from enfilade.ingest.openings.rays import Rays
from enfilade.ingest.records import F64, Bool, Surfels

VOXEL_M: Final = 0.1
CLEAR_M: Final = 0.25
"""Nothing is looked for so close to the wall itself."""

SAMPLES: Final = 6
"""Places along each axis of a hole that are looked at."""

FAR_M: Final = 0.3
"""What lies less far behind a hole is of the wall."""

OVER_FLOOR_M: Final = 0.3
"""The ground outside may be as high as the floor; so low, nothing is asked of it."""

INDOORS: Final = 1 / 3
"""Share of the rays through a window that end in other rooms, at most: through their windows."""

LEAST_IMAGE: Final = 30
"""Fewest points that tell a mirror."""

MIRRORED: Final = 0.5
"""Share of the points behind a mirror that have a surface before it as their image, at least."""


class Sight:
    """Tells whether the scanners of a room looked at a hole freely.

    Parameters
    ----------
    surfels
        What can stand in between.
    rays
        Scanner positions, and which scan stands in which room.
    """

    def __init__(self, surfels: Surfels, rays: Rays) -> None:
        self._rays = rays
        self._grid = CellGrid.around(surfels.positions, VOXEL_M)
        self._occupied = Gathered.by(self._grid.keys(surfels.positions)).keys
        self._start = rays.start.astype(np.float64)
        self._room = np.full(len(rays.start), -1, dtype=np.int32)
        self._room[rays.scan] = rays.from_room

    def share(self, hole: Hole) -> float:
        """Share of a hole that at least one scanner of its room looked at freely."""
        side = hole.side
        own = self._start[self._room == side.room]
        own = own[own @ side.normal - side.offset > CLEAR_M]
        places = _samples(hole)
        free = np.zeros(len(places), dtype=bool)
        for scanner in own:
            free |= self._free(scanner, places, side.normal)
        return float(free.mean())

    def leads_indoors(self, hole: Hole) -> bool:
        """Whether more than a few of the rays through a hole come from or go to other rooms."""
        rays, far = self._rays, hole.beyond > FAR_M
        ray = hole.ray[far]
        room = np.where(hole.outbound[far], rays.to_room[ray], rays.from_room[ray])
        return bool(len(ray) > 0 and ((room >= 0) & (room != hole.side.room)).mean() > INDOORS)

    def is_mirror(self, hole: Hole) -> bool:
        """Whether what lies behind a hole is the mirror image of what lies before it."""
        side = hole.side
        behind = self._rays.ends(hole.ray[hole.outbound & (hole.beyond > FAR_M)])
        behind = behind[behind[:, 2] > side.bounds[1] + OVER_FLOOR_M]
        if len(behind) < LEAST_IMAGE:
            return False
        depth = side.offset - behind @ side.normal
        return bool(self._grid.among(self._occupied, behind + 2 * depth[:, None] * side.normal).mean() > MIRRORED)

    def _free(self, scanner: F64, places: F64, normal: F64) -> Bool:
        """``(n,)``: whether nothing stands between a scanner and each place."""
        way = places - scanner
        height = float(((scanner - places) @ normal).max())
        steps = np.arange(0.5, np.linalg.norm(way, axis=1).max(), VOXEL_M * 0.7)
        length = np.linalg.norm(way, axis=1)
        along = steps[None, :] / length[:, None]
        before_wall = along < 1.0 - CLEAR_M / max(height, CLEAR_M)
        samples = scanner + along[:, :, None] * way[:, None, :]
        blocked = self._grid.among(self._occupied, samples.reshape(-1, 3)).reshape(along.shape) & before_wall
        return np.asarray(~blocked.any(axis=1), dtype=np.bool_)


def _samples(hole: Hole) -> F64:
    """``(n, 3)`` places in the middle three quarters of a hole."""
    left, bottom, right, top = hole.edges
    share = np.linspace(0.12, 0.88, SAMPLES)
    u, v = np.meshgrid(left + share * (right - left), bottom + share * (top - bottom))
    return hole.side.points(np.column_stack([u.ravel(), v.ravel()]))
