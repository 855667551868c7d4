"""Values for the parameters of a question; what remains is a question of literals."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, NoReturn

import numpy as np

from enfilade.errors import QuestionError
from enfilade.schema.names import hint

from .query_graph import Likeness, Pattern, QueryGraph
from .rewriting import pattern_with, with_expressions
from .syntax import Call, Expression, ListOf, Literal, Parameter, Place, Scalar, Subquery, Variable, rebuilt, walk

_LARGEST_INTEGER = 2**63 - 1


def bind(query: QueryGraph, parameters: Mapping[str, Any], likenesses: Mapping[str, Any]) -> QueryGraph:
    """Put in the values of all parameters, except what LIKE refers to.

    Parameters
    ----------
    query
        A question, resolved.
    parameters
        Values: None, a truth value, number, text, or a list of these.
    likenesses
        Names of examples that LIKE may refer to.

    Raises
    ------
    QuestionError
        If a parameter is missing or its value is none of these.
    """
    return _Binder(query.text, parameters, likenesses).question(query)


class _Binder:
    def __init__(self, text: str | None, parameters: Mapping[str, Any], likenesses: Mapping[str, Any]) -> None:
        self._text = text
        self._parameters = parameters
        self._likenesses = likenesses

    def question(self, query: QueryGraph) -> QueryGraph:
        for pattern in (query.pattern, *query.optional):
            self._check_references(pattern)
        return with_expressions(query, self._bound)

    def _bound(self, expression: Expression) -> Expression:
        if isinstance(expression, Parameter):
            return self._literal(expression)
        if isinstance(expression, Literal):
            return replace(expression, value=self._plain(expression.value, expression.place))
        if isinstance(expression, Subquery):
            self._check_references(expression.pattern)
            return replace(expression, pattern=pattern_with(expression.pattern, self._bound))
        if isinstance(expression, Call) and expression.function == "like":
            self._check_reference(expression.arguments[1])
            return replace(expression, arguments=(expression.arguments[0], self._reference(expression.arguments[1])))
        expression = rebuilt(expression, self._bound)
        if isinstance(expression, ListOf) and all(_is_scalar(item) for item in expression.items):
            return Literal(tuple(_scalar_value(item) for item in expression.items), place=expression.place)
        return expression

    def _reference(self, reference: Expression) -> Expression:
        return rebuilt(reference, self._bound) if isinstance(reference, Call) else reference

    def _literal(self, parameter: Parameter) -> Literal:
        if parameter.name not in self._parameters:
            self._missing(parameter, self._parameters)
        return Literal(self._plain(self._parameters[parameter.name], parameter.place), place=parameter.place)

    def _missing(self, parameter: Parameter, known: Mapping[str, Any]) -> NoReturn:
        names = [f"${name}" for name in known]
        advice = hint(f"${parameter.name}", names) if names else "none is given"
        self._fail(f"the parameter ${parameter.name} has no value: {advice}.", parameter.place)

    def _plain(self, value: Any, place: Place | None) -> Scalar | tuple[Scalar, ...]:
        if isinstance(value, np.ndarray | np.generic):
            value = value.tolist()
        if isinstance(value, list | tuple):
            return tuple(self._scalar(item, place) for item in value)
        return self._scalar(value, place)

    def _scalar(self, value: Any, place: Place | None) -> Scalar:
        if value is None or isinstance(value, bool):
            return value
        if isinstance(value, int):
            return value if abs(value) <= _LARGEST_INTEGER else self._finite(value, place)
        if isinstance(value, float):
            return self._finite(value, place)
        if not isinstance(value, str):
            self._fail(f"a {type(value).__name__} cannot stand in a question; give a number, a text or a list.", place)
        if any(0xD800 <= ord(letter) <= 0xDFFF for letter in value):
            self._fail("a text holds half a character (a lone surrogate); give whole characters.", place)
        return value

    def _finite(self, value: float, place: Place | None) -> float:
        if isinstance(value, int) or not math.isfinite(value):
            self._fail("a number is too large, or is none; give a finite one.", place)
        return value

    def _check_references(self, pattern: Pattern) -> None:
        for node in pattern.nodes:
            if isinstance(node.likeness, Likeness):
                self._check_reference(node.likeness.reference)

    def _check_reference(self, reference: Expression) -> None:
        known = {**self._parameters, **self._likenesses}
        for part in walk(reference):
            if isinstance(part, Parameter) and part.name not in known:
                self._missing(part, known)

    def _fail(self, message: str, place: Place | None) -> NoReturn:
        message = message.replace("?.", "?")
        if place is None:
            raise QuestionError(message)
        raise QuestionError(message, text=self._text, line=place.line, column=place.column)


def free_variables(expression: Expression) -> Iterator[str]:
    """Names that an expression mentions, those in the patterns of its subqueries included."""
    for part in walk(expression):
        if isinstance(part, Variable):
            yield part.name
        elif isinstance(part, Subquery):
            yield from pattern_variables(part.pattern)
        elif hasattr(part, "variable"):
            yield part.variable


def pattern_variables(pattern: Pattern) -> Iterator[str]:
    """Names that a pattern mentions anywhere, its own and those from outside."""
    yield from (node.name for node in pattern.nodes)
    yield from (edge.name for edge in pattern.edges)
    if pattern.where is not None:
        yield from free_variables(pattern.where)


def _is_scalar(expression: Expression) -> bool:
    return isinstance(expression, Literal) and not isinstance(expression.value, tuple)


def _scalar_value(expression: Expression) -> Scalar:
    assert isinstance(expression, Literal)
    assert not isinstance(expression.value, tuple)
    return expression.value
