"""E57 (ASTM E2807): several posed scans a file, structured or not, Cartesian or spherical."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np
import pye57
from pye57 import libe57

from enfilade.errors import InputError
from enfilade.ingest.records import F64, U8, Chunk, Scan

from .faults import naming_faults
from .placing import CHUNK, compacted, place
from .whereabouts import Whereabouts

CARTESIAN: Final = ("cartesianX", "cartesianY", "cartesianZ")
SPHERICAL: Final = ("sphericalRange", "sphericalAzimuth", "sphericalElevation")
COLOUR: Final = ("colorRed", "colorGreen", "colorBlue")
INVALID_STATES: Final = {CARTESIAN: "cartesianInvalidState", SPHERICAL: "sphericalInvalidState"}
_TYPES: Final = {**dict.fromkeys(("intensity", *COLOUR), np.float32), **dict.fromkeys(INVALID_STATES.values(), np.int8)}
_MOST_POINTS_A_BYTE: Final = 8
_LARGEST_XML_START: Final = 4096


@naming_faults("E57", native=(libe57.E57Exception,))
def read(path: Path, whereabouts: Whereabouts) -> Iterator[Scan]:
    """Read the scans of an E57 file, one at a time, in the file's common coordinates.

    Points that are flagged invalid, NaN or infinite are dropped.

    Raises
    ------
    InputError
        The file is damaged or empty, one of its scans has no position, no coordinates or no usable point, or several
        scans have lost their position.
    """
    _refuse_document_types(path)
    with pye57.E57(str(path)) as file:
        if file.scan_count == 0:
            raise InputError(f"{path} holds no scans: export it with its scan positions")
        names: set[str] = set()
        for index in range(file.scan_count):
            header = file.get_header(index)
            name = _name(header, f"{path.stem} {index}", names)
            rotation, translation = _pose(header, f"scan {name!r} of {path}")
            is_lost = header.has_pose() and not translation.any() and np.array_equal(rotation, np.eye(3))
            own = translation if header.has_pose() else None
            position = whereabouts.scanner(path, name, own, is_default=is_lost)
            yield Scan(name, path.name, _chunks(path, file, header, name, rotation, translation), position)


def _refuse_document_types(path: Path) -> None:
    """E57's XML has no document type; one that comes with entities could grow without bound."""
    with path.open("rb") as stream:
        header = stream.read(48)
        stream.seek(min(int.from_bytes(header[24:32], "little"), path.stat().st_size))
        if b"<!DOCTYPE" in stream.read(_LARGEST_XML_START):
            raise InputError(f"{path} cannot be read as E57: its XML declares a document type; export it again")


def _name(header: Any, otherwise: str, taken: set[str]) -> str:
    """Return the scan's name, with a number behind it where an earlier scan of the file is named alike."""
    given = header["name"].value().strip() if header.node.isDefined("name") else ""
    name = base = str(given) or otherwise
    number = 2
    while name in taken:
        name, number = f"{base} ({number})", number + 1
    taken.add(name)
    return name


def _pose(header: Any, what: str) -> tuple[F64, F64]:
    """Rotation ``(3, 3)`` and translation ``(3,)`` of the scanner; none at all where the scan has no pose."""
    if not header.has_pose():
        return np.eye(3), np.zeros(3)
    rotation = np.asarray(header.rotation_matrix, np.float64)
    translation = np.asarray(header.translation, np.float64)
    if not (np.isfinite(rotation).all() and np.isfinite(translation).all()):
        raise InputError(f"the scanner pose in {what} is not a number: export the scans again")
    return rotation, translation


@naming_faults("E57", native=(libe57.E57Exception,))
def _chunks(path: Path, file: Any, header: Any, name: str, rotation: F64, translation: F64) -> Iterator[Chunk]:
    what = f"scan {name!r} of {path}"
    fields = _fields(header, what)
    if header.point_count > _MOST_POINTS_A_BYTE * path.stat().st_size:
        raise InputError(f"{what} claims {header.point_count} points, more than the file can hold: export it again")
    columns, buffers = _buffers(file, [field for field in fields if field in header.point_fields])
    scale = _colour_scale(header)
    reader = header.points.reader(buffers)
    usable = 0
    try:
        while count := reader.read():
            chunk = _chunk({field: column[:count] for field, column in columns.items()}, rotation, translation, scale)
            usable += len(chunk.positions)
            yield chunk
    finally:
        reader.close()
    if usable == 0:
        raise InputError(f"{what} has no usable point: all {header.point_count} are invalid, NaN or infinite")


def _fields(header: Any, what: str) -> tuple[str, ...]:
    """Names of the columns to read, which the scan need not all have."""
    system = next((f for f in (CARTESIAN, SPHERICAL) if set(f) <= set(header.point_fields)), None)
    if system is None:
        raise InputError(f"{what} has neither Cartesian nor spherical coordinates")
    if header.point_count == 0:
        raise InputError(f"{what} has no points")
    colour = COLOUR if set(COLOUR) <= set(header.point_fields) else ()
    return (*system, INVALID_STATES[system], "intensity", *colour)


def _buffers(file: Any, fields: list[str]) -> tuple[dict[str, Any], Any]:
    """Arrays for the columns, and what lets the reader write into them."""
    columns = {field: np.empty(CHUNK, _TYPES.get(field, np.float64)) for field in fields}
    buffers = libe57.VectorSourceDestBuffer()
    for field, column in columns.items():
        buffers.append(libe57.SourceDestBuffer(file.image_file, field, column, CHUNK, True, True))
    return columns, buffers


def _chunk(columns: dict[str, Any], rotation: F64, translation: F64, colour_scale: float) -> Chunk:
    system = CARTESIAN if CARTESIAN[0] in columns else SPHERICAL
    first, second, third = (columns[field] for field in system)
    state = columns.get(INVALID_STATES[system], np.zeros(0, np.int8))
    positions, kept = place(first, second, third, state, system is SPHERICAL, rotation, translation)
    intensity = compacted(columns["intensity"], kept) if "intensity" in columns else None
    return Chunk(positions, intensity, _colour(columns, kept, colour_scale))


def _colour(columns: dict[str, Any], kept: Any, scale: float) -> U8 | None:
    if COLOUR[0] not in columns:
        return None
    channels = np.stack([columns[field] for field in COLOUR], axis=1)
    return compacted(np.clip(channels * np.float32(scale), 0.0, 255.0).astype(np.uint8), kept)


def _colour_scale(header: Any) -> float:
    """Return what brings colours to 0 to 255; the limits say what they go to in the file."""
    node = header.node
    if not (node.isDefined("colorLimits") and node["colorLimits"].isDefined("colorRedMaximum")):
        return 1.0
    limit = float(node["colorLimits"]["colorRedMaximum"].value())
    return 255.0 / limit if np.isfinite(limit) and limit > 0.0 else 1.0
