"""Sets doors, passages, glass walls and windows into a storey's drafts so that every room can be reached."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
import shapely
from shapely import Polygon

from .drafting import CLOSET, RISER_M, Draft
from .layouts import HUB, ROOM, STAIRWELL, Generator
from .linking import Stretch, stretches
from .plan import Hole, Leaf, Point
from .polygons import polygon_of
from .roofs import Roof
from .solids import Mesh, block

OUTSIDE = -1
_NEAR_M = 1.3
_MARGIN_M = 0.13
_KEPT_CLEAR_M = 0.95
_GOING_M = 0.28
_NARROW_M = 0.76
_PARAPET_M = 0.9
_PARTING, _JOINING = (0.4, 1.7), (0.62, 2.7)
"""A passage up to the ceiling takes at most both, or at least one, of this share of the wall and this width in metres:
it is clear what it does."""
_EVERYWHERE = shapely.box(-200.0, -200.0, 300.0, 300.0)


@dataclass(frozen=True, slots=True)
class Habits:
    """How a building's doors and windows are made.

    Attributes
    ----------
    lining
        Thickness of the frames of doors, 0 for none.
    open, ajar, closed
        Shares of the doors whose leaf stands open, ajar, and closed; what is left has no leaf.
    paired
        Whether doors of neighbouring rooms go side by side.
    loops
        Share of the neighbours that get a door though both can be reached without it.
    window_share
        Of the walls to the outside that get windows.
    glass_walls
        Whether rooms get glass walls to the corridor.
    wide
        Whether some ways are wide passages, with a lintel or up to the ceiling.
    """

    lining: float = 0.03
    open: float = 0.68
    ajar: float = 0.1
    closed: float = 0.12
    paired: bool = False
    loops: float = 0.25
    window_share: float = 0.9
    glass_walls: bool = False
    wide: bool = False


@dataclass(frozen=True, slots=True)
class Spot:
    """A place for a hole between two drafts: the wall, metres along it, and the size of the clear hole."""

    wall: Stretch
    along: float
    width: float
    height: float
    lining: float

    @property
    def place(self) -> Point:
        """The middle of the hole in plan."""
        return self.wall.middle(self.along)


@dataclass(slots=True)
class Storey:
    """A storey's drafts with the holes set so far.

    Attributes
    ----------
    names
        Of the drafts; they have to be unique in the building.
    floors
        Elevation of each draft's floor.
    taken
        What holes take of walls, so that no two meet.
    clear
        By draft, what has to be kept free of furniture.
    low_walls
        By draft, what tall furniture must not hide: windows.
    fixtures
        By draft, steps up to doors.
    walled_up
        Drafts that no door leads to.
    """

    drafts: list[Draft]
    names: list[str]
    floors: list[float]
    outline: Polygon
    habits: Habits
    random: Generator
    holes: list[Hole] = field(default_factory=list)
    taken: list[Polygon] = field(default_factory=list)
    clear: dict[int, list[Polygon]] = field(default_factory=lambda: defaultdict(list))
    low_walls: dict[int, list[Polygon]] = field(default_factory=lambda: defaultdict(list))
    fixtures: dict[int, list[Mesh]] = field(default_factory=lambda: defaultdict(list))
    walled_up: set[int] = field(default_factory=set)
    linked: set[frozenset[int]] = field(default_factory=set)

    def link(self) -> set[int]:
        """Set doors until every draft that can be reached is; return which are."""
        near = self._neighbours()
        reached = {next((k for k, d in enumerate(self.drafts) if d.use == HUB), 0)}
        while (added := self._reach(reached, near)) is not None:
            reached.add(added)
        for pair in sorted({(min(a, b), max(a, b)) for a, others in near.items() for b in others}):
            if frozenset(pair) not in self.linked and self._may_loop(*pair):
                self._door(*pair)
        return reached

    def _reach(self, reached: set[int], near: dict[int, list[int]]) -> int | None:
        """Set a door from what is reached to something that is not, and return that."""
        ways = [(self._cost(a, b), a, b) for a in sorted(reached) for b in near[a] if b not in reached]
        return next((b for _, a, b in sorted(ways) if self._door(a, b)), None)

    def _neighbours(self) -> dict[int, list[int]]:
        polygons = np.array([d.polygon for d in self.drafts], dtype=object)
        pairs = shapely.STRtree(polygons).query(polygons, predicate="dwithin", distance=_NEAR_M)
        near: dict[int, list[int]] = defaultdict(list)
        for a, b in sorted(zip(*pairs.tolist(), strict=True)):
            owners = {self.drafts[a].owner, self.drafts[b].owner} - {-1}
            if a != b and (not owners or owners <= {a, b}):
                near[a].append(b)
        return near

    def _cost(self, a: int, b: int) -> tuple[int, int]:
        """Ways from a hub first, then from stairwells and larger rooms."""
        use = self.drafts[a].use
        return (0 if use == HUB else 2 if use == STAIRWELL else 1), -int(self.drafts[a].area)

    def _may_loop(self, a: int, b: int) -> bool:
        uses = {self.drafts[a].use, self.drafts[b].use}
        if uses == {ROOM}:
            return bool(self.random.random() < self.habits.loops)
        return uses == {HUB} or (uses == {HUB, ROOM} and self.random.random() < self.habits.loops)

    def walls(self, a: int, b: int) -> list[Stretch]:
        """Return stretches of wall between two drafts, or a draft and `OUTSIDE`."""
        first, second = (self._plan_of(k) for k in (a, b))
        others = [d.polygon for k, d in enumerate(self.drafts) if k not in (a, b)]
        near = [o for o in others if o.dwithin(second if a == OUTSIDE else first, _NEAR_M)]
        curved = [k != OUTSIDE and self.drafts[k].round for k in (a, b)]
        if all(curved):
            return []
        if curved[0]:
            return stretches(second, first, near, curved=True)
        return stretches(first, second, near, curved=curved[1])

    def _plan_of(self, k: int) -> Polygon:
        return polygon_of(_EVERYWHERE.difference(self.outline)) if k == OUTSIDE else self.drafts[k].polygon

    def _door(self, a: int, b: int) -> bool:
        uses = {self.drafts[a].use, self.drafts[b].use}
        wide = self.habits.wide and uses == {ROOM} and self.random.random() < 0.6
        if wide and self.drafts[a].raised == self.drafts[b].raised and self._passage(a, b):
            return True
        width = 0.68 if CLOSET in uses else float(self.random.choice([0.76, 0.86, 0.86, 0.98]))
        if uses == {HUB}:
            width = 1.2
        height = min(float(self.random.choice([1.985, 2.0, 2.05, 2.11])), self._headroom(a, b) - 0.08)
        return self._set(a, b, width, height) or (width > _NARROW_M and self._set(a, b, _NARROW_M, height))

    def _headroom(self, a: int, b: int) -> float:
        floor = max(self.floors[a], self.floors[b])
        return min(self.drafts[a].roof.ceiling, self.drafts[b].roof.ceiling) - floor

    def _passage(self, a: int, b: int) -> bool:
        """Set a wide way, up to the ceiling or under a lintel."""
        level = self.drafts[a].roof == self.drafts[b].roof and not self.drafts[a].roof.slopes
        lintel = not level or self.random.random() < 0.5
        headroom = self._headroom(a, b)
        walls = self.walls(a, b)
        length = sum(wall.length for wall in walls)
        for wall in (w for w in walls if w.length > 2.2):
            span = (1.5, min(3.2, wall.length - 0.6))
            width = round(float(self.random.uniform(*span)), 2)
            if not lintel:
                width = _clear_cut(
                    width, length, may_join=width > sum(span) / 2 and wall.length - 0.6 > _joining(length)
                )
            height = round(headroom - 0.3, 2) if lintel else headroom
            spot = self._spot(a, b, wall, width, height)
            if spot is not None:
                kind = "door" if lintel else "passage"
                self._add(a, b, spot, Hole(kind, self._ends(a, b), spot.place, width, height))
                return True
        return False

    def _set(self, a: int, b: int, width: float, height: float) -> bool:
        walls, lining = self.walls(a, b), self.habits.lining
        self.random.shuffle(walls)
        for wall in sorted(walls, key=lambda wall: wall.length < width + 0.5):
            spot = self._spot(a, b, wall, width, height, lining=lining)
            if spot is not None:
                hole = Hole("door", self._ends(a, b), spot.place, width, height, leaf=self._leaf(a, b), lining=lining)
                self._add(a, b, spot, hole)
                return True
        return False

    def _spot(self, a: int, b: int, wall: Stretch, width: float, height: float, *, lining: float = 0.0) -> Spot | None:
        """Find a free place for a hole in a wall, and take it."""
        room = width + 2 * lining
        ends = room / 2 + _MARGIN_M, wall.length - room / 2 - _MARGIN_M
        if ends[1] < ends[0]:
            return None
        for along in self._places(a, b, ends):
            span = wall.span(along, room, _MARGIN_M - 0.02, 0.05)
            free = not any(span.intersects(other) for other in self.taken)
            if free and self._high_enough(a, b, wall.span(along, room, 0.0, 0.05), height + lining):
                self.taken.append(span)
                return Spot(wall, along, width, height, lining)
        return None

    def _places(self, a: int, b: int, ends: tuple[float, float]) -> Iterable[float]:
        if self.habits.paired:
            towards = sorted(ends, reverse=bool(max(a, b) % 2))
            return [*towards, *self.random.uniform(*ends, 6)]
        return [float(v) for v in self.random.uniform(*ends, 12)]

    def _high_enough(self, a: int, b: int, span: Polygon, height: float) -> bool:
        floor = max(self.floors[k] for k in (a, b) if k != OUTSIDE)
        corners = shapely.get_coordinates(span)
        roofs = [self.drafts[k].roof for k in (a, b) if k != OUTSIDE]
        return all(roof.heights(corners).min() >= floor + height + (0.05 if roof.slopes else 0.0) for roof in roofs)

    def _ends(self, a: int, b: int) -> tuple[str | None, str | None]:
        return (None if a == OUTSIDE else self.names[a]), (None if b == OUTSIDE else self.names[b])

    def _leaf(self, a: int, b: int) -> Leaf | None:
        """Return a leaf that opens into the smaller room, out of closets and curved or raised rooms into others."""
        habits, chance = self.habits, self.random.random()
        drafts = (self.drafts[a], self.drafts[b])
        into = 0 if drafts[0].area < drafts[1].area else 1
        if drafts[into].use == CLOSET or drafts[into].round:
            into = 1 - into
        if drafts[0].raised != drafts[1].raised:
            into = 0 if drafts[0].raised > drafts[1].raised else 1
        hinge = 1 if self.random.random() < 0.5 else -1
        if chance < habits.open:
            return Leaf(round(float(self.random.uniform(68.0, 92.0)), 1), into, hinge)
        if chance < habits.open + habits.ajar:
            return Leaf(round(float(self.random.uniform(8.0, 40.0)), 1), into, hinge)
        return Leaf(0.0, into, hinge) if chance < habits.open + habits.ajar + habits.closed else None

    def _add(self, a: int, b: int, spot: Spot, hole: Hole) -> None:
        self.holes.append(hole)
        self.linked.add(frozenset((a, b)))
        around = shapely.Point(hole.place).buffer(hole.width / 2 + _KEPT_CLEAR_M, quad_segs=4)
        for k in {a, b} - {OUTSIDE}:
            self.clear[k].append(around)
        if OUTSIDE not in (a, b) and self.floors[a] != self.floors[b]:
            self._add_steps(min(a, b, key=lambda k: self.floors[k]), max(a, b, key=lambda k: self.floors[k]), spot)

    def _add_steps(self, low: int, high: int, spot: Spot) -> None:
        """Put steps before a door to a higher floor."""
        across, gap = spot.wall.across, spot.wall.gap
        beyond = shapely.Point(np.array(spot.place) + across * (gap / 2 + 0.1))
        away = across if beyond.within(self.drafts[low].polygon) else -across
        count = round((self.floors[high] - self.floors[low]) / RISER_M)
        for k in range(1, count):
            step = block((0.0, 0.0), (_GOING_M * (count - k), spot.width + 0.2), 0.0, k * RISER_M)
            shift = np.array(spot.place) + away * (gap / 2 + _GOING_M * (count - k) / 2)
            turn = float(np.degrees(np.arctan2(away[1], away[0])))
            self.fixtures[low].append(step.turned(turn).moved([*shift, self.floors[low]]))

    def entrance(self, k: int, leaf: Leaf, width: float = 0.98) -> Spot | None:
        """Set a door from a draft to the outside."""
        for wall in self.walls(k, OUTSIDE):
            spot = self._spot(k, OUTSIDE, wall, width, 2.05)
            if spot is not None:
                self._add(k, OUTSIDE, spot, Hole("door", self._ends(k, OUTSIDE), spot.place, width, 2.05, leaf=leaf))
                return spot
        return None

    def windows(self, k: int) -> None:
        """Set windows into a draft's walls to the outside."""
        ceiling = self.drafts[k].roof.ceiling
        for wall in self.walls(k, OUTSIDE):
            if wall.length < 1.0 or self.random.random() > self.habits.window_share:
                continue
            sill = float(self.random.choice([0.1, 0.6, 0.85, 0.9, 1.2], p=[0.1, 0.1, 0.4, 0.3, 0.1]))
            height = round(min(float(self.random.uniform(1.1, 1.5)), ceiling - self.floors[k] - sill - 0.15), 2)
            for _ in range(max(1, int(wall.length / 2.8))):
                width = round(min(float(self.random.uniform(0.7, 1.9)), wall.length - 0.4), 2)
                self._window(k, OUTSIDE, wall, width, height, sill)

    def _window(self, a: int, b: int, wall: Stretch, width: float, height: float, sill: float) -> bool:
        spot = self._spot(a, b, wall, width, round(height + sill, 3)) if height > 0.4 else None
        if spot is None:
            return False
        self.holes.append(
            Hole("window", self._ends(a, b), spot.place, width, height, sill=sill, mullions=int(width / 1.2))
        )
        shade = shapely.Point(spot.place).buffer(width / 2 + 0.3, quad_segs=4)
        for k in {a, b} - {OUTSIDE}:
            self.low_walls[k].append(shade)
        return True

    def glaze(self, k: int, hub: int) -> None:
        """Fill what is left of the wall between a room and the hub with glass."""
        height = round(self._headroom(k, hub) - 0.1, 2)
        for wall in self.walls(hub, k):
            for width in np.arange(wall.length - 0.3, 1.2, -0.25):
                if height > 1.8 and self._window(hub, k, wall, round(float(width), 2), height, 0.05):
                    break

    def gallery(self, void: Polygon, name: str, roof: Roof) -> None:
        """Open the side of a draft to the upper part of a tall room, over a parapet."""
        sides = [
            (k, wall)
            for k, d in enumerate(self.drafts)
            for wall in stretches(d.polygon, void, [])
            if d.use in (HUB, ROOM)
        ]
        for k, wall in sorted(sides, key=lambda side: (self.drafts[side[0]].use != HUB, -side[1].length)):
            width = round(min(3.5, wall.length - 0.5), 2)
            headroom = min(self.drafts[k].roof.ceiling, roof.ceiling) - self.floors[k]
            spot = self._spot(k, OUTSIDE, wall, width, round(headroom - 0.25, 2)) if width > 1.2 else None
            if spot is not None:
                ends = (self.names[k], name)
                height = round(spot.height - _PARAPET_M, 2)
                self.holes.append(Hole("window", ends, spot.place, width, height, sill=_PARAPET_M, glazed=False))
                return


def _clear_cut(width: float, length: float, *, may_join: bool) -> float:
    """Return a width near `width` at which a passage clearly joins, or parts, two rooms with a wall of `length`."""
    share, most = _PARTING
    return round(max(width, _joining(length)) if may_join else min(width, share * length, most), 2)


def _joining(length: float) -> float:
    """Return the least width of a passage that clearly joins two rooms with a wall of a length between them."""
    share, least = _JOINING
    return min(share * length, least)
