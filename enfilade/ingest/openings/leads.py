"""Where holes lead: the room behind each, and which holes belong to one opening."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from shapely import LineString, Polygon, STRtree, box

from enfilade.ingest.openings.holes import Hole
from enfilade.ingest.openings.parameters import OpeningParameters
from enfilade.ingest.openings.rays import Rays
from enfilade.ingest.records import F64, I32, Bool, Room

APART_M = 0.2
"""A room whose plan is farther from a hole than the thickest wall and this does not begin behind it, ..."""

CLOSE_M = 1.2
"""... unless some of its points are this close behind."""

ON_BEHIND_M = (0.2, 0.4, 0.6, 0.8)
"""How far behind a hole it is looked up in whose plan that is."""

LEAST_COMMON_M = 0.05
"""Holes in the two faces of a wall that overlap by this much are one."""

LEAST_KNOWN = 0.4
"""Share of the vote that a room has against what is of no room, at least: else a space that is no room lies between.

Points too sparse to tell their room, as at the far end of a corridor, say nothing."""

NEAR_M = 1.0
"""A ray that ends this far behind a hole counts 1/e in the vote for the room there."""


@dataclass(frozen=True, slots=True)
class Lead:
    """Where a hole leads: `votes` for room `other`, which are `share` of all; `same` are for the hole's own room."""

    hole: Hole
    other: int
    votes: float
    share: float
    same: float

    @property
    def pair(self) -> tuple[int, int]:
        """The two rooms, the lower number first."""
        a, b = self.hole.side.room, self.other
        return (a, b) if a < b else (b, a)


@dataclass(frozen=True, slots=True)
class Group:
    """All holes of one opening between a pair of rooms, the one of most rays first."""

    pair: tuple[int, int]
    leads: tuple[Lead, ...]

    @property
    def main(self) -> Hole:
        """The hole of most rays."""
        return self.leads[0].hole

    @property
    def votes(self) -> float:
        """How much speaks for the pair of rooms."""
        return sum(lead.votes for lead in self.leads)


def group_holes(
    holes: Iterable[Hole], rays: Rays, rooms: Mapping[int, Room], parameters: OpeningParameters
) -> list[Group]:
    """Find where each hole leads, and put together those of one pair of rooms that face one another.

    Where groups of several pairs of rooms claim one place, the one with most votes stays: it is the room right
    behind the hole, not one further on.

    Parameters
    ----------
    holes
        Of any sides.
    rays
        All rays, with the rooms at their ends.
    rooms
        By number; holes that lead elsewhere are left out.
    parameters
        Thickest wall and fewest rays.

    Returns
    -------
    Ordered by pair of rooms.
    """
    plans = {number: Polygon(room.outline[0]) if room.outline else None for number, room in rooms.items()}
    leads: defaultdict[tuple[int, int], list[Lead]] = defaultdict(list)
    for hole in holes:
        lead = _lead(hole, rays, rooms, plans, parameters)
        if lead is not None:
            leads[lead.pair].append(lead)
    groups = [
        Group(pair, tuple(sorted(facing, key=lambda lead: -len(lead.hole.ray))))
        for pair in sorted(leads)
        for facing in _facing(leads[pair], parameters.max_gap_m)
    ]
    return without_rivals(groups, (), parameters.max_gap_m)


def without_rivals(groups: Sequence[Group], settled: Sequence[Group], max_gap_m: float) -> list[Group]:
    """Leave out each group that overlaps a settled one, or one of another pair of rooms that has more votes.

    Parameters
    ----------
    groups
        Those to choose from.
    settled
        Those that stay in any case.
    max_gap_m
        Thickest wall.

    Returns
    -------
    The groups that stay, in the order given.
    """
    everyone = [*groups, *settled]
    if not everyone:
        return []
    boxes = [_plan_box(group.main, max_gap_m) for group in everyone]
    tree = STRtree(boxes)
    stays = [False] * len(groups) + [True] * len(settled)
    for index in sorted(range(len(groups)), key=lambda i: (-groups[i].votes, i)):
        near = [j for j in tree.query(boxes[index]) if stays[j]]
        stays[index] = not any(_overlap(groups[index].main, everyone[j].main, max_gap_m) for j in near)
    return [group for group, kept in zip(groups, stays, strict=False) if kept]


def through(group: Group, rays: Rays) -> I32:
    """Return the rays that go through any of the holes from or to the room that the hole leads to, each once.

    Their other end need not be in the room on this side: a scanner may look through two doors at once.
    """
    leading = [lead.hole.ray[_far_rooms(lead.hole, rays) == lead.other] for lead in group.leads]
    return np.asarray(np.unique(np.concatenate(leading)), dtype=np.int32)


def _far_rooms(hole: Hole, rays: Rays) -> I32:
    """``(k,)`` room at the end behind a hole of each ray through it, -1 for none."""
    return np.asarray(np.where(hole.outbound, rays.to_room[hole.ray], rays.from_room[hole.ray]), dtype=np.int32)


def _lead(
    hole: Hole,
    rays: Rays,
    rooms: Mapping[int, Room],
    plans: Mapping[int, Polygon | None],
    parameters: OpeningParameters,
) -> Lead | None:
    """Ask the rays through a hole which room is behind it; None if it is the room itself, or none that begins there.

    A room whose plan covers what is right behind goes before one that more of the rays look into farther on.
    """
    room = hole.side.room
    far = _far_rooms(hole, rays)
    weight = np.exp(-hole.beyond / NEAR_M)
    weight[hole.beyond < parameters.max_gap_m] = 0.0  # on the reveal, which has no say
    far = known_by_plan(far, weight > 0.0, rays.ends(hole.ray), plans)
    sparse = hole.outbound & (rays.surfel[hole.ray] < 0)
    unknown = float(weight[(far < 0) & ~sparse].sum())
    same = float(weight[far == room].sum())
    others = (far != room) & (far >= 0) & (weight > 0.0)
    if others.sum() < parameters.min_rays:
        return None
    votes = np.bincount(far[others], weight[others])
    total = float(votes.sum()) + same
    enough = np.flatnonzero(votes > unknown * (1.0 / LEAST_KNOWN - 1.0)).tolist()
    likely = [other for other in enough if other in rooms]
    at_hole = {number for number in (room, *likely) if _covers_behind(rooms[number], plans[number], hole)}
    for other in sorted(likely, key=lambda other: (other not in at_hole, -votes[other])):
        if _begins_behind(hole, far == other, room in at_hole, plans[other], parameters):
            lead = Lead(hole, other, float(votes[other]), float(votes[other]) / total, same / total)
            return lead if lead.same < 0.6 else None
    return None


def known_by_plan(far: I32, asked: Bool, ends: F64, plans: Mapping[int, Polygon | None]) -> I32:
    """Give the ends that are of no room to the room in whose plan they lie, of those that other rays lead to."""
    told = far.copy()
    for other in np.unique(far[asked & (far >= 0)]).tolist():
        plan = plans.get(other)
        untold = np.flatnonzero(asked & (told < 0))
        if plan is not None and len(untold):
            told[untold[shapely.contains_xy(plan, ends[untold, :2])]] = other
    return told


def _begins_behind(
    hole: Hole, to_it: Bool, own_goes_on: bool, plan: Polygon | None, parameters: OpeningParameters
) -> bool:
    """Whether a room that rays reach through a hole begins behind it: not so where another space lies between.

    Where the plan of the hole's own room goes on behind it, as beside a flight of stairs, that lies between.
    """
    if plan is None or hole.side.horizontal:
        return True
    middle = float(hole.centre[2])
    ends = LineString([hole.side.point(u, middle)[:2] for u in hole.edges[[0, 2]]])
    if ends.distance(plan) < parameters.max_gap_m + APART_M:
        return True
    if own_goes_on:
        return False
    return int((hole.beyond[to_it & hole.outbound] < CLOSE_M).sum()) >= parameters.min_rays


def _covers_behind(room: Room, plan: Polygon | None, hole: Hole) -> bool:
    """Whether the plan of a room, at its height, covers most of what is right behind a hole in a wall."""
    height = float(hole.centre[2])
    ceiling = np.inf if room.ceiling_elevation is None else room.ceiling_elevation
    if plan is None or hole.side.horizontal or not room.floor_elevation < height < ceiling:
        return False
    u = np.linspace(hole.edges[0], hole.edges[2], 9)
    places = np.stack([u, np.full_like(u, hole.centre @ hole.side.v)], axis=1)
    behind = hole.side.points(places) - np.array(ON_BEHIND_M)[:, None, None] * hole.side.normal
    return float(shapely.contains_xy(plan, behind[..., 0], behind[..., 1]).mean()) > 0.5


def _facing(leads: list[Lead], max_gap_m: float) -> list[list[Lead]]:
    """Group the holes of one pair of rooms that lie in front of one another within the thickness of a wall."""
    first, second = np.nonzero([[_meet(a.hole, b.hole, max_gap_m) for b in leads] for a in leads])
    count = len(leads)
    graph = coo_array((np.ones(len(first)), (first, second)), shape=(count, count))
    parts, number = connected_components(graph, directed=False)
    return [[leads[i] for i in np.flatnonzero(number == part)] for part in range(parts)]


def _overlap(a: Hole, b: Hole, max_gap_m: float) -> bool:
    """Whether two holes overlap by more than a third, both ways, when seen along the normal of their side."""
    if abs(a.side.normal @ b.side.normal) < 0.9 or abs((a.centre - b.centre) @ a.side.normal) > max_gap_m + 0.1:
        return False
    return all(_share(interval(a, along), interval(b, along)) > 1 / 3 for along in (a.side.u, a.side.v))


def _meet(a: Hole, b: Hole, max_gap_m: float) -> bool:
    """Whether two holes overlap, or are in the two faces of a wall and overlap a little: each side may hide a part."""
    if _overlap(a, b, max_gap_m):
        return True
    if a.side.normal @ b.side.normal > -0.9 or abs((a.centre - b.centre) @ a.side.normal) > max_gap_m:
        return False
    return _common_m(a, b, a.side.u) > LEAST_COMMON_M and _common_m(a, b, a.side.v) > LEAST_COMMON_M


def _common_m(a: Hole, b: Hole, along: F64) -> float:
    (low_a, high_a), (low_b, high_b) = interval(a, along), interval(b, along)
    return min(high_a, high_b) - max(low_a, low_b)


def _share(a: tuple[float, float], b: tuple[float, float]) -> float:
    """Return the common part of two intervals as a share of the shorter one."""
    return (min(a[1], b[1]) - max(a[0], b[0])) / min(a[1] - a[0], b[1] - b[0])


def interval(hole: Hole, along: F64) -> tuple[float, float]:
    """Return from where to where a hole reaches along a direction, metres."""
    middle = float(hole.centre @ along)
    half = (abs(float(along @ hole.side.u)) * hole.width + abs(float(along @ hole.side.v)) * hole.height) / 2
    return middle - half, middle + half


def _plan_box(hole: Hole, margin: float) -> Polygon:
    half = (abs(hole.side.u) * hole.width + abs(hole.side.v) * hole.height) / 2
    low, high = hole.centre - half - margin, hole.centre + half + margin
    plan: Polygon = box(low[0], low[1], high[0], high[1])
    return plan
