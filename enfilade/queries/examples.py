"""What LIKE refers to, and how far stored objects are from it (Eq. 11).

A stored object is compared by `descriptor`, whose base is the floor. A file has no height over the floor: it is
compared by `foot_descriptor`, foot on foot. An object without one is compared by `descriptor`, as if the example
stood on the floor. With ``AT`` the file is set at that height and compared by `descriptor`.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from enfilade.descriptors import DEFAULT_LAYOUT, PAPER_LAYOUT, Layout, Shape, mesh_views, read_shape
from enfilade.descriptors.nearest import Effort
from enfilade.errors import NotFoundError, QuestionError
from enfilade.stores.base import Store
from enfilade.stores.described import FLOOR, FOOT, Described, DescribedObjects

from .query_graph import Likeness
from .ranking import Part, Ranking
from .syntax import Call, Expression, Literal, Parameter

OBJECT_PREFIX = "object:"

_EXISTS = {
    "sql": 'SELECT id FROM "object" WHERE id = :id',
    "cypher": "CYPHER 5 MATCH (o:Object) WHERE o.id = $id RETURN o.id",
}


Key = tuple[Expression, tuple[Expression, Expression] | None]


class Examples:
    """Reads the examples of a question and ranks the objects of a store by their likeness to each.

    Parameters
    ----------
    store
        Where the objects are.
    given
        Values of the parameters that LIKE may refer to: a path, ``object:ID``, or a shape.
    check
        Called now and then while descriptors are read; what it raises breaks that off.
    """

    def __init__(self, store: Store, given: Mapping[str, Any], check: Callable[[], None] = lambda: None) -> None:
        self._store = store
        self._given = given
        self._check = check
        self._rankings: dict[Key, Ranking] = {}
        self._described: Described | None = None

    def ranking(self, likeness: Likeness) -> Ranking:
        """Return the ranking by likeness to an example, one for all that name it alike.

        Raises
        ------
        NotFoundError
            If the example is an object that the store has not.
        InputError
            If the example's file cannot be read.
        """
        key = (likeness.reference, likeness.at)
        if key not in self._rankings:
            self._rankings[key] = Ranking(self._parts(likeness))
        return self._rankings[key]

    def within(self, likeness: Likeness) -> Collection[str]:
        """Ids of the objects that are like the example."""
        ranking = self.ranking(likeness)
        if likeness.within is None:
            return ranking.comparable()
        return ranking.within(number_of(likeness.within))

    def is_like(self, likeness: Likeness, id: str) -> bool:
        """Whether one object is like the example."""
        ranking = self.ranking(likeness)
        if likeness.within is None:
            return ranking.is_comparable(id)
        distance = ranking.distance(id)
        return distance is not None and distance <= number_of(likeness.within)

    @property
    def efforts(self) -> dict[Key, Effort]:
        """What each example took so far."""
        return {key: ranking.effort for key, ranking in self._rankings.items()}

    @property
    def described(self) -> Described:
        """The described objects of the store, as they are when the first example is looked at."""
        if self._described is None:
            self._described = self._store.described.current(self._check)
        return self._described

    def _parts(self, likeness: Likeness) -> list[Part]:
        target = self._target(likeness.reference)
        if isinstance(target, str):
            if likeness.at is not None:
                raise QuestionError("AT is for a file: the height of a stored object is known.")
            return self._like_object(target)
        if likeness.at is None:
            return [part for objects in self.described.objects for part in self._foot_on_foot(target, objects)]
        low, high = map(number_of, likeness.at)
        return [self._at_heights(target, objects, low, high) for objects in self.described.objects]

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

    def _like_object(self, id: str) -> list[Part]:
        for kind in (FLOOR, FOOT):
            for objects in self.described.objects:
                table = objects.table(kind)
                row = objects.row_of(id)
                if row is not None and table.valid[row]:
                    return [Part(objects, table, table.counts[row], self._check)]
        if not any(True for _ in self._store.rows(_EXISTS[self._store.dialect], {"id": id})):
            raise NotFoundError(f'there is no object "{id}" in {self._store.url} to be like.')
        return []

    def _foot_on_foot(self, shape: Shape, objects: DescribedObjects) -> Iterator[Part]:
        views = mesh_views(shape, layout_of(objects.shape))
        for table in (objects.table(FOOT), objects.floor_without_foot):
            if table.valid.any():
                yield Part(objects, table, views, self._check)

    def _at_heights(self, shape: Shape, objects: DescribedObjects, low: float, high: float) -> Part:
        layout = layout_of(objects.shape)
        count = 1 + int(np.ceil((high - low) / layout.slice_height_m - 1e-9))
        heights = np.linspace(low, high, count)
        views = [mesh_views(shape, layout, floor_offset_m=float(h), base_offset_m=float(h)) for h in heights]
        return Part(objects, objects.table(FLOOR), np.concatenate(views), self._check)


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
