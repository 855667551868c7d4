"""How far a match is from meeting a condition, from 0 (only just not) to 1 (not at all); likeness may go beyond.

A number that should have been another, or between others, is off by its difference from the nearest that would do,
divided by the greater of the two: 8 instead of 10 is off by 0.2, as is 12.5. Likeness is off by what its distance is
over the limit. Everything else is there or not: off by 1.
"""

from __future__ import annotations

from typing import Any

from enfilade.errors import QuestionError
from enfilade.queries.examples import Examples, number_of
from enfilade.queries.query_graph import Constraint, Equal
from enfilade.queries.relaxation import Condition, Entry, Holds, Near
from enfilade.queries.syntax import Comparison, Literal

from .matches import Match
from .values import value_of

ABSENT = 1.0
"""How far off is what is there or not."""


def excess(condition: Condition, match: Match, examples: Examples) -> float:
    """Return how far off an unmet condition is; the match knows the answers of the subqueries it compares."""
    match condition:
        case Entry(element, constraint):
            found = match.elements[element.name]
            return ABSENT if found is None else _from_constraint(found.properties.get(constraint.property), constraint)
        case Near(node, likeness, within):
            distance = examples.ranking(likeness).distance(match.id_of(node.name))
            assert distance is not None, "a near miss is like the example, but for the limit"
            return distance - number_of(within)
        case Holds(Comparison(operator, left, right)) if operator != "<>":
            try:
                return apart(value_of(left, match, examples), value_of(right, match, examples))
            except QuestionError:
                return ABSENT
    return ABSENT


def _from_constraint(value: Any, constraint: Constraint) -> float:
    if isinstance(constraint, Equal):
        assert isinstance(constraint.value, Literal)
        return apart(value, constraint.value.value)
    ends = [number_of(end) for end in (constraint.low, constraint.high) if end is not None]
    return min(apart(value, end) for end in ends)


def apart(value: Any, wanted: Any) -> float:
    """Return the difference of two numbers relative to the greater one, at most 1; all else is 1 apart."""
    if not all(isinstance(number, int | float) and not isinstance(number, bool) for number in (value, wanted)):
        return ABSENT
    if value == wanted:
        return 0.0
    relative = abs(value - wanted) / max(abs(value), abs(wanted))
    return min(relative, ABSENT) if relative == relative else ABSENT
