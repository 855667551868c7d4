"""What speaks for an opening."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from shapely import Point, STRtree, box

from enfilade.ingest.openings.edges import covered_share
from enfilade.ingest.openings.holes import PANE_M, Hole
from enfilade.ingest.openings.leads import Group
from enfilade.ingest.records import Bool, Surfels
from enfilade.ingest.sides import Side

FACING: Final = -0.95
"""Cosine between the normals of two faces of one wall, at most."""


def evidence_of_group(group: Group, rays: int, bounded: Bool, width: float) -> dict[str, float]:
    """Return what speaks for holes that rays go through, each from 0 to about 1.

    Parameters
    ----------
    group
        The holes.
    rays
        Rays that join the two rooms.
    bounded
        Edges with wall beside them.
    width
        Metres.
    """
    leads = group.leads
    return {
        "rays": float(np.log10(max(rays, 1))) / 4.0,
        "framed": float(np.mean(bounded)),
        "filled": max(lead.hole.fill for lead in leads),
        "agreed": max(lead.share for lead in leads),
        "both_sides": float(len({lead.hole.side.room for lead in leads}) == 2),
        "glazed": max(lead.hole.pane for lead in leads),
        "wide": min(width / 4.0, 1.0),
    }


class Walls:
    """Tells whether a wall stands behind a hole where there should be a hole, too: then it is a mirror.

    Parameters
    ----------
    walls, surfels
        All walls, and the surfels that they index.
    max_gap_m
        Thickest wall.
    """

    def __init__(self, walls: Sequence[Side], surfels: Surfels, max_gap_m: float) -> None:
        self._walls, self._surfels, self._max_gap_m = walls, surfels, max_gap_m
        corners = [wall.points(wall.bounds.reshape(2, 2))[:, :2] for wall in walls]
        self._tree = STRtree([box(*pair.min(axis=0), *pair.max(axis=0)) for pair in corners])

    def covered(self, hole: Hole) -> float:
        """Share of a hole that the face behind it covers."""
        centre = hole.centre
        near = self._tree.query(Point(centre[:2]).buffer(self._max_gap_m))
        return max((self._share(self._walls[k], hole) for k in near if self._backs(self._walls[k], hole)), default=0.0)

    def _backs(self, wall: Side, hole: Hole) -> bool:
        gap = wall.offset - float(wall.normal @ hole.centre)
        return bool(wall.normal @ hole.side.normal < FACING and 0.02 < gap < self._max_gap_m)

    def _share(self, wall: Side, hole: Hole) -> float:
        places = self._surfels.positions[wall.surfels] @ np.column_stack([hole.side.u, hole.side.v])
        return covered_share(places.astype(np.float64), hole.edges, PANE_M)
