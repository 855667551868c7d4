"""Near misses: what the conditions of a question are, what it asks without some of them, and how each is named.

A condition is an edge of the pattern (a path with its map), a value or range in a map, a limit of likeness, or one of
the parts of WHERE that AND joins. Labels, LIKE itself, distinct nodes and the one building are no conditions: they
always hold. What the words of a question mean (symmetry, combinations, segments used once) is taken from the question
as it is written, whatever of it is unmet.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

from .binding import free_variables
from .printing import edge_text, expression_text, node_text
from .query_graph import Constraint, EdgePattern, Likeness, NodePattern, Pattern
from .spelling import without_blanks
from .syntax import Expression, conjuncts


@dataclass(frozen=True, slots=True)
class Joined:
    """An edge or a path is there."""

    edge: EdgePattern


@dataclass(frozen=True, slots=True)
class Entry:
    """A value or range in the map of a node or an edge holds."""

    element: NodePattern | EdgePattern
    constraint: Constraint


@dataclass(frozen=True, slots=True)
class Near:
    """A likened node is within its limit."""

    node: NodePattern
    likeness: Likeness
    within: Expression


@dataclass(frozen=True, slots=True)
class Holds:
    """A part of WHERE is true."""

    expression: Expression


ValueCondition = Entry | Near | Holds
Condition = Joined | ValueCondition


def conditions_of(pattern: Pattern) -> tuple[Condition, ...]:
    """Return the conditions of a pattern: nodes, then edges, each followed by its map, then WHERE."""
    found: list[Condition] = []
    for node in pattern.nodes:
        found += [Entry(node, constraint) for constraint in node.constraints]
        if node.likeness is not None and node.likeness.within is not None:
            found.append(Near(node, node.likeness, node.likeness.within))
    for edge in pattern.edges:
        found.append(Joined(edge))
        found += [Entry(edge, constraint) for constraint in edge.constraints if edge.hops is None]
    return (*found, *map(Holds, conjuncts(pattern.where)))


def left_without(
    conditions: Sequence[Condition], edges: Collection[EdgePattern]
) -> Iterator[tuple[int, ValueCondition]]:
    """Conditions on values that are left when some edges are not there, and their numbers: maps go with edges."""
    for number, condition in enumerate(conditions):
        if not isinstance(condition, Joined) and not (isinstance(condition, Entry) and condition.element in edges):
            yield number, condition


def lost_names(pattern: Pattern, edges: Collection[EdgePattern]) -> tuple[str, ...]:
    """Return the names that mean nothing without these edges; an opening that stands as a node too stays."""
    return tuple(edge.name for edge in edges if edge.hops is None and pattern.node(edge.name) is None)


def mentions(condition: ValueCondition, names: Collection[str]) -> bool:
    """Whether a part of WHERE speaks of one of the names."""
    return isinstance(condition, Holds) and not set(names).isdisjoint(free_variables(condition.expression))


def bare(pattern: Pattern, without: Collection[EdgePattern]) -> Pattern:
    """Return a pattern without some of its edges and without any condition on values."""
    nodes = tuple(replace(node, constraints=(), likeness=_unlimited(node.likeness)) for node in pattern.nodes)
    kept = (edge for edge in pattern.edges if edge not in without)
    return Pattern(nodes, tuple(edge if edge.hops else replace(edge, constraints=()) for edge in kept))


def _unlimited(likeness: Likeness | None) -> Likeness | None:
    return None if likeness is None else replace(likeness, within=None)


def condition_texts(pattern: Pattern, text: str | None) -> list[str]:
    """Return what to call each condition: as it is written.

    Parameters
    ----------
    pattern
        As parsed or built by hand, before anything is put in for its parameters.
    text
        The question, if it was parsed.
    """
    return [_named(condition, pattern, text) for condition in conditions_of(pattern)]


def _named(condition: Condition, pattern: Pattern, text: str | None) -> str:
    match condition:
        case Joined(edge):
            return edge_with_ends(edge if edge.hops else replace(edge, constraints=()), pattern)
        case Entry(NodePattern() as node, constraint):
            return node_text(replace(node, constraints=(constraint,), likeness=None))
        case Entry(EdgePattern() as edge, constraint):
            return edge_with_ends(replace(edge, constraints=(constraint,)), pattern)
        case Near(node):
            return node_text(replace(node, constraints=()))
        case Holds(expression):
            return _written(expression, pattern, text) or expression_text(expression)
    raise AssertionError(condition)


def edge_with_ends(edge: EdgePattern, pattern: Pattern) -> str:
    """Return an edge as text, its nodes by their names."""
    left, right = (_end(pattern.node(name)) for name in (edge.left, edge.right))
    return f"{left}{edge_text(edge)}{right}"


def _end(node: NodePattern | None) -> str:
    """Return a node by its name; without one by its label."""
    assert node is not None
    return node_text(NodePattern(node.name, None if node.named else node.label))


def _written(expression: Expression, pattern: Pattern, text: str | None) -> str | None:
    """Return the piece of the text that an expression is; the parts of ``1 < a.x < 2`` have none of their own."""
    place = expression.place
    if text is None or place is None or place.start is None:
        return None
    alone = sum(part.place == place for part in conjuncts(pattern.where)) == 1
    return without_blanks(text[place.start : place.end]) if alone else None


def joined_by_part_of(pattern: Pattern) -> Iterator[frozenset[str]]:
    """Pairs of objects that the pattern joins by PART_OF, and that may share segments."""
    return (frozenset((edge.left, edge.right)) for edge in pattern.edges if "PART_OF" in edge.types)
