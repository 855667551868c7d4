"""What LIKE refers to, and how far every stored object is from it (Eq. 11).

A stored object is compared by `descriptor`, whose base is the floor. A file has no height over the floor: it is
compared by `foot_descriptor`, foot on foot. An object without one is compared by `descriptor`, as if the example
stood on the floor. With ``AT`` the file is set at that height and compared by `descriptor`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from enfilade.descriptors import DEFAULT_LAYOUT, PAPER_LAYOUT, Layout, Shape, distances, mesh_views, read_shape
from enfilade.errors import NotFoundError, QuestionError
from enfilade.stores.base import DescriptorTable, Store

from .query_graph import Likeness
from .syntax import Call, Expression, Literal, Parameter

OBJECT_PREFIX = "object:"

_DECIMALS = 12
"""Distances are exact to this many decimals; what lies beyond is noise of the summing."""

_EXISTS = {
    "sql": 'SELECT id FROM "object" WHERE id = :id',
    "cypher": "CYPHER 5 MATCH (o:Object) WHERE o.id = $id RETURN o.id",
}


class Examples:
    """Reads the examples of a question and measures the objects of a store against them, once each.

    Parameters
    ----------
    store
        Where the objects are.
    given
        Values of the parameters that LIKE may refer to: a path, ``object:ID``, or a shape.
    """

    def __init__(self, store: Store, given: Mapping[str, Any]) -> None:
        self._store = store
        self._given = given
        self._distances: dict[tuple[Expression, tuple[Expression, Expression] | None], dict[str, float]] = {}
        self._tables: dict[str, list[DescriptorTable]] = {}
        self.compared = 0
        """Distances computed so far, a mesh with all its views counted once an object."""

    def distances(self, likeness: Likeness) -> Mapping[str, float]:
        """Distance of every object that can be compared with the example, by id.

        Raises
        ------
        NotFoundError
            If the example is an object that the store has not.
        InputError
            If the example's file cannot be read.
        """
        key = (likeness.reference, likeness.at)
        if key not in self._distances:
            self._distances[key] = self._measured(likeness)
        return self._distances[key]

    def within(self, likeness: Likeness) -> dict[str, float]:
        """Distances of the objects that are like the example, by id."""
        found = self.distances(likeness)
        if likeness.within is None:
            return dict(found)
        limit = number_of(likeness.within)
        return {id: distance for id, distance in found.items() if distance <= limit}

    def _measured(self, likeness: Likeness) -> dict[str, float]:
        target = self._target(likeness.reference)
        if isinstance(target, str):
            if likeness.at is not None:
                raise QuestionError("AT is for a file: the height of a stored object is known.")
            return self._from_object(target)
        if likeness.at is None:
            return self._foot_on_foot(target)
        low, high = map(number_of, likeness.at)
        return self._at_heights(target, low, high)

    def _target(self, reference: Expression) -> str | Shape:
        """Return the id of an object, or a shape."""
        match reference:
            case Literal(str(path)):
                return read_shape(path)
            case Call("object", (Literal(str(id)),)):
                return id
            case Call("object", (Parameter(name),)) if isinstance(self._given[name], str):
                return str(self._given[name])
            case Parameter(name):
                return self._given_target(name, self._given[name])
        raise QuestionError("an example is a file in quotes, a $parameter or object('id').")

    def _given_target(self, name: str, value: Any) -> str | Shape:
        if isinstance(value, Shape):
            return value
        if isinstance(value, str) and value.startswith(OBJECT_PREFIX):
            return value.removeprefix(OBJECT_PREFIX)
        if isinstance(value, str | Path):
            return read_shape(value)
        raise QuestionError(f"${name} is no example; give a mesh or cloud file, or object:ID.")

    def _from_object(self, id: str) -> dict[str, float]:
        for property in ("descriptor", "foot_descriptor"):
            for table in self._table(property):
                row = next((i for i, known in enumerate(table.ids) if known == id), None)
                if row is not None:
                    return self._rows(table.counts[row], table)
        if not any(True for _ in self._store.rows(_EXISTS[self._store.dialect], {"id": id})):
            raise NotFoundError(f'there is no object "{id}" in {self._store.url} to be like.')
        return {}

    def _foot_on_foot(self, shape: Shape) -> dict[str, float]:
        found: dict[str, float] = {}
        for table in self._table("foot_descriptor"):
            found |= self._rows(mesh_views(shape, layout_of(table.shape)), table)
        for table in self._table("descriptor"):
            rest = [row for row, id in enumerate(table.ids) if id not in found]
            if rest:
                found |= self._rows(mesh_views(shape, layout_of(table.shape)), _taken(table, rest))
        return found

    def _at_heights(self, shape: Shape, low: float, high: float) -> dict[str, float]:
        found: dict[str, float] = {}
        for table in self._table("descriptor"):
            layout = layout_of(table.shape)
            count = 1 + int(np.ceil((high - low) / layout.slice_height_m - 1e-9))
            heights = np.linspace(low, high, count)
            views = [mesh_views(shape, layout, floor_offset_m=float(h), base_offset_m=float(h)) for h in heights]
            found |= self._rows(np.concatenate(views), table)
        return found

    def _table(self, property: str) -> Iterable[DescriptorTable]:
        if property not in self._tables:
            self._tables[property] = self._store.descriptors(property)
        return self._tables[property]

    def _rows(self, views: NDArray[np.uint16], table: DescriptorTable) -> dict[str, float]:
        self.compared += len(table.ids)
        found = np.round(distances(views, table.counts, table.shape), _DECIMALS)
        return dict(zip(table.ids, found.tolist(), strict=True))


def layout_of(shape: tuple[int, int, int]) -> Layout:
    """Return the layout of descriptors of a shape: ours, the paper's, or ours with as many bins."""
    for layout in (DEFAULT_LAYOUT, PAPER_LAYOUT):
        if layout.shape == shape:
            return layout
    return replace(DEFAULT_LAYOUT, slices=shape[0], shells=shape[1], sectors=shape[2])


def number_of(expression: Expression) -> float:
    """Return the value of a number in a bound question."""
    assert isinstance(expression, Literal)
    assert isinstance(expression.value, int | float)
    return expression.value


def _taken(table: DescriptorTable, rows: list[int]) -> DescriptorTable:
    ids = [table.ids[row] for row in rows]
    return DescriptorTable(table.shape, ids, table.counts[rows], table.floor_offsets[rows])
