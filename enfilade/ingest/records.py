"""What the stages hand to one another: small frozen dataclasses of arrays.

Conventions: ``N`` points of the thinned cloud, ``M`` surfels, ``P`` planes, ``S`` scans, ``R`` rooms. Positions
are metres relative to the building's origin. Index arrays use -1 for "none".
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]
I32 = NDArray[np.int32]
U8 = NDArray[np.uint8]
Bool = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Chunk:
    """Some of the points of a scan, so few (`readers.CHUNK`) that no file needs memory that counts.

    Attributes
    ----------
    positions
        ``(n, 3) float64``, metres, in the coordinates that all scans share; finite.
    intensity
        ``(n,) float32`` as the file has it, or None.
    colour
        ``(n, 3) uint8`` red, green, blue, or None.
    """

    positions: F64
    intensity: F32 | None = None
    colour: U8 | None = None


@dataclass(frozen=True, slots=True)
class Scan:
    """What one scanner position measured, as a reader hands it on.

    A moving scanner comes back to where it was: scans of one source that are named alike are parts of one.

    Attributes
    ----------
    name
        The scan's name in its file.
    source
        Name of the file.
    chunks
        The points, to be gone through once, before the next scan is asked for.
    scanner_position
        ``(3,) float64``, metres, in the same coordinates.
    """

    name: str
    source: str
    chunks: Iterable[Chunk]
    scanner_position: F64

    @classmethod
    def of_points(cls, name: str, source: str, positions: F64, scanner_position: F64) -> Scan:
        """Return a scan whose points, ``(n, 3) float64``, are in memory already."""
        return cls(name, source, (Chunk(positions),), scanner_position)


@dataclass(frozen=True, slots=True)
class ThinnedCloud:
    """All scans of a building, at most one point a voxel.

    Attributes
    ----------
    positions
        ``(N, 3) float32``, metres, relative to `origin`.
    scan
        ``(N,) int32``, the scan that measured the point.
    scanner_positions
        ``(S, 3) float32``, metres, relative to `origin`.
    scan_names
        S names, each another.
    origin
        ``(3,) float64``, metres: add it to get the scans' own coordinates.
    raw_count
        Points read, before thinning.
    intensity
        ``(N,) float32`` as the files have it, NaN where a scan has none; None where no scan has.
    colour
        ``(N, 3) uint8`` red, green, blue, black where a scan has none; None where no scan has.
    read_as
        ``(S,) int32`` the number of each scan in the order in which they were read; None where that is this order.
    """

    positions: F32
    scan: I32
    scanner_positions: F32
    scan_names: tuple[str, ...]
    origin: F64
    raw_count: int
    intensity: F32 | None = None
    colour: U8 | None = None
    read_as: I32 | None = None


@dataclass(frozen=True, slots=True)
class Surfels:
    """Small oriented patches: everything after thinning works on these.

    Attributes
    ----------
    positions, normals
        ``(M, 3) float32``; the normals are unit vectors turned towards the scanner.
    scan
        ``(M,) int32``, the scan that measured most of the surfel's points.
    point_surfel
        ``(N,) int32``, the surfel of each point of the thinned cloud, -1 for none.
    """

    positions: F32
    normals: F32
    scan: I32
    point_surfel: I32


@dataclass(frozen=True, slots=True)
class Bitmap:
    """Occupancy bitmap of a plane (§4): cell (i, j) covers ``origin + (j, j+1) cell_m u + (i, i+1) cell_m v``.

    Attributes
    ----------
    origin, u, v
        ``(3,) float32`` corner and unit axes in the plane.
    cell_m
        Side of a cell, metres.
    occupancy
        ``(H, W) float32`` in [0, 1], box-filtered.
    """

    origin: F32
    u: F32
    v: F32
    cell_m: float
    occupancy: F32


@dataclass(frozen=True, slots=True)
class Planes:
    """Planar patches, one per side of a wall.

    Attributes
    ----------
    normals
        ``(P, 3) float32`` unit vectors that point into the room.
    offsets
        ``(P,) float32``: ``normal · x = offset`` on the plane.
    surfel_plane
        ``(M,) int32``, the plane of each surfel, -1 for none.
    bitmaps
        P occupancy bitmaps.
    """

    normals: F32
    offsets: F32
    surfel_plane: I32
    bitmaps: tuple[Bitmap, ...]

    @property
    def horizontal(self) -> Bool:
        """``(P,)``: floors, ceilings and other level planes (within 15°)."""
        return np.greater(np.abs(self.normals[:, 2]), np.cos(np.radians(15.0)))

    @property
    def vertical(self) -> Bool:
        """``(P,)``: walls (within 15°)."""
        return np.less(np.abs(self.normals[:, 2]), np.sin(np.radians(15.0)))


@dataclass(frozen=True, slots=True)
class Groups:
    """Which scans share a room, before any point is looked at (§4, first phase).

    Attributes
    ----------
    scan_room
        ``(S,) int32`` room of each scan, -1 for those that stood outside.
    viewpoints
        ``(S, 3) float32``, metres: the scanners lifted to just below the ceiling, where lintels close the doors.
    floors
        ``(S,) float32`` height of the floor under each scanner, metres; -inf where none is seen.
    votes
        ``(S,) bool``, whether what the scan sees tells its room; one that stood in a wide passage sees two.
    """

    scan_room: I32
    viewpoints: F32
    floors: F32
    votes: Bool


@dataclass(frozen=True, slots=True)
class RoomLabels:
    """Which room each surfel belongs to (§4).

    Attributes
    ----------
    before, after
        ``(M,) int32`` room label before and after the diffusion, -1 for none. Before: the room of the scan.
    agreement
        ``(M,) float32`` share of the summed label distribution that the winning label has.
    scan_room
        ``(S,) int32`` room that each scan stands in, -1 for none.
    room_count
        R.
    """

    before: I32
    after: I32
    agreement: F32
    scan_room: I32
    room_count: int


@dataclass(frozen=True, slots=True)
class Plan:
    """A room seen from above, with its floor and ceiling; metres.

    Attributes
    ----------
    area
        m².
    centre
        ``(2,)``.
    outline
        Rings ``(K, 2)``, the outer one first.
    floor_elevation, ceiling_elevation
        None for a ceiling that is not level or was not seen.
    floor_plane
        Number of the floor's plane, -1 for none.
    """

    area: float
    centre: F64
    outline: tuple[F64, ...]
    floor_elevation: float
    ceiling_elevation: float | None
    floor_plane: int


@dataclass(frozen=True, slots=True)
class Room:
    """What was measured of one room; lengths in metres, relative to the origin.

    `outline` holds rings as ``(K, 2) float64`` arrays, outer one first; `scan_positions` is ``(S, 3) float64``, where
    the scanners of `scans` stood.
    """

    number: int
    area: float
    floor_elevation: float
    ceiling_elevation: float | None
    centroid: F64
    bounds: F64
    outline: tuple[F64, ...]
    point_count: int
    scans: tuple[str, ...]
    confidence: float
    floor_plane: int
    scan_positions: F64 = field(default_factory=lambda: np.empty((0, 3)))


@dataclass(frozen=True, slots=True)
class Storey:
    """Rooms (by number) whose floors lie at one level."""

    index: int
    elevation: float
    rooms: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Neighbour:
    """Two rooms that share a wall, floor or ceiling (§5.1).

    `plane_pairs` are (plane on the side of room a, plane on the side of room b).
    """

    room_a: int
    room_b: int
    gap: float
    area: float
    plane_pairs: tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True)
class Opening:
    """A hole between two rooms, or between a room and the outside (`room_b` is None) (§5.2).

    `sill` is how high it begins over the floor, `lintel` how much wall there is over it, 0 for a passage, None for one
    in a floor; `evidence` is what `confidence` was made of, by name.
    """

    kind: str
    orientation: str
    room_a: int
    room_b: int | None
    position: F64
    normal: F64
    width: float
    height: float
    sill: float
    area: float
    ray_count: int
    state: str | None
    confidence: float
    lintel: float | None = None
    evidence: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Segment:
    """One connected component of a room's points that is no structure (§6.1).

    `points` are indices into the thinned cloud.
    """

    number: int
    room: int
    points: I32
    size: F64
    position: F64
    floor_offset: float


@dataclass(frozen=True, slots=True)
class Combination:
    """One to three nearby segments described together (§6.2)."""

    segments: tuple[int, ...]
    size: F64
    position: F64
    floor_offset: float
    point_count: int
    descriptor: NDArray[np.uint16]
    foot_descriptor: NDArray[np.uint16]


@dataclass(frozen=True, slots=True)
class Objects:
    """Everything that stands or hangs in the rooms.

    `near` holds (segment, segment, least distance in metres).
    """

    segments: tuple[Segment, ...]
    combinations: tuple[Combination, ...]
    near: tuple[tuple[int, int, float], ...] = field(default=())
