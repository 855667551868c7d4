"""Generates whole buildings, furnished and ready to be scanned: for the same seed always the same."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import count, pairwise

import numpy as np

from . import drafting
from .build import build
from .doors import Habits, Storey
from .drafting import CLOSET, TALL, Draft, Walls
from .faults import FAULTS
from .furnishing import furnish
from .interiors import Interior
from .layouts import HUB, LAYOUTS, ROOM, STAIRWELL, Frame, Generator, Layout
from .plan import Leaf, Level, Plan, Space
from .recipes import FEATURES, Recipe, half_of, recipe_of
from .roofs import Roof
from .scene import Scene, turned
from .simulation import Parameters
from .solids import Mesh
from .stairwells import reserve_stairs, stairs_between
from .stations import Setup
from .surroundings import GARDEN_M, balcony, grounds_of

_SLAB_M = 0.3
_KNEE_M = 1.1
_RAISED_BY = 2
_UNSCANNED_SHARE = 0.3
_GLAZED_SHARE = 0.6
_GLAZED_FROM_M2 = 8.0
_TRIES = 8


@dataclass(frozen=True, slots=True)
class Generated:
    """A generated building.

    Attributes
    ----------
    name
        Kind of building and seed.
    half
        ``develop`` or ``check``.
    description
        What makes it hard, in words.
    scene
        To be scanned.
    parameters
        How.
    """

    name: str
    half: str
    description: str
    scene: Scene
    parameters: Parameters


def name_of(seed: int) -> str:
    """Return the name of the building of a seed."""
    return f"{recipe_of(seed).name.replace(' ', '-')}-{seed:02d}"


def generate(seed: int, *, faults: str | None = None) -> Generated:
    """Generate the building of a seed.

    Parameters
    ----------
    seed
        From 1.
    faults
        A key of `FAULTS`, in place of that of the recipe.
    """
    recipe = recipe_of(seed)
    chosen = faults or recipe.faults
    plan, random = _plan(seed, recipe, chosen)
    scene = build(plan)
    if "turned" in recipe.features:
        shift = np.array([*random.uniform(-900.0, 900.0, 2).round(1), round(float(random.uniform(5, 300)), 1)])
        scene = turned(scene, round(float(random.uniform(8.0, 82.0)), 1), shift)
    scanner = replace(FAULTS[chosen], angular_step_deg=recipe.step_deg, seed=seed)
    said = ", ".join(FEATURES[name] for name in sorted(recipe.features))
    description = f"{len(scene.storeys)} storeys, {len(scene.rooms)} rooms, {chosen} faults: {said}"
    return Generated(scene.name, half_of(seed), description, scene, Parameters(scanner, _setup(recipe)))


def generated_plan(seed: int) -> Plan:
    """Return the plan that the building of a seed is built after."""
    recipe = recipe_of(seed)
    return _plan(seed, recipe, recipe.faults)[0]


def _plan(seed: int, recipe: Recipe, faults: str) -> tuple[Plan, Generator]:
    """Make plans until one comes out whose stairs can be reached on all storeys."""
    for attempt in count(4):
        random = np.random.default_rng([seed, attempt])
        maker = _Maker(name_of(seed), recipe, faults, random)
        plan = maker.plan()
        if not maker.stuck:
            break
    return plan, random


def _setup(recipe: Recipe) -> Setup:
    if "few scans" in recipe.features:
        return Setup(area_a_scan_m2=60.0, seen_share=0.7, gain_share=0.2)
    if "many scans" in recipe.features:
        return Setup(area_a_scan_m2=9.0, seen_share=0.99)
    return Setup(area_a_scan_m2=recipe.area_a_scan_m2)


class _Maker:
    """Makes the plan of one building; `stuck` says that no door leads to its stairs or main rooms."""

    def __init__(self, name: str, recipe: Recipe, faults: str, random: Generator) -> None:
        self._name, self._recipe, self._random, self._faults = name, recipe, random, faults
        thick, thin = self._has("thick walls"), self._has("thin walls")
        outer = (0.45, 0.6) if thick else (0.2, 0.26) if thin else (0.28, 0.42)
        inner = (0.22, 0.45) if thick else (0.07, 0.11) if thin else (0.1, 0.22)
        self._walls = Walls(round(float(random.uniform(*outer)), 2), inner, random)
        self._height = round(float(random.uniform(2.45, 2.75) if recipe.dwelling else random.uniform(2.7, 3.2)), 2)
        self._frame = self._framed()
        self._habits = self._inhabited()
        self._count: Counter[str] = Counter()
        self._solids: list[Mesh] = []
        self.stuck = False

    def _has(self, feature: str) -> bool:
        return feature in self._recipe.features

    def _framed(self) -> Frame:
        recipe, random = self._recipe, self._random
        width, depth = (round(float(random.uniform(*span)), 1) for span in (recipe.width, recipe.depth))
        corridors = {"hall": (2.9, 3.4), "flat": (1.2, 1.7)}
        corridor = round(float(random.uniform(*corridors.get(recipe.layout, (1.35, 2.3)))), 2)
        line = round((depth - corridor) * float(random.uniform(0.42, 0.52)), 2)
        stairs = recipe.storeys > 1 and recipe.layout != "hall"
        if stairs and recipe.layout != "suite":
            depth = max(depth, round(line + corridor + 5.4, 2))
        return Frame(width, depth, recipe.wing, line, corridor, stairs, recipe.room_width)

    def _inhabited(self) -> Habits:
        shares = (0.25, 0.15, 0.55) if self._has("shut") else (0.68, 0.1, 0.1)
        return Habits(
            float(self._random.choice([0.0, 0.02, 0.03, 0.04])),
            *shares,
            paired=self._has("paired doors"),
            loops=0.12 if self._has("paired doors") else 0.25,
            glass_walls=self._has("glass walls"),
            wide=self._has("wide passages"),
        )

    def plan(self) -> Plan:
        """Make the plan."""
        layouts = self._layouts()
        storeys = [self._storey(index, *named, layouts[index]) for index, named in enumerate(self._floors())]
        stairs = tuple(stairs_between(lower, upper, topmost=upper is storeys[-1]) for lower, upper in pairwise(storeys))
        outdoors = 2 + int(self._random.integers(2)) if self._has("outside scans") else 0
        ground = -round(float(self._random.uniform(0.12, 0.5)), 2)
        grounds = grounds_of(layouts[0].outline, ground, outdoors, self._random)
        levels = [self._level(*named, storey) for named, storey in zip(self._floors(), storeys, strict=True)]
        if self._has("unscanned"):
            levels = _with_unscanned(levels)
        return Plan(
            self._name,
            layouts[0].outline,
            tuple(levels),
            stairs,
            _SLAB_M,
            GARDEN_M,
            ground,
            (*grounds.solids, *self._solids),
            grounds.stations,
        )

    def _floors(self) -> list[tuple[str, float]]:
        """Names and elevations of the storeys."""
        below = self._has("basement")
        above = ["Ground floor", "Upper floor", "Second floor"][: self._recipe.storeys - below]
        names = ["Basement", *above] if below else above
        if self._has("attic"):
            names[-1] = "Attic"
        rise = self._height + _SLAB_M
        return [(name, round((k - below) * rise, 2)) for k, name in enumerate(names)]

    def _layouts(self) -> list[Layout]:
        """Divide the storeys, some like the one below, all with the stairs in one place."""
        layouts = [self._layout()]
        hub = layouts[0].cells[0].rectangle
        for _ in range(1, self._recipe.storeys):
            tries = [self._layout() for _ in range(_TRIES)] if self._random.random() < 0.6 else []
            fit = [layout for layout in tries if layout.cells[0].rectangle == hub]
            layouts.append(layouts[-1] if self._has("double height") or not fit else fit[0])
        return layouts

    def _layout(self) -> Layout:
        layout = LAYOUTS[self._recipe.layout](self._frame, self._random)
        if self._has("open plan"):
            layout = drafting.with_open_plan(layout, self._random, 2 + int(self._random.integers(2)))
        return layout

    def _storey(self, index: int, name: str, floor: float, layout: Layout) -> Storey:
        drafts = drafting.drafts_of(layout, self._walls, self._roof(name, floor))
        void = None
        if self._has("double height"):
            over = self._roof(name, floor + self._height + _SLAB_M) if index == 0 else None
            drafts, void = drafting.with_tall_room(drafts, over)
        if name != "Attic":
            drafts = self._shaped(drafts)
        names = [self._named(draft, name) for draft in drafts]
        floors = [floor + draft.raised for draft in drafts]
        storey = Storey(drafts, names, floors, layout.outline, self._habits, self._random)
        if self._recipe.storeys > 1:
            reserve_stairs(storey)
        self._set_holes(storey, name)
        if void is not None and index == 1:
            storey.gallery(void, self._tall, self._roof(name, floor))
        return storey

    def _roof(self, name: str, floor: float) -> Roof:
        if name != "Attic":
            return Roof(round(floor + self._height, 3))
        steep = float(self._random.uniform(0.75, 1.0))
        eaves = floor + _KNEE_M - steep * self._walls.outer
        slopes = ((0.0, steep, eaves), (0.0, -steep, eaves + steep * self._frame.depth))
        return Roof(round(floor + self._height, 3), slopes)

    def _shaped(self, drafts: list[Draft]) -> list[Draft]:
        """Make of plain rooms what the recipe asks for."""
        random = self._random
        if self._has("round room") or self._has("octagon"):
            drafts = drafting.with_round_room(drafts, 28 if self._has("round room") else 8)
        if self._has("columns"):
            drafts = drafting.with_columns(drafts, random)
        if self._has("closets"):
            drafts = drafting.with_closets(drafts, 2, random)
        if self._has("low ceilings"):
            drafts = drafting.with_low_ceilings(drafts, random)
        if self._has("raised floors"):
            drafts = drafting.with_raised_floors(drafts, _RAISED_BY, random)
        return drafts

    def _named(self, draft: Draft, storey: str) -> str:
        kind = self._kind(draft, storey)
        self._count[kind] += 1
        name = f"{kind} {self._count[kind]}"
        if draft.use == TALL:
            self._tall = name
        return name

    def _kind(self, draft: Draft, storey: str) -> str:
        fixed = {HUB: "Corridor" if self._recipe.layout == "corridor" else "Hall", STAIRWELL: "Stairwell"}
        fixed |= {CLOSET: "Closet", TALL: "Living room"}
        if draft.use in fixed:
            return fixed[draft.use]
        if storey == "Basement":
            return "Store"
        kinds = _DWELLING if self._recipe.dwelling else _WORK
        fit = next(names for most, names in kinds if draft.area < most)
        fresh = [name for name in fit if not self._count[name]] or fit
        return str(self._random.choice(fresh))

    def _set_holes(self, storey: Storey, name: str) -> None:
        reached = storey.link()
        self._drop(storey, reached)
        if storey.floors[0] - storey.drafts[0].raised == 0.0:
            leaf = Leaf(0.0, 0)
            any(
                storey.entrance(k, leaf)
                for k in sorted(range(len(storey.drafts)), key=lambda k: storey.drafts[k].use != HUB)
            )
        if self._has("balcony") and name == self._floors()[-1][0]:
            self._add_balcony(storey)
        hub = next((k for k, d in enumerate(storey.drafts) if d.use == HUB), None)
        for k, draft in enumerate(storey.drafts):
            if k in storey.walled_up:
                continue
            glazed = self._habits.glass_walls and draft.use == ROOM and draft.area > _GLAZED_FROM_M2
            if glazed and hub is not None and self._random.random() < _GLAZED_SHARE:
                storey.glaze(k, hub)
            if draft.use not in (CLOSET, STAIRWELL) and name != "Basement":
                storey.windows(k)

    def _drop(self, storey: Storey, reached: set[int]) -> None:
        """Leave rooms that no door leads to walled up."""
        for k in range(len(storey.drafts)):
            if k not in reached:
                storey.walled_up.add(k)
                self.stuck |= storey.drafts[k].use in (HUB, STAIRWELL, TALL)

    def _add_balcony(self, storey: Storey) -> None:
        rooms = sorted((k for k, d in enumerate(storey.drafts) if d.use == ROOM), key=lambda k: -storey.drafts[k].area)
        angle = 0.0 if self._random.random() < 0.5 else 85.0
        for k in rooms:
            spot = storey.entrance(k, Leaf(angle, 0, glass=True), width=0.9)
            if spot is not None:
                self._solids += balcony(spot, storey.floors[k])
                return

    def _level(self, name: str, floor: float, storey: Storey) -> Level:
        spaces = [self._space(storey, k) for k in range(len(storey.drafts)) if k not in storey.walled_up]
        return Level(name, floor, round(floor + self._height, 3), tuple(spaces), tuple(storey.holes))

    def _space(self, storey: Storey, k: int) -> Space:
        draft, random = storey.drafts[k], self._random
        room = Interior(draft, storey.floors[k], storey.clear[k], storey.low_walls[k], random)
        kind = storey.names[k].rsplit(" ", 1)[0]
        clutter = {"light": 0, "medium": 1, "heavy": 2}[self._faults] + (4 if self._has("cramped") else 0)
        mirror = self._has("mirrors") and draft.use in (ROOM, HUB) and random.random() < 0.4
        furnish(room, kind, random, clutter=0 if draft.use in (CLOSET, STAIRWELL) else clutter, mirror=mirror)
        skipped = self._has("unscanned") and draft.use == ROOM and random.random() < _UNSCANNED_SHARE
        return Space(
            storey.names[k],
            draft.polygon,
            tuple(room.pieces),
            storey.floors[k],
            draft.roof,
            tuple(room.mirrors),
            tuple(storey.fixtures[k]),
            scanned=draft.use != CLOSET and not skipped,
        )


def _with_unscanned(levels: Sequence[Level]) -> list[Level]:
    """See to it that there is a room without scans: if there is none, the smallest becomes one."""
    spaces = [space for level in levels for space in level.spaces]
    if not all(space.scanned for space in spaces):
        return list(levels)
    smallest = min(spaces, key=lambda space: space.polygon.area)
    return [
        replace(level, spaces=tuple(replace(s, scanned=s is not smallest) for s in level.spaces)) for level in levels
    ]


_DWELLING = (
    (3.4, ("Toilet", "Store")),
    (6.5, ("Bath", "Store", "Study")),
    (10.5, ("Kitchen", "Bath", "Bedroom", "Study")),
    (18.0, ("Kitchen", "Bedroom", "Dining room", "Living room")),
    (np.inf, ("Living room", "Dining room", "Bedroom")),
)
_WORK = (
    (4.5, ("Toilet", "Store")),
    (9.0, ("Office", "Kitchen", "Store", "Toilet")),
    (20.0, ("Office", "Meeting room")),
    (45.0, ("Meeting room", "Office", "Open office")),
    (np.inf, ("Open office",)),
)
"""Areas up to which rooms are of these kinds."""
