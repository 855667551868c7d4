"""The same question with other expressions in it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from .query_graph import Column, Constraint, Equal, Likeness, Pattern, QueryGraph, SortKey
from .syntax import Expression

Change = Callable[[Expression], Expression]


def with_expressions(query: QueryGraph, change: Change) -> QueryGraph:
    """Return a question with `change` applied to each of its expressions, those in patterns included."""
    return replace(
        query,
        pattern=pattern_with(query.pattern, change),
        optional=tuple(pattern_with(pattern, change) for pattern in query.optional),
        columns=tuple(Column(c.name, change(c.expression)) for c in query.columns),
        order=tuple(SortKey(change(k.expression), k.descending) for k in query.order),
        skip=_changed(query.skip, change),
        limit=_changed(query.limit, change),
        per_building=_changed(query.per_building, change),
        relax=_changed(query.relax, change),
    )


def pattern_with(pattern: Pattern, change: Change) -> Pattern:
    """Return a pattern with `change` applied to each of its expressions."""
    nodes = tuple(
        replace(
            node,
            constraints=tuple(_constraint(c, change) for c in node.constraints),
            likeness=None if node.likeness is None else _likeness(node.likeness, change),
        )
        for node in pattern.nodes
    )
    edges = tuple(replace(e, constraints=tuple(_constraint(c, change) for c in e.constraints)) for e in pattern.edges)
    return Pattern(nodes, edges, _changed(pattern.where, change))


def _constraint(constraint: Constraint, change: Change) -> Constraint:
    if isinstance(constraint, Equal):
        return replace(constraint, value=change(constraint.value))
    return replace(constraint, low=_changed(constraint.low, change), high=_changed(constraint.high, change))


def _likeness(likeness: Likeness, change: Change) -> Likeness:
    """Return a likeness with other limits; the reference stays, it is looked up when the example is read."""
    at = None if likeness.at is None else (change(likeness.at[0]), change(likeness.at[1]))
    return replace(likeness, within=_changed(likeness.within, change), at=at)


def _changed(expression: Expression | None, change: Change) -> Expression | None:
    return None if expression is None else change(expression)
