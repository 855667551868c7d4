"""The best objects for the likened nodes of a question, more of them each time, and what the rest cannot do.

Matches grow combinatorially, objects do not. So the store is asked for the matches that hold one of the best objects
for one of the likened nodes. Every other match is farther in each of these nodes than the last object that was asked
for; the sum of those distances is a bound of its own (the threshold algorithm of Fagin, Lotem and Naor, 2003). When
enough matches are nearer than that, no other can be among the answer.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final

import numpy as np

from enfilade.queries.examples import Examples, number_of
from enfilade.queries.explanation import Explanation
from enfilade.queries.query_graph import Pattern

from .matches import Match
from .pruning import likened_nodes, score_of

FIRST_OBJECTS: Final = 64
"""Best objects a node that the store is asked for at first, at least."""
GROWTH: Final = 16
"""How many times as many it is the next time."""
MOST_TIMES: Final = 3
"""Times that the store is asked so; then it is asked for everything."""
MOST_SHARE: Final = 0.5
"""Share of all objects above which it is better asked for everything at once."""

_NOISE: Final = 1e-9
"""More than the sums of distances can differ by when they are added in another order."""


class BestObjects:
    """The best objects for each likened node of a pattern.

    Parameters
    ----------
    pattern
        With at least one likened node.
    examples
        What LIKE refers to.
    rows
        How many rows are needed.

    Attributes
    ----------
    new
        Objects that came with the last growth, by node.
    beyond
        The sum of distances of every match without one of the objects so far is greater.
    """

    def __init__(self, pattern: Pattern, examples: Examples, rows: int) -> None:
        self._likened = {
            name: (examples.ranking(likeness), np.inf if likeness.within is None else number_of(likeness.within))
            for name, likeness in likened_nodes([pattern]).items()
        }
        self._count = max(FIRST_OBJECTS, rows)
        self._times = 0
        self._known: dict[str, set[str]] = {name: set() for name in self._likened}
        self.new: dict[str, list[str]] = {}
        self.beyond = 0.0

    @property
    def is_all(self) -> bool:
        """Whether every match holds one of the objects so far."""
        return math.isinf(self.beyond)

    def grow(self, explanation: Explanation) -> bool:
        """Take more objects; returns whether that is worth while."""
        largest = max(ranking.effort.candidates for ranking, _ in self._likened.values())
        if self._times == MOST_TIMES or self._count > max(MOST_SHARE * largest, FIRST_OBJECTS):
            return False
        with explanation.timed("examples and bounds"):
            best = {name: ranking.best(self._count, limit) for name, (ranking, limit) in self._likened.items()}
        self.beyond = sum(found.beyond for found in best.values())
        self.new = {name: [id for id in found.distances if id not in self._known[name]] for name, found in best.items()}
        for name, ids in self.new.items():
            self._known[name].update(ids)
        self._times += 1
        self._count *= GROWTH
        return True


def surely_best(matches: Iterable[Match], beyond: float) -> list[Match]:
    """Keep the matches with a better score than any whose sum of distances is greater than `beyond`."""
    limit = score_of(beyond - _NOISE) if math.isfinite(beyond) else -math.inf
    return [match for match in matches if match.score > limit]
