"""What every store can do; SQLite and Neo4j differ only behind this."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import Any, ClassVar, Final, Self

import numpy as np
from numpy.typing import NDArray

from enfilade.errors import EnfiladeError
from enfilade.schema.graph import BuildingGraph


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
class DescriptorTable:
    """All descriptors of one kind and shape in a store, one row an object.

    Attributes
    ----------
    shape
        Slices, shells, sectors.
    ids
        n object ids.
    counts
        ``(n, bins) uint16``, each row sums to `enfilade.descriptors.TOTAL`.
    floor_offsets
        ``(n,) float32`` metres, NaN where unknown.
    """

    shape: tuple[int, int, int]
    ids: Sequence[str]
    counts: NDArray[np.uint16]
    floor_offsets: NDArray[np.float32]


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
    def descriptors(self, property: str) -> list[DescriptorTable]:
        """All values of ``descriptor`` or ``foot_descriptor``, one table a shape."""

    @abstractmethod
    def close(self) -> None:
        """Let go of files and connections."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
