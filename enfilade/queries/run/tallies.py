"""Statistics without the matches themselves: the store says how often each combination of needed values occurs."""

from __future__ import annotations

from enfilade.queries.compiler import Wanted
from enfilade.queries.kinds import whole_scope
from enfilade.queries.query_graph import QueryGraph
from enfilade.queries.sayable import is_mixed
from enfilade.queries.syntax import Call, Expression, PropertyOf, Subquery, Variable, aggregates, walk

from .needs import split_conditions


def wanted_values(query: QueryGraph) -> tuple[Wanted, ...] | None:
    """Return what the rows of the answer are made of, ids first, or None where the matches themselves are needed.

    They are for likeness, options, near misses, what only Python tests, and `collect`, which keeps their order.
    """
    pattern = query.pattern
    expressions = [*(column.expression for column in query.columns), *(key.expression for key in query.order)]
    if query.optional or query.relax is not None or not any(map(aggregates, expressions)):
        return None
    if any(node.likeness is not None for node in pattern.nodes) or any(map(is_mixed, pattern.edges)):
        return None
    if split_conditions(pattern, {})[1] or any(_needs_matches(part) for e in expressions for part in walk(e)):
        return None
    scope = whole_scope(query)
    found: dict[Wanted, None] = {}
    for part in (part for expression in expressions for part in walk(expression)):
        if isinstance(part, PropertyOf):
            found[Wanted(part.variable, part.name)] = None
        elif isinstance(part, Variable) and part.name in scope:
            found[Wanted(part.name, "id")] = None
    return tuple(sorted(found, key=lambda wanted: wanted.property != "id"))


def _needs_matches(expression: Expression) -> bool:
    return isinstance(expression, Subquery) or (
        isinstance(expression, Call) and expression.function in ("collect", "like")
    )
