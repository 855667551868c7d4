"""What a scanner saw of furnished rooms, and what the ingest made of it: the objects that questions look for."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from enfilade.atomic import replacing
from enfilade.clouds import read_cloud
from enfilade.ingest.pipeline import ingest
from enfilade.schema.ids import parse
from enfilade.schema.topology import topology
from enfilade.simulate import Parameters, Scanner, simulate
from enfilade.simulate.scene import Scene

F64 = NDArray[np.float64]

LEAST_POINTS: Final = 150
"""A furnishing of which fewer points were seen is not looked for."""
SAME_IOU: Final = 0.5
"""An object is a furnishing if their 3 cm voxels have at least this intersection over union."""
VOXEL_M: Final = 0.03
SAME_PLACE_M: Final = 0.015
"""Points are thinned to one a centimetre: a point of the truth lies so near to one of the same place."""


@dataclass(frozen=True, slots=True)
class Target:
    """An object that a question may find.

    Attributes
    ----------
    points
        ``(n, 3) float64`` metres, at most one a cubic centimetre.
    floor
        Height of the floor of its room, metres.
    furnishing
        Number of the furnishing that it is, over all rooms; -1 for one that is none.
    mesh
        ``class/name`` of the furnishing's mesh; empty for none.
    mostly
        Mesh of the furnishing that most of it belongs to, be it a part of that only or more than that.
    parts
        Numbers of its segments, over all rooms.
    """

    points: F64
    floor: float
    furnishing: int
    mesh: str
    mostly: str
    parts: tuple[int, ...]

    @property
    def kind(self) -> str:
        """Class of its mesh."""
        return self.mesh.split("/")[0]


@dataclass(frozen=True, slots=True)
class Pool:
    """Targets of many rooms: furnishings as scanned, or objects as ingested."""

    targets: tuple[Target, ...]
    furnishings: Mapping[int, str]
    """Mesh of each furnishing that at least one target is."""


def scan_rooms(scenes: Iterable[Scene], folder: Path) -> list[Path]:
    """Scan and ingest each room once; what is in the folder already is used again."""
    return [_scan_room(scene, number, folder) for number, scene in enumerate(scenes, start=1)]


def _scan_room(scene: Scene, number: int, folder: Path) -> Path:
    kept = folder / f"{scene.name}.npz"
    if kept.exists():
        return kept
    folder.mkdir(parents=True, exist_ok=True)
    scanner = Scanner(angular_step_deg=0.45, range_noise_m=0.003, registration_m=0.003, seed=number)
    file = folder / f"{scene.name}.e57"
    if not file.exists() or not file.with_suffix(".truth").exists():
        simulate(scene, file, parameters=Parameters(scanner=scanner))
    truth = read_cloud(file.with_suffix(".truth") / "cloud.ply")
    found = ingest([file], building=scene.name)
    room_of = topology(found.graph).room_of
    objects = list(found.graph.of_label("Object"))
    rooms = {node.id: node.properties["floor_elevation"] for node in found.graph.of_label("Room")}
    arrays: dict[str, Any] = {
        "names": np.array([piece.name for piece in scene.furnishings]),
        "true_points": truth.positions,
        "true": truth.object,
        "points": found.cloud.positions,
        "segment": found.cloud.object,
        "parts": np.array([(*parse(node.id).numbers, -1, -1)[:3] for node in objects]).reshape(-1, 3),
        "floors": np.array([rooms[room_of[node.id]] for node in objects], dtype=np.float64),
    }
    with replacing(kept) as stream:
        np.savez_compressed(stream, **arrays)
    return kept


def furnishings_as_scanned(rooms: Iterable[Path]) -> Pool:
    """Every furnishing that was seen, by the points that lie on it."""
    targets: list[Target] = []
    for arrays, first in _opened(rooms):
        for number, name in enumerate(arrays["names"].tolist()):
            points = arrays["true_points"][arrays["true"] == number]
            if _asked(name, len(points)):
                targets.append(Target(points, 0.0, first + number, name, name, (len(targets),)))
    return Pool(tuple(targets), {target.furnishing: target.mesh for target in targets})


def objects_as_ingested(rooms: Iterable[Path]) -> Pool:
    """Every segment and combination, with the furnishing that it is."""
    targets: list[Target] = []
    for arrays, first in _opened(rooms):
        same = _Sameness(arrays)
        segment_base = first * 1000
        for parts, floor in zip(arrays["parts"], arrays["floors"].tolist(), strict=True):
            own = tuple(int(part) for part in parts if part >= 0)
            points = arrays["points"][np.isin(arrays["segment"], own)]
            number, main = same.furnishing(own), same.main(own)
            name, mostly = (str(arrays["names"][n]) if n >= 0 else "" for n in (number, main))
            numbers = tuple(segment_base + part for part in own)
            targets.append(Target(points, floor, first + number if number >= 0 else -1, name, mostly, numbers))
    return Pool(tuple(targets), {target.furnishing: target.mesh for target in targets if target.furnishing >= 0})


def _opened(rooms: Iterable[Path]) -> Iterable[tuple[Mapping[str, Any], int]]:
    """Arrays of each room, and the number of its first furnishing over all rooms."""
    first = 0
    for room in rooms:
        with np.load(room) as file:
            arrays = {name: file[name] for name in file.files}
        yield arrays, first
        first += len(arrays["names"])


def _asked(name: str, points: int) -> bool:
    return points >= LEAST_POINTS and name.split("/")[0] not in ("other", "clutter")


class _Sameness:
    """Overlap of segments and furnishings of a room, in voxels of 3 cm."""

    def __init__(self, arrays: Mapping[str, Any]) -> None:
        furniture = arrays["true"] >= 0
        tree = cKDTree(arrays["true_points"][furniture])
        apart, nearest = tree.query(arrays["points"], distance_upper_bound=SAME_PLACE_M)
        label = np.append(arrays["true"][furniture], -1)[np.where(np.isfinite(apart), nearest, -1)]
        cells = np.floor((arrays["points"] - arrays["points"].min(axis=0)) / VOXEL_M).astype(np.int64)
        voxel = (cells[:, 0] << 42) | (cells[:, 1] << 21) | cells[:, 2]
        own, labelled = arrays["segment"] >= 0, label >= 0
        segments = _sets(arrays["segment"][own], np.column_stack([voxel, label])[own])
        self._segments = {segment: np.unique(rows, axis=0) for segment, rows in segments.items()}
        self._furnishings = {n: np.unique(rows) for n, rows in _sets(label[labelled], voxel[labelled]).items()}
        names = arrays["names"].tolist()
        seen = np.bincount(arrays["true"][furniture], minlength=len(names))
        self._asked = {number for number, name in enumerate(names) if _asked(name, int(seen[number]))}

    def furnishing(self, parts: tuple[int, ...]) -> int:
        """Number of the furnishing that some segments are; -1 for none."""
        rows = np.concatenate([self._segments[part] for part in parts])
        own = np.unique(rows[:, 0])
        for number in sorted(self._asked.intersection(np.unique(rows[:, 1]).tolist())):
            other = self._furnishings[number]
            both = len(np.intersect1d(own, other, assume_unique=True))
            if both / (len(own) + len(other) - both) >= SAME_IOU:
                return int(number)
        return -1

    def main(self, parts: tuple[int, ...]) -> int:
        """Number of the furnishing that most voxels of some segments belong to; -1 for none."""
        labels, shares = np.unique(np.concatenate([self._segments[p][:, 1] for p in parts]), return_counts=True)
        return int(labels[shares.argmax()])


def _sets(keys: NDArray[Any], values: NDArray[Any]) -> dict[int, NDArray[Any]]:
    """Values of each key, found with one sort."""
    order = np.argsort(keys, kind="stable")
    found, first = np.unique(keys[order], return_index=True)
    return dict(zip(found.tolist(), np.split(values[order], first[1:]), strict=True))
