"""Scenes from IFC building models."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from enfilade.errors import InputError

from .casting import Caster
from .doorways import doorways
from .flights import stairs_between
from .frames import frame_of, in_the_way, measured_hole, opening_of, rooms_beside
from .ifc_model import ROLES, Element, Model, read_model
from .locate import Locator, commonest
from .polygons import plan_samples
from .scene import OUTSIDE, Furnishing, Opening, Room, Scene, SceneParts
from .solids import Mesh, merge
from .units import Units, units_of

_CLEAR_OF_FLOOR_M = 0.1


def ifc_scene(path: Path, *, closed_share: float = 0.1, seed: int = 1) -> Scene:
    """Make a scene of an IFC building model.

    Parameters
    ----------
    path
        The IFC file.
    closed_share
        Share of the doors between two rooms that are closed; doors to the outside always are.
    seed
        Says which ones.

    Raises
    ------
    InputError
        If the file cannot be read, or has no bodies or no rooms.
    """
    building = _Building(read_model(path))
    units = building.units()
    if not units.rooms:
        raise InputError(f"{path}: the model has no rooms (IfcSpace) under a roof; scan it as a mesh instead")
    openings, shut = building.openings(units, closed_share, np.random.default_rng(seed))
    return _reachable(building.scene(path.stem, units, openings, shut))


class _Building:
    """The elements of a model, sorted by what they are to the scanner."""

    def __init__(self, model: Model) -> None:
        self._storeys = model.storeys
        self._of = {role: [e for e in model.elements if e.role == role] for role in (*ROLES, "fabric")}
        self._doors, self._windows = self._of["door"], self._of["window"]
        fabric = {e.number: e for e in self._of["fabric"]}
        fillings = (*self._doors, *self._windows)
        self._frames = {e.number: frame_of(e, fabric.get(e.host or -1)) for e in fillings}
        self._fillings = {e.number: in_the_way(e, self._frames[e.number]) for e in fillings}

    def units(self) -> Units:
        """Find the rooms."""
        bodies = [(e.name, e.mesh) for e in self._of["space"]]
        windows = [e.mesh for e in self._windows]
        walls = Caster(merge([*(e.mesh for e in self._of["fabric"]), *windows, *self._door_frames()]))
        return units_of(bodies, self._storeys, walls)

    def openings(
        self, units: Units, closed_share: float, generator: np.random.Generator
    ) -> tuple[list[Opening], set[int]]:
        """Find doors, doorways, windows and stairs; and the doors (by entity number) that are shut."""
        rooms, locator = units.rooms, Locator(units.rooms)
        fabric = Caster(merge([*(e.mesh for e in self._of["fabric"]), *self._door_frames()]))
        found: list[Opening] = []
        shut: set[int] = set()
        for door in self._doors:
            frame = measured_hole(self._frames[door.number], fabric)
            sides = rooms_beside(frame, locator)
            closed = OUTSIDE in sides or generator.random() < closed_share
            if closed:
                shut.add(door.number)
            if sides[0] != sides[1]:
                found.append(opening_of("door", "closed" if closed else "open", frame, sides, _floor(rooms, sides)))
        found += doorways(units.borders, units.unit, rooms, fabric, found)
        for window in self._windows:
            sides = rooms_beside(self._frames[window.number], locator)
            if sides[0] != sides[1]:
                frame = self._frames[window.number]
                found.append(opening_of("window", "closed", frame, sides, _floor(rooms, sides)))
        flights = (stairs_between(e.mesh, rooms, locator, fabric) for e in self._of["stairs"])
        return [*found, *(flight for flight in flights if flight is not None)], shut

    def scene(self, name: str, units: Units, openings: Sequence[Opening], shut: set[int]) -> Scene:
        """Put the scene together."""
        parts = SceneParts()
        ground = [e for e in self._of["ground"] if not _reaches_indoors(e.mesh, units.rooms)]
        for element in (*self._of["fabric"], *self._of["stairs"], *ground):
            _add_element(parts, element, element.see_through)
        for window in self._windows:
            panes = window.see_through if window.see_through.any() else self._fillings[window.number]
            _add_element(parts, window, panes)
        for door in self._doors:
            if door.number in shut:
                _add_element(parts, door, door.see_through)
        for frame in self._door_frames(without=shut):
            parts.add_structure(frame)
        locator = Locator(units.rooms)
        furnishings = []
        for number, piece in enumerate(self._of["furniture"]):
            parts.add_furnishing(piece.mesh, number)
            furnishings.append(Furnishing(number, _room_of(piece.mesh, locator), piece.name))
        return Scene(name, *parts.arrays(), units.storeys, units.rooms, tuple(openings), tuple(furnishings))

    def _door_frames(self, without: frozenset[int] | set[int] = frozenset()) -> list[Mesh]:
        return [door.part(~self._fillings[door.number]) for door in self._doors if door.number not in without]


def _add_element(parts: SceneParts, element: Element, glass: NDArray[np.bool_]) -> None:
    if not glass.all():
        parts.add_structure(element.part(~glass))
    if glass.any():
        parts.add_glass(element.part(glass))


def _reaches_indoors(ground: Mesh, rooms: Sequence[Room]) -> bool:
    """Whether a terrain, often drawn without a hole for the building, runs through a room."""
    caster = Caster(ground)
    for room in rooms:
        low, high = room.floor_elevation + _CLEAR_OF_FLOOR_M, room.ceiling_elevation - _CLEAR_OF_FLOOR_M
        feet = plan_samples(room.polygon, low)
        if caster.blocked(feet, np.column_stack([feet[:, :2], np.full(len(feet), high)])).any():
            return True
    return False


def _floor(rooms: Sequence[Room], sides: tuple[int, int]) -> float:
    """Elevation that a sill counts from: the higher floor of the rooms beside."""
    return max(rooms[side].floor_elevation for side in sides if side != OUTSIDE)


def _room_of(mesh: Mesh, locator: Locator) -> int:
    """Room that most of a piece of furniture stands in."""
    centres = mesh.vertices[mesh.triangles].mean(axis=1)
    return commonest(locator.rooms_of(np.concatenate([centres, mesh.bounds.mean(axis=0)[None]])))


def _reachable(scene: Scene) -> Scene:
    """Leave out rooms that no door, passage or stairs leads to, unless that were all."""
    entered = {room for opening in scene.openings if opening.kind != "window" for room in opening.rooms}
    kept = [room for room in scene.rooms if room.number in entered] or list(scene.rooms)
    number = {room.number: k for k, room in enumerate(kept)} | {OUTSIDE: OUTSIDE}
    storeys = sorted({room.storey for room in kept})
    rooms = tuple(replace(r, number=number[r.number], storey=storeys.index(r.storey)) for r in kept)
    sides = [(number.get(o.rooms[0], OUTSIDE), number.get(o.rooms[1], OUTSIDE)) for o in scene.openings]
    openings = tuple(replace(o, rooms=s) for o, s in zip(scene.openings, sides, strict=True) if s != (OUTSIDE, OUTSIDE))
    furnishings = tuple(replace(f, room=number.get(f.room, OUTSIDE)) for f in scene.furnishings)
    levels = tuple(replace(scene.storeys[index], index=k) for k, index in enumerate(storeys))
    return replace(scene, rooms=rooms, storeys=levels, openings=openings, furnishings=furnishings)
