"""The virtual terrestrial laser scanner: what it measures from one position."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .casting import F32, Caster
from .scene import Scene
from .solids import F64, Mesh, unit_normals

Generator = np.random.Generator
_DARKNESS = 7
_CLEAR_M = 1e-3
"""How far off a mirror a ray starts that it throws back."""


@dataclass(frozen=True, slots=True)
class Scanner:
    """What the scanner can and cannot do; defaults are those of a phase-shift scanner set to a coarse grid.

    Attributes
    ----------
    angular_step_deg
        Step of the grid in azimuth and elevation.
    elevation_from_deg, elevation_to_deg
        Vertical field of view; the tripod hides what is below.
    range_noise_m
        Standard deviation of a range.
    range_from_m, range_to_m
        Shortest and longest range.
    mixed_share, mixed_jump_m
        Share of the pixels next to an edge, with at least so much depth behind it, that get a range in between.
    grazing_from_deg
        Angle of incidence from which returns get lost, all of them at 90°.
    glass_return
        Share of rays that a pane sends back; the others go through.
    glass_loss
        Share of the rays through a pane that never come back.
    dropout
        Share of rays lost for no reason.
    dark_share, dark_loss
        Share of the surfaces and pieces of furniture that are dark, and of the rays lost on them.
    people
        Mean number of people who stand about during a scan, elsewhere in each.
    registration_m, registration_deg
        Standard deviation of each coordinate and of each angle of the pose that the registration gives a scan.
    seed
        Of everything random.
    """

    angular_step_deg: float = 0.4
    elevation_from_deg: float = -60.0
    elevation_to_deg: float = 90.0
    range_noise_m: float = 0.002
    range_from_m: float = 0.3
    range_to_m: float = 60.0
    mixed_share: float = 0.2
    mixed_jump_m: float = 0.05
    grazing_from_deg: float = 80.0
    glass_return: float = 0.08
    glass_loss: float = 0.3
    dropout: float = 0.005
    dark_share: float = 0.0
    dark_loss: float = 0.6
    people: float = 0.0
    registration_m: float = 0.002
    registration_deg: float = 0.01
    seed: int = 1


@dataclass(frozen=True, slots=True)
class Pose:
    """Where a scan is said to stand: ``world = rotation @ local + translation``."""

    rotation: F64
    translation: F64

    @property
    def quaternion(self) -> F64:
        """``(4,)`` w, x, y, z of the rotation, for angles below 180°."""
        matrix = self.rotation
        w = np.sqrt(max(0.0, 1.0 + np.trace(matrix))) / 2
        skew = [matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0], matrix[1, 0] - matrix[0, 1]]
        return np.array([w, *(np.array(skew) / (4 * w))])

    def apply(self, local: NDArray[Any]) -> F64:
        """``(K, 3)`` scanner coordinates to ``(K, 3) float64`` world coordinates."""
        moved: F64 = np.einsum("ij,kj->ik", local.astype(np.float64), self.rotation) + self.translation
        return moved


@dataclass(frozen=True, slots=True)
class Scan:
    """What one position measured, K points.

    Attributes
    ----------
    name
        Of the scan in the file.
    pose
        The registered pose, with its error.
    local
        ``(K, 3) float32`` in the scanner's frame, metres.
    intensity
        ``(K,) float32`` in 0 to 1.
    triangle
        ``(K,) int32`` the scene's triangle that was hit, -1 for a person.
    hit
        ``(K, 3) float64`` the true point on that triangle, metres, in the scene's coordinates.
    normal
        ``(K, 3) float32`` its unit normal, turned towards the scanner.
    mixed
        ``(K,)`` whether the range lies between that of two surfaces.
    stray
        ``(K,)`` whether nothing of the building is there: people, and what a mirror shows behind itself.
    """

    name: str
    pose: Pose
    local: F32
    intensity: F32
    triangle: NDArray[np.int32]
    hit: F64
    normal: F32
    mixed: NDArray[np.bool_]
    stray: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class _Hits:
    """What K rays meet: range (infinity for nothing), triangle, unit normal, true point, and whether it is stray."""

    ranges: F32
    triangle: NDArray[np.int32]
    normal: F32
    points: F64
    stray: NDArray[np.bool_]

    def replaced(self, rays: NDArray[np.intp], other: _Hits, *, triangle: NDArray[np.int32]) -> None:
        """Put other hits in the place of some, as stray ones."""
        self.ranges[rays], self.normal[rays], self.points[rays] = other.ranges, other.normal, other.points
        self.triangle[rays], self.stray[rays] = triangle, True


class Tracer:
    """The scene as the scanner's rays meet it."""

    def __init__(self, scene: Scene, scanner: Scanner) -> None:
        self._scanner = scanner
        self._solid_ids = np.flatnonzero(~scene.glass)
        self._glass_ids = np.flatnonzero(scene.glass)
        self._solids = Caster(scene.submesh(~scene.glass))
        self._panes = Caster(scene.submesh(scene.glass))
        self._mirror = scene.mirror
        self._dark = _dark_triangles(scene, scanner)
        self._normals = unit_normals(scene.mesh).astype(np.float32)
        self._directions = ray_grid(scanner)

    def scan(self, name: str, station: F64, generator: Generator, people: Mesh | None = None) -> Scan:
        """Measure from one position, past people; the scanner's frame is turned by a random yaw."""
        yaw = rotation_about_z(generator.uniform(-170.0, 170.0))
        directions = np.einsum("ij,kj->ik", self._directions.reshape(-1, 3), yaw.astype(np.float32))
        hits = self._hits(station, directions, generator, people)
        measured, mixed = self._measure(hits.ranges, directions, hits.normal, generator)
        cosine = -np.einsum("ij,ij->i", hits.normal, directions)
        keep = self._returned(hits, np.abs(cosine), generator)
        normal = hits.normal * np.where(cosine < 0, -1, 1)[:, None].astype(np.float32)
        local = self._directions.reshape(-1, 3)[keep] * measured[keep, None]
        return Scan(
            name,
            self._registered(station, yaw, generator),
            local.astype(np.float32),
            _intensity(hits.triangle[keep], np.abs(cosine[keep]), self._dark[hits.triangle[keep]]),
            hits.triangle[keep],
            hits.points[keep],
            normal[keep],
            mixed[keep],
            hits.stray[keep],
        )

    def _hits(self, station: F64, directions: F32, generator: Generator, people: Mesh | None) -> _Hits:
        ranges, triangle = self._first_hits(station, directions, generator)
        hits = self._hits_of(ranges, triangle, station, directions)
        if people is not None and len(people.triangles):
            self._meet(people, station, directions, hits)
        mirrored = np.flatnonzero((hits.triangle >= 0) & self._mirror[hits.triangle])
        if len(mirrored):
            self._reflect(mirrored, directions, hits)
        return hits

    def _hits_of(self, ranges: F32, triangle: NDArray[np.int32], starts: F64, directions: F32) -> _Hits:
        normal = self._normals[np.maximum(triangle, 0)]
        # Where nothing is met, any point will do.
        points = starts + directions * np.where(np.isfinite(ranges), ranges, 0)[:, None]
        return _Hits(ranges, triangle, normal, points, np.zeros(len(ranges), dtype=np.bool_))

    def _meet(self, people: Mesh, station: F64, directions: F32, hits: _Hits) -> None:
        """Let people stand in the way."""
        ranges, triangle = Caster(people).cast(station, directions)
        before = np.flatnonzero(ranges < hits.ranges)
        normal = unit_normals(people).astype(np.float32)[triangle[before]]
        points = station + directions[before] * ranges[before, None]
        nobody = np.full(len(before), -1, dtype=np.int32)
        body = _Hits(ranges[before], triangle[before], normal, points, np.ones(len(before), dtype=np.bool_))
        hits.replaced(before, body, triangle=nobody)

    def _reflect(self, rays: NDArray[np.intp], directions: F32, hits: _Hits) -> None:
        """Follow rays that mirrors throw back; what they meet is measured straight on, behind the mirror."""
        normal = hits.normal[rays]
        along = np.einsum("ij,ij->i", normal, directions[rays])
        turned = directions[rays] - 2 * along[:, None] * normal
        starts = hits.points[rays] + _CLEAR_M * turned
        ranges, triangle = self._solids.cast(starts, turned)
        met = self._hits_of(ranges, np.where(triangle >= 0, self._solid_ids[triangle], -1), starts, turned)
        there = _Hits(
            hits.ranges[rays] + _CLEAR_M + ranges, met.triangle, _mirrored(met.normal, normal), met.points, met.stray
        )
        hits.replaced(rays, there, triangle=met.triangle.astype(np.int32))

    def _first_hits(self, station: F64, directions: F32, generator: Generator) -> tuple[F32, NDArray[np.int32]]:
        """Range and triangle of what each ray meets; infinity and -1 where it meets nothing."""
        ranges, triangle = self._solids.cast(station, directions)
        ranges = ranges.copy()
        triangle = np.where(triangle >= 0, self._solid_ids[triangle], -1).astype(np.int32)
        if not len(self._glass_ids):
            return ranges, triangle
        pane_range, pane = self._panes.cast(station, directions)
        through = pane_range < ranges
        chance = generator.random(len(ranges), dtype=np.float32)
        back = through & (chance < self._scanner.glass_return)
        lost = through & (chance > 1 - self._scanner.glass_loss)
        ranges = np.where(back, pane_range, np.where(lost, np.float32(np.inf), ranges))
        return ranges, np.where(back, self._glass_ids[pane], np.where(lost, -1, triangle)).astype(np.int32)

    def _measure(
        self, ranges: F32, directions: F32, normal: F32, generator: Generator
    ) -> tuple[F32, NDArray[np.bool_]]:
        """Ranges with noise and edge-mixed pixels, and which those are."""
        edge, beside = self._edges(ranges, directions, normal, generator)
        weight = generator.random(len(edge), dtype=np.float32)
        measured = ranges.copy()
        measured[edge] = weight * ranges[edge] + (1 - weight) * ranges[beside]
        noise = generator.standard_normal(len(ranges), dtype=np.float32)
        mixed = np.zeros(len(ranges), dtype=np.bool_)
        mixed[edge] = True
        return measured + noise * np.float32(self._scanner.range_noise_m), mixed

    def _edges(
        self, ranges: F32, directions: F32, normal: F32, generator: Generator
    ) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Pixels to mix and the neighbour each is mixed with: the next column's, or the next one above.

        Neighbours on one plane differ in range too, so what counts is how far the neighbour lies off the plane.
        """
        scanner = self._scanner
        columns, rows = self._directions.shape[:2]
        chance = generator.random(len(ranges), dtype=np.float32)
        chosen = np.flatnonzero(chance < scanner.mixed_share)
        above = np.where(chosen % rows < rows - 1, chosen + 1, chosen)
        beside = np.where(chance[chosen] < scanner.mixed_share / 2, (chosen + rows) % (columns * rows), above)
        both = np.isfinite(ranges[chosen]) & np.isfinite(ranges[beside])
        chosen, beside = chosen[both], beside[both]
        apart = directions[beside] * ranges[beside, None] - directions[chosen] * ranges[chosen, None]
        off_plane = np.abs(np.einsum("ij,ij->i", normal[chosen], apart))
        jump = (off_plane > scanner.mixed_jump_m) & (np.abs(ranges[beside] - ranges[chosen]) > scanner.mixed_jump_m)
        return chosen[jump], beside[jump]

    def _returned(self, hits: _Hits, cosine: F32, generator: Generator) -> NDArray[np.bool_]:
        """Which rays come back: in range, not lost at a grazing angle, on something dark or at random."""
        scanner = self._scanner
        incidence = np.degrees(np.arccos(np.clip(cosine, 0.0, 1.0)))
        loss = np.clip((incidence - scanner.grazing_from_deg) / (90.0 - scanner.grazing_from_deg), 0.0, 1.0)
        dropout = scanner.dropout + (scanner.dark_loss - scanner.dropout) * self._dark[hits.triangle]
        chance = generator.random(len(hits.ranges), dtype=np.float32)
        in_range = (hits.ranges >= scanner.range_from_m) & (hits.ranges <= scanner.range_to_m)
        return in_range & (chance >= dropout + (1 - dropout) * loss)

    def _registered(self, station: F64, yaw: F64, generator: Generator) -> Pose:
        shift = generator.normal(0.0, self._scanner.registration_m, 3)
        angles = np.radians(generator.normal(0.0, self._scanner.registration_deg, 3))
        return Pose(_small_rotation(angles) @ yaw, station + shift)


def ray_grid(scanner: Scanner) -> F32:
    """``(columns, rows, 3) float32`` unit directions, columns of one azimuth from low to high."""
    step = scanner.angular_step_deg
    azimuth = np.radians(np.arange(0.0, 360.0 - step / 2, step))[:, None]
    elevation = np.radians(np.arange(scanner.elevation_from_deg, scanner.elevation_to_deg + step / 2, step))[None]
    level = np.cos(elevation)
    directions = np.stack(
        np.broadcast_arrays(np.cos(azimuth) * level, np.sin(azimuth) * level, np.sin(elevation)), axis=-1
    )
    return directions.astype(np.float32)


def rotation_about_z(angle_deg: float) -> F64:
    """``(3, 3)`` rotation matrix."""
    cosine, sine = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def _small_rotation(angles: F64) -> F64:
    """Rotation by a ``(3,)`` vector of radians (Rodrigues)."""
    angle = float(np.linalg.norm(angles))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = angles / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotation: F64 = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return rotation


def _mirrored(normal: F32, mirror: F32) -> F32:
    """``(K, 3)`` normals as a mirror of normals `mirror` shows them."""
    shown: F32 = normal - 2 * np.einsum("ij,ij->i", normal, mirror)[:, None] * mirror
    return shown


def _dark_triangles(scene: Scene, scanner: Scanner) -> NDArray[np.bool_]:
    """``(T + 1,)`` whether each triangle is dark, by surface and piece of furniture; the last, for none, is not."""
    thing = np.where(scene.furnishing >= 0, scene.surface.max(initial=-1) + 1 + scene.furnishing, scene.surface)
    chance = np.random.default_rng([scanner.seed, _DARKNESS]).random(int(thing.max(initial=-1)) + 2)
    return np.append((chance < scanner.dark_share)[thing] & (thing >= 0), False)


def _intensity(triangle: NDArray[np.int32], cosine: F32, dark: NDArray[np.bool_]) -> F32:
    """Lambert's law with a reflectance that depends on the triangle pair (a box's side has two)."""
    reflectance = np.where(dark, 0.1, 0.4 + 0.1 * ((triangle // 2) % 6))
    return (reflectance * cosine).astype(np.float32)
