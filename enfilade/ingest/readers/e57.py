"""E57 (ASTM E2807): several posed scans a file, structured or not, Cartesian or spherical."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np
import pye57
from pye57 import libe57
from pye57.utils import convert_spherical_to_cartesian

from enfilade.errors import InputError
from enfilade.ingest.records import F64, Bool, Scan

CARTESIAN: Final = ("cartesianX", "cartesianY", "cartesianZ")
SPHERICAL: Final = ("sphericalRange", "sphericalAzimuth", "sphericalElevation")
INVALID_STATES: Final = {CARTESIAN: "cartesianInvalidState", SPHERICAL: "sphericalInvalidState"}


def read(path: Path) -> Iterator[Scan]:
    """Read the scans of an E57 file, one at a time, in the file's common coordinates.

    Points that are flagged invalid, NaN or infinite are dropped.

    Raises
    ------
    InputError
        The file is damaged or empty, one of its scans has no pose, no coordinates or no usable point, or several
        scans have lost their position.
    """
    if path.stat().st_size == 0:
        raise InputError(f"{path} is empty (0 bytes): export or copy it again")
    try:
        with pye57.E57(str(path)) as file:
            if file.scan_count == 0:
                raise InputError(f"{path} holds no scans: export it with its scan positions")
            _refuse_lost_positions(file, path)
            for index in range(file.scan_count):
                yield _read_scan(file, index, path)
    except libe57.E57Exception as error:
        raise InputError(f"{path} cannot be read as E57: {_first_line(error)}; export or copy it again") from error


def _read_scan(file: pye57.E57, index: int, path: Path) -> Scan:
    header = file.get_header(index)
    name = _name(header, index, path)
    rotation, translation = _pose(header, f"scan {name!r} of {path}")
    local = _local_points(file, header, f"scan {name!r} of {path}")
    return Scan(name, path.name, np.einsum("ij,kj->ik", local, rotation) + translation, translation)


def _name(header: Any, index: int, path: Path) -> str:
    name = header["name"].value().strip() if header.node.isDefined("name") else ""
    return str(name) or f"{path.stem} {index}"


def _refuse_lost_positions(file: pye57.E57, path: Path) -> None:
    """One scan may stand at the origin unturned: the others are registered to it. Several cannot."""
    names = []
    for index in range(file.scan_count):
        header = file.get_header(index)
        if header.has_pose() and not np.any(header.translation) and np.array_equal(header.rotation_matrix, np.eye(3)):
            names.append(_name(header, index, path))
    if len(names) > 1:
        raise InputError(
            f"{len(names)} scans of {path}, {names[0]!r} and {names[1]!r} among them, all stand at the origin, as "
            "exports write it when the positions are lost: export the scans registered, with their positions"
        )


def _pose(header: Any, what: str) -> tuple[F64, F64]:
    """Rotation ``(3, 3)`` and translation ``(3,)`` of the scanner."""
    if not header.has_pose():
        raise InputError(f"no scanner pose in {what}: export the scans registered, with their positions")
    rotation = np.asarray(header.rotation_matrix, np.float64)
    translation = np.asarray(header.translation, np.float64)
    if not (np.isfinite(rotation).all() and np.isfinite(translation).all()):
        raise InputError(f"the scanner pose in {what} is not a number: export the scans again")
    return rotation, translation


def _local_points(file: pye57.E57, header: Any, what: str) -> F64:
    """``(n, 3) float64`` usable points in the scanner's own coordinates."""
    fields = next((f for f in (CARTESIAN, SPHERICAL) if set(f) <= set(header.point_fields)), None)
    if fields is None:
        raise InputError(f"{what} has neither Cartesian nor spherical coordinates")
    if header.point_count == 0:
        raise InputError(f"{what} has no points")
    columns = _columns(file, header, [*fields, INVALID_STATES[fields]])
    points = np.stack([columns[field] for field in fields], axis=1)
    usable = np.isfinite(points).all(axis=1) & _flagged_valid(columns, INVALID_STATES[fields])
    if not usable.any():
        raise InputError(f"{what} has no usable point: all {len(points)} are invalid, NaN or infinite")
    points = points if usable.all() else points[usable]
    return points if fields is CARTESIAN else np.asarray(convert_spherical_to_cartesian(points))


def _columns(file: pye57.E57, header: Any, fields: list[str]) -> dict[str, Any]:
    wanted = [field for field in fields if field in header.point_fields]
    columns, buffers = file.make_buffers(wanted, header.point_count)
    read = header.points.reader(buffers).read()
    return {field: column[:read] for field, column in columns.items()}


def _flagged_valid(columns: dict[str, Any], state: str) -> Bool | np.bool_:
    """Where the invalid state allows the coordinates (0; 1 is a direction only, 2 is nothing)."""
    return np.asarray(columns[state] == 0) if state in columns else np.True_


def _first_line(error: libe57.E57Exception) -> str:
    return str(error).strip().splitlines()[0]
