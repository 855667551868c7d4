"""Reads an IFC file: what has a body, as meshes in metres and world coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import ifcopenshell
import ifcopenshell.geom
import ifcopenshell.util.unit
import numpy as np
from ifcopenshell.util.placement import get_local_placement
from numpy.typing import NDArray

from enfilade.errors import InputError

from .solids import F64, I32, Mesh

ROLES = {
    "space": ("IfcSpace",),
    "door": ("IfcDoor",),
    "window": ("IfcWindow",),
    "stairs": ("IfcStair", "IfcStairFlight", "IfcRamp", "IfcRampFlight"),
    "ground": ("IfcSite", "IfcGeographicElement"),
    "furniture": (
        "IfcFurnishingElement",
        "IfcDistributionElement",
        "IfcElectricalElement",
        "IfcTransportElement",
    ),
}
"""What IFC classes are to the scanner; all others are fabric: walls, slabs, columns."""
_BODILESS = ("IfcFeatureElementSubtraction", "IfcAnnotation", "IfcGrid", "IfcVirtualElement", "IfcPort")
_CLASSLESS = "IfcBuildingElementProxy"
_SMALL_M = 3.0
_SEE_THROUGH = 0.3
_THREADS = 2


@dataclass(frozen=True, slots=True)
class Element:
    """One building element with a body.

    Attributes
    ----------
    number
        Of the entity in the file.
    role
        A key of `ROLES`, or ``fabric``.
    mesh
        In world coordinates, metres.
    item
        ``(T,) int32`` the part of the body that each triangle belongs to.
    see_through
        ``(T,)`` whether its material is transparent.
    placement
        ``(4, 4)`` the element's frame in world coordinates: for doors and windows x along the width, z up.
    host
        Number of the wall that it fills a hole of, or None.
    """

    number: int
    role: str
    name: str
    mesh: Mesh
    item: I32
    see_through: NDArray[np.bool_]
    placement: F64
    host: int | None

    def part(self, mask: NDArray[np.bool_]) -> Mesh:
        """Return some of the triangles."""
        return Mesh(self.mesh.vertices, self.mesh.triangles[mask])


@dataclass(frozen=True, slots=True)
class Model:
    """Elements of an IFC file in the order of the file, and the (elevation, name) of its storeys from the lowest."""

    elements: tuple[Element, ...]
    storeys: tuple[tuple[float, str], ...]


def read_model(path: Path) -> Model:
    """Read an IFC file.

    Raises
    ------
    InputError
        If the file is missing, no IFC, or has no bodies.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    try:
        file = ifcopenshell.open(str(path))
    except (OSError, RuntimeError, ifcopenshell.Error) as error:
        raise InputError(f"{path}: no readable IFC file ({error})") from error
    elements = _elements(file)
    if not elements:
        raise InputError(f"{path}: the IFC file has no element with a body, so there is nothing to scan")
    return Model(elements, _storeys(file))


def _storeys(file: Any) -> tuple[tuple[float, str], ...]:
    unit = ifcopenshell.util.unit.calculate_unit_scale(file)
    placed = [(s, get_local_placement(s.ObjectPlacement)) for s in file.by_type("IfcBuildingStorey")]
    return tuple(sorted((float(frame[2, 3]) * unit, storey.Name or "") for storey, frame in placed))


def _elements(file: Any) -> tuple[Element, ...]:
    geometry: Any = ifcopenshell.geom
    iterator = geometry.iterator(geometry.settings(), file, _THREADS)
    found: dict[int, Element] = {}
    going = bool(iterator.initialize())
    while going:
        shape = iterator.get()
        entity = file.by_id(shape.id)
        if len(shape.geometry.faces) and not any(entity.is_a(name) for name in _BODILESS):
            found[shape.id] = _element(entity, shape)
        going = bool(iterator.next())
    return tuple(found[number] for number in sorted(found))


def _element(entity: Any, shape: Any) -> Element:
    geometry = shape.geometry
    placement = np.array(shape.transformation.matrix, dtype=np.float64).reshape(4, 4).T
    local = np.array(geometry.verts, dtype=np.float64).reshape(-1, 3)
    triangles = np.array(geometry.faces, dtype=np.int32).reshape(-1, 3)
    material = np.array(geometry.material_ids, dtype=np.int64)
    transparency = np.array([m.transparency for m in geometry.materials] + [0.0], dtype=np.float64)
    mesh = Mesh(local @ placement[:3, :3].T + placement[:3, 3], triangles)
    return Element(
        shape.id,
        _role(entity, mesh),
        getattr(entity, "LongName", None) or entity.Name or entity.is_a(),
        mesh,
        np.array(geometry.item_ids, dtype=np.int32),
        np.nan_to_num(transparency)[material] > _SEE_THROUGH,
        placement,
        _host(entity),
    )


def _role(entity: Any, mesh: Mesh) -> str:
    """Role by class; what has no class of its own is furniture if it is small."""
    if entity.is_a(_CLASSLESS):
        return "furniture" if np.ptp(mesh.bounds, axis=0).max() <= _SMALL_M else "fabric"
    return next((role for role, classes in ROLES.items() if any(entity.is_a(c) for c in classes)), "fabric")


def _host(entity: Any) -> int | None:
    for filling in getattr(entity, "FillsVoids", ()):
        for voiding in filling.RelatingOpeningElement.VoidsElements:
            return int(voiding.RelatingBuildingElement.id())
    return None
