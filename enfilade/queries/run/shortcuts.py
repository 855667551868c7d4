"""When a question can be answered from the best objects alone, and when likeness is better tested at the end."""

from __future__ import annotations

from typing import Final

from enfilade.queries.query_graph import Equal, Likeness, Pattern, QueryGraph
from enfilade.queries.syntax import Call, Comparison, Expression, Literal, Membership, PropertyOf, Variable, conjuncts

from .rows import is_aggregated, number_of_rows

_ANCHORS: Final = ("id", "building")
"""Properties whose value leaves at most the nodes of one building."""


def rows_needed(query: QueryGraph) -> int | None:
    """Return how many rows, best score first, tell the answer; None where it takes all rows, or nothing is likened.

    That is SKIP and LIMIT together, where the rows are in the order of their scores.
    """
    limit = number_of_rows(query.limit)
    is_likened = any(node.likeness is not None for node in query.pattern.nodes)
    if limit is None or query.relax is not None or not is_likened or is_aggregated(query) or not _best_first(query):
        return None
    return limit + (number_of_rows(query.skip) or 0)


def is_anchored(pattern: Pattern) -> bool:
    """Whether a pattern names a node or its building, so that it has few matches."""
    equal = [c.property for node in pattern.nodes for c in node.constraints if isinstance(c, Equal)]
    return any(property in _ANCHORS for property in equal) or any(map(_anchors, conjuncts(pattern.where)))


def like_limits(pattern: Pattern) -> list[tuple[str, Likeness]]:
    """Return, for like() in WHERE, within which distance of what an object must be for the condition to be true.

    It says what all matches have in common, not all of the condition.
    """
    own = {node.name for node in pattern.nodes}
    limits = filter(None, map(_like_limit, conjuncts(pattern.where)))
    return [(name, likeness) for name, likeness in limits if name in own]


def _like_limit(condition: Expression) -> tuple[str, Likeness] | None:
    match condition:
        case Comparison(
            "<" | "<=" | "=", Call("like", (Variable(name), reference)), Literal(int() | float()) as limit
        ) | Comparison(">" | ">=" | "=", Literal(int() | float()) as limit, Call("like", (Variable(name), reference))):
            return name, Likeness(reference, limit)
    return None


def _best_first(query: QueryGraph) -> bool:
    score = Variable("score")
    if query.order:
        return query.order[0].expression == score and query.order[0].descending
    return not query.distinct or any(column.expression == score for column in query.columns)


def _anchors(condition: Expression) -> bool:
    match condition:
        case Comparison("=", PropertyOf(_, name), Literal()) | Comparison("=", Literal(), PropertyOf(_, name)):
            return name in _ANCHORS
        case Membership(PropertyOf(_, name), Literal()):
            return name in _ANCHORS
    return False
