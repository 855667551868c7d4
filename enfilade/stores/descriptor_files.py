"""The descriptors of a store as files in the user's cache folder, mapped into memory by whoever asks.

A folder of its own for each store holds, for each shape of descriptors, one file an array (`described.layout`), and a
manifest that says which rows are of which building, in which revision. Files only grow: a writer, one at a time, adds
rows behind those that the manifest knows, puts them on the disk, and then replaces the manifest in one step. So a
reader sees an old whole or a new whole, and what a killed writer left behind the end counts as nothing. Rows of
buildings that were replaced or removed stay until they are the most; then the rest is copied to new files.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import secrets
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from enfilade.atomic import replacing
from enfilade.stores.base import BuildingDescriptors
from enfilade.stores.described import Arrays, Place, Shape, arrays_of, layout

FORMAT: Final = 1
LEAST_DEAD_ROWS: Final = 4096
"""Fewer rows of no building are left where they are."""

_MANIFEST: Final = "manifest.json"
_LOCK: Final = "lock"
_POLL_S: Final = 0.05
_ROWS_AT_ONCE: Final = 4096


class DamagedError(OSError):
    """The files are not what the manifest says: to be made again."""


@dataclass(slots=True)
class Manifest:
    """What lies where.

    Attributes
    ----------
    places
        Of each building where its rows are.
    folders
        Of each shape the folder of its files, and how many rows they have.
    """

    places: dict[str, Place] = field(default_factory=dict)
    folders: dict[Shape, tuple[str, int]] = field(default_factory=dict)

    def stale(self, wanted: dict[str, str | None]) -> list[str]:
        """Return the buildings that are to be read anew, by the revisions that the store has."""
        return [
            building
            for building, revision in wanted.items()
            if revision is None or building not in self.places or self.places[building].revision != revision
        ]

    def differs(self, wanted: dict[str, str | None]) -> bool:
        """Whether anything is stale or gone."""
        return self.places.keys() != wanted.keys() or bool(self.stale(wanted))

    def drop(self, stale: list[str], wanted: dict[str, str | None]) -> None:
        """Forget what is stale, and what the store has no more."""
        for building in [*stale, *(self.places.keys() - wanted.keys())]:
            self.places.pop(building, None)


class DescriptorFiles:
    """The files of one store.

    Parameters
    ----------
    folder
        Folder of all stores' files.
    store
        What tells the store from all others.
    """

    def __init__(self, folder: Path, store: str) -> None:
        self._store = store
        self.folder = folder / hashlib.sha256(store.encode()).hexdigest()[:24]

    def version(self) -> tuple[int, ...] | None:
        """Return what tells the manifest as it is from what it was; None where there is none."""
        try:
            found = (self.folder / _MANIFEST).stat()
        except FileNotFoundError:
            return None
        return found.st_ino, found.st_mtime_ns, found.st_size

    def read(self) -> Manifest:
        """Return the manifest; an empty one where there is none, or none of ours."""
        try:
            document = json.loads((self.folder / _MANIFEST).read_bytes())
            return _decoded(document, self._store)
        except (FileNotFoundError, ValueError, TypeError, KeyError, AttributeError):
            return Manifest()

    def open(self, manifest: Manifest) -> dict[Shape, Arrays]:
        """Map the files into memory. Raises DamagedError where they are not as the manifest says."""
        return {shape: self._mapped(shape, *where) for shape, where in manifest.folders.items()}

    @contextmanager
    def alone(self, check: Callable[[], None]) -> Iterator[None]:
        """Keep other processes from writing while the block runs; `check` may raise while this one waits."""
        if not self.folder.exists():
            self.folder.mkdir(parents=True, exist_ok=True)
            _clear_away(self.folder.parent)
        with (self.folder / _LOCK).open("w") as file:
            while True:
                try:
                    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    break
                except BlockingIOError:
                    check()
                    time.sleep(_POLL_S)
            yield

    def append(self, manifest: Manifest, buildings: Iterator[BuildingDescriptors], most_rows: int) -> bool:
        """Put the rows of buildings behind those there are, and save the manifest.

        Stops after so many rows. Returns whether all buildings were there.
        """
        rows = 0
        with ExitStack() as stack:
            sheets: dict[Shape, _Sheet] = {}
            done = False
            while rows < most_rows and not done:
                found = next(buildings, None)
                done = found is None
                if found is not None:
                    manifest.places[found.building] = self._added(manifest, found, sheets, stack)
                    rows += len(found.numbers)
            for sheet in sheets.values():
                sheet.sync()
        self._save(manifest)
        return done

    def compact(self, manifest: Manifest) -> None:
        """Copy the rows that are still of a building to new files, where most are not; nothing is saved yet."""
        for shape, (name, rows) in list(manifest.folders.items()):
            own = {b: place for b, place in manifest.places.items() if place.shape == shape}
            live = sum(place.count for place in own.values())
            if rows - live <= max(live, LEAST_DEAD_ROWS):
                continue
            arrays = self._mapped(shape, name, rows)
            manifest.folders[shape] = (_new_name(shape), 0)
            with ExitStack() as stack:
                sheet = _Sheet(self.folder / manifest.folders[shape][0], shape, 0, stack)
                for building, place in own.items():
                    here = slice(place.first, place.first + place.count)
                    first = sheet.add({name: array[here] for name, array in arrays.items()})
                    manifest.places[building] = Place(place.revision, shape, first, place.count)
                sheet.sync()
                manifest.folders[shape] = (manifest.folders[shape][0], sheet.rows)

    def _added(
        self, manifest: Manifest, found: BuildingDescriptors, sheets: dict[Shape, _Sheet], stack: ExitStack
    ) -> Place:
        count = len(found.numbers)
        if found.shape is None or count == 0:
            return Place(found.revision, None, 0, 0)
        name, rows = manifest.folders.get(found.shape, (_new_name(found.shape), 0))
        if found.shape not in sheets:
            sheets[found.shape] = _Sheet(self.folder / name, found.shape, rows, stack)
        sheet = sheets[found.shape]
        first = sheet.add(arrays_of(found))
        manifest.folders[found.shape] = (name, sheet.rows)
        return Place(found.revision, found.shape, first, count)

    def _save(self, manifest: Manifest) -> None:
        with replacing(self.folder / _MANIFEST) as file:
            file.write(json.dumps(_encoded(manifest, self._store), separators=(",", ":")).encode())
        kept = {name for name, _ in manifest.folders.values()}
        for path in self.folder.iterdir():
            if path.is_dir() and path.name not in kept:
                shutil.rmtree(path, ignore_errors=True)

    def _mapped(self, shape: Shape, name: str, rows: int) -> Arrays:
        arrays: dict[str, NDArray[Any]] = {}
        for array, (width, kind) in layout(shape).items():
            path = self.folder / name / array
            if rows == 0:
                arrays[array] = np.empty((0, width), dtype=kind)
                continue
            try:
                arrays[array] = np.memmap(path, dtype=kind, mode="r", shape=(rows, width))
            except (FileNotFoundError, ValueError) as error:  # ValueError: the file is too short
                raise DamagedError(path) from error
        return arrays


def _clear_away(folder: Path) -> None:
    """Remove the files of embedded stores that are no longer there."""
    for manifest in folder.glob(f"*/{_MANIFEST}"):
        try:
            kind, _, path = json.loads(manifest.read_bytes())["store"].partition(":")
        except (OSError, ValueError, TypeError, KeyError, AttributeError):
            continue
        if kind == "sqlite" and not Path(path).exists():
            shutil.rmtree(manifest.parent, ignore_errors=True)


class _Sheet:
    """The files of one shape, open to be added to."""

    def __init__(self, folder: Path, shape: Shape, rows: int, stack: ExitStack) -> None:
        folder.mkdir(exist_ok=True)
        self.rows = rows
        self._kinds = {name: kind for name, (_, kind) in layout(shape).items()}
        self._files: dict[str, BinaryIO] = {}
        for name, (width, kind) in layout(shape).items():
            file = stack.enter_context((folder / name).open("r+b" if rows else "wb"))
            end = rows * width * kind.itemsize
            if file.seek(0, os.SEEK_END) < end:
                raise DamagedError(folder / name)
            file.seek(end)
            file.truncate()
            self._files[name] = file

    def add(self, arrays: Arrays) -> int:
        """Add rows; returns the number of the first."""
        first = self.rows
        for name, file in self._files.items():
            for start in range(0, len(arrays[name]), _ROWS_AT_ONCE):
                part = arrays[name][start : start + _ROWS_AT_ONCE]
                file.write(np.ascontiguousarray(part, dtype=self._kinds[name]).tobytes())
        self.rows += len(arrays["flags"])
        return first

    def sync(self) -> None:
        """Put everything on the disk."""
        for file in self._files.values():
            file.flush()
            os.fsync(file.fileno())


def _new_name(shape: Shape) -> str:
    return f"{'x'.join(map(str, shape))}-{secrets.token_hex(4)}"


def _encoded(manifest: Manifest, store: str) -> dict[str, Any]:
    shapes = list(manifest.folders)
    numbers = {shape: number for number, shape in enumerate(shapes)}
    return {
        "format": FORMAT,
        "store": store,
        "shapes": [[list(shape), *manifest.folders[shape]] for shape in shapes],
        "buildings": {
            building: [place.revision, None if place.shape is None else numbers[place.shape], place.first, place.count]
            for building, place in manifest.places.items()
        },
    }


def _decoded(document: Any, store: str) -> Manifest:
    """Return the manifest that a document is; raises one of many errors where it is none of ours."""
    if document["format"] != FORMAT or document["store"] != store:
        raise ValueError(document["store"])
    shapes: list[Shape] = []
    manifest = Manifest()
    for (slices, shells, sectors), name, rows in document["shapes"]:
        shapes.append((int(slices), int(shells), int(sectors)))
        if "/" in name or min(shapes[-1]) < 1:
            raise ValueError(name)
        manifest.folders[shapes[-1]] = (str(name), int(rows))
    for building, (revision, number, first, count) in document["buildings"].items():
        shape = None if number is None else shapes[number]
        if first < 0 or count < 0 or (shape is not None and first + count > manifest.folders[shape][1]):
            raise ValueError(building)
        manifest.places[building] = Place(revision, shape, int(first), int(count))
    return manifest
