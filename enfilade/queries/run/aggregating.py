"""Cypher's grouping: rows that agree in what is not aggregated become one."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any, Final

from enfilade.errors import QuestionError
from enfilade.queries.examples import Examples, number_of
from enfilade.queries.query_graph import Column
from enfilade.queries.syntax import (
    PERCENTILES,
    Call,
    Expression,
    Literal,
    PropertyOf,
    Variable,
    aggregates,
    children,
    is_aggregate,
    rebuilt,
)

from .matches import Match
from .values import plain, value_of


def check_grouping(columns: Sequence[Column]) -> None:
    """Check that what stands beside an aggregate in one column is a column of its own.

    Raises
    ------
    QuestionError
        If it is not: it would have many values in a group.
    """
    keys = {column.expression for column in columns if not aggregates(column.expression)}
    for column in columns:
        if aggregates(column.expression) and not _grouped(column.expression, keys):
            raise QuestionError(
                f'"{column.name}" mixes an aggregate with what is no column of its own; return that too.'
            )


def _grouped(expression: Expression, keys: set[Expression]) -> bool:
    if expression in keys or is_aggregate(expression):
        return True
    if isinstance(expression, Variable | PropertyOf):
        return isinstance(expression, PropertyOf) and Variable(expression.variable) in keys
    return all(_grouped(part, keys) for part in children(expression))


def grouped(
    matches: Iterable[Match], columns: Sequence[Column], examples: Examples
) -> list[tuple[tuple[Any, ...], Match]]:
    """Return one row a group and its first match, in the order in which the groups appear.

    Without a column that is not aggregated there is one group, even of no matches.
    """
    keys = [column for column in columns if not aggregates(column.expression)]
    groups: dict[Any, list[Match]] = {} if keys else {(): []}
    for match in matches:
        values = tuple(hashable(value_of(column.expression, match, examples)) for column in keys)
        groups.setdefault(values, []).append(match)
    return [
        (tuple(_column(column, group, examples) for column in columns), group[0] if group else Match({}))
        for group in groups.values()
    ]


def hashable(value: Any) -> Any:
    """Return a value as a key that equals another one when the values are the same to DISTINCT."""
    value = plain(value)
    if isinstance(value, list):
        return tuple(map(hashable, value))
    if isinstance(value, dict):
        return json.dumps(value, sort_keys=True)
    return (type(value).__name__, value) if isinstance(value, bool) else value


def _column(column: Column, group: Sequence[Match], examples: Examples) -> Any:
    expression = _with_values(column.expression, group, examples)
    return plain(value_of(expression, group[0] if group else Match({}), examples))


def _with_values(expression: Expression, group: Sequence[Match], examples: Examples) -> Expression:
    """Put in the values of the aggregates."""
    if isinstance(expression, Call) and is_aggregate(expression):
        value = _aggregate(expression, group, examples)
        return Literal(tuple(value) if isinstance(value, list) else value)
    return (
        rebuilt(expression, lambda part: _with_values(part, group, examples)) if aggregates(expression) else expression
    )


def _aggregate(call: Call, group: Sequence[Match], examples: Examples) -> Any:
    if not call.arguments:
        return sum(match.weight for match in group)
    values = [value for m in group for value in [value_of(call.arguments[0], m, examples)] * m.weight]
    present = [plain(value) for value in values if value is not None]
    if call.distinct:
        first: dict[Any, Any] = {}
        for value in present:
            first.setdefault(hashable(value), value)
        present = list(first.values())
    if call.function in PERCENTILES:
        percentile = _percentile if call.function == "percentileCont" else _percentile_of_them
        return percentile(sorted(present), number_of(call.arguments[1])) if present else None
    return _AGGREGATES[call.function](present)


def _sum(values: list[Any]) -> Any:
    return sum(values) if all(isinstance(value, int) for value in values) else math.fsum(values)


def _average(values: list[Any]) -> float | None:
    return math.fsum(values) / len(values) if values else None


def _deviation(values: list[Any], *, sample: bool = True) -> float | None:
    """Return the standard deviation of a sample, or of all there are; 0 of one value, as Neo4j has it."""
    if len(values) < 2:
        return 0.0 if values else None
    mean = math.fsum(values) / len(values)
    return math.sqrt(math.fsum((value - mean) ** 2 for value in values) / (len(values) - sample))


def _percentile(ordered: list[Any], share: float) -> float:
    """Return the value below which a share of the values lies, interpolated."""
    place = share * (len(ordered) - 1)
    low = math.floor(place)
    high = min(low + 1, len(ordered) - 1)
    return float(ordered[low] + (ordered[high] - ordered[low]) * (place - low))


def _percentile_of_them(ordered: list[Any], share: float) -> Any:
    """Return the first of the values that a share of them is not above."""
    return ordered[max(math.ceil(share * len(ordered)), 1) - 1]


_AGGREGATES: Final[dict[str, Callable[[list[Any]], Any]]] = {
    "count": len,
    "sum": _sum,
    "avg": _average,
    "min": lambda values: min(values, default=None),
    "max": lambda values: max(values, default=None),
    "collect": list,
    "stDev": _deviation,
    "stDevP": partial(_deviation, sample=False),
}
