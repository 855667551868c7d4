"""A name of its own for each node and edge, those without a name and those in subqueries included."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from .query_graph import UNNAMED, Column, Pattern, QueryGraph, SortKey
from .syntax import Expression, PropertyOf, Subquery, Variable, rebuilt

Names = Mapping[str, str]


def separated(query: QueryGraph) -> QueryGraph:
    """Return the question with no name twice.

    ``EXISTS { (x)... } AND EXISTS { (x)... }`` speaks of two nodes x; the second gets another name. What has no
    name is numbered within its pattern, and gets a name that is unique in the question.
    """
    renamer = _Renamer()
    called: Names = {}
    patterns = []
    for pattern in (query.pattern, *query.optional):
        renamed, called = renamer.pattern(pattern, called)
        patterns.append(renamed)
    return replace(
        query,
        pattern=patterns[0],
        optional=tuple(patterns[1:]),
        columns=tuple(Column(c.name, renamer.expression(c.expression, called)) for c in query.columns),
        order=tuple(SortKey(renamer.expression(k.expression, called), k.descending) for k in query.order),
    )


class _Renamer:
    def __init__(self) -> None:
        self._taken: set[str] = set()

    def pattern(self, pattern: Pattern, outer: Names) -> tuple[Pattern, Names]:
        names = dict.fromkeys([*(node.name for node in pattern.nodes), *(edge.name for edge in pattern.edges)])
        own = [name for name in names if name not in outer or name.startswith(UNNAMED)]
        called = {**outer, **{name: self._free(name) for name in own}}
        nodes = tuple(replace(node, name=called[node.name]) for node in pattern.nodes)
        edges = tuple(
            replace(e, name=called[e.name], left=called.get(e.left, e.left), right=called.get(e.right, e.right))
            for e in pattern.edges
        )
        where = None if pattern.where is None else self.expression(pattern.where, called)
        return Pattern(nodes, edges, where), called

    def expression(self, expression: Expression, called: Names) -> Expression:
        if isinstance(expression, Subquery):
            return replace(expression, pattern=self.pattern(expression.pattern, called)[0])
        if isinstance(expression, Variable):
            return replace(expression, name=called.get(expression.name, expression.name))
        if isinstance(expression, PropertyOf):
            return replace(expression, variable=called.get(expression.variable, expression.variable))
        return rebuilt(expression, lambda part: self.expression(part, called))

    def _free(self, name: str) -> str:
        """Return the name, or one like it that nothing else has."""
        while name in self._taken:
            name += "'"
        self._taken.add(name)
        return name
