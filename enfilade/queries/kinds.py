"""What kind of value each expression has, and whether the question uses it rightly.

Runs on a bound question: all values are known. Comparing a text with a number is an error here, not a match that
silently never comes.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, NoReturn

from enfilade.errors import QuestionError
from enfilade.schema.definition import Kind, Property

from .query_graph import Between, Constraint, Equal, Likeness, Pattern, QueryGraph
from .syntax import (
    PERCENTILES,
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
    Place,
    PropertyOf,
    Subquery,
    TextTest,
    Variable,
    children,
)
from .vocabulary import Meaning, edge_meaning, shared_properties

Scope = Mapping[str, Meaning]

TEXT, NUMBER, TRUTH, LIST, NODE, EDGE, UNKNOWN = "text", "number", "truth value", "list", "node", "edge", "unknown"

MOST_UNMET: Final = 3
"""Conditions that a near miss may leave unmet at most."""

_SCALARS: Final = (TEXT, NUMBER, TRUTH)
_NUMERIC_AGGREGATES: Final = ("avg", "sum", "stDev", "stDevP", *PERCENTILES)


def check_kinds(query: QueryGraph) -> None:
    """Check that a bound question compares like with like.

    Raises
    ------
    QuestionError
        Where text is compared with a number, a range is reversed, a condition is no truth value, and the like.
    """
    _Checker(query.text).question(query)


def scope_of(pattern: Pattern, outer: Scope) -> dict[str, Meaning]:
    """Return what the names mean inside a resolved pattern."""
    edges = {edge.name: edge_meaning(edge.types) for edge in pattern.edges if edge.named}
    return {**outer, **edges, **{node.name: Meaning(node.label) for node in pattern.nodes}}


def whole_scope(query: QueryGraph) -> dict[str, Meaning]:
    """Return what the names mean in RETURN."""
    scope: dict[str, Meaning] = {}
    for pattern in (query.pattern, *query.optional):
        scope = scope_of(pattern, scope)
    return scope


def kind_of(expression: Expression, scope: Scope) -> str:
    """Return the kind of an expression's value; null and what only a row knows are unknown."""
    match expression:
        case Literal(value):
            return _kind_of_value(value)
        case PropertyOf(variable, name):
            return _kind_of_property(scope[variable].properties()[name])
        case Variable(name) if name in scope:
            return NODE if scope[name].is_node else EDGE
        case Variable(name):
            return NUMBER
        case ListOf():
            return LIST
        case Comparison() | Logic() | Not() | IsNull() | Membership() | TextTest():
            return TRUTH
        case Negative():
            return NUMBER
        case Arithmetic(operator, left, right):
            kinds = {kind_of(left, scope), kind_of(right, scope)}
            return TEXT if operator == "+" and TEXT in kinds else UNKNOWN if UNKNOWN in kinds else NUMBER
        case Subquery(kind):
            return TRUTH if kind == "exists" else NUMBER
        case Call(function, arguments):
            return _kind_of_call(function, arguments, scope)
    return UNKNOWN


def _kind_of_call(function: str, arguments: tuple[Expression, ...], scope: Scope) -> str:
    if function == "collect":
        return LIST
    return kind_of(arguments[0], scope) if function in ("min", "max") else NUMBER


def _kind_of_value(value: object) -> str:
    if isinstance(value, bool):
        return TRUTH
    if isinstance(value, int | float):
        return NUMBER
    return TEXT if isinstance(value, str) else LIST if isinstance(value, tuple) else UNKNOWN


def _kind_of_property(property: Property) -> str:
    if property.kind is Kind.TEXT:
        return TEXT
    return NUMBER if property.kind.numeric else LIST


class _Checker:
    def __init__(self, text: str | None) -> None:
        self._text = text

    def question(self, query: QueryGraph) -> None:
        scope: Scope = {}
        for pattern in (query.pattern, *query.optional):
            scope = self._pattern(pattern, scope)
        for expression in (*(c.expression for c in query.columns), *(k.expression for k in query.order)):
            self._expression(expression, scope)
        for word, number in (("SKIP", query.skip), ("LIMIT", query.limit), ("PER BUILDING", query.per_building)):
            if number is not None:
                self._check_number_of_rows(word, number)
        if query.relax is not None:
            self._check_relax(query.relax)

    def _check_number_of_rows(self, word: str, number: Expression) -> None:
        value = getattr(number, "value", None)
        if isinstance(value, bool) or not isinstance(value, int) or value < 0:
            self._fail(f"{word} takes a whole number from 0, not {_shown(value)}.", number.place)

    def _check_relax(self, number: Expression) -> None:
        value = getattr(number, "value", None)
        if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= MOST_UNMET:
            self._fail(f"RELAX takes a whole number from 1 to {MOST_UNMET}, not {_shown(value)}.", number.place)

    def _pattern(self, pattern: Pattern, outer: Scope) -> Scope:
        scope = scope_of(pattern, outer)
        for node in pattern.nodes:
            for constraint in node.constraints:
                self._constraint(constraint, scope[node.name].properties()[constraint.property])
            if node.likeness is not None:
                self._likeness(node.likeness)
        for edge in pattern.edges:
            known = shared_properties(edge.types)
            for constraint in edge.constraints:
                self._constraint(constraint, known[constraint.property])
        if pattern.where is not None:
            self._condition(pattern.where, scope)
        return scope

    def _constraint(self, constraint: Constraint, property: Property) -> None:
        if not property.kind.scalar:
            advice = f"; write 'x' IN a.{property.name} in WHERE" if property.kind is Kind.TEXTS else ""
            self._fail(
                f"{property.name} is a {property.kind.value} and cannot stand in a map{advice}.", constraint.place
            )
        if isinstance(constraint, Between):
            self._between(constraint, property)
        elif isinstance(constraint, Equal):
            self._alike(_kind_of_property(property), kind_of(constraint.value, {}), constraint.place)

    def _between(self, constraint: Between, property: Property) -> None:
        if not property.kind.numeric:
            self._fail(f"{property.name} is text; a range is for numbers.", constraint.place)
        if constraint.low is None and constraint.high is None:
            self._fail(f"the range of {property.name} has no end; give it one, or leave it out.", constraint.place)
        ends = [self._number(end, "the end of a range") for end in (constraint.low, constraint.high) if end is not None]
        if len(ends) == 2 and ends[0] > ends[1]:
            self._fail(
                f"the range {ends[0]:g}..{ends[1]:g} is reversed; write {ends[1]:g}..{ends[0]:g}.", constraint.place
            )

    def _likeness(self, likeness: Likeness) -> None:
        if likeness.within is not None and self._number(likeness.within, "WITHIN") < 0:
            self._fail("WITHIN takes a distance from 0 to 2.", likeness.within.place)
        if likeness.at is not None:
            low, high = (self._number(end, "AT") for end in likeness.at)
            if low > high:
                self._fail(f"the range {low:g}..{high:g} is reversed; write {high:g}..{low:g}.", likeness.place)

    def _number(self, expression: Expression, what: str) -> float:
        value = getattr(expression, "value", None)
        if isinstance(value, bool) or not isinstance(value, int | float):
            self._fail(f"{what} is a number, not {_shown(value)}.", expression.place)
        return value

    def _condition(self, expression: Expression, scope: Scope) -> None:
        kind = kind_of(expression, scope)
        if kind not in (TRUTH, UNKNOWN):
            self._fail(
                f"a condition is true or false, and this is a {kind}; compare it with something.", expression.place
            )
        self._expression(expression, scope)

    def _expression(self, expression: Expression, scope: Scope) -> None:
        match expression:
            case Comparison(operator, left, right):
                self._comparison(operator, kind_of(left, scope), kind_of(right, scope), expression.place)
            case Logic() | Not():
                for operand in children(expression):
                    self._condition(operand, scope)
                return
            case TextTest(operator, left, right):
                self._expect((TEXT,), (left, right), operator, scope)
            case Arithmetic(operator, left, right):
                allowed = (TEXT, NUMBER) if operator == "+" else (NUMBER,)
                self._expect(allowed, (left, right), operator, scope)
            case Negative(operand):
                self._expect((NUMBER,), (operand,), "-", scope)
            case Membership(item, container):
                self._membership(item, container, scope)
            case Call(function, arguments):
                self._call(function, arguments, scope)
            case Subquery(_, pattern):
                self._pattern(pattern, scope)
        for child in children(expression):
            self._expression(child, scope)

    def _comparison(self, operator: str, left: str, right: str, place: Place | None) -> None:
        self._alike(left, right, place)
        kinds = {left, right} - {UNKNOWN}
        allowed = (*_SCALARS, NODE) if operator in ("=", "<>") else (TEXT, NUMBER)
        wrong = next((kind for kind in kinds if kind not in allowed), None)
        if wrong is not None:
            self._fail(f"a {wrong} cannot be compared by {operator}.", place)

    def _alike(self, left: str, right: str, place: Place | None) -> None:
        if UNKNOWN not in (left, right) and left != right:
            self._fail(f"a {left} is compared with a {right}, which never match; give a {left}.", place)

    def _expect(self, kinds: tuple[str, ...], operands: tuple[Expression, ...], what: str, scope: Scope) -> None:
        for operand in operands:
            kind = kind_of(operand, scope)
            if kind not in (*kinds, UNKNOWN):
                self._fail(f"{what} takes a {' or a '.join(kinds)}, not a {kind}.", operand.place)

    def _membership(self, item: Expression, container: Expression, scope: Scope) -> None:
        self._expect((LIST,), (container,), "IN", scope)
        kind = kind_of(item, scope)
        for element in _elements(container, scope):
            self._alike(kind, element, item.place)

    def _call(self, function: str, arguments: tuple[Expression, ...], scope: Scope) -> None:
        if function in _NUMERIC_AGGREGATES:
            self._expect((NUMBER,), arguments[:1], function, scope)
        if function in ("min", "max"):
            self._expect((TEXT, NUMBER), arguments, function, scope)
        if function in PERCENTILES and not 0 <= self._number(arguments[1], "the percentile") <= 1:
            self._fail("the percentile is a number from 0 to 1.", arguments[1].place)
        if function == "collect" and kind_of(arguments[0], scope) == EDGE:
            self._fail("an edge cannot be collected; collect its properties.", arguments[0].place)

    def _fail(self, message: str, place: Place | None) -> NoReturn:
        if place is None:
            raise QuestionError(message)
        raise QuestionError(message, text=self._text, line=place.line, column=place.column)


def _elements(container: Expression, scope: Scope) -> set[str]:
    """Kinds of the elements of a list, as far as they are known."""
    match container:
        case Literal(value) if isinstance(value, tuple):
            return {_kind_of_value(item) for item in value}
        case ListOf(items):
            return {kind_of(item, scope) for item in items}
        case PropertyOf(variable, name):
            kind = scope[variable].properties()[name].kind
            return {TEXT} if kind is Kind.TEXTS else {NUMBER} if kind in (Kind.REALS, Kind.INTEGERS) else set()
    return set()


def _shown(value: object) -> str:
    return "an expression" if value is None else repr(value)
