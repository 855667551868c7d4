"""What every store can do; SQLite and Neo4j differ only behind this."""

from __future__ import annotations

import math
import secrets
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import TracebackType
from typing import TYPE_CHECKING, Any, ClassVar, Final, Self

import numpy as np
from numpy.typing import NDArray

from enfilade.errors import EnfiladeError
from enfilade.schema.graph import BuildingGraph
from enfilade.schema.ids import MAX_SEGMENTS, parse

if TYPE_CHECKING:
    from enfilade.stores.descriptor_cache import DescriptorCache


@dataclass(frozen=True, slots=True)
class BuildingSummary:
    """One line of ``enfilade buildings``."""

    id: str
    name: str | None
    storeys: int
    rooms: int
    openings: int
    objects: int
    area: float | None
    ingested_at: str | None


@dataclass(frozen=True, slots=True)
class BuildingDescriptors:
    """Descriptors of the objects of one building, as it was written last.

    Attributes
    ----------
    building
        Its id.
    revision
        What tells this version of the building from all others; None where it is not known.
    shape
        Slices, shells, sectors; None for a building without descriptors.
    numbers
        ``(n, 3) int64`` numbers of each object's segments, as in its id; -1 for none.
    floor, foot
        ``(n, bins) uint16``, `descriptor` and `foot_descriptor`; zeros where one is missing, never both.
    """

    building: str
    revision: str | None
    shape: tuple[int, int, int] | None
    numbers: NDArray[np.int64]
    floor: NDArray[np.uint16]
    foot: NDArray[np.uint16]

    @classmethod
    def from_rows(
        cls,
        building: str,
        revision: str | None,
        shape: tuple[int, int, int] | None,
        rows: Sequence[tuple[str, bytes | None, bytes | None]],
    ) -> BuildingDescriptors:
        """Return the descriptors from rows of id, `descriptor`, `foot_descriptor`, as stores hold them."""
        bins = 0 if shape is None else math.prod(shape)
        missing = bytes(2 * bins)
        blobs = ([floor or missing for _, floor, _ in rows], [foot or missing for _, _, foot in rows])
        floor, foot = (
            np.frombuffer(b"".join(kind), dtype="<u2").reshape(len(rows), bins).astype(np.uint16, copy=False)
            for kind in blobs
        )
        numbers = np.array([(*parse(id).numbers, -1, -1)[:MAX_SEGMENTS] for id, _, _ in rows], dtype=np.int64)
        return cls(building, revision, shape, numbers.reshape(-1, MAX_SEGMENTS), floor, foot)


def new_revision() -> str:
    """Return a word that no building was ever marked with."""
    return secrets.token_hex(8)


ROWS_AT_ONCE: Final = 8_000
"""Nodes and edges that `in_batches` puts into one transaction: some 10 MB with their descriptors."""


def in_batches(graphs: Iterable[BuildingGraph], rows: int = ROWS_AT_ONCE) -> Iterator[list[BuildingGraph]]:
    """Yield graphs as lists for `Store.write_all`, each of at least `rows` nodes and edges but for the last.

    Where the next graph cannot be had, those before it come first, and then the error.
    """
    batch: list[BuildingGraph] = []
    waiting = 0
    try:
        for graph in graphs:
            batch.append(graph)
            waiting += len(graph.nodes) + len(graph.edges)
            if waiting >= rows:
                yield batch
                batch, waiting = [], 0
    except EnfiladeError:
        if batch:
            yield batch
        raise
    if batch:
        yield batch


class Store(ABC):
    """A graph database that holds many buildings."""

    dialect: ClassVar[str]
    """Which compiler writes for it: ``"sql"`` or ``"cypher"``."""

    @property
    @abstractmethod
    def url(self) -> str:
        """Address of the store, without a password."""

    @property
    def identity(self) -> str:
        """What tells the store from all others of this user, wherever it is opened from."""
        return self.url

    def write(self, graph: BuildingGraph) -> None:
        """Put a building in, in one transaction; an older version of it disappears in the same moment."""
        self.write_all([graph])

    @abstractmethod
    def write_all(self, graphs: Sequence[BuildingGraph]) -> None:
        """Put buildings in, all or none, in one transaction: much faster than one by one.

        They must fit memory, ours and the server's; `in_batches` takes many apart. Of a building that is there twice
        the last stays. Raises GraphError where one breaks the schema.
        """

    @abstractmethod
    def read(self, building: str) -> BuildingGraph:
        """Return a building's whole graph, as it was written. Raises NotFoundError."""

    @abstractmethod
    def properties(self, node: str) -> dict[str, Any]:
        """Return the properties of one node by its key, without its descriptors. Raises NotFoundError."""

    @abstractmethod
    def remove(self, building: str) -> None:
        """Take a building out, in one transaction. Raises NotFoundError."""

    @abstractmethod
    def buildings(self) -> list[BuildingSummary]:
        """All buildings, by id."""

    @abstractmethod
    def rows(
        self, text: str, parameters: Mapping[str, Any], *, timeout_s: float | None = None, most: int | None = None
    ) -> Iterator[tuple[Any, ...]]:
        """Run a compiled question, read-only; yields `most` rows at most. Raises StoreError past the time limit."""

    @abstractmethod
    def plan(self, text: str, parameters: Mapping[str, Any]) -> str:
        """Return the engine's own plan for a compiled question, as text."""

    @abstractmethod
    def revisions(self) -> dict[str, str | None]:
        """Of each building what tells its version from all others, None where that is not known."""

    @abstractmethod
    def descriptors(self, buildings: Sequence[str]) -> Iterator[BuildingDescriptors]:
        """Yield the descriptors of buildings, each as it stood at one moment; one that is gone is left out."""

    @cached_property
    def described(self) -> DescriptorCache:
        """The descriptors of all objects, kept at hand."""
        from enfilade.stores.descriptor_cache import DescriptorCache  # which needs this module

        return DescriptorCache(self)

    @abstractmethod
    def close(self) -> None:
        """Let go of files and connections."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
