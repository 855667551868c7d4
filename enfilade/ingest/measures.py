"""What is measured of a room: area, floor and ceiling, outline, bounds (§4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import ndimage

from .records import F32, F64, I32, Bool, Planes, Room, RoomLabels, Surfels, ThinnedCloud

I64 = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class MeasureParameters:
    """How rooms are measured.

    Attributes
    ----------
    area_cell_m
        Side of the plan grid's cells (c of §4).
    outline_gap_m
        Gaps in the plan up to this wide are closed before the outline is drawn.
    outline_tolerance_m
        How far the simplified outline may stray.
    """

    area_cell_m: float = 0.05
    outline_gap_m: float = 0.30
    outline_tolerance_m: float = 0.06


def measure_rooms(
    cloud: ThinnedCloud,
    surfels: Surfels,
    planes: Planes,
    labels: RoomLabels,
    parameters: MeasureParameters = MeasureParameters(),
) -> tuple[Room, ...]:
    """Measure every room, in order of number."""
    order = np.argsort(labels.after, kind="stable")
    ends = np.cumsum(np.bincount(labels.after + 1, minlength=labels.room_count + 1))
    point_room = labels.after[surfels.point_surfel[surfels.point_surfel >= 0]]
    counts = np.bincount(point_room[point_room >= 0], minlength=labels.room_count)
    rooms = []
    for number in range(labels.room_count):
        members = order[ends[number] : ends[number + 1]]
        scans = np.flatnonzero(labels.scan_room == number)
        positions, plane = surfels.positions[members], planes.surfel_plane[members]
        level = positions[_on(planes.horizontal, plane)]
        level = level if len(level) else positions
        floor = _floor(planes, positions, plane, cloud.scanner_positions[scans])
        elevation = _mean_height(positions[plane == floor]) if floor >= 0 else float(positions[:, 2].min())
        rooms.append(
            Room(
                number=number,
                area=_area(level, parameters.area_cell_m),
                floor_elevation=elevation,
                ceiling_elevation=_ceiling(planes, positions, plane, elevation),
                centroid=_centroid(level, elevation, parameters.area_cell_m),
                bounds=np.concatenate([positions.min(axis=0), positions.max(axis=0)]).astype(np.float64),
                outline=_outline(level, parameters),
                point_count=int(counts[number]),
                scans=tuple(cloud.scan_names[scan] for scan in scans),
                confidence=float(labels.agreement[members].mean(dtype=np.float64)),
                floor_plane=floor,
            )
        )
    return tuple(rooms)


def _mean_height(positions: F32) -> float:
    return float(positions[:, 2].mean(dtype=np.float64))


def _on(kind: Bool, plane: I32) -> Bool:
    """Where `plane` is one of a kind."""
    return (plane >= 0) & np.append(kind, False)[plane]


def _floor(planes: Planes, positions: F32, plane: I32, scanners: F32) -> int:
    """Plane that holds most of the room's floor (Eq. 7), of those below its scanners if it has any; -1 for none."""
    upward = _on(planes.horizontal & (planes.normals[:, 2] > 0.0), plane)
    if len(scanners):
        upward &= positions[:, 2] < scanners[:, 2].min()
    return int(np.argmax(np.bincount(plane[upward]))) if upward.any() else -1


def _ceiling(planes: Planes, positions: F32, plane: I32, floor: float, least_height_m: float = 1.5) -> float | None:
    """Mean height of the plane that holds most of the room's ceiling."""
    downward = _on(planes.horizontal & (planes.normals[:, 2] < 0.0), plane)
    downward &= positions[:, 2] > floor + least_height_m
    if not downward.any():
        return None
    ceiling = np.argmax(np.bincount(plane[downward]))
    return _mean_height(positions[downward & (plane == ceiling)])


def _area(level: F32, cell_m: float) -> float:
    """Number of plan cells that hold a horizontal surfel, times their area."""
    return len(np.unique(_cells(level, cell_m), axis=0)) * cell_m**2


def _centroid(level: F32, elevation: float, cell_m: float) -> F64:
    centre = (np.unique(_cells(level, cell_m), axis=0).mean(axis=0) + 0.5) * cell_m
    return np.array([centre[0], centre[1], elevation])


def _cells(positions: F32, cell_m: float) -> I64:
    return np.floor(positions[:, :2].astype(np.float64) / cell_m).astype(np.int64)


def _outline(level: F32, parameters: MeasureParameters) -> tuple[F64, ...]:
    """Rings of the largest connected piece of the plan, the outer one first."""
    cell_m = parameters.area_cell_m
    cells = _cells(level, cell_m)
    closing = int(np.ceil(parameters.outline_gap_m / cell_m / 2.0))
    low = cells.min(axis=0) - closing - 1
    grid = np.zeros(cells.max(axis=0) - low + closing + 2, bool)
    grid[tuple((cells - low).T)] = True
    grid = ndimage.binary_closing(grid, np.ones((3, 3), bool), iterations=closing)
    pieces, count = ndimage.label(grid)
    if count > 1:
        grid = pieces == 1 + np.argmax(np.bincount(pieces[pieces > 0])[1:])
    polygon = _polygon(grid, low, cell_m).simplify(parameters.outline_tolerance_m)
    rings = (polygon.exterior, *polygon.interiors)
    return tuple(np.asarray(ring.coords, np.float64) for ring in rings)


def _polygon(grid: Bool, low: I64, cell_m: float) -> shapely.Polygon:
    """Union of the cells of a connected grid, made from runs of cells along y."""
    edges = np.diff(np.pad(grid, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    x, first = np.nonzero(edges == 1)
    past = np.nonzero(edges == -1)[1]
    runs = shapely.box(*(cell_m * np.stack([x + low[0], first + low[1], x + low[0] + 1, past + low[1]])))
    union = shapely.union_all(runs, grid_size=cell_m / 100.0)
    return max(shapely.get_parts(union), key=lambda part: part.area)
