"""Near misses: matches that leave some conditions of the question unmet.

They are found by how many conditions are unmet. For each set of edges that may be missing one statement asks for the
rest of the pattern, with the other conditions counted in the store; a few that it cannot test are tested after it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Any

from enfilade.errors import QuestionError
from enfilade.queries.compiler import Counted, Search
from enfilade.queries.examples import Examples
from enfilade.queries.expansion import expansions
from enfilade.queries.kinds import scope_of
from enfilade.queries.query_graph import EdgePattern, Pattern
from enfilade.queries.relaxation import (
    Holds,
    Joined,
    ValueCondition,
    bare,
    conditions_of,
    edge_with_ends,
    joined_by_part_of,
    left_without,
    lost_names,
    mentions,
)
from enfilade.queries.sayable import sayable
from enfilade.queries.syntax import Comparison, Expression, Subquery, walk
from enfilade.stores.deadline import Deadline

from .excess import excess
from .matches import Element, Match
from .matching import Matcher
from .values import measure_likeness, value_of


class NearMisses:
    """Finds the matches of a pattern that leave a number of its conditions unmet.

    Parameters
    ----------
    matcher
        Asks the store; it knows which objects may be combinations and which properties are needed.
    examples
        What LIKE refers to.
    pattern
        Resolved and bound.
    combining
        Names of objects that may be combinations.
    deadline
        When to give up.
    """

    def __init__(
        self,
        matcher: Matcher,
        examples: Examples,
        pattern: Pattern,
        combining: frozenset[str],
        deadline: Deadline,
    ) -> None:
        self._deadline = deadline
        self._matcher = matcher
        self._examples = examples
        self._pattern = pattern
        self._combining = combining
        self._scope = scope_of(pattern, {})
        self._sharing = frozenset(joined_by_part_of(pattern))
        self._conditions = conditions_of(pattern)
        self._edges = {
            condition.edge: i for i, condition in enumerate(self._conditions) if isinstance(condition, Joined)
        }
        self._known: dict[tuple[Any, ...], list[Match]] = {}

    def with_unmet(self, count: int) -> list[Match]:
        """Return the matches with exactly so many conditions unmet; to be asked for 0, 1, 2 and so on in turn.

        A match without an edge is left out where the same nodes have the edge and no more conditions are unmet.
        """
        if count == 0:
            (found,) = self._matcher.extended(self._pattern, {}, [Match({})], "MATCH")
        else:
            found = [match for size in range(count + 1) for match in self._lacking(size, count - size)]
        for match in self._deadline.watched(found):
            self._known.setdefault(self._nodes_of(match), []).append(match)
        kept = [match for match in self._deadline.watched(found) if not self._is_covered(match)]
        return self._measured(kept)

    def _nodes_of(self, match: Match) -> tuple[Any, ...]:
        return tuple(match.id_of(node.name) for node in self._pattern.nodes)

    def _is_covered(self, match: Match) -> bool:
        """Whether another match has the same nodes and edges, and an edge more."""
        lacking = self._edges_unmet(match)
        return bool(lacking) and any(
            self._edges_unmet(other) < lacking
            and all(match.id_of(edge.name) == other.id_of(edge.name) for edge in self._edges.keys() - lacking)
            for other in self._known[self._nodes_of(match)]
        )

    def _edges_unmet(self, match: Match) -> frozenset[EdgePattern]:
        return frozenset(edge for edge, number in self._edges.items() if number in match.unmet)

    # Statements

    def _lacking(self, size: int, rest: int) -> Iterator[Match]:
        """Find the matches that lack so many edges, and of whose other conditions so many are unmet."""
        for edges in combinations(self._edges, size):
            yield from self._without(edges, rest)

    def _without(self, edges: Sequence[EdgePattern], rest: int) -> list[Match]:
        lost = lost_names(self._pattern, edges)
        left = dict(left_without(self._conditions, edges))
        after = [number for number, condition in left.items() if not self._in_store(condition, lost)]
        told = [number for number in left if number not in after]
        if rest > len(left):
            return []
        counted = Counted(tuple(left[number] for number in told), max(0, rest - len(after)), min(rest, len(told)))
        missing = tuple(self._edges[edge] for edge in edges)
        found = [
            Match(
                {**elements, **dict.fromkeys(lost)}, unmet=(*missing, *(told[i] for i, one in enumerate(unmet) if one))
            )
            for elements, unmet in self._rows(edges, counted, [self._expression(number) for number in after])
        ]
        return self._tested(found, after, len(edges) + rest)

    def _rows(
        self, edges: Sequence[EdgePattern], counted: Counted, after: Sequence[Expression]
    ) -> Iterator[tuple[dict[str, Element], tuple[int, ...]]]:
        without = "".join(f" without {edge_with_ends(edge, self._pattern)}" for edge in edges)
        unmet = "" if counted.most == 0 else f", up to {counted.most} other conditions unmet"
        title = f"MATCH{without}{unmet}"
        for expansion in expansions(bare(self._pattern, edges), {}, self._combining, sharing=self._sharing):
            columns = self._matcher.columns(expansion)
            search = Search(expansion, self._scope, (), columns, (), self._combining, counted)
            yield from self._matcher.found(search, after, title, {})

    def _in_store(self, condition: ValueCondition, lost: Sequence[str]) -> bool:
        if not isinstance(condition, Holds):
            return True
        return sayable(condition.expression, self._scope) and not mentions(condition, lost)

    # What the store does not test

    def _tested(self, matches: list[Match], after: Sequence[int], count: int) -> list[Match]:
        """Return the matches of which, with the conditions tested here, just so many are unmet."""
        for number in after:
            expression = self._expression(number)
            self._answer(expression, matches)
            for match in self._deadline.watched(matches):
                if not self._is_true(expression, match):
                    match.unmet = (*match.unmet, number)
            matches = [match for match in matches if len(match.unmet) <= count]
        return [match for match in matches if len(match.unmet) == count]

    def _expression(self, number: int) -> Expression:
        condition = self._conditions[number]
        assert isinstance(condition, Holds)
        return condition.expression

    def _answer(self, expression: Expression, matches: Sequence[Match]) -> None:
        measure_likeness(expression, matches, self._examples)
        for part in walk(expression):
            if isinstance(part, Subquery):
                self._matcher.answer(part, matches, self._scope)

    def _is_true(self, expression: Expression, match: Match) -> bool:
        """Whether a condition holds; one that cannot be worked out, as what ruled that out is unmet, does not."""
        try:
            return value_of(expression, match, self._examples) is True
        except QuestionError:
            return False

    def _measured(self, matches: list[Match]) -> list[Match]:
        """Note how far off the unmet conditions are."""
        for number, condition in enumerate(self._conditions):
            if isinstance(condition, Holds) and isinstance(condition.expression, Comparison):
                self._answer(condition.expression, [match for match in matches if number in match.unmet])
        for match in self._deadline.watched(matches):
            match.unmet = tuple(sorted(match.unmet))
            match.excesses = tuple(excess(self._conditions[number], match, self._examples) for number in match.unmet)
        return matches
