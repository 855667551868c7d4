"""Expressions of the question language, as small frozen dataclasses.

Two expressions are equal when they say the same; where they stand in the text does not count.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any, Final, TypeVar

if TYPE_CHECKING:
    from .query_graph import Pattern

Scalar = None | bool | int | float | str

AGGREGATES: Final = (
    *("count", "avg", "min", "max", "sum", "collect"),
    *("stDev", "stDevP", "percentileCont", "percentileDisc"),
)
"""Functions that fold many matches into one value, as the language spells them."""

PERCENTILES: Final = ("percentileCont", "percentileDisc")
"""Those that take a share beside a value."""

SCORES: Final = ("score", "mean_score")
"""Names that stand for a match's likeness."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where something stands in the text: line and column, counted from 1, and its first and last offset."""

    line: int
    column: int
    start: int | None = None
    end: int | None = None


@dataclass(frozen=True)
class Expression:
    """Base of all expressions; `place` is for error messages only."""

    place: Place | None = field(default=None, compare=False, repr=False, kw_only=True)


@dataclass(frozen=True)
class Literal(Expression):
    """A number, text, true, false, null, or (from a parameter only) a list of these."""

    value: Scalar | tuple[Scalar, ...]


@dataclass(frozen=True)
class Parameter(Expression):
    """``$name``."""

    name: str


@dataclass(frozen=True)
class ListOf(Expression):
    """``[1, 2, $x]``."""

    items: tuple[Expression, ...]


@dataclass(frozen=True)
class Variable(Expression):
    """A node or edge of the pattern, or `score` and `mean_score`."""

    name: str


@dataclass(frozen=True)
class PropertyOf(Expression):
    """``a.area``."""

    variable: str
    name: str


@dataclass(frozen=True)
class Negative(Expression):
    """``-x``."""

    operand: Expression


@dataclass(frozen=True)
class Arithmetic(Expression):
    """``x + y`` and its like; `operator` is one of ``+ - * / % ^``."""

    operator: str
    left: Expression
    right: Expression


@dataclass(frozen=True)
class Comparison(Expression):
    """`operator` is one of ``= <> < <= > >=``."""

    operator: str
    left: Expression
    right: Expression


@dataclass(frozen=True)
class Logic(Expression):
    """Two or more conditions joined by ``AND``, ``OR`` or ``XOR``."""

    operator: str
    operands: tuple[Expression, ...]


@dataclass(frozen=True)
class Not(Expression):
    """``NOT x``."""

    operand: Expression


@dataclass(frozen=True)
class IsNull(Expression):
    """``x IS NULL``, or ``x IS NOT NULL`` where `negated`."""

    operand: Expression
    negated: bool


@dataclass(frozen=True)
class Membership(Expression):
    """``x IN list``."""

    item: Expression
    container: Expression


@dataclass(frozen=True)
class TextTest(Expression):
    """`operator` is ``STARTS WITH``, ``ENDS WITH`` or ``CONTAINS``."""

    operator: str
    left: Expression
    right: Expression


@dataclass(frozen=True)
class Call(Expression):
    """A function of the language; ``count(*)`` is a call without arguments."""

    function: str
    arguments: tuple[Expression, ...]
    distinct: bool = False


@dataclass(frozen=True)
class Subquery(Expression):
    """``EXISTS { pattern }`` or ``count { pattern }``; `kind` is ``exists`` or ``count``."""

    kind: str
    pattern: Pattern


AnyExpression = TypeVar("AnyExpression", bound=Expression)


def children(expression: Expression) -> Iterator[Expression]:
    """Expressions directly inside another one; those of a subquery's pattern are not among them."""
    for spot in fields(expression):
        value = getattr(expression, spot.name)
        if isinstance(value, Expression):
            yield value
        elif isinstance(value, tuple):
            yield from (item for item in value if isinstance(item, Expression))


def walk(expression: Expression) -> Iterator[Expression]:
    """Return an expression and everything inside it, but not what is inside a subquery's pattern."""
    yield expression
    for child in children(expression):
        yield from walk(child)


def rebuilt(expression: AnyExpression, change: Callable[[Expression], Expression]) -> AnyExpression:
    """Return the same expression with `change` applied to each of its direct children."""
    changed: dict[str, Any] = {}
    for spot in fields(expression):
        value = getattr(expression, spot.name)
        if isinstance(value, Expression):
            changed[spot.name] = change(value)
        elif isinstance(value, tuple) and any(isinstance(item, Expression) for item in value):
            changed[spot.name] = tuple(change(item) for item in value)
    return replace(expression, **changed) if changed else expression


def conjuncts(expression: Expression | None) -> tuple[Expression, ...]:
    """Conditions that must all hold for the expression to hold."""
    if expression is None:
        return ()
    if isinstance(expression, Logic) and expression.operator == "AND":
        return tuple(part for operand in expression.operands for part in conjuncts(operand))
    return (expression,)


def is_aggregate(expression: Expression) -> bool:
    """Whether the expression is a call of an aggregating function."""
    return isinstance(expression, Call) and expression.function in AGGREGATES


def aggregates(expression: Expression) -> bool:
    """Whether an aggregating function is called anywhere in the expression."""
    return any(map(is_aggregate, walk(expression)))
