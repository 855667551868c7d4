"""Holes that no ray goes through to another room: closed doors, and windows and doors to the outside.

A closed door lies a little behind its wall: rays go through the plane of the wall and end soon after (the paper's
Figure 6). Behind glass there may be nothing that sends a ray back: the wall has a hole, framed on all sides, that a
scanner looked at and saw nothing in; or there is the ground outside, which is of no room.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import shapely
from scipy import ndimage
from scipy.spatial import cKDTree
from shapely import Point, Polygon

from enfilade.ingest.openings.behind import Behind
from enfilade.ingest.openings.confidence import probability
from enfilade.ingest.openings.grid import Grid, bridged, opened, values
from enfilade.ingest.openings.holes import Hole, measure_hole
from enfilade.ingest.openings.parameters import OpeningParameters
from enfilade.ingest.openings.rays import SideView
from enfilade.ingest.openings.sight import Sight
from enfilade.ingest.records import Bool, Opening, Room, Surfels
from enfilade.ingest.sides import Side

FLOOR_M: Final = 0.08
"""A hole that begins this close to the floor begins at the floor: thresholds are lower, parapets higher."""

AROUND_M: Final = 0.3
"""Width of the wall around a hole that tells whose it is."""

RIVAL_M: Final = 3.0
"""Openings whose middles are farther apart than this never overlap by much."""

FILLED: Final = 0.75
"""Share of its rectangle that a hole without rays fills, at least."""

LEAST_EDGES: Final = 3
"""So many edges of a hole have wall beside them, at least; furniture may hide one."""

OFF_BORDER_M: Final = 0.15
"""The wall that a hole is in lies no farther than this from the outline of its room."""

RECESS_M: Final = 0.5
"""Outlines go this far out with the recesses of windows, at most."""

LEAST_RETURNED: Final = 0.2
"""Where less of a hole sent rays back, from it or through it, it has to be framed on all sides and not begin at the
floor: what is in the shadow of furniture sends none back."""

LEAST_SEEN: Final = 0.6
"""Share of a hole that a scanner looked at freely, at least."""


def find_blind_holes(view: SideView, parameters: OpeningParameters) -> list[Hole]:
    """Find the holes of a wall, whether rays go through or not.

    Parameters
    ----------
    view
        Rays through the wall and points on it.
    parameters
        Cell size, bridged gaps, smallest hole.

    Returns
    -------
    Holes that are rectangles of some size.
    """
    grid = Grid(view.side, parameters.cell_m)
    gap = parameters.bridge_m / parameters.cell_m
    crossed = grid.cells(view.crossing)
    wall = bridged(grid.mostly(grid.cells(view.wall), crossed), gap)
    hidden = bridged(grid.marked(grid.cells(view.front)), gap)
    components = ndimage.label(opened(~wall & ~hidden & grid.inner(view.side)))[0]
    size = np.bincount(components.ravel())
    number = values(components, crossed)
    least_cells = parameters.min_width_m * parameters.min_height_m / parameters.cell_m**2
    holes = []
    for k, box in enumerate(ndimage.find_objects(components), start=1):
        if size[k] >= least_cells:
            places = grid.centres(components[box] == k, (box[0].start, box[1].start))
            hole = measure_hole(view, np.flatnonzero(number == k), places, int(size[k]), parameters)
            if hole.fill > FILLED:
                holes.append(hole)
    return holes


def is_doorway(hole: Hole, floor: float, parameters: OpeningParameters) -> bool:
    """Whether a hole is as large as a door and framed like one, though few rays go through.

    An open leaf or what stands in the room may hide most of it; the wall beside it shows how wide it is.
    """
    walled = bool(hole.bounded[[0, 2, 3]].all())
    wide = parameters.min_width_m <= hole.width <= parameters.max_closed_width_m
    reaches_down = hole.edges[1] - floor < parameters.min_sill_m
    high = hole.edges[3] - floor >= parameters.min_closed_height_m and hole.lintel >= parameters.min_lintel_m
    return bool(walled and wide and reaches_down and high)


def open_blind(
    found: Iterable[Hole],
    walls: Sequence[Side],
    rooms: Mapping[int, Room],
    settled: Iterable[Opening],
    surfels: Surfels,
    sight: Sight,
    parameters: OpeningParameters,
) -> list[Opening]:
    """Turn framed holes into closed doors, windows, and doors to the outside, leaving out those that furniture hides.

    Parameters
    ----------
    found
        Holes of all walls that lead to no room.
    walls
        All walls: the one behind a hole tells which room it leads to; none behind is the outside.
    rooms
        By number.
    settled
        Openings that rays go through to a room; what lies at these is left out.
    surfels
        Those that the walls index.
    sight
        Tells what stands between a scanner and a hole, and what is a mirror.
    parameters
        Sizes and thresholds.

    Returns
    -------
    One opening for the holes in the two sides of a wall.
    """
    behind = Behind(walls, rooms, parameters.max_gap_m)
    plans = {number: Polygon(room.outline[0], room.outline[1:]) for number, room in rooms.items() if room.outline}
    framed = [
        clipped
        for hole in found
        if (clipped := above_hidden(hole, rooms[hole.side.room].floor_elevation, parameters)) is not None
        and _framed(clipped, rooms[hole.side.room].floor_elevation, parameters)
        and bounds_room(clipped, plans.get(hole.side.room), surfels)
    ]
    framed.sort(
        key=lambda hole: (-hole.bounded.sum(), -round(hole.width * hole.height, 1), -_wall_around(hole, surfels))
    )
    outer = [hole.reveal for hole in framed if hole.reveal > parameters.surface_m and not behind.rooms(hole)]
    thickness = float(np.median(outer)) if outer else 0.0
    openings = [opening for opening in settled if opening.orientation == "horizontal"]
    candidates = [
        opening
        for hole in framed
        if (opening := _opening(hole, behind, thickness, rooms, sight, parameters)) is not None
    ]
    return _one_a_place(candidates, openings, parameters.max_gap_m)


def above_floor(hole: Hole, floor: float) -> Hole | None:
    """Cut a hole off at the floor: the wall of a room that looks down into another goes on below it."""
    if hole.edges[3] <= floor:
        return None
    if hole.edges[1] >= floor - FLOOR_M:
        return hole
    edges, bounded = hole.edges.copy(), hole.bounded.copy()
    edges[1], bounded[1] = floor, False
    return replace(hole, edges=edges, bounded=bounded)


def above_hidden(hole: Hole, floor: float, parameters: OpeningParameters) -> Hole | None:
    """Cut a hole off at the floor, or where rays begin to go through it: furniture hides the parapet of a window.

    Rays go through an open door, and into the leaf of a closed one, lower than any sill.
    """
    cut = above_floor(hole, floor)
    if cut is None or cut.edges[1] - floor >= FLOOR_M or not floor + parameters.min_sill_m < hole.lowest < cut.edges[3]:
        return cut
    edges, bounded = cut.edges.copy(), cut.bounded.copy()
    edges[1], bounded[1] = hole.lowest, False
    return replace(cut, edges=edges, bounded=bounded)


def bounds_room(hole: Hole, plan: Polygon | None, surfels: Surfels) -> bool:
    """Whether a hole is in a wall that bounds its room, and not in the side of what stands in it.

    The outline runs along the wall around it, or no farther behind it than a recess is deep.
    """
    if plan is None or not plan.contains(Point((hole.centre - RECESS_M * hole.side.normal)[:2])):
        return True
    around = surfels.positions[hole.side.surfels[_around(hole, surfels)]]
    off = np.atleast_1d(shapely.distance(shapely.points(around[:, :2]), plan.boundary))
    return bool(len(around)) and float(np.mean(off < OFF_BORDER_M)) > 0.5


def _framed(hole: Hole, floor: float, parameters: OpeningParameters) -> bool:
    """Whether wall surrounds a hole of some size, but for one edge."""
    at_floor = hole.edges[1] - floor < FLOOR_M
    large = hole.width >= parameters.min_width_m and hole.height >= parameters.min_height_m
    return bool(large and hole.bounded[[0, 2, 3]].sum() + (at_floor or hole.bounded[1]) >= LEAST_EDGES)


@dataclass(frozen=True, slots=True)
class _Way:
    """What a framed hole may be.

    Attributes
    ----------
    at_floor
        Whether it begins at the floor.
    kind
        Door or window.
    is_open
        Whether most of it lets rays pass.
    behind
        Thickness of the wall and the room behind a closed door; None where the outside is.
    """

    at_floor: bool
    kind: str
    is_open: bool
    behind: tuple[float, int] | None


def _opening(
    hole: Hole,
    behind: Behind,
    thickness: float,
    rooms: Mapping[int, Room],
    sight: Sight,
    parameters: OpeningParameters,
) -> Opening | None:
    room = rooms[hole.side.room]
    way = _way(hole, room.floor_elevation, behind, sight, parameters)
    seen = _seen(hole, way, sight, parameters) if way is not None else 0.0
    if way is None or seen < LEAST_SEEN or sight.is_mirror(hole):
        return None
    edges = hole.edges.copy()
    if way.at_floor:
        edges[1] = room.floor_elevation
    gap, number = (max(hole.reveal, thickness), None) if way.behind is None else way.behind
    a, b = (room.number, number) if number is None or room.number < number else (number, room.number)
    width, height = (edges[2:] - edges[:2]).tolist()
    evidence = _evidence(hole, seen, width, height, room_behind=number is not None)
    chosen = parameters.confidence
    return Opening(
        kind=way.kind,
        orientation="horizontal",
        room_a=a,
        room_b=b,
        position=hole.side.point(*(edges[:2] + edges[2:]) / 2) - gap / 2 * hole.side.normal,
        normal=hole.side.normal,
        width=width,
        height=height,
        sill=float(edges[1] - room.floor_elevation),
        area=width * height,
        ray_count=int((hole.beyond > parameters.max_inset_m).sum()),
        state="open" if way.kind == "door" and way.is_open else "closed",
        confidence=probability(chosen.closed if way.kind == "door" else chosen.outside, evidence),
        lintel=hole.lintel,
        evidence=evidence,
    )


def _way(hole: Hole, floor: float, behind: Behind, sight: Sight, parameters: OpeningParameters) -> _Way | None:
    """Tell a closed door to another room from a way out; None for what else leads to a room or ends in the own one."""
    at_floor = bool(hole.edges[1] - floor < FLOOR_M)
    is_high = hole.height > parameters.min_closed_height_m
    is_door = at_floor and is_high and hole.width < parameters.max_closed_width_m
    is_open = hole.passed > 0.5 and hole.leaf < 0.5
    around = behind.rooms(hole)
    other = next(((gap, number) for gap, number in around if number != hole.side.room), None)
    planned = behind.room_of_plan(hole) if other is None else None
    if is_door and not is_open and planned is not None:
        other = (hole.reveal, planned)
    if other is None and (around or planned is not None or sight.leads_indoors(hole)):
        return None
    if other is not None and (not is_door or is_open or hole.leaf < 0.5):
        return None
    return _Way(at_floor, "door" if is_door else "window", is_open, other)


def _seen(hole: Hole, way: _Way, sight: Sight, parameters: OpeningParameters) -> float:
    """Share of a hole that scanners looked at freely; 0 where it may as well be in the shadow of something."""
    returned = min(hole.leaf + hole.passed, 1.0)
    if returned < LEAST_RETURNED and (way.at_floor or not hole.bounded.all()):
        return 0.0
    if way.at_floor and hole.height <= parameters.min_closed_height_m and hole.passed < 0.5:
        return 0.0
    return max(sight.share(hole), returned)


def _evidence(hole: Hole, seen: float, width: float, height: float, *, room_behind: bool) -> dict[str, float]:
    return {
        "framed": float(hole.bounded.mean()),
        "filled": hole.fill,
        "seen": seen,
        "leaf": hole.leaf,
        "passed": hole.passed,
        "room_behind": float(room_behind),
        "glazed": hole.pane,
        "wide": min(width / 4.0, 1.0),
        "high": min(height / 4.0, 1.0),
    }


def _wall_around(hole: Hole, surfels: Surfels) -> int:
    """Count the surfels of a hole's own side around it: two rooms may claim it, and one has the wall."""
    return int(np.count_nonzero(_around(hole, surfels)))


def _around(hole: Hole, surfels: Surfels) -> Bool:
    """Which surfels of a hole's own side are around it."""
    side = hole.side
    places = surfels.positions[side.surfels] @ np.column_stack([side.u, side.v])
    near = (places > hole.edges[:2] - AROUND_M) & (places < hole.edges[2:] + AROUND_M)
    return np.asarray(near.all(axis=1))


def _one_a_place(candidates: list[Opening], settled: list[Opening], max_gap_m: float) -> list[Opening]:
    """Leave out candidates that lie where a settled opening or an earlier candidate does."""
    everyone = [*settled, *candidates]
    if not candidates:
        return []
    tree = cKDTree([opening.position for opening in everyone])
    stays = [True] * len(settled) + [False] * len(candidates)
    for index in range(len(settled), len(everyone)):
        own = everyone[index]
        near = (j for j in tree.query_ball_point(own.position, RIVAL_M) if stays[j])
        stays[index] = not any(_at_one_place(own, everyone[j], max_gap_m) for j in near)
    return [opening for opening, kept in zip(everyone, stays, strict=True) if kept][len(settled) :]


def _at_one_place(a: Opening, b: Opening, max_gap_m: float) -> bool:
    """Whether two openings overlap when seen along the normal."""
    apart = a.position - b.position
    if abs(a.normal @ b.normal) < 0.9 or abs(apart @ a.normal) > max_gap_m:
        return False
    aside = np.linalg.norm(apart[:2] - (apart @ a.normal) * a.normal[:2])
    return bool(aside < (a.width + b.width) / 2 and abs(apart[2]) < (a.height + b.height) / 2)
