"""A tiny scanner for tests: rectangles that stand along the axes, rays from given places, nearest hits.

It makes the very records that the stages before the neighbours hand on, so that those after can be tested alone.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field

import numpy as np

from enfilade.ingest.records import Planes, Room, RoomLabels, Surfels, ThinnedCloud


@dataclass(frozen=True)
class Rectangle:
    """A rectangle across `axis` at `at`, from `low` to `high` along the other two axes, facing `sign`."""

    axis: int
    at: float
    low: tuple[float, float]
    high: tuple[float, float]
    sign: int
    room: int
    plane: bool = True

    @property
    def others(self) -> list[int]:
        return [a for a in range(3) if a != self.axis]


@dataclass
class BoxScene:
    """Rectangles and scanner positions (each with its room)."""

    rectangles: list[Rectangle] = field(default_factory=list)
    scanners: list[tuple[tuple[float, float, float], int]] = field(default_factory=list)
    floors: dict[int, tuple[float, float | None]] = field(default_factory=dict)

    def add(self, axis, at, low, high, sign, room, *, plane=True, holes=()):
        """Add a rectangle with rectangular holes (low, high) cut out."""
        for piece_low, piece_high in pieces(low, high, holes):
            self.rectangles.append(Rectangle(axis, at, piece_low, piece_high, sign, room, plane))

    def room(self, number, low, high, *, holes=None, skip=()):
        """Add the six inner sides of a box; `holes` by side, such as ``{"x1": [((y, z), (y, z))]}``."""
        holes = holes or {}
        for axis, name in enumerate("xyz"):
            others = [a for a in range(3) if a != axis]
            for end, at, sign in ((0, low[axis], 1), (1, high[axis], -1)):
                side = f"{name}{end}"
                if side in skip:
                    continue
                corner_low = tuple(low[a] for a in others)
                corner_high = tuple(high[a] for a in others)
                self.add(axis, at, corner_low, corner_high, sign, number, holes=holes.get(side, ()))
        self.floors[number] = (low[2], high[2])

    def tunnel_x(self, x0, x1, low, high, room, *, sill=False):
        """Line a hole through a wall across x: two jambs, a lintel, a threshold or a sill."""
        (y0, z0), (y1, z1) = low, high
        self.add(1, y0, (x0, z0), (x1, z1), 1, room, plane=False)
        self.add(1, y1, (x0, z0), (x1, z1), -1, room, plane=False)
        self.add(2, z1, (x0, y0), (x1, y1), -1, room, plane=False)
        self.add(2, z0, (x0, y0), (x1, y1), 1, room, plane=sill)

    def block(self, low, high, room, *, plane=False):
        """Add the outer sides of a box, as furniture."""
        for axis in range(3):
            others = [a for a in range(3) if a != axis]
            for at, sign in ((low[axis], -1), (high[axis], 1)):
                self.add(
                    axis, at, tuple(low[a] for a in others), tuple(high[a] for a in others), sign, room, plane=plane
                )

    def scan(self, *, step_deg=0.7, noise=0.002, seed=1, voxel=0.012):
        """Trace all rays; returns cloud, surfels, planes, labels, rooms."""
        rng = np.random.default_rng(seed)
        positions, scans, hit = [], [], []
        for number, (place, _) in enumerate(self.scanners):
            directions = sphere(step_deg)
            distance, rectangle = self._trace(np.array(place), directions)
            seen = np.isfinite(distance)
            noisy = distance[seen] + rng.normal(0, noise, seen.sum())
            positions.append(np.array(place) + noisy[:, None] * directions[seen])
            scans.append(np.full(seen.sum(), number))
            hit.append(rectangle[seen])
        return self._records(np.concatenate(positions), np.concatenate(scans), np.concatenate(hit), voxel)

    def _trace(self, place, directions):
        best = np.full(len(directions), np.inf)
        which = np.full(len(directions), -1)
        for number, r in enumerate(self.rectangles):
            with np.errstate(divide="ignore", invalid="ignore"):
                t = (r.at - place[r.axis]) / directions[:, r.axis]
                crossing = place + t[:, None] * directions
            a, b = r.others
            inside = (crossing[:, a] >= r.low[0]) & (crossing[:, a] <= r.high[0])
            inside &= (crossing[:, b] >= r.low[1]) & (crossing[:, b] <= r.high[1])
            nearer = inside & (t > 1e-6) & (t < best)
            best[nearer] = t[nearer]
            which[nearer] = number
        return best, which

    def _records(self, positions, scans, hit, voxel):
        _, first = np.unique(np.floor(positions / voxel).astype(int), axis=0, return_index=True)
        positions, scans, hit = positions[first], scans[first], hit[first]
        planes_of = self._plane_numbers()
        key = np.column_stack([np.floor(positions / 0.05).astype(int), hit])
        _, surfel_first, point_surfel = np.unique(key, axis=0, return_index=True, return_inverse=True)
        point_surfel = point_surfel.ravel()
        count = np.bincount(point_surfel)
        means = np.column_stack([np.bincount(point_surfel, positions[:, a]) / count for a in range(3)])
        normal = np.zeros((len(self.rectangles), 3))
        for i, r in enumerate(self.rectangles):
            normal[i, r.axis] = r.sign
        surfel_hit = hit[surfel_first]
        surfels = Surfels(
            means.astype(np.float32),
            normal[surfel_hit].astype(np.float32),
            scans[surfel_first].astype(np.int32),
            point_surfel.astype(np.int32),
        )
        room = np.array([r.room for r in self.rectangles])
        cloud = ThinnedCloud(
            positions.astype(np.float32),
            scans.astype(np.int32),
            np.array([p for p, _ in self.scanners], dtype=np.float32),
            tuple(f"scan {i}" for i in range(len(self.scanners))),
            np.zeros(3),
            len(positions),
        )
        scan_room = np.array([r for _, r in self.scanners], dtype=np.int32)
        labels = RoomLabels(
            scan_room[surfels.scan],
            room[surfel_hit].astype(np.int32),
            np.ones(len(means), dtype=np.float32),
            scan_room,
            len(self.floors),
        )
        normals, offsets = self._planes(planes_of, normal)
        planes = Planes(normals, offsets, planes_of[surfel_hit], ())
        return cloud, surfels, planes, labels, self._rooms(surfels, labels)

    def _plane_numbers(self):
        keys: dict[tuple, int] = {}
        return np.array(
            [keys.setdefault((r.axis, r.at, r.sign), len(keys)) if r.plane else -1 for r in self.rectangles],
            dtype=np.int32,
        )

    def _planes(self, planes_of, normal):
        count = planes_of.max() + 1
        normals, offsets = np.zeros((count, 3), dtype=np.float32), np.zeros(count, dtype=np.float32)
        for r, p, n in zip(self.rectangles, planes_of, normal, strict=True):
            if p >= 0:
                normals[p], offsets[p] = n, r.at * r.sign
        return normals, offsets

    def _rooms(self, surfels, labels):
        rooms = []
        for number, (floor, ceiling) in sorted(self.floors.items()):
            own = surfels.positions[labels.after == number].astype(np.float64)
            bounds = np.concatenate([own.min(axis=0), own.max(axis=0)])
            extent = bounds[3:] - bounds[:3]
            rooms.append(
                Room(
                    number,
                    float(extent[0] * extent[1]),
                    floor,
                    ceiling,
                    (bounds[:3] + bounds[3:]) / 2,
                    bounds,
                    (),
                    len(own),
                    (),
                    1.0,
                    -1,
                )
            )
        return tuple(rooms)


def sphere(step_deg):
    """Directions of a scanner that turns about the vertical axis."""
    azimuth = np.radians(np.arange(0, 360, step_deg))
    elevation = np.radians(np.arange(-65, 90, step_deg))
    a, e = np.meshgrid(azimuth, elevation)
    return np.column_stack([(np.cos(e) * np.cos(a)).ravel(), (np.cos(e) * np.sin(a)).ravel(), np.sin(e).ravel()])


def pieces(low, high, holes):
    """Cut rectangular holes out of a rectangle: cells of the grid that all edges make, outside the holes."""
    xs = sorted({low[0], high[0], *(h[i][0] for h in holes for i in (0, 1))})
    ys = sorted({low[1], high[1], *(h[i][1] for h in holes for i in (0, 1))})
    for x0, x1 in itertools.pairwise(xs):
        for y0, y1 in itertools.pairwise(ys):
            middle = ((x0 + x1) / 2, (y0 + y1) / 2)
            if not any(h[0][0] < middle[0] < h[1][0] and h[0][1] < middle[1] < h[1][1] for h in holes):
                yield (x0, y0), (x1, y1)


def two_rooms(*, holes=(), thickness=0.2, step_deg=0.7):
    """Room 0 (4 x 3 m) and room 1 (3 x 3 m), 2.5 m high, a wall across x between them with holes (y, z)."""
    scene = BoxScene()
    x1 = 4.0 + thickness
    scene.room(0, (0, 0, 0), (4, 3, 2.5), holes={"x1": holes})
    scene.room(1, (x1, 0, 0), (x1 + 3, 3, 2.5), holes={"x0": holes})
    for low, high in holes:
        scene.tunnel_x(4.0, x1, low, high, 0)
    scene.scanners = [((2.2, 1.3, 1.5), 0), ((x1 + 1.4, 1.7, 1.5), 1)]
    return scene
