"""A question and a store in, ranked rows out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Final

from enfilade.errors import QuestionError
from enfilade.stores.base import Store
from enfilade.stores.deadline import Deadline

from .binding import bind
from .checks import resolve
from .examples import Examples
from .expansion import combining_objects
from .explanation import Explanation
from .kinds import Scope, check_kinds, scope_of, whole_scope
from .parse import NESTED, parse
from .query_graph import Pattern, QueryGraph
from .relaxation import condition_texts
from .result import UNMET, Result, Unmet
from .run.best_objects import BestObjects, surely_best
from .run.matches import Match
from .run.matching import Ids, Matcher
from .run.near import NearMisses
from .run.needs import needed_properties
from .run.pruning import is_apart, likened_nodes, one_of_each, scored, uses_segments_once, without_overlap
from .run.rows import Row, check_rows, number_of_rows, ranked, rows_of
from .run.shortcuts import is_anchored, rows_needed
from .run.tallies import wanted_values
from .run.values import measure_likeness
from .sayable import is_mixed
from .symmetry import Symmetry, order_of_appearance, question_symmetries, smaller_first
from .syntax import Subquery, walk

MOST_ROWS: Final = 1_000_000
"""Rows that are returned at most, if nothing else is said."""


def answer(
    store: Store,
    question: str | QueryGraph,
    *,
    parameters: Mapping[str, Any] | None = None,
    likenesses: Mapping[str, Any] | None = None,
    timeout_s: float | None = 60.0,
    most_rows: int | None = MOST_ROWS,
    explain_only: bool = False,
) -> Result:
    """Answer a question.

    Parameters
    ----------
    store
        Where to look.
    question
        Text, or a query graph.
    parameters
        Values of ``$names``: None, truth values, numbers, texts, lists of these.
    likenesses
        Examples that LIKE names as parameters: a mesh or cloud file, ``object:ID``, or a shape.
    timeout_s
        Seconds after which to give up; None for never.
    most_rows
        Rows that are returned at most; the result says how many were left out. None for all.
    explain_only
        Whether only to say what would be asked of the store.

    Raises
    ------
    QuestionError
        If the question cannot be understood.
    NotFoundError, InputError
        If an example is missing or cannot be read.
    StoreError
        If the store fails, or the time is over.
    """
    given = {**(parameters or {}), **(likenesses or {})}
    try:
        asked = parse(question) if isinstance(question, str) else question
        query = _understood(asked, parameters or {}, given)
    except RecursionError:
        raise QuestionError(NESTED) from None
    deadline = Deadline(timeout_s)
    examples = Examples(store, given, deadline.check)
    answering = _Answering(store, query, examples, deadline, run=not explain_only)
    rows = answering.rows()
    answering.explanation.tell_likeness(examples)
    kept = rows[:most_rows]
    result = _result(query, kept, condition_texts(asked.pattern, asked.text), answering.explanation)
    return replace(result, left_out=len(rows) - len(kept))


def _understood(query: QueryGraph, parameters: Mapping[str, Any], given: Mapping[str, Any]) -> QueryGraph:
    """Return a question with every name checked and every value put in."""
    query = bind(resolve(query), parameters, given)
    check_kinds(query)
    check_rows(query)
    return query


def _result(query: QueryGraph, rows: list[Row], conditions: list[str], explanation: Explanation) -> Result:
    columns = [column.name for column in query.columns]
    named = [dict(zip(columns, row.values, strict=True)) for row in rows]
    if query.relax is None:
        return Result(columns, named, explanation)
    unmet = [
        tuple(map(Unmet, (conditions[number] for number in row.match.unmet), row.match.excesses))
        for row in rows
        if row.match is not None
    ]
    for row, misses in zip(named, unmet, strict=True):
        row[UNMET] = [miss.condition for miss in misses]
    return Result([*columns, UNMET], named, explanation, unmet)


class _Answering:
    """The way of one question: matches, options, symmetry, scores, overlap, rows."""

    def __init__(self, store: Store, query: QueryGraph, examples: Examples, deadline: Deadline, *, run: bool) -> None:
        self._query = query
        self._examples = examples
        self._deadline = deadline
        self._run = run
        self._patterns = [query.pattern, *query.optional]
        self._combining = combining_objects(query)
        self.explanation = Explanation(store.url)
        self._matcher = Matcher(
            store,
            examples,
            self._combining,
            needed_properties(query),
            deadline,
            self.explanation,
            run=run,
        )

    def rows(self) -> list[Row]:
        with self.explanation.timed("symmetry of the question"):
            symmetries = [] if self._query.keep_all else question_symmetries(self._query)
        order = list(dict.fromkeys(name for pattern in self._patterns for name in order_of_appearance(pattern)))
        values = wanted_values(self._query)
        if values is not None:
            smaller = tuple(smaller_first(order, symmetries))
            return self._finished(self._matcher.tallied(self._query.pattern, values, smaller), symmetries, order)
        if self._query.relax is not None:
            return self._with_near_misses(symmetries, order)
        rows = self._best_rows(symmetries, order)
        return self._finished(self._matches(symmetries, order), symmetries, order) if rows is None else rows

    def _with_near_misses(self, symmetries: list[Symmetry], order: list[str]) -> list[Row]:
        """Rows of full matches and near misses; those with more unmet are not looked for if there are rows enough."""
        near = NearMisses(self._matcher, self._examples, self._query.pattern, self._combining, self._deadline)
        limit = number_of_rows(self._query.limit)
        matches: list[Match] = []
        rows: list[Row] = []
        for unmet in range((number_of_rows(self._query.relax) or 0) + 1):
            matches += one_of_each(near.with_unmet(unmet), order, symmetries)
            rows = self._finished(matches, symmetries, order)
            if limit is not None and len(rows) >= limit:
                break
        return rows

    def _best_rows(self, symmetries: list[Symmetry], order: list[str]) -> list[Row] | None:
        """Answer from the matches that hold the best objects; None where that is not enough."""
        needed = rows_needed(self._query)
        if needed is None or is_anchored(self._query.pattern) or not self._run:
            return None
        with self.explanation.timed("examples and bounds"):
            best = BestObjects(self._query.pattern, self._examples, needed)
        found: dict[Any, Match] = {}
        while best.grow(self.explanation):
            for name, ids in best.new.items():
                for match in self._matches(symmetries, order, {name: ids}):
                    found.setdefault(tuple(match.id_of(name) for name in order), match)
            rows = self._finished(list(found.values()), symmetries, order, best.beyond)
            if best.is_all or len(rows) == number_of_rows(self._query.limit):
                return rows
        return None

    def _matches(self, symmetries: list[Symmetry], order: list[str], best: Ids | None = None) -> list[Match]:
        """All matches, options included, one of each set of symmetric ones.

        With `best`, only those in which the named nodes are some of the best objects.
        """
        in_store = not self._query.optional and not any(is_mixed(edge) for edge in self._query.pattern.edges)
        smaller = tuple(smaller_first(order, symmetries)) if in_store else ()
        scope: Scope = {}
        (matches,) = self._matcher.extended(self._query.pattern, scope, [Match({})], "MATCH", smaller, best)
        scope = scope_of(self._query.pattern, scope)
        for pattern in self._query.optional:
            matches = self._with_option(matches, pattern, scope)
            scope = scope_of(pattern, scope)
        return matches if in_store else one_of_each(self._deadline.watched(matches), order, symmetries)

    def _with_option(self, matches: list[Match], pattern: Pattern, scope: Scope) -> list[Match]:
        found = self._matcher.extended(pattern, scope, matches, "OPTIONAL MATCH")
        names = [*(node.name for node in pattern.nodes), *(edge.name for edge in pattern.edges)]
        missing = {name: None for name in names if name not in scope}
        result: list[Match] = []
        for match, extensions in zip(matches, found, strict=True):
            fitting = [extension for extension in self._deadline.watched(extensions) if self._fits(extension, match)]
            result += fitting or [Match({**match.elements, **missing})]
        return result

    def _fits(self, extended: Match, match: Match) -> bool:
        """Whether what an option adds is none of what the match has, nor shares a segment with it."""
        new = [name for name in extended.elements if name not in match.elements]
        objects = {node.name for pattern in self._patterns for node in pattern.nodes if node.label == "Object"}
        edges = [edge for pattern in self._patterns for edge in pattern.edges]
        joined = [frozenset((edge.left, edge.right)) for edge in edges if "PART_OF" in edge.types]
        return is_apart(extended, new, match.elements) and uses_segments_once(extended, objects, joined)

    def _finished(
        self, matches: list[Match], symmetries: list[Symmetry], order: list[str], beyond: float = math.inf
    ) -> list[Row]:
        """Rows of matches; all others are farther from the examples than `beyond`."""
        with self.explanation.timed("scores, order, columns"):
            likened = likened_nodes(self._patterns)
            matches = surely_best(scored(matches, likened, self._examples), beyond)
            self._answer_columns(matches)
            meanings = whole_scope(self._query)
            named = [name for name in order if not name.startswith("#") and meanings[name].is_node]
            rest = [name for name in order if name not in named]
            self.explanation.counts["matches"] = sum(match.weight for match in matches)
            if likened and not self._query.keep_all:
                matches = without_overlap(matches, [*named, *rest], likened, symmetries)
                self.explanation.counts["matches that overlap no better one"] = len(matches)
            if not self._run:
                return []
            return rows_of(self._query, self._deadline.watched(ranked(matches, named, rest)), named, self._examples)

    def _answer_columns(self, matches: list[Match]) -> None:
        """Answer the subqueries in RETURN and ORDER BY."""
        expressions = (*(c.expression for c in self._query.columns), *(k.expression for k in self._query.order))
        for expression in expressions:
            measure_likeness(expression, matches, self._examples)
        for part in (part for expression in expressions for part in walk(expression)):
            if isinstance(part, Subquery):
                rest = [match for match in matches if id(part) not in match.answers]
                self._matcher.answer(part, rest, whole_scope(self._query))
