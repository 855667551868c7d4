"""Real homes as room graphs (CubiCasa5k), in metres: what a storey of a corpus is made of."""

from __future__ import annotations

import gzip
import json
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any, Final

FUNCTIONS: Final = {
    "Bath": "bath",
    "Bedroom": "bedroom",
    "Entry": "hall",
    "Garage": "garage",
    "Kitchen": "kitchen",
    "LivingRoom": "living room",
    "Outdoor": "terrace",
    "Storage": "storage",
}
WALL_M: Final = 0.45
"""Rooms whose boxes are no farther apart share a wall."""

SHARED_M: Final = 0.5
"""Least length of wall that two neighbours share."""

Box = tuple[float, float, float, float]
"""x0 y0 x1 y1, metres."""


@dataclass(frozen=True, slots=True)
class PlanRoom:
    """A room of a plan; nothing says what an undefined one is for."""

    function: str | None
    area: float
    box: Box


@dataclass(frozen=True, slots=True)
class PlanDoor:
    """A door between two rooms, by number, or from one to the outside."""

    rooms: tuple[int, ...]
    position: tuple[float, float]
    width: float


@dataclass(frozen=True, slots=True)
class PlanWall:
    """Where two rooms are neighbours: the gap between their boxes and the length that they share, metres."""

    rooms: tuple[int, int]
    gap: float
    length: float


@dataclass(frozen=True, slots=True)
class Home:
    """One plan."""

    rooms: tuple[PlanRoom, ...]
    doors: tuple[PlanDoor, ...]
    walls: tuple[PlanWall, ...]

    @property
    def outline(self) -> Box:
        """The box around all rooms."""
        sides = list(zip(*(room.box for room in self.rooms), strict=True))
        return min(sides[0]), min(sides[1]), max(sides[2]), max(sides[3])


def read_homes(path: Path) -> list[Home]:
    """Read plans, one a line; those with fewer than two rooms are left out."""
    with gzip.open(path, "rt", encoding="utf-8") as file:
        homes = [_home(json.loads(line)) for line in file]
    return [home for home in homes if len(home.rooms) > 1]


def overlap(a: Box, b: Box) -> float:
    """Return the area that two boxes share, square metres."""
    width, depth = min(a[2], b[2]) - max(a[0], b[0]), min(a[3], b[3]) - max(a[1], b[1])
    return max(width, 0.0) * max(depth, 0.0)


def _home(plan: dict[str, Any]) -> Home:
    scale = plan["m_per_px"]
    rooms = tuple(PlanRoom(FUNCTIONS.get(r["type"]), r["m2"], _box(r["bbox"], scale)) for r in plan["rooms"])
    doors = []
    for a, b, x, y, width in plan["doors"]:
        sides = tuple(dict.fromkeys(side for side in (a, b) if side >= 0))
        if sides:
            doors.append(PlanDoor(sides, (x * scale, y * scale), width * scale))
    pairs = (_wall(a, b, rooms[a].box, rooms[b].box) for a, b in combinations(range(len(rooms)), 2))
    return Home(rooms, tuple(doors), tuple(wall for wall in pairs if wall is not None))


def _box(pixels: list[int], scale: float) -> Box:
    x0, y0, x1, y1 = (value * scale for value in pixels)
    return x0, y0, x1, y1


def _wall(a: int, b: int, one: Box, other: Box) -> PlanWall | None:
    gap_x, gap_y = (max(one[i], other[i]) - min(one[i + 2], other[i + 2]) for i in (0, 1))
    gap, length = max(gap_x, gap_y), -min(gap_x, gap_y)
    return PlanWall((a, b), max(gap, 0.05), length) if gap <= WALL_M and length >= SHARED_M else None
