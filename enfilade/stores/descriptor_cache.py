"""Keeps the descriptors of a store at hand, so that a question never reads those of buildings that did not change."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

from enfilade.cache import cache_folder
from enfilade.stores.base import BuildingDescriptors, Store
from enfilade.stores.described import Described, DescribedObjects, grouped_places, in_memory
from enfilade.stores.descriptor_files import DamagedError, DescriptorFiles, Manifest

Check = Callable[[], None]

ROWS_BETWEEN_SAVES: Final = 100_000
"""Rows after which what was read so far is safe: a reading that is broken off goes on from there the next time."""

_TRIES: Final = 3
"""Another process may replace the files between the manifest and them; where that is not it, they are damaged."""


@dataclass(slots=True)
class _Mapped:
    """What was found in the files, and in which version of them."""

    version: tuple[int, ...] | None = None
    manifest: Manifest = field(default_factory=Manifest)
    described: Described | None = None


class DescriptorCache:
    """The descriptors of one store, in files of the user's cache folder, or in memory where it cannot be written.

    Parameters
    ----------
    store
        Where the descriptors come from.
    folder
        Of all stores' files; by default one in the user's cache folder.
    """

    def __init__(self, store: Store, folder: Path | None = None) -> None:
        self._store = store
        self._files = DescriptorFiles(folder or cache_folder() / "descriptors", store.identity)
        self._lock = threading.Lock()
        self._mapped = _Mapped()
        self._read: dict[str, BuildingDescriptors] = {}
        self._in_memory = Described(())

    def current(self, check: Check = lambda: None) -> Described:
        """Return all described objects of the store as they are now.

        Parameters
        ----------
        check
            Called now and then; what it raises breaks the work off.

        Raises
        ------
        StoreError
            If the store fails.
        """
        start = time.perf_counter()
        with self._lock:
            wanted = self._store.revisions()
            try:
                found, read_anew = self._from_files(wanted, check)
            except OSError:  # the folder is read-only, full, or no folder
                found, read_anew = self._from_memory(wanted, check)
        return replace(found, read_anew=read_anew, seconds=time.perf_counter() - start)

    def _from_files(self, wanted: dict[str, str | None], check: Check) -> tuple[Described, int]:
        read_anew = 0
        for attempt in range(_TRIES):
            if self._files.version() != self._mapped.version:
                self._mapped = _Mapped(self._files.version(), self._files.read())
            if self._mapped.manifest.differs(wanted) or attempt == _TRIES - 1:
                read_anew += self._refresh(wanted, check)
            try:
                return self._opened(), read_anew
            except DamagedError:
                self._mapped = _Mapped()
        raise DamagedError(self._files.folder)

    def _refresh(self, wanted: dict[str, str | None], check: Check) -> int:
        """Bring the files up to date; returns how many buildings were read."""
        with self._files.alone(check):
            manifest = self._files.read()
            try:
                self._files.open(manifest)
            except DamagedError:
                manifest = Manifest()
            stale = manifest.stale(wanted)
            manifest.drop(stale, wanted)
            self._files.compact(manifest)
            buildings = _checked(self._store.descriptors(stale), check)
            while not self._files.append(manifest, buildings, ROWS_BETWEEN_SAVES):
                pass
            self._mapped = _Mapped(self._files.version(), manifest)
        return len(stale)

    def _opened(self) -> Described:
        if self._mapped.described is None:
            arrays = self._files.open(self._mapped.manifest)
            places = grouped_places(self._mapped.manifest.places)
            objects = [DescribedObjects(shape, arrays[shape], own) for shape, own in places.items()]
            self._mapped.described = Described(objects)
        return self._mapped.described

    def _from_memory(self, wanted: dict[str, str | None], check: Check) -> tuple[Described, int]:
        stale = [b for b, revision in wanted.items() if revision is None or _revision(self._read.get(b)) != revision]
        if stale or self._read.keys() != wanted.keys():
            for building in [*stale, *(self._read.keys() - wanted.keys())]:
                self._read.pop(building, None)
            for found in _checked(self._store.descriptors(stale), check):
                self._read[found.building] = found
            self._in_memory = in_memory(self._read.values())
        return self._in_memory, len(stale)


def _revision(found: BuildingDescriptors | None) -> str | None:
    return None if found is None else found.revision


def _checked(buildings: Iterator[BuildingDescriptors], check: Check) -> Iterator[BuildingDescriptors]:
    for found in buildings:
        check()
        yield found
