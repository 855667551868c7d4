"""What the virtual scanner stands in: triangles that know what they are, and the truth about rooms and openings."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from shapely import Polygon

from .solids import F64, I32, Mesh, merge, unit_normals

OUTSIDE = -1


@dataclass(frozen=True, slots=True)
class Storey:
    """A storey: its index from the lowest, its level in metres, its name."""

    index: int
    elevation: float
    name: str


@dataclass(frozen=True, slots=True)
class Room:
    """A space bounded by walls.

    Attributes
    ----------
    number
        Number of the id, also the place in `Scene.rooms`.
    storey
        Index of its storey.
    outline
        Rings as ``(K, 2) float64``, metres, open, the outer one first.
    boundary
        Closed mesh of the space: a point is in the room where it is in the mesh.
    floor_elevation, ceiling_elevation
        Metres; of a ceiling that slopes the median.
    scanned
        Whether a scanner may be set up in it.
    """

    number: int
    storey: int
    name: str
    outline: tuple[F64, ...]
    boundary: Mesh
    floor_elevation: float
    ceiling_elevation: float
    scanned: bool = True

    @property
    def polygon(self) -> Polygon:
        """The plan polygon."""
        return Polygon(self.outline[0], self.outline[1:])

    @property
    def area(self) -> float:
        """Area of the plan polygon, m²."""
        return float(self.polygon.area)


@dataclass(frozen=True, slots=True)
class Opening:
    """A door, passage, window, stairs or hatch.

    Attributes
    ----------
    kind, state
        As in the graph; `state` is None where there is nothing to open.
    position
        ``(3,)`` centre of the hole, metres.
    axis, normal
        ``(3,)`` unit vectors along the width and across the hole.
    width, height
        Of the hole along `axis` and along ``normal × axis``, metres.
    depth
        Thickness of the wall or slab, metres.
    sill
        Height of the lower edge over the floor, metres; None for openings in a slab.
    rooms
        The two rooms, the one that `normal` points away from first; `OUTSIDE` for none.
    ends
        Of stairs: ``(2, 3)`` foot and head, where scanners are wanted; otherwise None.
    """

    kind: str
    state: str | None
    position: F64
    axis: F64
    normal: F64
    width: float
    height: float
    depth: float
    sill: float | None
    rooms: tuple[int, int]
    ends: F64 | None = None

    @property
    def horizontal(self) -> bool:
        """Whether one goes through it level (a door), not up or down (stairs)."""
        return self.kind not in ("stairs", "hatch")


@dataclass(frozen=True, slots=True)
class Furnishing:
    """One piece of furniture or fixture: number of the id, room (`OUTSIDE` for none), name."""

    number: int
    room: int
    name: str


@dataclass(frozen=True, slots=True)
class Scene:
    """Triangles and the truth about them.

    Attributes
    ----------
    mesh
        T triangles, metres.
    furnishing
        ``(T,) int32`` number of the piece of furniture, -1 for structure.
    surface
        ``(T,) int32`` number of the flat side of a wall, slab or other structure, -1 for furniture and glass.
    glass
        ``(T,)`` whether the scanner sees through.
    mirror
        ``(T,)`` whether rays are thrown back.
    stations
        ``(S, 3)`` scanner positions to use, or None to find them.
    outdoors
        ``(K, 3)`` scanner positions outside, in addition to those found.
    """

    name: str
    mesh: Mesh
    furnishing: I32
    surface: I32
    glass: NDArray[np.bool_]
    mirror: NDArray[np.bool_]
    storeys: tuple[Storey, ...]
    rooms: tuple[Room, ...]
    openings: tuple[Opening, ...]
    furnishings: tuple[Furnishing, ...]
    stations: F64 | None = None
    outdoors: F64 = field(default_factory=lambda: np.empty((0, 3)))

    def submesh(self, mask: NDArray[np.bool_]) -> Mesh:
        """Return some of the triangles, in order, with all vertices."""
        return Mesh(self.mesh.vertices, self.mesh.triangles[mask])


class SceneParts:
    """Collects meshes by what they are, and makes per-triangle arrays of them."""

    def __init__(self) -> None:
        self._meshes: list[Mesh] = []
        self._numbers: list[tuple[int, int, bool, bool]] = []
        self._solids = 0

    def add_structure(self, mesh: Mesh) -> None:
        """Add one wall, slab, stair or the like, or all sides of a room."""
        self._add(mesh, solid=self._solids)
        self._solids += 1

    def add_glass(self, mesh: Mesh) -> None:
        """Add a pane."""
        self._add(mesh, glass=True)

    def add_mirror(self, mesh: Mesh) -> None:
        """Add a mirror."""
        self._add(mesh, mirror=True)

    def add_furnishing(self, mesh: Mesh, number: int) -> None:
        """Add a piece of furniture."""
        self._add(mesh, furnishing=number)

    def arrays(self) -> tuple[Mesh, I32, I32, NDArray[np.bool_], NDArray[np.bool_]]:
        """Mesh, furnishing, surface, glass and mirror as `Scene` has them."""
        counts = [len(mesh.triangles) for mesh in self._meshes]
        furnishing, solid, glass, mirror = (np.repeat([n[k] for n in self._numbers], counts) for k in range(4))
        mesh = merge(self._meshes)
        surface = _surfaces(mesh, solid)
        return mesh, furnishing.astype(np.int32), surface, glass.astype(np.bool_), mirror.astype(np.bool_)

    def _add(
        self, mesh: Mesh, *, furnishing: int = -1, solid: int = -1, glass: bool = False, mirror: bool = False
    ) -> None:
        self._meshes.append(mesh)
        self._numbers.append((furnishing, solid, glass, mirror))


def places_of(numbers: NDArray[np.integer], count: int) -> list[NDArray[np.intp]]:
    """Return where each number from 0 to below `count` stands, in order; negative ones are left out."""
    places = np.flatnonzero(numbers >= 0)
    order = places[np.argsort(numbers[places], kind="stable")]
    return np.split(order, np.searchsorted(numbers[order], np.arange(1, count)))[:count]


def _surfaces(mesh: Mesh, solid: NDArray[np.int_]) -> I32:
    """``(T,)`` number of each solid's flat sides: same solid, same normal (to 0.02), same offset (to 1 cm)."""
    normals = unit_normals(mesh)
    offsets = np.einsum("ij,ij->i", normals, mesh.vertices[mesh.triangles[:, 0]])
    keys = np.column_stack([solid, np.round(normals * 50), np.round(offsets * 100)])
    surface = np.full(len(keys), -1, dtype=np.int32)
    structure = solid >= 0
    surface[structure] = np.unique(keys[structure], axis=0, return_inverse=True)[1].reshape(-1)
    return surface


def turned(scene: Scene, angle_deg: float, shift: F64) -> Scene:
    """Return the scene turned anticlockwise about the z axis and then shifted by ``(3,)`` metres."""
    rotation = Mesh(np.eye(3), np.empty((0, 3), dtype=np.int32)).turned(angle_deg).vertices.T

    def placed(points: F64) -> F64:
        moved: F64 = points @ rotation.T + shift
        return moved

    def room(r: Room) -> Room:
        rings = tuple(placed(np.column_stack([ring, np.zeros(len(ring))]))[:, :2] for ring in r.outline)
        floor, ceiling = r.floor_elevation + shift[2], r.ceiling_elevation + shift[2]
        boundary = Mesh(placed(r.boundary.vertices), r.boundary.triangles)
        return replace(
            r, outline=rings, boundary=boundary, floor_elevation=float(floor), ceiling_elevation=float(ceiling)
        )

    def opening(o: Opening) -> Opening:
        ends = None if o.ends is None else placed(o.ends)
        axis, normal = o.axis @ rotation.T, o.normal @ rotation.T
        return replace(o, position=placed(o.position), axis=axis, normal=normal, ends=ends)

    return replace(
        scene,
        mesh=Mesh(placed(scene.mesh.vertices), scene.mesh.triangles),
        storeys=tuple(replace(s, elevation=float(s.elevation + shift[2])) for s in scene.storeys),
        rooms=tuple(room(r) for r in scene.rooms),
        openings=tuple(opening(o) for o in scene.openings),
        stations=None if scene.stations is None else placed(scene.stations),
        outdoors=placed(scene.outdoors),
    )
