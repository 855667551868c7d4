"""Matches of a pattern, or ways to extend matches by another one: a statement for the store, and what it left over.

One method does it all. The MATCH of a question extends the empty match; an OPTIONAL MATCH extends each match so
far; a subquery that the store cannot test is extended too, and its extensions counted.
"""

from __future__ import annotations

import json
import time
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import islice
from typing import Any, Final

from enfilade.errors import StoreError, UnsupportedError
from enfilade.queries.compile_cypher import compile_cypher
from enfilade.queries.compile_sql import compile_sql
from enfilade.queries.compiler import BestIds, Compiled, GivenIds, LikeIds, Search, Wanted
from enfilade.queries.examples import Examples
from enfilade.queries.expansion import Expansion, expansions, given_nodes
from enfilade.queries.explanation import Explanation, step_of
from enfilade.queries.kinds import Scope, scope_of
from enfilade.queries.query_graph import Pattern
from enfilade.queries.symmetry import Symmetry, inner_symmetries, order_of_appearance
from enfilade.queries.syntax import Expression, Subquery, walk
from enfilade.schema.definition import EDGE_PROPERTIES, NODE_PROPERTIES
from enfilade.schema.definition import Property as SchemaProperty
from enfilade.stores.base import Store
from enfilade.stores.deadline import Deadline

from .decoding import decoded
from .matches import Element, Match
from .needs import split_conditions
from .pruning import likened_nodes, one_of_each, scored, without_overlap
from .shortcuts import is_anchored, like_limits
from .values import measure_likeness, value_of

MOST_VALUES: Final = 10_000_000
"""Ids and properties that a question may fetch, and that its matches with options may hold: some 2 GB of memory."""

_ROWS_AT_ONCE: Final = 4096
"""Rows whose objects are measured at once."""

Pairs = tuple[tuple[str, str], ...]
Ids = Mapping[str, Collection[str]]
PutIn = Mapping[type[GivenIds | BestIds], Mapping[str, list[str]]]


class Matcher:
    """Finds the matches of patterns in a store.

    Parameters
    ----------
    store
        Where to look.
    examples
        What LIKE refers to.
    combining
        Names of objects that may be combinations.
    needed
        Properties to fetch, by the name of the element.
    deadline
        When to give up.
    explanation
        Hears of every statement.
    run
        Whether to run the statements; else they are only written.
    """

    def __init__(
        self,
        store: Store,
        examples: Examples,
        combining: frozenset[str],
        needed: Mapping[str, set[str]],
        deadline: Deadline,
        explanation: Explanation,
        *,
        run: bool,
    ) -> None:
        self._store = store
        self._examples = examples
        self._combining = combining
        self._needed = needed
        self._deadline = deadline
        self._explanation = explanation
        self._run = run
        self._nodes: dict[str, Element] = {}
        self._values_left = MOST_VALUES

    def extended(
        self,
        pattern: Pattern,
        outer: Scope,
        matches: Sequence[Match],
        title: str,
        smaller: Pairs = (),
        best: Ids | None = None,
    ) -> list[list[Match]]:
        """Return the extensions of each match by a pattern, its WHERE included.

        Parameters
        ----------
        pattern
            Resolved and bound.
        outer
            What the names of the matches mean.
        matches
            What is to be extended; ``[Match({})]`` to begin with.
        title
            How an explanation calls it.
        smaller
            Pairs of elements of which the first must have the smaller id.
        best
            Of likened nodes the objects that are asked for, where those are not all.
        """
        scope = scope_of(pattern, outer)
        given = given_nodes(pattern, outer)
        told, after = split_conditions(pattern, outer)
        few = bool(given or is_anchored(pattern))
        chosen = best or {} if few else self._let_through(pattern, best or {})
        ids: PutIn = {
            GivenIds: self._given_ids(given, matches),
            BestIds: {name: list(some) for name, some in chosen.items()},
        }
        likeness_after = few or bool(best)
        groups: dict[Any, list[dict[str, Element]]] = {}
        for expansion in expansions(pattern, outer, self._combining):
            search = Search(
                expansion,
                scope,
                told,
                self.columns(expansion),
                smaller,
                self._combining,
                likeness_after=likeness_after,
                best=frozenset(chosen),
            )
            for found, _ in self.found(search, after, title, ids):
                key = self._key(given, found) if outer else None
                groups.setdefault(key, []).append({n: e for n, e in found.items() if n not in given})
        extensions = [
            [
                Match({**match.elements, **found})
                for found in self._afforded(groups.get(self._key_of(given, match, outer), ()), match)
            ]
            for match in self._deadline.watched(matches)
        ]
        return self._tested(extensions, after, scope)

    def tallied(self, pattern: Pattern, columns: tuple[Wanted, ...], smaller: Pairs) -> list[Match]:
        """Return the matches of a pattern that the store tests whole, those with the same values as one.

        Parameters
        ----------
        pattern
            Resolved and bound.
        columns
            Which values.
        smaller
            As in `extended`.
        """
        scope = scope_of(pattern, {})
        told, _ = split_conditions(pattern, {})
        (expansion,) = expansions(pattern, {}, self._combining)
        search = Search(expansion, scope, told, columns, smaller, self._combining, tally=True)
        return [Match(dict(found), weight=n) for found, (n,) in self.found(search, (), "MATCH, counted", {}) if n]

    def _let_through(self, pattern: Pattern, best: Ids) -> Ids:
        """Return the objects that nodes are asked for: of the best ones, those that like() in WHERE lets through."""
        chosen = dict(best)
        for name, likeness in like_limits(pattern):
            allowed = set(self._examples.within(likeness)) if self._run else set()
            chosen[name] = allowed.intersection(chosen[name]) if name in chosen else allowed
        return {name: sorted(ids) for name, ids in chosen.items()}

    def _given_ids(self, given: Sequence[str], matches: Sequence[Match]) -> dict[str, list[str]]:
        ids = {name: {match.id_of(name) for match in matches} - {None} for name in given}
        return {name: sorted(found) for name, found in ids.items()}

    @staticmethod
    def _key(given: Sequence[str], found: Mapping[str, Element]) -> Any:
        """Return what a row shares with the matches that it extends: the nodes they both name, or the building."""
        if given:
            return tuple(found[name].id for name in given)
        return next(element.building for element in found.values() if element.is_node)

    @staticmethod
    def _key_of(given: Sequence[str], match: Match, outer: Scope) -> Any:
        if not outer:
            return None
        return tuple(match.id_of(name) for name in given) if given else match.building

    def columns(self, expansion: Expansion) -> tuple[Wanted, ...]:
        """Return what must come back of a pattern: the elements, and those of their properties that are needed."""
        columns = []
        for element in [
            *(point.name for point in expansion.points),
            *(link.name for link in expansion.links if not link.hidden),
        ]:
            extra = sorted(self._needed.get(element, set()) - {"id"})
            columns += [Wanted(element, name) for name in ("id", *extra)]
        return tuple(columns)

    # Statements and rows

    def found(
        self, search: Search, after: Sequence[Expression], title: str, ids: PutIn
    ) -> Iterator[tuple[dict[str, Element], tuple[int, ...]]]:
        """Run one statement; yields the elements behind the names, and 1 for each counted condition that is unmet.

        Parameters
        ----------
        search
            What to look for.
        after
            Conditions that are tested on the rows, for the explanation.
        title
            How an explanation calls it.
        ids
            Ids to put in.
        """
        compiled = compile_sql(search) if self._store.dialect == "sql" else compile_cypher(search)
        step = step_of(title, compiled, after, search.likened_after)
        self._explanation.steps.append(step)
        if not self._run:
            return
        likened = {p.name: p.likeness for p in search.expansion.points if p.likeness is not None}
        with self._explanation.timed("examples and bounds"):
            parameters = self._filled(compiled, ids)
            for likeness in likened.values():
                self._examples.ranking(likeness)
        start = time.perf_counter()
        step.rows = step.kept = 0
        rows = self._rows(compiled, parameters)
        while batch := list(islice(rows, _ROWS_AT_ONCE)):
            some = [(self._elements(search, row), tuple(row[len(search.columns) :])) for row in batch]
            step.rows += len(some)
            for point in search.likened_after:
                assert point.likeness is not None
                self._examples.ranking(point.likeness).measure(elements[point.name].id for elements, _ in some)
            for elements, unmet in some:
                if all(self._examples.is_like(likeness, elements[name].id) for name, likeness in likened.items()):
                    step.kept += 1
                    yield elements, unmet
        step.seconds = time.perf_counter() - start

    def _rows(self, compiled: Compiled, parameters: Mapping[str, Any]) -> Iterator[tuple[Any, ...]]:
        """Rows of a statement, until the whole question's time is over or they are too many for memory."""
        width = max(len(compiled.columns), 1)
        most = self._values_left // width
        try:
            rows = self._store.rows(compiled.text, parameters, timeout_s=self._deadline.left_s(), most=most + 1)
            for number, row in enumerate(self._deadline.watched(rows)):
                if number == most:
                    raise UnsupportedError(f"the question has more than {number:,} matches; make it narrower.")
                self._deadline.rows += 1
                yield row
                self._values_left -= width
        except StoreError:
            self._deadline.check()
            raise

    def _afforded(self, found: Sequence[dict[str, Element]], match: Match) -> Iterator[dict[str, Element]]:
        """Yield what extends a match, as long as memory and time allow."""
        if match.elements:
            self._values_left -= len(found) * (len(match.elements) + 1)
            if self._values_left < 0:
                raise UnsupportedError("the question has too many matches; make it narrower.")
        return self._deadline.watched(found)

    def _filled(self, compiled: Compiled, ids: PutIn) -> dict[str, Any]:
        """Return the parameters with lists of ids in place of what stands for them."""
        return {name: self._filled_value(value, ids) for name, value in compiled.parameters.items()}

    def _filled_value(self, value: Any, ids: PutIn) -> Any:
        if isinstance(value, LikeIds):
            items: list[Any] = list(self._examples.within(value.likeness))
        elif isinstance(value, GivenIds | BestIds):
            items = ids[type(value)][value.name]
        elif isinstance(value, tuple):
            items = list(value)
        else:
            return value
        return json.dumps(items) if self._store.dialect == "sql" else items

    def _elements(self, search: Search, row: Sequence[Any]) -> dict[str, Element]:
        elements: dict[str, Element] = {}
        types = {link.name: EDGE_PROPERTIES[link.type] for link in search.expansion.links}
        labels = {point.name: NODE_PROPERTIES[point.label] for point in search.expansion.points}
        for column, value in zip(search.columns, row, strict=False):
            name = column.element
            if column.property == "id":
                elements[name] = self._node(value) if name in labels else Element(value, is_node=False)
                if name in labels:
                    elements[name].properties["id"] = value
                continue
            known: Mapping[str, SchemaProperty] = labels.get(name) or types[name]
            element = elements.setdefault(name, Element(None, is_node=name in labels))
            element.properties[column.property] = decoded(value, known[column.property].kind)
        return elements

    def _node(self, id: str) -> Element:
        """One element a node, in whatever match it stands."""
        if id not in self._nodes:
            self._nodes[id] = Element(id, is_node=True)
        return self._nodes[id]

    # Conditions that the store does not test

    def _tested(self, extensions: list[list[Match]], after: Sequence[Expression], scope: Scope) -> list[list[Match]]:
        for condition in after:
            everyone = [match for found in extensions for match in found]
            for part in walk(condition):
                if isinstance(part, Subquery):
                    self.answer(part, everyone, scope)
            if self._run:
                measure_likeness(condition, everyone, self._examples)
                extensions = [
                    [
                        match
                        for match in self._deadline.watched(found)
                        if value_of(condition, match, self._examples) is True
                    ]
                    for found in extensions
                ]
        return extensions

    def _holds(self, condition: Expression, match: Match) -> bool:
        return value_of(condition, match, self._examples) is True

    def answer(self, subquery: Subquery, matches: Sequence[Match], scope: Scope) -> None:
        """Note the result of a subquery in each match."""
        pattern = subquery.pattern
        found = self.extended(pattern, scope, matches, f"{subquery.kind} {{ }}")
        if subquery.kind == "exists":
            for match, extensions in zip(matches, found, strict=True):
                match.answers[id(subquery)] = bool(extensions)
            return
        symmetries = inner_symmetries(pattern, scope)
        for match, extensions in zip(matches, found, strict=True):
            match.answers[id(subquery)] = len(self._counted(pattern, extensions, symmetries))

    def _counted(self, pattern: Pattern, matches: Iterable[Match], symmetries: Sequence[Symmetry]) -> list[Match]:
        kept = one_of_each(matches, order_of_appearance(pattern), symmetries)
        likened = likened_nodes([pattern])
        if not likened:
            return kept
        order = order_of_appearance(pattern)
        return without_overlap(scored(kept, likened, self._examples), order, likened, symmetries)
