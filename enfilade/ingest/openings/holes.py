"""Holes in the side of a room: cells without wall points that rays go through, and their edges."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from enfilade.ingest.openings.edges import covered_share, edges_of, pane_share
from enfilade.ingest.openings.grid import Grid, bridged, opened, values
from enfilade.ingest.openings.parameters import OpeningParameters
from enfilade.ingest.openings.rays import SideView
from enfilade.ingest.records import F64, I32, Bool
from enfilade.ingest.sides import Side

WALL_M: Final = 0.3
"""Leaves and panes are no deeper behind the face of a wall."""

PANE_M: Final = 0.1
"""Side of the cells in which a pane is looked for, at least, ..."""

PANE_RAYS: Final = 50
"""... and so large that so many rays go through each: glass sends few back."""

LAYER_M: Final = 0.03
"""Two layers of this thickness hold a pane or a leaf."""

LEAST_POINTS: Final = 20
"""Fewer points over a hole are no wall."""

REVEAL_M: Final = 0.12
"""Points up to this far behind the wall, in a hole, are its reveal: they show its edge."""

JAMB_M: Final = 0.04
"""Points this close to the edge of a hole, behind its wall, are on the reveal ..."""

GAP_M: Final = 0.09
"""... as deep as they follow one another with no gap wider than this."""

LOWEST: Final = 0.02
"""Such a share of the rays through a hole may cross it below where the others begin: they are stray."""


@dataclass(frozen=True, slots=True)
class Hole:
    """A hole in one side.

    Attributes
    ----------
    side
        The side that it is in.
    edges
        ``(4,)`` left, bottom, right, top along the axes of the side, metres.
    bounded
        ``(4,) bool`` whether there is wall beside that edge.
    ray, end, beyond, outbound
        The rays through it, as in `SideView`.
    fill
        Share of the rectangle that rays went through.
    lintel
        Height of the wall over it, metres.
    pane
        Share of its inner part where something between the faces of the wall sent rays back: all of it where a
        leaf is closed, most of it where there is glass.
    leaf, passed
        Shares of its inner part where rays end soon behind the wall, and where rays pass far beyond.
    reveal
        How deep its reveal was seen to be, metres: as thick as the wall, if nothing in the hole hides it.
    lowest
        Height along the axes of the side from which on rays go through: higher than its bottom where what stands before
        the wall hides that; infinite where none do.
    """

    side: Side
    edges: F64
    bounded: Bool
    ray: I32
    end: F64
    beyond: F64
    outbound: Bool
    fill: float
    lintel: float
    pane: float
    leaf: float = 0.0
    passed: float = 0.0
    reveal: float = 0.0
    lowest: float = np.inf

    @property
    def width(self) -> float:
        """Width, metres."""
        return float(self.edges[2] - self.edges[0])

    @property
    def height(self) -> float:
        """Height, metres."""
        return float(self.edges[3] - self.edges[1])

    @property
    def centre(self) -> F64:
        """Middle of the rectangle."""
        return self.side.point((self.edges[0] + self.edges[2]) / 2, (self.edges[1] + self.edges[3]) / 2)


def find_holes(view: SideView, parameters: OpeningParameters) -> list[Hole]:
    """Find the holes of one side.

    Parameters
    ----------
    view
        Rays through the side and points on it.
    parameters
        Cell size, bridged gaps and smallest hole.

    Returns
    -------
    Holes that are wide and high enough and have enough rays.
    """
    if len(view.ray) < parameters.min_rays:
        return []
    grid = Grid(view.side, parameters.cell_m)
    crossed = grid.cells(view.crossing)
    wall = grid.marked(grid.cells(view.wall))
    free = bridged(grid.marked(crossed) & ~wall, parameters.bridge_m / parameters.cell_m)
    components = ndimage.label(opened(free & ~wall))[0]
    size = np.bincount(components.ravel())
    number = values(components, crossed)
    order = np.argsort(number, kind="stable")
    holes = []
    for members in np.split(order, np.flatnonzero(np.diff(number[order])) + 1):
        if number[members[0]] > 0 and len(members) >= parameters.min_rays:
            hole = measure_hole(view, members, view.crossing[members], int(size[number[members[0]]]), parameters)
            if hole.width >= parameters.min_width_m and hole.height >= parameters.min_height_m:
                holes.append(hole)
    return holes


def measure_hole(
    view: SideView, members: NDArray[np.int_], places: F64, cells: int, parameters: OpeningParameters
) -> Hole:
    """Measure the rectangle around a hole, edge by edge.

    Parameters
    ----------
    view
        The side that it is in.
    members
        Rays through it, as indices into the view.
    places
        ``(n, 2)`` where the side is known to have no surface, along its axes.
    cells
        Number of the hole's cells.
    parameters
        Their size, and how far behind a wall the leaf of a closed door is.

    Returns
    -------
    The hole.
    """
    cell_m = parameters.cell_m
    outbound, beyond = view.outbound[members], view.beyond[members]
    places = np.concatenate([places, view.end[members[outbound & (beyond < REVEAL_M)]]])
    edges, bounded = edges_of(places, view.wall, cell_m)
    fill = cells * cell_m**2 / max((edges[2] - edges[0]) * (edges[3] - edges[1]), cell_m**2)
    soon = outbound & (beyond < parameters.max_inset_m)
    leaf, passed = (covered_share(view.crossing[members[some]], edges, PANE_M) for some in (soon, ~soon))
    return Hole(
        side=view.side,
        edges=edges,
        bounded=bounded,
        ray=view.ray[members],
        end=view.end[members],
        beyond=view.beyond[members],
        outbound=view.outbound[members],
        fill=min(fill, 1.0),
        lintel=_wall_over(view.wall, edges),
        pane=_pane(view, members, edges),
        leaf=leaf,
        passed=passed,
        reveal=_reveal(view, members, edges, parameters.max_gap_m),
        lowest=float(np.quantile(view.crossing[members, 1], LOWEST)) if len(members) else np.inf,
    )


def _pane(view: SideView, members: NDArray[np.int_], edges: F64) -> float:
    """Share of a hole that rays end in at one depth within the wall; reveals lie at its edges, leaves stand open."""
    within = members[view.outbound[members] & (view.beyond[members] < WALL_M)]
    size = np.maximum(edges[2:] - edges[:2], PANE_M)
    enough = float(np.sqrt(PANE_RAYS * size.prod() / max(len(members), 1)))
    cell_m = min(max(PANE_M, enough), float(size.min()) / 5)
    return pane_share(view.wall, view.end[within], view.beyond[within], edges, cell_m, LAYER_M)


def _reveal(view: SideView, members: NDArray[np.int_], edges: F64, max_gap_m: float) -> float:
    """How deep the points along the left, right and upper edge of a hole go on from its wall, metres."""
    behind = members[view.outbound[members] & (view.beyond[members] < max_gap_m)]
    u, v = view.end[behind].T
    left, bottom, right, top = edges
    upright = (np.minimum(np.abs(u - left), np.abs(u - right)) < JAMB_M) & (v > bottom) & (v < top + JAMB_M)
    level = (np.abs(v - top) < JAMB_M) & (u > left) & (u < right)
    depths = np.sort(np.append(view.beyond[behind[upright | level]], 0.0))
    wide = np.flatnonzero(np.diff(depths) > GAP_M)
    return float(depths[wide[0]] if len(wide) else depths[-1])


def _wall_over(wall: F64, edges: F64) -> float:
    """Height of the wall over a hole, 0 if there is none."""
    over = wall[(wall[:, 0] > edges[0]) & (wall[:, 0] < edges[2]) & (wall[:, 1] > edges[3]), 1]
    return float(np.percentile(over, 99) - edges[3]) if len(over) > LEAST_POINTS else 0.0
