"""Holes that no ray goes through to another room: closed doors, and windows and doors to the outside.

A closed door lies a little behind its wall: rays go through the plane of the wall and end soon after (the paper's
Figure 6). Behind glass there is nothing that sends a ray back: the wall has a hole, framed on all sides, that a
scanner looked at and saw nothing in.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree
from shapely import Point, Polygon, STRtree, box

from enfilade.ingest.openings.confidence import probability
from enfilade.ingest.openings.grid import Grid, bridged, opened, values
from enfilade.ingest.openings.holes import Hole, measure_hole
from enfilade.ingest.openings.parameters import OpeningParameters
from enfilade.ingest.openings.rays import SideView
from enfilade.ingest.openings.sight import Sight
from enfilade.ingest.records import F64, Opening, Room, Surfels
from enfilade.ingest.sides import Side

FLOOR_M: Final = 0.05
"""A hole that begins this close to the floor begins at the floor."""

IN_LINE_M: Final = 12.0
"""A wall is thought to go on for so far."""

AROUND_M: Final = 0.3
"""Width of the wall around a hole that tells whose it is."""

RIVAL_M: Final = 3.0
"""Openings whose middles are farther apart than this never overlap by much."""


@dataclass(frozen=True, slots=True)
class BlindHole:
    """A framed hole in a wall.

    Attributes
    ----------
    hole
        Its place and rays.
    leaf
        Share of its cells where rays end soon behind the wall.
    passed
        Share of its cells that rays pass far beyond.
    """

    hole: Hole
    leaf: float
    passed: float


def find_blind_holes(view: SideView, floor: float, parameters: OpeningParameters) -> Iterator[BlindHole]:
    """Find the framed holes of a wall, whether rays go through or not.

    Parameters
    ----------
    view
        Rays through the wall and points on it.
    floor
        Elevation of the room's floor, metres.
    parameters
        Cell size, bridged gaps, smallest hole.

    Yields
    ------
    Holes with wall at their left, right and top, and at their bottom if they do not begin at the floor.
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
    for k, box in enumerate(ndimage.find_objects(components), start=1):
        if size[k] >= least_cells:
            cells = components[box] == k
            members = np.flatnonzero(number == k)
            corner = (box[0].start, box[1].start)
            hole = measure_hole(view, members, grid.centres(cells, corner), int(size[k]), parameters.cell_m)
            if _framed(hole, floor, parameters):
                soon = view.outbound[members] & (view.beyond[members] < parameters.max_inset_m)
                leaf, passed = (
                    (bridged(grid.marked(crossed[members[some]]), gap)[box] & cells).sum() / size[k]
                    for some in (soon, ~soon)
                )
                yield BlindHole(hole, float(leaf), float(passed))


def open_blind(
    found: Iterable[BlindHole],
    walls: Sequence[Side],
    rooms: Mapping[int, Room],
    settled: Iterable[Opening],
    surfels: Surfels,
    sight: Sight,
    parameters: OpeningParameters,
) -> list[Opening]:
    """Turn framed holes into closed doors and windows, leaving out those that furniture hides.

    Parameters
    ----------
    found
        Framed holes of all walls.
    walls
        All walls: the one behind a hole tells which room it leads to; none behind is the outside.
    rooms
        By number.
    settled
        Openings that rays go through; what lies at these is left out.
    surfels
        Those that the walls index.
    sight
        Tells what stands between a scanner and a hole.
    parameters
        Sizes and thresholds.

    Returns
    -------
    One opening for the holes in the two sides of a wall.
    """
    behind = _Behind(walls, parameters.max_gap_m)
    openings = [opening for opening in settled if opening.orientation == "horizontal"]
    candidates = [
        opening
        for blind in sorted(found, key=lambda b: (-round(b.leaf, 1), -_wall_around(b.hole, surfels), b.hole.side.room))
        if (opening := _opening(blind, behind, rooms, sight, parameters)) is not None
    ]
    return _one_a_place(candidates, openings, parameters.max_gap_m)


class _Behind:
    """Finds the wall that stands behind a hole, looking the other way."""

    def __init__(self, walls: Sequence[Side], max_gap_m: float) -> None:
        self._walls = walls
        self._max_gap_m = max_gap_m
        corners = [np.array([wall.point(wall.bounds[i], wall.bounds[1])[:2] for i in (0, 2)]) for wall in walls]
        self._tree = STRtree([box(*pair.min(axis=0), *pair.max(axis=0)) for pair in corners])

    def rooms(self, hole: Hole) -> list[int]:
        """Rooms of the walls behind a hole, the nearest first.

        The hole's own room is among them where a part of it goes around, or where it was given the back of a leaf.
        """
        centre = hole.centre
        near = self._tree.query(Point(centre[:2]).buffer(self._max_gap_m))
        gaps = [(self._gap(self._walls[i], hole, centre), self._walls[i].room) for i in near]
        return [room for gap, room in sorted(gaps) if 0.02 < gap < self._max_gap_m]

    def room_in_line(self, hole: Hole) -> int | None:
        """Room whose wall would stand behind a hole if it went on, as that of a corridor seen in part does.

        Long walls are more likely to go on than short ones, near ones more than far ones.
        """
        centre = hole.centre
        near = self._tree.query(Point(centre[:2]).buffer(IN_LINE_M))
        possible = []
        for wall in (self._walls[i] for i in near):
            if wall.room != hole.side.room and 0.02 < self._gap(wall, hole, centre, IN_LINE_M) < self._max_gap_m:
                u = centre @ wall.u
                apart = max(wall.bounds[0] - u, u - wall.bounds[2])
                possible.append((apart - (wall.bounds[2] - wall.bounds[0]), wall.room))
        return min(possible)[1] if possible else None

    def _gap(self, wall: Side, hole: Hole, centre: F64, beside_m: float = 0.0) -> float:
        """Thickness between a hole and a wall that faces away and reaches across it, else infinity."""
        u, v = centre @ wall.u, centre @ wall.v
        low, high = wall.bounds[:2], wall.bounds[2:]
        across = low[0] - beside_m < u < high[0] + beside_m and low[1] < v < high[1]
        if not across or wall.normal @ hole.side.normal > -0.95:
            return float("inf")
        return float(wall.normal @ centre - wall.offset) * -1.0


def _framed(hole: Hole, floor: float, parameters: OpeningParameters) -> bool:
    """Whether wall surrounds a hole that is a rectangle of some size."""
    at_floor = hole.edges[1] - floor < FLOOR_M
    large = hole.width >= parameters.min_width_m and hole.height >= parameters.min_height_m
    return bool(large and hole.fill > 0.75 and hole.bounded[[0, 2, 3]].all() and (at_floor or hole.bounded[1]))


def _opening(
    blind: BlindHole, behind: _Behind, rooms: Mapping[int, Room], sight: Sight, parameters: OpeningParameters
) -> Opening | None:
    hole = blind.hole
    room, around = rooms[hole.side.room], behind.rooms(hole)
    other = next((number for number in around if number != room.number), None)
    at_floor = hole.edges[1] - room.floor_elevation < FLOOR_M
    is_door = at_floor and hole.height > parameters.min_closed_height_m and hole.width < parameters.max_closed_width_m
    is_open = is_door and blind.passed > 0.5
    if is_door and other is None:
        other = behind.room_in_line(hole)
    if other is None and (around or _indoors(hole, rooms, parameters.max_gap_m)):
        return None
    seen = sight.share(hole)
    if (is_door and not is_open and other is not None and blind.leaf < 0.5) or seen < 0.6:
        return None
    if not is_door and other is not None:
        return None
    edges = hole.edges.copy()
    if at_floor:
        edges[1] = room.floor_elevation
    middle = (edges[:2] + edges[2:]) / 2
    a, b = (room.number, other) if other is None or room.number < other else (other, room.number)
    width, height = (edges[2:] - edges[:2]).tolist()
    chosen = parameters.confidence
    evidence = {
        "framed": float(hole.bounded.mean()),
        "filled": hole.fill,
        "seen": seen,
        "leaf": blind.leaf,
        "passed": blind.passed,
        "room_behind": float(other is not None),
        "glazed": hole.pane,
        "wide": min(width / 4.0, 1.0),
        "high": min(height / 4.0, 1.0),
    }
    return Opening(
        kind="door" if is_door else "window",
        orientation="horizontal",
        room_a=a,
        room_b=b,
        position=hole.side.point(*middle),
        normal=hole.side.normal,
        width=width,
        height=height,
        sill=float(edges[1] - room.floor_elevation),
        area=width * height,
        ray_count=int((hole.beyond > parameters.max_inset_m).sum()),
        state="open" if is_open else "closed",
        confidence=probability(chosen.closed if is_door else chosen.outside, evidence),
        lintel=hole.lintel,
        evidence=evidence,
    )


def _wall_around(hole: Hole, surfels: Surfels) -> int:
    """Count the surfels of a hole's own side around it: two rooms may claim it, and one has the wall."""
    side = hole.side
    places = surfels.positions[side.surfels] @ np.column_stack([side.u, side.v])
    near = (places > hole.edges[:2] - AROUND_M) & (places < hole.edges[2:] + AROUND_M)
    return int(np.count_nonzero(near.all(axis=1)))


def _indoors(hole: Hole, rooms: Mapping[int, Room], max_gap_m: float) -> bool:
    """Whether any room lies behind a hole."""
    level = float(hole.centre[2])
    behind = [Point((hole.centre - depth * hole.side.normal)[:2]) for depth in (max_gap_m, 2 * max_gap_m)]
    for room in rooms.values():
        ceiling = room.ceiling_elevation if room.ceiling_elevation is not None else room.bounds[5]
        if room.outline and room.floor_elevation < level < ceiling:
            plan = Polygon(room.outline[0])
            if any(plan.contains(place) for place in behind):
                return True
    return False


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
