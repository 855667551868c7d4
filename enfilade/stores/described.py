"""All described objects of a store at one moment, as arrays: what likeness is measured on."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from enfilade.descriptors.bounds import blocks_of, rings_of
from enfilade.descriptors.nearest import DescriptorTable
from enfilade.errors import GraphError
from enfilade.schema.ids import MAX_SEGMENTS, object_id, parse
from enfilade.stores.base import BuildingDescriptors

Shape = tuple[int, int, int]
Arrays = Mapping[str, NDArray[np.generic]]

FLOOR, FOOT = "floor", "foot"
KINDS: Final = {FLOOR: 1, FOOT: 2}
"""The two descriptors of an object, and the bit of its flags that says that it has one."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where the objects of a building lie in the arrays of their shape.

    Attributes
    ----------
    revision
        Of the building, as it was read; None where that was not known.
    shape
        Slices, shells, sectors; None for a building without descriptors.
    first, count
        Rows.
    """

    revision: str | None
    shape: Shape | None
    first: int
    count: int


def layout(shape: Shape) -> dict[str, tuple[int, np.dtype[np.generic]]]:
    """Return the arrays of a shape: of each the length of a row, and the type of its values."""
    slices, shells, sectors = shape
    counts = np.dtype("<u2")
    found: dict[str, tuple[int, np.dtype[np.generic]]] = {
        "numbers": (MAX_SEGMENTS, np.dtype("<i8")),
        "flags": (1, np.dtype("u1")),
    }
    for kind in KINDS:
        found[kind] = (slices * shells * sectors, counts)
        found[f"{kind}-rings"] = (slices * shells, counts)
        found[f"{kind}-blocks"] = (-(-slices // 2) * -(-shells // 2), counts)
    return found


def arrays_of(found: BuildingDescriptors) -> Arrays:
    """Return the rows of a building, as `layout` says."""
    assert found.shape is not None
    flags = np.zeros((len(found.numbers), 1), dtype=np.uint8)
    arrays: dict[str, NDArray[np.generic]] = {"numbers": found.numbers, "flags": flags}
    for kind, counts in ((FLOOR, found.floor), (FOOT, found.foot)):
        rings = rings_of(counts, found.shape)
        arrays |= {kind: counts, f"{kind}-rings": rings, f"{kind}-blocks": blocks_of(rings, found.shape)}
        flags[rings.any(axis=1)] |= KINDS[kind]
    return arrays


class DescribedObjects:
    """The objects of all buildings whose descriptors have one shape.

    Parameters
    ----------
    shape
        Slices, shells, sectors.
    arrays
        As `layout` says, n rows; some may be of no object any more.
    places
        The buildings of that shape.
    """

    def __init__(self, shape: Shape, arrays: Arrays, places: Mapping[str, Place]) -> None:
        self.shape = shape
        self._arrays = arrays
        self._places = places
        self._tables: dict[str, DescriptorTable] = {}
        self._rows_of: dict[str, dict[tuple[int, ...], int]] = {}

    def table(self, kind: str) -> DescriptorTable:
        """Descriptors with their base at the floor, or at the object's own foot."""
        if kind not in self._tables:
            self._tables[kind] = self._table(kind, self._has(kind))
        return self._tables[kind]

    @cached_property
    def floor_without_foot(self) -> DescriptorTable:
        """Descriptors with their base at the floor, of objects that have no other."""
        return self._table(FLOOR, self._has(FLOOR) & ~self._has(FOOT))

    def row_of(self, id: str) -> int | None:
        """Row of an object, or None where it is not among these."""
        building, _, local = id.partition("/")
        if building not in self._places or not local:
            return None
        if building not in self._rows_of:
            place = self._places[building]
            numbers = self._arrays["numbers"][place.first : place.first + place.count].tolist()
            self._rows_of[building] = {tuple(own): place.first + i for i, own in enumerate(numbers)}
        try:
            key = parse(id)
        except GraphError:  # ids that LIKE names may be anything
            return None
        return self._rows_of[building].get((*key.numbers, -1, -1)[:MAX_SEGMENTS]) if key.label == "Object" else None

    def ids_of(self, rows: NDArray[np.int64]) -> list[str]:
        """Ids of the objects in some rows."""
        names, firsts = self._buildings
        which = (np.searchsorted(firsts, rows, side="right") - 1).tolist()
        numbers = self._arrays["numbers"][rows].tolist()
        return [
            object_id(names[building], *(number for number in own if number >= 0))
            for building, own in zip(which, numbers, strict=True)
        ]

    @cached_property
    def _buildings(self) -> tuple[list[str], NDArray[np.int64]]:
        """Buildings in the order of their rows, and the first row of each."""
        ordered = sorted((place.first, name) for name, place in self._places.items() if place.count)
        return [name for _, name in ordered], np.array([first for first, _ in ordered], dtype=np.int64)

    @cached_property
    def _live(self) -> NDArray[np.bool_]:
        live = np.zeros(len(self._arrays["flags"]), dtype=np.bool_)
        for place in self._places.values():
            live[place.first : place.first + place.count] = True
        return live

    def _has(self, kind: str) -> NDArray[np.bool_]:
        return np.asarray(self._live & ((self._arrays["flags"][:, 0].astype(np.uint8) & KINDS[kind]) > 0))

    def _table(self, kind: str, valid: NDArray[np.bool_]) -> DescriptorTable:
        counts, rings, blocks = (
            self._arrays[name].astype(np.uint16, copy=False) for name in (kind, f"{kind}-rings", f"{kind}-blocks")
        )
        return DescriptorTable(self.shape, counts, rings, blocks, valid)


@dataclass(frozen=True)
class Described:
    """All described objects of a store.

    Attributes
    ----------
    objects
        One group a shape, by shape.
    read_anew
        Number of buildings that were read from the store for this; the others were known.
    seconds
        How long that took.
    """

    objects: Sequence[DescribedObjects]
    read_anew: int = 0
    seconds: float = 0.0


def grouped_places(places: Mapping[str, Place]) -> dict[Shape, dict[str, Place]]:
    """Return the places of buildings by shape, those without descriptors left out."""
    found: dict[Shape, dict[str, Place]] = {}
    for building, place in places.items():
        if place.shape is not None and place.count:
            found.setdefault(place.shape, {})[building] = place
    return dict(sorted(found.items()))


def in_memory(buildings: Iterable[BuildingDescriptors]) -> Described:
    """Return described objects that lie in no file."""
    groups: dict[Shape, list[BuildingDescriptors]] = {}
    for found in buildings:
        if found.shape is not None and len(found.numbers):
            groups.setdefault(found.shape, []).append(found)
    objects = []
    for shape, members in sorted(groups.items()):
        parts = [arrays_of(found) for found in members]
        arrays = {name: np.concatenate([part[name] for part in parts]) for name in layout(shape)}
        firsts = np.cumsum([0, *(len(found.numbers) for found in members)]).tolist()
        places = {
            found.building: Place(found.revision, shape, first, len(found.numbers))
            for found, first in zip(members, firsts, strict=False)
        }
        objects.append(DescribedObjects(shape, arrays, places))
    return Described(objects)
