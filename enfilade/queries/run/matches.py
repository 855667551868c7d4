"""A match: what each name of the question stands for in one place of the store."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Final

EXCESS_DECIMALS: Final = 6
"""How far off a near miss is counts to this many decimals."""


@dataclass(slots=True)
class Element:
    """A node or a stored edge, with those of its properties that the question needs.

    `id` is a node's id; for an edge it is what the engine tells it by, which is good for one answer only.
    """

    id: Any
    is_node: bool
    properties: dict[str, Any] = field(default_factory=dict)

    @property
    def building(self) -> str:
        """Id of the node's building, which its own begins with."""
        return str(self.id).partition("/")[0]

    @property
    def segments(self) -> frozenset[str]:
        """Ids of an object's segments; where they are missing, its own id tells them."""
        named = self.properties.get("segments")
        if named is not None:
            return frozenset(named)
        building, _, numbers = self.id.partition("/")
        return frozenset(f"{building}/{number}" for number in numbers.split("+"))


@dataclass(slots=True)
class Match:
    """One way to find the pattern.

    Attributes
    ----------
    elements
        What is behind each name; None behind the names of an OPTIONAL MATCH that found nothing.
    answers
        Results of subqueries that the store did not test, by the subquery's identity.
    score, mean_score
        Likeness; set when all elements are known.
    unmet
        Numbers of the conditions that do not hold, of a near miss.
    excesses
        How far off each of them is.
    weight
        How many matches it stands for; more than one where only their values are told.
    """

    elements: dict[str, Element | None]
    answers: dict[int, bool | int] = field(default_factory=dict)
    score: float = 0.0
    mean_score: float = 0.0
    unmet: tuple[int, ...] = ()
    excesses: tuple[float, ...] = ()
    weight: int = 1

    def id_of(self, name: str) -> Any:
        """Id of the element behind a name, or None."""
        element = self.elements.get(name)
        return None if element is None else element.id

    @property
    def rank(self) -> tuple[int, float, float]:
        """What a match sorts by: conditions unmet, how far off they are, and its score, best first."""
        return (*self.miss, -self.score)

    @property
    def miss(self) -> tuple[int, float]:
        """Number of conditions unmet, and how far off they are together."""
        return len(self.unmet), round(math.fsum(self.excesses), EXCESS_DECIMALS) + 0.0

    @property
    def building(self) -> str:
        """Id of the building that the match lies in."""
        return next(e.building for e in self.elements.values() if e is not None and e.is_node)
