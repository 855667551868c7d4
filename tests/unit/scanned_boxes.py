"""Box-shaped rooms joined by a door, sampled as a scanner would: scenes small enough for unit tests."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from enfilade.ingest.records import Scan

F64 = NDArray[np.float64]


@dataclass(frozen=True)
class Box:
    """A room: low and high corner, scanner, name of its scan."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    scanner: tuple[float, float, float]
    name: str


@dataclass(frozen=True)
class Door:
    """A hole in every wall that is nearly at ``x``, from y to y and up to a height."""

    x: float
    y: tuple[float, float]
    top: float

    def holds(self, points: F64, depth: float = 0.4) -> NDArray[np.bool_]:
        return (
            (np.abs(points[:, 0] - self.x) < depth)
            & (points[:, 1] > self.y[0])
            & (points[:, 1] < self.y[1])
            & (points[:, 2] < self.top)
        )


LEFT = Box((0.0, 0.0, 0.0), (4.0, 3.0, 2.5), (1.5, 1.2, 1.5), "left")
RIGHT = Box((4.15, 0.0, 0.0), (8.0, 3.0, 2.5), (6.5, 1.8, 1.5), "right")
DOOR = Door(4.075, (1.0, 1.9), 2.05)


def scan(own: Box, boxes: list[Box], door: Door | None, *, spacing: float = 0.02, noise: float = 0.002) -> Scan:
    """What one scanner sees: its own room, and through the door a part of the others."""
    rng = np.random.default_rng(len(own.name))
    points = np.concatenate([_surface(box, spacing, rng) for box in boxes])
    room = np.concatenate([np.full(len(_surface(box, spacing, rng)), i) for i, box in enumerate(boxes)])
    scanner = np.array(own.scanner)
    if door is not None:
        points, room = points[~door.holds(points)], room[~door.holds(points)]
    here = room == boxes.index(own)
    if door is not None:
        here |= _through(points, scanner, door)
    points = points[here]
    return Scan.of_points(own.name, "boxes.e57", points + rng.normal(0.0, noise, points.shape), scanner)


def scans(door: Door | None = DOOR) -> list[Scan]:
    """Both rooms, one scan each."""
    return [scan(box, [LEFT, RIGHT], door) for box in (LEFT, RIGHT)]


def _surface(box: Box, spacing: float, rng: np.random.Generator) -> F64:
    low, high = np.array(box.low), np.array(box.high)
    faces = []
    for axis in range(3):
        others = [other for other in range(3) if other != axis]
        steps = [np.arange(low[o] + spacing / 2, high[o], spacing) for o in others]
        grid = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 2)
        for value in (low[axis], high[axis]):
            face = np.full((len(grid), 3), value)
            face[:, others] = grid
            faces.append(face)
    points = np.concatenate(faces)
    return points + rng.uniform(-1e-3, 1e-3, points.shape)


def _through(points: F64, scanner: F64, door: Door) -> NDArray[np.bool_]:
    """Points behind the door that a straight line from the scanner reaches through it."""
    beyond = (points[:, 0] - door.x) * (scanner[0] - door.x) < 0.0
    ray = points - scanner
    seen = beyond.copy()
    for face in (door.x - 0.075, door.x + 0.075):
        share = (face - scanner[0]) / np.where(ray[:, 0] == 0.0, 1.0, ray[:, 0])
        crossing = scanner + share[:, None] * ray
        seen &= door.holds(crossing)
    return seen
