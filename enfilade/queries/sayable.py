"""Which conditions every store can test itself, with the language's exact meaning; the others are tested after it."""

from __future__ import annotations

from .kinds import Scope, scope_of
from .query_graph import EdgePattern, Pattern
from .syntax import (
    Comparison,
    Expression,
    IsNull,
    Literal,
    Logic,
    Membership,
    Not,
    PropertyOf,
    Subquery,
    TextTest,
    Variable,
)
from .vocabulary import OPENING_EDGES


def sayable(expression: Expression, scope: Scope) -> bool:
    """Whether a compiler may write the condition.

    Arithmetic is not among it (the engines divide and overflow each in their own way), nor like(), nor what depends
    on the order in which overlapping matches are preferred (LIKE inside ``count { }``).
    """
    match expression:
        case Literal(value):
            return not isinstance(value, tuple)
        case PropertyOf(variable, name):
            return scope[variable].properties()[name].kind.scalar
        case Comparison(_, left, right):
            return all(sayable(side, scope) or _is_node(side, scope) for side in (left, right))
        case Logic(_, operands):
            return all(sayable(operand, scope) for operand in operands)
        case Not(operand):
            return sayable(operand, scope)
        case IsNull(operand):
            return isinstance(operand, PropertyOf) or sayable(operand, scope)
        case Membership(item, container):
            is_list = isinstance(container, Literal) and isinstance(container.value, tuple)
            return is_list and sayable(item, scope)
        case TextTest(_, left, right):
            is_text = isinstance(right, Literal) and isinstance(right.value, str) and "\0" not in right.value
            return is_text and sayable(left, scope)
        case Subquery(kind, pattern):
            return _sayable_pattern(kind, pattern, scope)
    return False


def _is_node(expression: Expression, scope: Scope) -> bool:
    return isinstance(expression, Variable) and expression.name in scope and scope[expression.name].is_node


def is_mixed(edge: EdgePattern) -> bool:
    """Whether an edge may be of several stored types, or an opening or a stored one."""
    return len(edge.types) > 1 and not set(edge.types) <= set(OPENING_EDGES)


def _sayable_pattern(kind: str, pattern: Pattern, outer: Scope) -> bool:
    likened = any(node.likeness is not None for node in pattern.nodes)
    if kind == "count" and (likened or any(is_mixed(edge) for edge in pattern.edges)):
        return False
    return pattern.where is None or sayable(pattern.where, scope_of(pattern, outer))
