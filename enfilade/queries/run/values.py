"""Values of expressions in a match, in Cypher's three-valued logic: None is unknown."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Final

from enfilade.errors import QuestionError
from enfilade.queries.examples import Examples
from enfilade.queries.query_graph import Likeness
from enfilade.queries.syntax import (
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
    PropertyOf,
    Subquery,
    TextTest,
    Variable,
    walk,
)

from .matches import Element, Match


def value_of(expression: Expression, match: Match, examples: Examples) -> Any:
    """Return the value of an expression; what is missing or unknown is None.

    Raises
    ------
    QuestionError
        If a whole number is divided by zero.
    """
    return _VALUES[type(expression)](expression, match, examples)


def measure_likeness(expression: Expression, matches: Sequence[Match], examples: Examples) -> None:
    """Measure at once what like() in an expression will ask of the matches one by one."""
    for part in walk(expression):
        match part:
            case Call("like", (Variable(name), reference)) if matches:
                ids = (id for match in matches if (id := match.id_of(name)) is not None)
                examples.ranking(Likeness(reference)).measure(ids)


def plain(value: Any) -> Any:
    """Return a value as it stands in a row: a node as its id."""
    if isinstance(value, list):
        return [plain(item) for item in value]
    return value.id if isinstance(value, Element) else value


def _variable(expression: Variable, match: Match, examples: Examples) -> Any:
    if expression.name in match.elements:
        return match.elements[expression.name]
    return match.score if expression.name == "score" else match.mean_score


def _property(expression: PropertyOf, match: Match, examples: Examples) -> Any:
    element = match.elements[expression.variable]
    return None if element is None else element.properties.get(expression.name)


def _comparison(expression: Comparison, match: Match, examples: Examples) -> bool | None:
    left = value_of(expression.left, match, examples)
    right = value_of(expression.right, match, examples)
    return compared(expression.operator, left, right)


def compared(operator: str, left: Any, right: Any) -> bool | None:
    """Compare two values; those of different kinds are not equal, and neither is the smaller."""
    if left is None or right is None:
        return None
    left, right = plain(left), plain(right)
    if _kind(left) is not _kind(right):
        return {"=": False, "<>": True}.get(operator)
    return bool(_COMPARISONS[operator](left, right))


def _kind(value: Any) -> type:
    return float if isinstance(value, int | float) and not isinstance(value, bool) else type(value)


def _logic(expression: Logic, match: Match, examples: Examples) -> bool | None:
    values = [value_of(operand, match, examples) for operand in expression.operands]
    if expression.operator == "XOR":
        return None if None in values else sum(values) % 2 == 1
    decisive = expression.operator == "OR"
    if decisive in values:
        return decisive
    return None if None in values else not decisive


def _not(expression: Not, match: Match, examples: Examples) -> bool | None:
    value = value_of(expression.operand, match, examples)
    return None if value is None else not value


def _is_null(expression: IsNull, match: Match, examples: Examples) -> bool:
    return (value_of(expression.operand, match, examples) is None) is not expression.negated


def _membership(expression: Membership, match: Match, examples: Examples) -> bool | None:
    container = value_of(expression.container, match, examples)
    if container is None:
        return None
    item = value_of(expression.item, match, examples)
    return _any(compared("=", item, element) for element in container)


def _any(values: Iterable[bool | None]) -> bool | None:
    found = set(values)
    return True if True in found else None if None in found else False


def _text_test(expression: TextTest, match: Match, examples: Examples) -> bool | None:
    left = value_of(expression.left, match, examples)
    right = value_of(expression.right, match, examples)
    if not isinstance(left, str) or not isinstance(right, str):
        return None
    return _TEXT_TESTS[expression.operator](left, right)


def _negative(expression: Negative, match: Match, examples: Examples) -> Any:
    value = value_of(expression.operand, match, examples)
    return None if value is None else -value


def _arithmetic(expression: Arithmetic, match: Match, examples: Examples) -> Any:
    left = value_of(expression.left, match, examples)
    right = value_of(expression.right, match, examples)
    if left is None or right is None:
        return None
    try:
        return _ARITHMETIC[expression.operator](left, right)
    except ZeroDivisionError:
        raise QuestionError(f"a whole number is divided by zero in {expression.operator}; rule 0 out first.") from None
    except OverflowError:
        return math.inf


def _add(left: Any, right: Any) -> Any:
    if isinstance(left, str) or isinstance(right, str):
        return f"{left}{right}"
    return left + right


def _divide(left: float, right: float) -> float:
    if isinstance(left, int) and isinstance(right, int):
        quotient = abs(left) // abs(right)
        return quotient if (left < 0) == (right < 0) else -quotient
    if right == 0:
        return math.nan if left == 0 else math.copysign(math.inf, left) * math.copysign(1.0, right)
    return left / right


def _modulo(left: float, right: float) -> float:
    if isinstance(left, int) and isinstance(right, int):
        rest = abs(left) % abs(right)
        return -rest if left < 0 else rest
    return math.nan if right == 0 else math.fmod(left, right)


def _raise_to(left: float, right: float) -> float:
    if left == 0 and right < 0:
        return math.inf
    power = float(left) ** float(right)
    return math.nan if isinstance(power, complex) else power


def _call(expression: Call, match: Match, examples: Examples) -> Any:
    subject, reference = expression.arguments
    element = value_of(subject, match, examples)
    return None if element is None else examples.ranking(Likeness(reference)).distance(element.id)


_COMPARISONS: Final[dict[str, Callable[[Any, Any], bool]]] = {
    "=": lambda a, b: a == b,
    "<>": lambda a, b: a != b,
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
}
_TEXT_TESTS: Final[dict[str, Callable[[str, str], bool]]] = {
    "STARTS WITH": str.startswith,
    "ENDS WITH": str.endswith,
    "CONTAINS": str.__contains__,
}
_ARITHMETIC: Final[dict[str, Callable[[Any, Any], Any]]] = {
    "+": _add,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": _divide,
    "%": _modulo,
    "^": _raise_to,
}
_VALUES: Final[dict[type[Expression], Callable[[Any, Match, Examples], Any]]] = {
    Literal: lambda e, match, examples: list(e.value) if isinstance(e.value, tuple) else e.value,
    ListOf: lambda e, match, examples: [value_of(item, match, examples) for item in e.items],
    Variable: _variable,
    PropertyOf: _property,
    Comparison: _comparison,
    Logic: _logic,
    Not: _not,
    IsNull: _is_null,
    Membership: _membership,
    TextTest: _text_test,
    Negative: _negative,
    Arithmetic: _arithmetic,
    Call: _call,
    Subquery: lambda e, match, examples: match.answers[id(e)],
}
