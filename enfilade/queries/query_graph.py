"""The question as a graph: nodes, edges, constraints, likeness, and what is returned.

Text, JSON and Python all come to this one structure; the compilers start from it. By hand::

    QueryGraph(
        pattern=Pattern(
            nodes=(NodePattern("a", "Room", (Between("area", Literal(10), Literal(20)),)), NodePattern("b", "Room")),
            edges=(EdgePattern("a", "b", ("DOOR",)),),
        ),
        columns=(Column("a", Variable("a")), Column("b", Variable("b"))),
    )
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import count
from typing import Any, Final

from .syntax import Expression, Place

UNNAMED: Final = "#"
"""First character of the names given to nodes and edges that have none; no name in a text starts so."""


@dataclass(frozen=True)
class Equal:
    """``{property: value}``."""

    property: str
    value: Expression
    place: Place | None = field(default=None, compare=False, repr=False, kw_only=True)


@dataclass(frozen=True)
class Between:
    """``{property: low..high}``; both ends count, either may be missing."""

    property: str
    low: Expression | None = None
    high: Expression | None = None
    place: Place | None = field(default=None, compare=False, repr=False, kw_only=True)


Constraint = Equal | Between


@dataclass(frozen=True)
class Likeness:
    """``LIKE reference WITHIN limit AT low..high``.

    Attributes
    ----------
    reference
        A text (file), ``object(id)`` or a parameter.
    within
        Greatest distance that counts, or None.
    at
        Least and greatest height of the example's foot over the floor, metres, or None: foot on foot.
    """

    reference: Expression
    within: Expression | None = None
    at: tuple[Expression, Expression] | None = None
    place: Place | None = field(default=None, compare=False, repr=False, kw_only=True)


@dataclass(frozen=True)
class NodePattern:
    """A node of the pattern; in an inner or optional pattern it may be one of the outer ones."""

    name: str
    label: str | None = None
    constraints: tuple[Constraint, ...] = ()
    likeness: Likeness | None = None
    place: Place | None = field(default=None, compare=False, repr=False, kw_only=True)

    @property
    def named(self) -> bool:
        """Whether the question gives it a name."""
        return not self.name.startswith(UNNAMED)


@dataclass(frozen=True)
class EdgePattern:
    """An edge of the pattern, as written from left to right.

    Attributes
    ----------
    left, right
        Names of its nodes.
    types
        Edge types, one of which it has; ``DOOR`` and its like stand for room, opening, room.
    direction
        ``"-"``, ``">"`` (to the right) or ``"<"``.
    constraints
        On the edge's properties, or the opening's.
    hops
        Least and greatest number of edges on a path; None for one edge.
    name
        Its name, or a made-up one.
    """

    left: str
    right: str
    types: tuple[str, ...]
    direction: str = "-"
    constraints: tuple[Constraint, ...] = ()
    hops: tuple[int, int] | None = None
    name: str = UNNAMED
    place: Place | None = field(default=None, compare=False, repr=False, kw_only=True)

    @property
    def named(self) -> bool:
        """Whether the question gives it a name."""
        return not self.name.startswith(UNNAMED)


@dataclass(frozen=True)
class Pattern:
    """Nodes in order of appearance, edges, and the condition on both.

    A node without a name in the text is called ``#1``, ``#2``, ..., an edge ``#e1``, ``#e2``, ....
    """

    nodes: tuple[NodePattern, ...] = ()
    edges: tuple[EdgePattern, ...] = ()
    where: Expression | None = None

    def __post_init__(self) -> None:
        """Give numbers to the edges that have none."""
        numbers = count(1)
        edges = tuple(
            replace(edge, name=f"{UNNAMED}e{next(numbers)}") if edge.name == UNNAMED else edge for edge in self.edges
        )
        object.__setattr__(self, "edges", edges)

    def node(self, name: str) -> NodePattern | None:
        """Return the node of that name, or None."""
        return next((node for node in self.nodes if node.name == name), None)


@dataclass(frozen=True)
class Column:
    """One returned value and its name."""

    name: str
    expression: Expression


@dataclass(frozen=True)
class SortKey:
    """One expression of ORDER BY."""

    expression: Expression
    descending: bool = False


@dataclass(frozen=True)
class QueryGraph:
    """A whole question.

    Attributes
    ----------
    pattern
        Everything in MATCH.
    columns
        Everything in RETURN.
    optional
        One pattern an OPTIONAL MATCH.
    distinct, keep_all
        ``RETURN DISTINCT``, ``RETURN ALL``.
    order
        ORDER BY.
    skip, limit, per_building
        Numbers of rows, or None.
    relax
        How many conditions a match may leave unmet, or None: all are met.
    text
        What it was parsed from, for error messages.
    """

    pattern: Pattern
    columns: tuple[Column, ...]
    optional: tuple[Pattern, ...] = ()
    distinct: bool = False
    keep_all: bool = False
    order: tuple[SortKey, ...] = ()
    skip: Expression | None = None
    limit: Expression | None = None
    per_building: Expression | None = None
    relax: Expression | None = None
    text: str | None = field(default=None, compare=False, repr=False)

    def __str__(self) -> str:
        """Return the question as text; parsing it gives the same question."""
        from .printing import printed

        return printed(self)

    def to_json(self) -> dict[str, Any]:
        """Return the question as plain values that `json` can write."""
        from .exchange import encode

        return encode(self)

    @staticmethod
    def from_json(document: Any) -> QueryGraph:
        """Return the question that `to_json` made plain. Raises QuestionError where it did not."""
        from .exchange import decode

        return decode(document)
