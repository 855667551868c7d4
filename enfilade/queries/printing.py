"""From the query graph to text; parsing the text gives the same query graph."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Final

from enfilade.errors import QuestionError

from .query_graph import (
    UNNAMED,
    Column,
    Constraint,
    EdgePattern,
    Equal,
    Likeness,
    NodePattern,
    Pattern,
    QueryGraph,
    SortKey,
)
from .spelling import after_colon, quoted, text_in_quotes
from .syntax import (
    Arithmetic,
    Call,
    Comparison,
    Expression,
    IsNull,
    ListOf,
    Literal,
    Logic,
    Membership,
    Negative,
    Not,
    Parameter,
    PropertyOf,
    Scalar,
    Subquery,
    TextTest,
    Variable,
)

_ARROWS: Final = {"-": ("-", "-"), ">": ("-", "->"), "<": ("<-", "-")}
_ATOMS: Final = (Literal, Parameter, ListOf, Variable, PropertyOf, Call, Subquery)


def printed(query: QueryGraph) -> str:
    """Return a question as text, a clause a line."""
    lines = [f"MATCH {_pattern(query.pattern)}"]
    lines += [f"OPTIONAL MATCH {_pattern(pattern)}" for pattern in query.optional]
    words = ["RETURN", *["ALL"] * query.keep_all, *["DISTINCT"] * query.distinct]
    lines.append(" ".join([*words, ", ".join(map(_column, query.columns))]))
    if query.order:
        lines.append(f"ORDER BY {', '.join(map(_sort_key, query.order))}")
    tail = {"SKIP": query.skip, "LIMIT": query.limit, "PER BUILDING": query.per_building, "RELAX": query.relax}
    lines += [f"{word} {expression_text(number)}" for word, number in tail.items() if number is not None]
    return "\n".join(lines)


def expression_text(expression: Expression) -> str:
    """Return an expression as text."""
    return _PRINTERS[type(expression)](expression)


def _column(column: Column) -> str:
    text = expression_text(column.expression)
    return text if text == column.name else f"{text} AS {quoted(column.name)}"


def _sort_key(key: SortKey) -> str:
    return expression_text(key.expression) + " DESC" * key.descending


def _pattern(pattern: Pattern) -> str:
    where = "" if pattern.where is None else f" WHERE {expression_text(pattern.where)}"
    return ", ".join(_chains(pattern)) + where


def _chains(pattern: Pattern) -> Iterator[str]:
    """Comma parts; an edge that goes on where the last one ended lengthens its chain."""
    new = {node.name: node for node in pattern.nodes}
    ends = {name for edge in pattern.edges for name in (edge.left, edge.right)}
    chain, end = "", None
    for edge in pattern.edges:
        early = [name for name in _before(list(new), edge) if new[name].named or name not in ends]
        if edge.left != end or early:
            yield from [chain] if chain else []
            yield from (node_text(new.pop(name)) for name in early)
            chain = _mention(edge.left, new)
        chain += edge_text(edge) + _mention(edge.right, new)
        end = edge.right
    yield from [chain] if chain else []
    yield from map(node_text, new.values())


def _before(new: list[str], edge: EdgePattern) -> list[str]:
    """Names of nodes that must be mentioned before the edge, to keep the order of appearance."""
    left = new.index(edge.left) if edge.left in new else None
    right = new.index(edge.right) if edge.right in new else None
    if left is None or right is None:
        return new[: left or right or 0]
    return new[:left] if right < left or right == left + 1 else new[:right]


def _mention(name: str, new: dict[str, NodePattern]) -> str:
    if name not in new and name.startswith(UNNAMED):
        raise QuestionError("a node without a name has edges that are not next to each other; give it a name.")
    return node_text(new.pop(name)) if name in new else f"({quoted(name)})"


def node_text(node: NodePattern) -> str:
    """Return a node as text, in its brackets."""
    name = quoted(node.name) if node.named else ""
    label = f":{after_colon(node.label)}" if node.label else ""
    parts = [name + label, _map(node.constraints), _likeness(node.likeness)]
    return f"({' '.join(part for part in parts if part)})"


def edge_text(edge: EdgePattern) -> str:
    """Return an edge as text, without the nodes at its ends."""
    name = quoted(edge.name) if edge.named else ""
    types = ":" + "|".join(map(after_colon, edge.types))
    hops = _hops(*edge.hops) if edge.hops else ""
    entries = _map(edge.constraints)
    before, after = _ARROWS[edge.direction]
    return f"{before}[{name}{types}{hops}{' ' * bool(entries)}{entries}]{after}"


def _hops(low: int, high: int) -> str:
    return f"*{low}" if low == high else f"*{low}..{high}"


def _map(constraints: tuple[Constraint, ...]) -> str:
    return f"{{{', '.join(map(_constraint, constraints))}}}" if constraints else ""


def _constraint(constraint: Constraint) -> str:
    name = quoted(constraint.property)
    if isinstance(constraint, Equal):
        return f"{name}: {expression_text(constraint.value)}"
    low, high = ("" if end is None else expression_text(end) for end in (constraint.low, constraint.high))
    return f"{name}: {low}..{high}"


def _likeness(likeness: Likeness | None) -> str:
    if likeness is None:
        return ""
    text = f"LIKE {expression_text(likeness.reference)}"
    if likeness.within is not None:
        text += f" WITHIN {expression_text(likeness.within)}"
    if likeness.at is not None:
        low, high = map(expression_text, likeness.at)
        text += f" AT {low}" if likeness.at[0] == likeness.at[1] else f" AT {low}..{high}"
    return text


def _operand(expression: Expression) -> str:
    text = expression_text(expression)
    return text if isinstance(expression, _ATOMS) else f"({text})"


def _literal(expression: Literal) -> str:
    value = expression.value
    return f"[{', '.join(map(_scalar, value))}]" if isinstance(value, tuple) else _scalar(value)


def _scalar(value: Scalar) -> str:
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    return text_in_quotes(value) if isinstance(value, str) else repr(value)


def _call(call: Call) -> str:
    if not call.arguments:
        return f"{call.function}(*)"
    return f"{quoted(call.function)}({'DISTINCT ' * call.distinct}{', '.join(map(expression_text, call.arguments))})"


def _subquery(subquery: Subquery) -> str:
    word = "EXISTS" if subquery.kind == "exists" else subquery.kind
    return f"{word} {{ {_pattern(subquery.pattern)} }}"


def _binary(expression: Any) -> str:
    return f"{_operand(expression.left)} {expression.operator} {_operand(expression.right)}"


def _is_null(expression: IsNull) -> str:
    return f"{_operand(expression.operand)} IS {'NOT ' * expression.negated}NULL"


_PRINTERS: Final[dict[type[Expression], Callable[[Any], str]]] = {
    Literal: _literal,
    Parameter: lambda e: f"${quoted(e.name)}",
    ListOf: lambda e: f"[{', '.join(map(expression_text, e.items))}]",
    Variable: lambda e: quoted(e.name),
    PropertyOf: lambda e: f"{quoted(e.variable)}.{quoted(e.name)}",
    Negative: lambda e: f"-{_operand(e.operand)}",
    Arithmetic: _binary,
    Comparison: _binary,
    TextTest: _binary,
    Logic: lambda e: f" {e.operator} ".join(map(_operand, e.operands)),
    Not: lambda e: f"NOT {_operand(e.operand)}",
    IsNull: _is_null,
    Membership: lambda e: f"{_operand(e.item)} IN {_operand(e.container)}",
    Call: _call,
    Subquery: _subquery,
}
