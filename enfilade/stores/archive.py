"""A store together with the folder that holds the labelled clouds of its buildings.

The graph of a building knows the name of its cloud there (property ``cloud``). A cloud is written under a new
name before the graph that points to it, and an old one is taken away after it: whatever happens in between,
a graph never points to another version's points.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from hashlib import sha256
from itertools import groupby
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from enfilade.clouds import LABELS, LabelledCloud, read_cloud, write_cloud
from enfilade.errors import EnfiladeError, NotFoundError
from enfilade.progress import Progress, Silent
from enfilade.schema.graph import BuildingGraph
from enfilade.stores.base import Store, in_batches

_SILENT: Final = Silent()


def default_clouds_folder(store: Store) -> Path:
    """Return ``NAME.clouds`` beside an SQLite file, ``enfilade.clouds`` in the working folder otherwise."""
    scheme, _, rest = store.url.partition(":")
    return Path(rest).with_suffix(".clouds") if scheme == "sqlite" else Path("enfilade.clouds")


def cloud_file_name(store_url: str, building: str, cloud: LabelledCloud) -> str:
    """Return a file name that any file system takes, another for each store, building and change in its points.

    Stores may share a folder, and what one of them removes must not be the cloud of another.
    """
    readable = re.sub(r"[^A-Za-z0-9._-]+", "-", building).strip("-.")[:60] or "building"
    digest = sha256(f"{store_url}\0{building}".encode("utf-8", "surrogatepass"))
    columns = (cloud.positions, *(getattr(cloud, label) for label in LABELS), cloud.intensity, cloud.colour)
    with ThreadPoolExecutor() as threads:
        for part in threads.map(_digest, (column for column in columns if column is not None)):
            digest.update(part)
    return f"{readable}-{digest.hexdigest()[:16]}.ply"


def _digest(column: NDArray[Any]) -> bytes:
    return sha256(np.ascontiguousarray(column).data).digest()


@dataclass(frozen=True, slots=True)
class Archive:
    """Graphs in a store, clouds in a folder.

    Parameters
    ----------
    store
        Where the graphs live.
    clouds
        Folder of the labelled clouds; made when the first is written.
    """

    store: Store
    clouds: Path

    def save(self, graph: BuildingGraph, cloud: LabelledCloud | None) -> None:
        """Put a building in, in place of an older version of it; without `cloud` it has none."""
        before = self._cloud_name(graph.building)
        root = graph.nodes[graph.building]
        root.properties.pop("cloud", None)
        if cloud is not None:
            name = cloud_file_name(self.store.url, graph.building, cloud)
            self.clouds.mkdir(parents=True, exist_ok=True)
            write_cloud(self.clouds / name, cloud)
            root.properties["cloud"] = name
        after = root.properties.get("cloud")
        try:
            self.store.write(graph)
        except EnfiladeError:
            self._discard(after, kept=before)
            raise
        self._discard(before, kept=after)

    def save_all(self, buildings: Iterable[tuple[BuildingGraph, LabelledCloud | None]]) -> Iterator[str]:
        """Put buildings in, those without cloud many at once; yields the id of each when it is in."""
        for is_plain, group in groupby(buildings, key=lambda pair: pair[1] is None):
            if is_plain:
                for batch in in_batches(graph for graph, _ in group):
                    self._save_plain(batch)
                    yield from (graph.building for graph in batch)
                continue
            for graph, cloud in group:
                self.save(graph, cloud)
                yield graph.building

    def _save_plain(self, graphs: Sequence[BuildingGraph]) -> None:
        before = [self._cloud_name(graph.building) for graph in graphs]
        for graph in graphs:
            graph.nodes[graph.building].properties.pop("cloud", None)
        self.store.write_all(graphs)
        for name in before:
            self._discard(name, kept=None)

    def cloud_path(self, building: str) -> Path:
        """Return where a building's labelled cloud lies. Raises NotFoundError where it has none."""
        name = self._cloud_name(building)
        if name is None or not (self.clouds / name).is_file():
            raise NotFoundError(f"The building {building!r} has no labelled cloud in {self.clouds}; ingest it again.")
        return self.clouds / name

    def cloud(self, building: str) -> LabelledCloud | None:
        """Return a building's labelled cloud, or None where it has none: a graph without it still answers."""
        name = self._cloud_name(building)
        return read_cloud(self.clouds / name) if name is not None and (self.clouds / name).is_file() else None

    def remove(self, building: str) -> None:
        """Take a building out, graph and cloud. Raises NotFoundError."""
        name = self._cloud_name(building)
        self.store.remove(building)
        if name is not None:
            (self.clouds / name).unlink(missing_ok=True)

    def _discard(self, name: str | None, *, kept: str | None) -> None:
        if name is not None and name != kept:
            (self.clouds / name).unlink(missing_ok=True)

    def _cloud_name(self, building: str) -> str | None:
        try:
            properties = self.store.properties(building)
        except NotFoundError:
            return None
        name = properties.get("cloud")
        # A graph made elsewhere may say anything here; only a plain file name stays inside the folder.
        return name if isinstance(name, str) and name == Path(name).name and name.endswith(".ply") else None


def copy_buildings(
    source: Archive, target: Archive, buildings: Sequence[str] | None = None, *, progress: Progress = _SILENT
) -> list[str]:
    """Copy buildings with their clouds, each in a moment; one that is there already is replaced.

    Parameters
    ----------
    source, target
        From where and to where.
    buildings
        Ids, or None for all.
    progress
        Hears of each building.

    Returns
    -------
    list of str
        The ids copied, in order.

    Raises
    ------
    NotFoundError
        If the source lacks one of the buildings; then none is copied.
    """
    known = {summary.id: None for summary in source.store.buildings()}
    ids = list(known if buildings is None else dict.fromkeys(buildings))
    missing = next((id for id in ids if id not in known), None)
    if missing is not None:
        raise NotFoundError(f'there is no building "{missing}" in {source.store.url}; nothing was copied')
    progress.start("copy", len(ids))
    for _ in target.save_all((source.store.read(id), source.cloud(id)) for id in ids):
        progress.advance()
    return ids
