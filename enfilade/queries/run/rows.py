"""From matches to the rows of the answer: values, DISTINCT, order, SKIP and LIMIT."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from enfilade.errors import UnsupportedError
from enfilade.queries.examples import Examples
from enfilade.queries.query_graph import QueryGraph
from enfilade.queries.syntax import Expression, Literal, Variable, aggregates, rebuilt

from .aggregating import check_grouping, grouped, hashable
from .matches import Match
from .pruning import ids_key
from .values import plain, value_of


@dataclass(slots=True)
class Row:
    """A row of the answer, what it is ordered by, and the match whose building and unmet conditions it has, if any."""

    values: tuple[Any, ...]
    key: tuple[Any, ...]
    match: Match | None


def ranked(matches: list[Match], named: Sequence[str], rest: Sequence[str]) -> list[Match]:
    """Order matches: full ones by score, best first, then near misses; ties by ids, those of the named nodes first."""
    order = [*named, *rest]
    return sorted(matches, key=lambda match: (match.rank, ids_key(match, order)))


def check_rows(query: QueryGraph) -> None:
    """Check what can be said of the rows before there are any.

    Raises
    ------
    QuestionError
        If a column mixes an aggregate with what is not grouped.
    UnsupportedError
        If rows are limited by building, but are of none, or are of near misses that could not be told apart.
    """
    check_grouping(query.columns)
    if query.relax is not None and is_aggregated(query):
        raise UnsupportedError("RELAX does not go with aggregates, which would count near misses as matches.")
    if query.relax is not None and query.optional:
        raise UnsupportedError("RELAX does not go with OPTIONAL MATCH; put what may be missing into MATCH.")
    if query.per_building is not None and is_aggregated(query):
        raise UnsupportedError(
            "PER BUILDING does not go with aggregates, whose rows are of no one building; use LIMIT."
        )


def rows_of(query: QueryGraph, matches: Iterable[Match], named: Sequence[str], examples: Examples) -> list[Row]:
    """Return the rows of the answer.

    Parameters
    ----------
    query
        Resolved and bound.
    matches
        As `ranked` gives them.
    named
        Names of the named nodes, by which ties are broken.
    examples
        What like() refers to.
    """
    if is_aggregated(query):
        groups = grouped(matches, query.columns, examples)
        rows = [Row(values, _key_of_values(query, values, match, examples), None) for values, match in groups]
    else:
        rows = [_row(query, match, named, examples) for match in matches]
        if query.distinct:
            rows = _distinct(rows)
    rows.sort(key=lambda row: row.key)
    kept = _per_building(rows, number_of_rows(query.per_building))
    start, count = number_of_rows(query.skip) or 0, number_of_rows(query.limit)
    return kept[start : None if count is None else start + count]


def is_aggregated(query: QueryGraph) -> bool:
    """Whether a column has an aggregate."""
    return any(aggregates(column.expression) for column in query.columns)


def _row(query: QueryGraph, match: Match, named: Sequence[str], examples: Examples) -> Row:
    values = tuple(plain(value_of(column.expression, match, examples)) for column in query.columns)
    if query.distinct:
        return Row(values, (match.miss, _key_of_values(query, values, match, examples)), match)
    asked = [_directed(value_of(k.expression, match, examples), k.descending) for k in query.order]
    score = () if query.order else (-match.score,)
    return Row(values, (match.miss, *asked, *score, ids_key(match, named), *map(sortable, values)), match)


def _distinct(rows: Iterable[Row]) -> list[Row]:
    found: dict[Any, Row] = {}
    for row in rows:
        found.setdefault(hashable(list(row.values)), row)
    return list(found.values())


def _key_of_values(query: QueryGraph, values: tuple[Any, ...], match: Match, examples: Examples) -> tuple[Any, ...]:
    """Return what a row of many matches sorts by: ORDER BY, the score, then column by column.

    `match` is one of them; what ORDER BY may take is the same in all.
    """
    by_expression = {c.expression: value for c, value in zip(query.columns, values, strict=True)}
    asked = [
        _directed(value_of(_with_columns(k.expression, by_expression), match, examples), k.descending)
        for k in query.order
    ]
    scores = [_directed(by_expression[score], True) for score in (Variable("score"),) if score in by_expression]
    return (*asked, *scores, *map(sortable, values))


def _with_columns(expression: Expression, values: dict[Expression, Any]) -> Expression:
    """Put in the values of columns that are more than a name."""
    if expression in values and not isinstance(expression, Variable):
        value = values[expression]
        return Literal(tuple(value) if isinstance(value, list) else value)
    return rebuilt(expression, lambda part: _with_columns(part, values))


def _directed(value: Any, descending: bool) -> Any:
    missing, *key = sortable(value)
    return missing, (_Reversed(key) if descending else key)


def sortable(value: Any) -> tuple[bool, int, Any]:
    """Return what a value sorts by: missing ones last, numbers apart from texts, not-a-number behind all numbers."""
    value = plain(value)
    if value is None:
        return True, 0, 0
    if isinstance(value, list):
        return False, 3, [sortable(item) for item in value]
    if isinstance(value, dict):
        return False, 4, json.dumps(value, sort_keys=True)
    if isinstance(value, str):
        return False, 0, value
    if isinstance(value, bool):
        return False, 1, value
    return False, 2, (math.isnan(value), 0 if math.isnan(value) else value)


class _Reversed:
    """Sorts the other way round."""

    __slots__ = ("_key",)

    def __init__(self, key: Any) -> None:
        self._key = key

    def __lt__(self, other: _Reversed) -> bool:
        return bool(other._key < self._key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Reversed) and bool(self._key == other._key)

    __hash__ = None  # type: ignore[assignment]


def _per_building(rows: list[Row], count: int | None) -> list[Row]:
    if count is None:
        return rows
    seen: dict[str | None, int] = {}
    kept = []
    for row in rows:
        building = None if row.match is None else row.match.building
        seen[building] = seen.get(building, 0) + 1
        if seen[building] <= count:
            kept.append(row)
    return kept


def number_of_rows(expression: Expression | None) -> int | None:
    """Return the number behind LIMIT and its like, or None where there is none."""
    if expression is None:
        return None
    assert isinstance(expression, Literal)
    assert isinstance(expression.value, int)
    return expression.value
