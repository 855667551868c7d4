"""Which properties of which elements must come back from the store, because something is done with them after it."""

from __future__ import annotations

from collections.abc import Iterator

from enfilade.queries.binding import free_variables
from enfilade.queries.kinds import Scope, scope_of, whole_scope
from enfilade.queries.query_graph import Pattern, QueryGraph
from enfilade.queries.relaxation import Entry, Holds, conditions_of
from enfilade.queries.sayable import sayable
from enfilade.queries.syntax import Expression, PropertyOf, Subquery, conjuncts, walk


def needed_properties(query: QueryGraph) -> dict[str, set[str]]:
    """Return the properties to fetch, by the name of the element."""
    found: dict[str, set[str]] = {}
    for variable, name in _uses(query):
        found.setdefault(variable, set()).add(name)
    return found


def split_conditions(pattern: Pattern, outer: Scope) -> tuple[tuple[Expression, ...], tuple[Expression, ...]]:
    """Return the conditions that the store tests, and those that are tested after it.

    A statement for an extension has the nodes from outside in it, but not the edges.
    """
    scope = scope_of(pattern, outer)
    edges = {name for name, meaning in outer.items() if not meaning.is_node}
    told: list[Expression] = []
    after: list[Expression] = []
    for part in conjuncts(pattern.where):
        in_store = sayable(part, scope) and not edges & set(free_variables(part))
        (told if in_store else after).append(part)
    return tuple(told), tuple(after)


def _uses(query: QueryGraph) -> Iterator[tuple[str, str]]:
    scope: Scope = {}
    for pattern in (query.pattern, *query.optional):
        yield from _in_pattern(pattern, scope)
        scope = scope_of(pattern, scope)
    if query.relax is not None:
        yield from _for_excess(query.pattern)
    whole = whole_scope(query)
    for expression in (*(c.expression for c in query.columns), *(k.expression for k in query.order)):
        yield from _in_expression(expression, whole)


def _for_excess(pattern: Pattern) -> Iterator[tuple[str, str]]:
    """Properties that tell how far off an unmet condition is."""
    for condition in conditions_of(pattern):
        if isinstance(condition, Entry):
            yield condition.element.name, condition.constraint.property
        elif isinstance(condition, Holds):
            yield from _in_expression(condition.expression, scope_of(pattern, {}))


def _in_pattern(pattern: Pattern, outer: Scope) -> Iterator[tuple[str, str]]:
    scope = scope_of(pattern, outer)
    yield from ((node.name, "segments") for node in pattern.nodes if node.label == "Object")
    for condition in split_conditions(pattern, outer)[1]:
        yield from _in_expression(condition, scope)


def _in_expression(expression: Expression, scope: Scope) -> Iterator[tuple[str, str]]:
    for part in walk(expression):
        if isinstance(part, PropertyOf):
            yield part.variable, part.name
        elif isinstance(part, Subquery):
            yield from _in_pattern(part.pattern, scope)
