"""One spelling for expressions that mean the same up to the order of AND, OR, =, <>, + and *.

Two expressions have equal canonical texts under two namings if the first naming makes of the one what the second
makes of the other. Names inside EXISTS and count do not matter, nor the order in which their patterns are written.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import islice, permutations, product
from typing import Final

from .kinds import TEXT, Scope, kind_of, scope_of
from .query_graph import Constraint, EdgePattern, Equal, Likeness, NodePattern, Pattern
from .syntax import (
    Arithmetic,
    Call,
    Comparison,
    Expression,
    IsNull,
    Literal,
    Logic,
    PropertyOf,
    Subquery,
    Variable,
    children,
)

Names = Mapping[str, str]

_TURNED: Final = {">": "<", ">=": "<="}
_MOST_ORDERS: Final = 5040
"""Orders of the nodes of an inner pattern that are looked at; more than seven like nodes are taken as written."""


def canonical(expression: Expression, names: Names, scope: Scope) -> str:
    """Return the canonical text of an expression.

    Parameters
    ----------
    expression
        Any expression of a bound question.
    names
        What to call each variable.
    scope
        What each variable means.
    """
    match expression:
        case Literal(value):
            return _value(value)
        case Variable(name):
            return names.get(name, name)
        case PropertyOf(variable, name):
            return f"{names.get(variable, variable)}.{name}"
        case Logic(operator) if operator != "XOR":
            return _joined(operator, _operands(expression, operator), names, scope)
        case Comparison(operator, left, right):
            return _comparison(operator, canonical(left, names, scope), canonical(right, names, scope))
        case Arithmetic(operator) if operator in "+*" and kind_of(expression, scope) != TEXT:
            return _joined(operator, _operands(expression, operator), names, scope)
        case Subquery(kind, pattern):
            return f"{kind}{{{_pattern(pattern, names, scope)}}}"
    parts = ",".join(canonical(child, names, scope) for child in children(expression))
    return f"{type(expression).__name__}{_details(expression)}({parts})"


def canonical_constraint(constraint: Constraint) -> str:
    """Return the canonical text of a constraint of a map."""
    if isinstance(constraint, Equal):
        return f"{constraint.property}={canonical(constraint.value, {}, {})}"
    ends = ("" if end is None else canonical(end, {}, {}) for end in (constraint.low, constraint.high))
    return f"{constraint.property}:{'..'.join(ends)}"


def canonical_likeness(likeness: Likeness | None) -> str:
    """Return the canonical text of a likeness."""
    if likeness is None:
        return ""
    parts = [likeness.reference, likeness.within, *(likeness.at or ())]
    return " LIKE " + " ".join("-" if part is None else canonical(part, {}, {}) for part in parts)


def described_node(node: NodePattern) -> str:
    """Return what a node of a pattern is, apart from its name and its edges."""
    entries = sorted({canonical_constraint(c) for c in node.constraints})
    return f"{node.label}{entries}{canonical_likeness(node.likeness)}"


def described_edge(edge: EdgePattern) -> str:
    """Return what an edge of a pattern is, apart from its name, its ends and its direction."""
    entries = sorted({canonical_constraint(c) for c in edge.constraints})
    return f"{sorted(edge.types)}{edge.hops}{entries}"


def edge_between(edge: EdgePattern, names: Names) -> str:
    """Return an edge with the names of its ends; how it is written does not matter."""
    return f"{ends_between(edge, names)} {described_edge(edge)}"


def ends_between(edge: EdgePattern, names: Names) -> str:
    """Return the ends of an edge by name; how it is written does not matter."""
    left, right = names.get(edge.left, edge.left), names.get(edge.right, edge.right)
    if edge.direction == "<" or (edge.direction == "-" and left > right):
        left, right = right, left
    return f"{left}{'-' if edge.direction == '-' else '>'}{right}"


def _joined(operator: str, operands: Iterable[Expression], names: Names, scope: Scope) -> str:
    return f"({f' {operator} '.join(sorted(canonical(operand, names, scope) for operand in operands))})"


def _operands(expression: Expression, operator: str) -> Iterator[Expression]:
    """Operands of a chain of one operator, however it is put in brackets."""
    if getattr(expression, "operator", None) != operator or not isinstance(expression, Logic | Arithmetic):
        yield expression
        return
    for child in children(expression):
        yield from _operands(child, operator)


def _comparison(operator: str, left: str, right: str) -> str:
    if operator in _TURNED:
        left, operator, right = right, _TURNED[operator], left
    elif operator in ("=", "<>"):
        left, right = sorted((left, right))
    return f"({left} {operator} {right})"


def _value(value: object) -> str:
    if isinstance(value, tuple):
        return f"[{','.join(sorted(map(_value, value)))}]"
    if isinstance(value, int) and not isinstance(value, bool) and float(value) == value:
        return repr(float(value))
    return repr(value)


def _details(expression: Expression) -> str:
    match expression:
        case Call(function, _, distinct):
            return f"[{function}{distinct}]"
        case IsNull(_, negated):
            return f"[{negated}]"
    return f"[{getattr(expression, 'operator', getattr(expression, 'name', ''))}]"


def _pattern(pattern: Pattern, names: Names, scope: Scope) -> str:
    """Return the least text of a pattern over the orders of its own nodes that its shape leaves open."""
    inside = scope_of(pattern, scope)
    own = [node for node in pattern.nodes if node.name not in scope]
    colours = _colours(pattern, own, names)
    groups = [[n.name for n in own if colours[n.name] == colour] for colour in sorted(set(colours.values()))]
    orders = islice(product(*(permutations(group) for group in groups)), _MOST_ORDERS)
    return min(_in_order(pattern, [n for group in order for n in group], names, inside) for order in orders)


def _colours(pattern: Pattern, own: list[NodePattern], names: Names) -> dict[str, str]:
    """Return a text for each own node that tells nodes apart by what they are and what is around them."""
    colours = {node.name: described_node(node) for node in own}
    for _ in own:
        around = {**names, **colours}
        colours = {
            name: f"{colour}{sorted(edge_between(e, around) for e in pattern.edges if name in (e.left, e.right))}"
            for name, colour in colours.items()
        }
        ranks = {colour: f"<{rank}>" for rank, colour in enumerate(sorted(set(colours.values())))}
        colours = {name: ranks[colour] for name, colour in colours.items()}
    return colours


def _in_order(pattern: Pattern, order: list[str], names: Names, scope: Scope) -> str:
    depth = sum(name.startswith("~") for name in names.values())
    called = {**names, **{name: f"~{depth + i}" for i, name in enumerate(order)}}
    nodes = sorted(f"{called.get(node.name, node.name)}:{described_node(node)}" for node in pattern.nodes)
    edges = sorted(pattern.edges, key=lambda edge: edge_between(edge, called))
    called |= {edge.name: f"~{depth + len(order) + i}" for i, edge in enumerate(edges)}
    where = "" if pattern.where is None else canonical(pattern.where, called, scope)
    return f"{nodes} {[edge_between(edge, called) for edge in edges]} {where}"
