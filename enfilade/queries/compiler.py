"""What both compilers share: they write text and parameters, and run nothing.

A compiler turns one expansion of a pattern into one statement. The columns of its rows are told beside the text.
Every value of the user's is a parameter; names in the text are ours.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Final

from .expansion import Expansion, Point, Route, expansions
from .kinds import Scope, scope_of
from .query_graph import Constraint, Equal, Likeness
from .relaxation import Entry, Holds, Near, ValueCondition
from .spelling import KEYWORDS
from .symmetry import inner_symmetries, order_of_appearance, smaller_first
from .syntax import (
    Comparison,
    Expression,
    IsNull,
    Literal,
    Logic,
    Membership,
    Not,
    PropertyOf,
    Scalar,
    Subquery,
    TextTest,
    Variable,
)


@dataclass(frozen=True, slots=True)
class LikeIds:
    """Stands for the ids of all objects that are like an example; they are put in before the text is run."""

    likeness: Likeness


@dataclass(frozen=True, slots=True)
class GivenIds:
    """Stands for the ids that a node from outside may have; they are put in before the text is run."""

    name: str


@dataclass(frozen=True, slots=True)
class BestIds:
    """Stands for the ids of the objects that a node is asked for; they are put in before the text is run."""

    name: str


@dataclass(frozen=True, slots=True)
class Wanted:
    """One column of a compiled question: a property of an element; an edge's ``id`` is the engine's own."""

    element: str
    property: str


@dataclass(frozen=True, slots=True)
class Counted:
    """Conditions of which from `least` to `most` are unmet in each row; a column each tells which, by 1."""

    conditions: tuple[ValueCondition, ...]
    least: int
    most: int


@dataclass(frozen=True, slots=True)
class Search:
    """What one statement looks for.

    Attributes
    ----------
    expansion
        The pattern, spelled out.
    scope
        What the names mean, those from outside included.
    conditions
        Conditions that the store can test.
    columns
        What to return.
    smaller
        Pairs of elements of which the first has the smaller id: one of each set of symmetric matches.
    combining
        Names of objects that may be combinations.
    counted
        Conditions that may be unmet, in a search for near misses.
    likeness_after
        Whether likeness is tested on the rows: where these are few anyway, that is less than to find all that is like.
    best
        Names of nodes that are asked for only some objects: the best, or those that like() in WHERE lets through.
    tally
        Whether rows that agree in all columns are one, with their number as a last column.
    """

    expansion: Expansion
    scope: Scope
    conditions: tuple[Expression, ...]
    columns: tuple[Wanted, ...]
    smaller: tuple[tuple[str, str], ...]
    combining: frozenset[str]
    counted: Counted | None = None
    likeness_after: bool = False
    best: frozenset[str] = frozenset()
    tally: bool = False

    @property
    def likened_after(self) -> tuple[Point, ...]:
        """Nodes whose limit of likeness is tested on the rows."""
        limited = (p for p in self.expansion.points if p.likeness is not None and p.likeness.within is not None)
        return tuple(limited) if self.likeness_after else ()


@dataclass(frozen=True, slots=True)
class Compiled:
    """A statement of a store's own language, its parameters, and what its columns are."""

    text: str
    parameters: Mapping[str, Any]
    columns: tuple[Wanted, ...] = field(default=())


MOST_MARKS: Final = 100
"""A longer list of values is one parameter."""

_PLAIN_ALIAS: Final = re.compile(r"[a-z][a-z0-9]*")
_RESERVED: Final = re.compile(r"[nex]\d+|x|y|any|case|coalesce|count|elementid|exists|match|null|size|table|true|false")
"""Names that the compilers make up themselves, and words that could be read otherwise."""


class Compiler(ABC):
    """Writes one statement; the subclasses say how their language spells things."""

    dialect: ClassVar[str]
    mark: ClassVar[str]
    """What stands before a parameter's name."""

    def __init__(self, search: Search) -> None:
        self._search = search
        self._parameters: dict[str, Any] = {}
        self._marks: dict[tuple[type, Any], str] = {}
        self._aliases: dict[str, str] = {}
        self._links: set[str] = set()
        self._fresh = 0

    @classmethod
    def compile(cls, search: Search) -> Compiled:
        """Write the statement for a search."""
        compiler = cls(search)
        compiler._links |= {link.name for link in search.expansion.links}
        return Compiled(compiler._statement(search), compiler._parameters, search.columns)

    # What the languages spell differently

    @abstractmethod
    def _statement(self, search: Search) -> str:
        """Return the whole statement."""

    @abstractmethod
    def _subquery(self, kind: str, expansion: Expansion, conditions: Sequence[str]) -> str:
        """Return a test for, or the number of, matches of an inner pattern."""

    @abstractmethod
    def _route(self, route: Route) -> str:
        """Return a test for a path."""

    @abstractmethod
    def _same_parts(self, a: str, b: str) -> str:
        """Return a test that two objects share a segment."""

    @abstractmethod
    def _parts(self, alias: str) -> str:
        """Return the number of segments of an object."""

    @abstractmethod
    def _property(self, alias: str, name: str) -> str:
        """Return a property of an element."""

    @abstractmethod
    def _key(self, alias: str) -> str:
        """Return what tells an edge from all others."""

    def _columns(self, search: Search) -> str:
        """Return the list of columns: what is wanted, then what is unmet, then the number of such rows."""
        wanted = [self._returned(column) for column in search.columns]
        return ", ".join([*wanted, *self._unmet(search), *(["count(*)"] if search.tally else [])])

    def _returned(self, column: Wanted) -> str:
        """Return what stands in the list of columns for one of them."""
        alias = self._alias(column.element)
        is_key = column.element in self._links and column.property == "id"
        return self._key(alias) if is_key else self._property(alias, column.property)

    @abstractmethod
    def _same(self, left: str, operator: str, right: str) -> str:
        """Compare two nodes or two edges for being the same."""

    @abstractmethod
    def _in(self, item: str, values: Sequence[str]) -> str:
        """Return a test that an item is among parameters."""

    @abstractmethod
    def _among(self, item: str, parameter: str) -> str:
        """Return a test that an item is in a list that is one parameter."""

    @abstractmethod
    def _text_test(self, operator: str, left: str, right: str, value: str) -> str:
        """Return a test of how a text starts, ends or what it contains; `value` is the constant itself."""

    @abstractmethod
    def _xor(self, operands: Sequence[str]) -> str:
        """Return the exclusive or of conditions."""

    # Names and values

    def _alias(self, name: str) -> str:
        """Return the name of an element in the text: the question's own where it is plain."""
        if name not in self._aliases:
            plain = _PLAIN_ALIAS.fullmatch(name) and not _RESERVED.fullmatch(name) and name not in KEYWORDS
            self._aliases[name] = name if plain else self._new("n")
        return self._aliases[name]

    def _new(self, letter: str) -> str:
        self._fresh += 1
        return f"{letter}{self._fresh}"

    def _parameter(self, value: Any) -> str:
        """Return the mark of a parameter with a value; equal values of one type share it."""
        name = self._marks.setdefault((type(value), value), f"p{len(self._marks)}")
        self._parameters[name] = value
        return self.mark + name

    # Conditions

    def _all_conditions(self, expansion: Expansion, *, inner: bool) -> list[str]:
        """Everything that must hold of an expansion, apart from its edges and the WHERE."""
        found = [text for point in expansion.points for text in self._point_conditions(point, inner=inner)]
        for name, kinds in expansion.kinds.items():
            found.append(self._in(self._of(name, "kind"), [self._parameter(kind) for kind in kinds]))
        for link in expansion.links:
            found += [self._constraint(self._alias(link.name), entry) for entry in link.constraints]
        for low, high in expansion.climbs:
            found.append(f"{self._of(high, 'floor_elevation')} > {self._of(low, 'floor_elevation')}")
        found += [self._same(self._alias(a), "<>", self._alias(b)) for a, b in expansion.apart]
        found += [f"NOT {self._same_parts(self._alias(a), self._alias(b))}" for a, b in expansion.exclusive]
        found += [f"{self._of(a, 'building')} = {self._of(b, 'building')}" for a, b in expansion.together]
        return found + [self._route(route) for route in expansion.routes]

    def _point_conditions(self, point: Point, *, inner: bool) -> list[str]:
        alias = self._alias(point.name)
        found = [self._constraint(alias, entry) for entry in point.constraints]
        if point.single:
            found.append(f"{self._parts(alias)} = 1")
        if point.name in self._search.best and not inner:
            found.append(self._among(self._property(alias, "id"), self._parameter(BestIds(point.name))))
        elif point.likeness is not None:
            found.append(self._likeness(point.name, point.likeness, inner=inner))
        if point.given and not inner:
            found.append(self._among(self._property(alias, "id"), self._parameter(GivenIds(point.name))))
        return found

    def _likeness(self, name: str, likeness: Likeness, *, inner: bool) -> str:
        """Test likeness where a limit makes the list short or nothing comes after; else leave out what has no shape."""
        if inner or (likeness.within is not None and not self._search.likeness_after):
            return self._among(self._of(name, "id"), self._parameter(LikeIds(likeness)))
        shapes = (self._of(name, property) for property in ("descriptor", "foot_descriptor"))
        return f"({' OR '.join(f'{shape} IS NOT NULL' for shape in shapes)})"

    def _constraint(self, alias: str, constraint: Constraint) -> str:
        subject = self._property(alias, constraint.property)
        if isinstance(constraint, Equal):
            return f"{subject} = {self._value(constraint.value)}"
        ends = ((">=", constraint.low), ("<=", constraint.high))
        return " AND ".join(f"{subject} {sign} {self._value(end)}" for sign, end in ends if end is not None)

    def _value(self, expression: Expression) -> str:
        assert isinstance(expression, Literal)
        return self._parameter(expression.value)

    def _of(self, name: str, property: str) -> str:
        return self._property(self._alias(name), property)

    def _smaller(self, pairs: Iterable[tuple[str, str]]) -> list[str]:
        return [f"{self._identity(a)} < {self._identity(b)}" for a, b in pairs]

    def _identity(self, name: str) -> str:
        return self._key(self._alias(name)) if name in self._links else self._of(name, "id")

    def _wheres(self, search: Search) -> list[str]:
        """Return all conditions of a statement but those that its edges are."""
        tested = [self._condition(condition, search.scope) for condition in search.conditions]
        found = self._all_conditions(search.expansion, inner=False) + tested + self._smaller(search.smaller)
        if search.counted is not None and search.counted.most == 0:
            found += [self._counted(condition, search.scope) for condition in search.counted.conditions]
        elif search.counted is not None:
            unmet = " + ".join(self._unmet(search))
            numbers = range(search.counted.least, search.counted.most + 1)
            found.append(self._in(f"({unmet})", [str(number) for number in numbers]))
        return found

    def _unmet(self, search: Search) -> list[str]:
        """Return, for each condition that may be unmet, 1 where it is not true and 0 where it is."""
        if search.counted is None or search.counted.most == 0:
            return []
        return [
            f"CASE WHEN {self._counted(condition, search.scope)} THEN 0 ELSE 1 END"
            for condition in search.counted.conditions
        ]

    def _counted(self, condition: ValueCondition, scope: Scope) -> str:
        match condition:
            case Entry(element, constraint):
                return self._constraint(self._alias(element.name), constraint)
            case Near(node, likeness):
                return self._among(self._of(node.name, "id"), self._parameter(LikeIds(likeness)))
            case Holds(expression):
                return self._condition(expression, scope)

    def _condition(self, expression: Expression, scope: Scope) -> str:
        match expression:
            case Literal():
                return self._value(expression)
            case PropertyOf(variable, name):
                return self._of(variable, name)
            case Comparison(operator, left, right) if isinstance(left, Variable) and isinstance(right, Variable):
                return f"({self._same(self._alias(left.name), operator, self._alias(right.name))})"
            case Comparison(operator, left, right):
                return f"({self._condition(left, scope)} {operator} {self._condition(right, scope)})"
            case Logic(operator, operands):
                texts = [self._condition(operand, scope) for operand in operands]
                return self._xor(texts) if operator == "XOR" else f"({_joined(operator, texts)})"
            case Not(operand):
                return f"(NOT {self._condition(operand, scope)})"
            case IsNull(operand, negated):
                return f"({self._condition(operand, scope)} IS {'NOT ' * negated}NULL)"
            case Membership(item, Literal(values)):
                assert isinstance(values, tuple)
                return self._one_of(self._condition(item, scope), values)
            case TextTest(operator, left, Literal(value)):
                assert isinstance(value, str)
                return self._text_test(operator, self._condition(left, scope), self._parameter(value), value)
            case Subquery():
                return self._matches(expression, scope)
        raise AssertionError(f"{expression} is not for a store")

    def _one_of(self, item: str, values: tuple[Scalar, ...]) -> str:
        if len(values) > MOST_MARKS:
            return f"({self._among(item, self._parameter(values))})"
        return self._in(item, [self._parameter(value) for value in values])

    def _matches(self, subquery: Subquery, outer: Scope) -> str:
        pattern = subquery.pattern
        scope = scope_of(pattern, outer)
        beside = next(point.name for point in self._search.expansion.points)
        smaller: list[tuple[str, str]] = []
        if subquery.kind == "count":
            smaller = smaller_first(order_of_appearance(pattern), inner_symmetries(pattern, outer))
        texts = []
        for expansion in expansions(pattern, outer, self._search.combining, beside):
            self._links |= {link.name for link in expansion.links}
            conditions = self._all_conditions(expansion, inner=True) + self._smaller(smaller)
            if pattern.where is not None:
                conditions.append(self._condition(pattern.where, scope))
            texts.append(self._subquery(subquery.kind, expansion, conditions))
        joined = " OR ".join(texts) if subquery.kind == "exists" else " + ".join(texts)
        return f"({joined})" if texts else self._nothing(subquery.kind)

    def _nothing(self, kind: str) -> str:
        return "(1 = 0)" if kind == "exists" else "0"


def _joined(operator: str, texts: Sequence[str]) -> str:
    """Join conditions; many are put in brackets by halves, as engines limit how deep an expression may be."""
    if len(texts) <= MOST_MARKS:
        return f" {operator} ".join(texts)
    half = len(texts) // 2
    return f"({_joined(operator, texts[:half])}) {operator} ({_joined(operator, texts[half:])})"
