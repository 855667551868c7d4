"""How far the objects of a store are from one example: measured one by one, within a limit, or the nearest first."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import add

import numpy as np
from numpy.typing import NDArray

from enfilade.descriptors.nearest import DescriptorTable, Effort, Nearest
from enfilade.stores.described import DescribedObjects


class Part:
    """Objects that are compared with the same views of an example, by the same of their descriptors.

    Parameters
    ----------
    objects
        The objects of one shape.
    table
        Their descriptors; which of them are compared it says itself.
    views
        ``(V, bins)`` counts of the example.
    check
        Called now and then while objects are measured; what it raises breaks that off.
    """

    def __init__(
        self,
        objects: DescribedObjects,
        table: DescriptorTable,
        views: NDArray[np.uint16],
        check: Callable[[], None] = lambda: None,
    ) -> None:
        self.objects = objects
        self.nearest = Nearest(views, table, check)
        self._valid = table.valid

    def row_of(self, id: str) -> int | None:
        """Row of an object that is compared here, or None."""
        row = self.objects.row_of(id)
        return row if row is not None and self._valid[row] else None


@dataclass(frozen=True, slots=True)
class Best:
    """The nearest objects.

    Attributes
    ----------
    distances
        By id, nearest first.
    beyond
        Every other object is farther than this; infinite where there is no other.
    """

    distances: dict[str, float]
    beyond: float


class Ranking:
    """Ranks the objects of a store by their distance to an example, as far as it is asked to.

    Parameters
    ----------
    parts
        No object is in two of them.
    """

    def __init__(self, parts: Sequence[Part]) -> None:
        self._parts = parts
        self._known: dict[str, float | None] = {}
        self._comparable: list[str] | None = None

    @property
    def effort(self) -> Effort:
        """What it took so far."""
        return reduce(add, (part.nearest.effort for part in self._parts), Effort())

    def distance(self, id: str) -> float | None:
        """Return the distance of an object; None for one that cannot be compared."""
        if id not in self._known:
            self.measure([id])
        return self._known[id]

    def measure(self, ids: Iterable[str]) -> None:
        """Measure some objects at once, which takes less time than one by one."""
        rest = [id for id in dict.fromkeys(ids) if id not in self._known]
        for part in self._parts:
            rows = {id: row for id in rest if (row := part.row_of(id)) is not None}
            found = part.nearest.of(np.array(list(rows.values()), dtype=np.int64))
            self._known.update(zip(rows, found.tolist(), strict=True))
        for id in rest:
            self._known.setdefault(id)

    def is_comparable(self, id: str) -> bool:
        """Whether an object has a distance, without measuring it."""
        return any(part.row_of(id) is not None for part in self._parts)

    def comparable(self) -> list[str]:
        """Ids of all objects that have a distance."""
        if self._comparable is None:
            self._comparable = [id for part in self._parts for id in part.objects.ids_of(part.nearest.rows)]
        return self._comparable

    def within(self, limit: float) -> dict[str, float]:
        """Distances of all objects within a limit, by id."""
        return self._kept((part, *part.nearest.within(limit)) for part in self._parts)

    def best(self, count: int, limit: float = np.inf) -> Best:
        """Return so many of the nearest objects, and all tied with the last, but none beyond a limit."""
        found = self._kept((part, *part.nearest.best(count)) for part in self._parts)
        ordered = sorted(found.items(), key=lambda item: item[1])
        if len(ordered) < min(count, self.effort.candidates) or count >= self.effort.candidates:
            last = np.inf
        else:
            last = ordered[count - 1][1] if count else -np.inf
        beyond = last if last < limit else np.inf
        return Best({id: distance for id, distance in ordered if distance <= min(last, limit)}, float(beyond))

    def _kept(self, found: Iterable[tuple[Part, NDArray[np.int64], NDArray[np.float64]]]) -> dict[str, float]:
        kept: dict[str, float] = {}
        for part, rows, distances in found:
            kept.update(zip(part.objects.ids_of(rows), distances.tolist(), strict=True))
        self._known.update(kept)
        return kept
