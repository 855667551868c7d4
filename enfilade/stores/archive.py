"""A store together with the folder that holds the labelled clouds of its buildings.

The graph of a building knows the name of its cloud there (property ``cloud``). A cloud is written under a new
name before the graph that points to it, and an old one is taken away after it: whatever happens in between,
a graph never points to another version's points.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from enfilade.clouds import LabelledCloud, read_cloud, write_cloud
from enfilade.errors import NotFoundError
from enfilade.schema.graph import BuildingGraph
from enfilade.stores.base import Store


def default_clouds_folder(store: Store) -> Path:
    """Return ``NAME.clouds`` beside an SQLite file, ``enfilade.clouds`` in the working folder otherwise."""
    scheme, _, rest = store.url.partition(":")
    return Path(rest).with_suffix(".clouds") if scheme == "sqlite" else Path("enfilade.clouds")


def cloud_file_name(building: str, content_hash: str) -> str:
    """Return a file name that any file system takes, different for every building and version."""
    readable = re.sub(r"[^A-Za-z0-9._-]+", "-", building).strip("-.")[:60] or "building"
    digest = sha256(f"{building}\0{content_hash}".encode("utf-8", "surrogatepass")).hexdigest()
    return f"{readable}-{digest[:16]}.ply"


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
            name = cloud_file_name(graph.building, str(root.properties.get("content_hash", "")))
            self.clouds.mkdir(parents=True, exist_ok=True)
            write_cloud(self.clouds / name, cloud)
            root.properties["cloud"] = name
        self.store.write(graph)
        if before is not None and before != root.properties.get("cloud"):
            (self.clouds / before).unlink(missing_ok=True)

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

    def _cloud_name(self, building: str) -> str | None:
        try:
            properties = self.store.properties(building)
        except NotFoundError:
            return None
        name = properties.get("cloud")
        # A graph made elsewhere may say anything here; only a plain file name stays inside the folder.
        return name if isinstance(name, str) and name == Path(name).name and name.endswith(".ply") else None
