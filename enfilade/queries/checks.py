"""Every name in a question against the schema: labels, edge types, properties, variables, functions.

`resolve` also fills in what a question leaves out: the labels that its edges leave no choice in, and the
expressions that ORDER BY means by the names of columns.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import NoReturn

from enfilade.errors import QuestionError
from enfilade.schema.definition import NODES
from enfilade.schema.names import hint

from .labels import inferred_labels
from .query_graph import Column, EdgePattern, Likeness, NodePattern, Pattern, QueryGraph, SortKey
from .result import UNMET
from .separation import separated
from .spelling import FUNCTIONS
from .syntax import (
    PERCENTILES,
    SCORES,
    Call,
    Expression,
    Parameter,
    Place,
    PropertyOf,
    Subquery,
    Variable,
    aggregates,
    children,
    is_aggregate,
    rebuilt,
    walk,
)
from .vocabulary import EDGE_TYPES, OPENING_EDGES, Meaning, edge_meaning, may_point, shared_properties

Scope = Mapping[str, Meaning]

_ARGUMENTS = {"like": 2, "object": 1, **dict.fromkeys(PERCENTILES, 2)}


def resolve(query: QueryGraph) -> QueryGraph:
    """Check all names of a question and fill in what it leaves out.

    Raises
    ------
    QuestionError
        At the first name that is wrong, with its place and the nearest known name.
    """
    return _Resolver(query.text).question(separated(query))


class _Resolver:
    def __init__(self, text: str | None) -> None:
        self._text = text

    def question(self, query: QueryGraph) -> QueryGraph:
        pattern, scope = self._pattern(query.pattern, {})
        optional = []
        for clause in query.optional:
            self._check_option(clause, scope)
            resolved, scope = self._pattern(clause, scope)
            optional.append(resolved)
        columns = tuple(Column(c.name, self._value(c.expression, scope)) for c in query.columns)
        self._check_columns(columns, scope)
        if query.relax is not None:
            self._check_free(columns)
        resolved_query = replace(query, pattern=pattern, optional=tuple(optional), columns=columns)
        return replace(resolved_query, order=tuple(self._sort_key(key, resolved_query, scope) for key in query.order))

    def _check_option(self, clause: Pattern, scope: Scope) -> None:
        for node in clause.nodes:
            if node.likeness is not None and node.name in scope:
                self._fail(f'"{node.name}" is not new here; put its LIKE where it first stands.', node.likeness.place)

    def _fail(self, message: str, place: Place | None) -> NoReturn:
        message = message.replace("?.", "?")
        if place is None:
            raise QuestionError(message)
        raise QuestionError(message, text=self._text, line=place.line, column=place.column)

    # Patterns

    def _pattern(self, pattern: Pattern, outer: Scope) -> tuple[Pattern, dict[str, Meaning]]:
        for edge in pattern.edges:
            self._check_edge(edge)
        for node in pattern.nodes:
            self._check_node(node, outer)
        edges = self._edge_meanings(pattern, outer)
        known = {**{name: m.label for name, m in outer.items()}, **{name: m.label for name, m in edges.items()}}
        labels = inferred_labels(pattern, known, self._fail)
        nodes = tuple(replace(node, label=labels[node.name]) for node in pattern.nodes)
        scope = {**outer, **edges, **{node.name: Meaning(node.label) for node in nodes}}
        for node in nodes:
            self._check_constraints(node, scope[node.name].properties(), f"A {node.label}")
            self._check_likeness(node)
        where = None if pattern.where is None else self._condition(pattern.where, scope)
        return Pattern(nodes, pattern.edges, where), scope

    def _edge_meanings(self, pattern: Pattern, outer: Scope) -> dict[str, Meaning]:
        found: dict[str, Meaning] = {}
        for edge in pattern.edges:
            meaning = edge_meaning(edge.types)
            node = pattern.node(edge.name)
            if edge.name in found or edge.name in outer or (node is not None and not meaning.is_node):
                self._fail(f'the name "{edge.name}" is taken; name the edge otherwise.', edge.place)
            if edge.named:
                found[edge.name] = meaning
        return found

    def _check_node(self, node: NodePattern, outer: Scope) -> None:
        if node.label is not None and node.label not in NODES:
            self._fail(f'there is no label "{node.label}": {hint(node.label, NODES)}.', node.place)
        meaning = outer.get(node.name)
        if meaning is not None and not meaning.is_node:
            self._fail(f'"{node.name}" is an edge and cannot stand as a node; use another name.', node.place)

    def _check_edge(self, edge: EdgePattern) -> None:
        for type in edge.types:
            if type not in EDGE_TYPES:
                self._fail(f'there is no edge type "{type}": {hint(type, EDGE_TYPES)}.', edge.place)
            if edge.direction != "-" and not may_point(type):
                self._fail(f"{type} has no direction; write -[:{type}]- without an arrow.", edge.place)
        openings = [type for type in edge.types if type in OPENING_EDGES]
        if edge.named and openings and len(openings) < len(edge.types):
            self._fail("an edge that may be an opening or not cannot have a name; leave the name out.", edge.place)
        if edge.hops is not None:
            self._check_path(edge)
        known = shared_properties(edge.types)
        for constraint in edge.constraints:
            if constraint.property not in known:
                self._fail_property(constraint.property, "|".join(edge.types), known, constraint.place)

    def _check_path(self, edge: EdgePattern) -> None:
        if edge.named:
            self._fail("a path cannot have a name; leave the name out.", edge.place)
        if edge.direction != "-":
            self._fail("a path has no direction; write it without an arrow.", edge.place)
        if edge.types != ("NEIGHBOUR",) and not set(edge.types) <= set(OPENING_EDGES):
            self._fail("a path leads through openings, or through NEIGHBOUR alone.", edge.place)

    def _check_constraints(self, node: NodePattern, known: Mapping[str, object], what: str) -> None:
        for constraint in node.constraints:
            if constraint.property not in known:
                self._fail_property(constraint.property, what, known, constraint.place)

    def _fail_property(self, name: str, what: str, known: Iterable[str], place: Place | None) -> NoReturn:
        names = tuple(known)
        if not names:
            self._fail(f'{what} has no property "{name}", nor any other.', place)
        self._fail(f'{what} has no property "{name}": {hint(name, names)}.', place)

    def _check_likeness(self, node: NodePattern) -> None:
        if node.likeness is not None:
            if node.label != "Object":
                self._fail(f"only an Object can be LIKE an example, not a {node.label}.", node.likeness.place)
            self._check_reference(node.likeness)

    def _check_reference(self, likeness: Likeness) -> None:
        reference = likeness.reference
        if isinstance(reference, Call) and likeness.at is not None:
            self._fail("AT is for a file: the height of a stored object is known.", likeness.place)

    # Expressions

    def _condition(self, expression: Expression, scope: Scope) -> Expression:
        for part in walk(expression):
            if is_aggregate(part):
                self._fail("a condition cannot aggregate; use count { } or return the aggregate.", part.place)
            if isinstance(part, Variable) and part.name in SCORES and part.name not in scope:
                self._fail(f"{part.name} stands in RETURN and ORDER BY; limit likeness by WITHIN.", part.place)
        return self._value(expression, scope)

    def _value(self, expression: Expression, scope: Scope) -> Expression:
        """Check the names in an expression and resolve the patterns in it."""
        if isinstance(expression, Variable):
            self._check_variable(expression.name, scope, expression.place)
        if isinstance(expression, PropertyOf):
            self._check_property(expression, scope)
        if isinstance(expression, Call):
            self._check_call(expression, scope)
        if isinstance(expression, Subquery):
            return replace(expression, pattern=self._pattern(expression.pattern, scope)[0])
        return rebuilt(expression, lambda part: self._value(part, scope))

    def _check_variable(self, name: str, scope: Scope, place: Place | None) -> None:
        if name not in scope and name not in SCORES:
            known = [known for known in scope if not known.startswith("#")]
            self._fail(f'there is no variable "{name}": {hint(name, (*known, *SCORES))}.', place)

    def _check_property(self, expression: PropertyOf, scope: Scope) -> None:
        self._check_variable(expression.variable, scope, expression.place)
        if expression.variable in SCORES:
            self._fail(f"{expression.variable} is a number and has no properties.", expression.place)
        meaning = scope[expression.variable]
        if expression.name not in meaning.properties():
            what = f"A {meaning}" if meaning.is_node else str(meaning)
            self._fail_property(expression.name, what, meaning.properties(), expression.place)

    def _check_call(self, call: Call, scope: Scope) -> None:
        name = call.function
        if name not in FUNCTIONS:
            self._fail(f'there is no function "{name}": {hint(name, FUNCTIONS)}.', call.place)
        if call.arguments and len(call.arguments) != _ARGUMENTS.get(name, 1):
            self._fail(f"{name} takes {_ARGUMENTS.get(name, 1)} argument(s), not {len(call.arguments)}.", call.place)
        if not call.arguments and name != "count":
            self._fail(f"{name} needs an argument.", call.place)
        if call.distinct and not is_aggregate(call):
            self._fail(f"{name} takes no DISTINCT.", call.place)
        if is_aggregate(call) and any(map(aggregates, call.arguments)):
            self._fail("an aggregate cannot stand inside another one.", call.place)
        if name == "like":
            self._check_like(call, scope)

    def _check_like(self, call: Call, scope: Scope) -> None:
        subject, reference = call.arguments
        if not isinstance(subject, Variable):
            self._fail("like() takes a variable and an example: like(o, $x).", call.place)
        self._check_variable(subject.name, scope, subject.place)
        if subject.name not in scope or scope[subject.name].label != "Object":
            self._fail(f'like() takes an Object, and "{subject.name}" is none.', subject.place)
        is_text = getattr(reference, "value", None).__class__ is str
        is_object = isinstance(reference, Call) and reference.function == "object"
        if not (is_text or is_object or isinstance(reference, Parameter)):
            self._fail("an example is a file in quotes, a $parameter or object('id').", call.place)

    # Columns and order

    def _check_columns(self, columns: tuple[Column, ...], scope: Scope) -> None:
        twice = next((name for name, n in Counter(c.name for c in columns).items() if n > 1), None)
        for column in columns:
            expression = column.expression
            if column.name == twice:
                self._fail(f'two columns are named "{twice}"; rename one with AS.', columns[-1].expression.place)
            if isinstance(expression, Variable) and expression.name in scope and not scope[expression.name].is_node:
                self._fail(f'"{expression.name}" is an edge; return its properties, or count it.', expression.place)

    def _check_free(self, columns: tuple[Column, ...]) -> None:
        """Check that no column has the name of the one that RELAX adds."""
        taken = next((column for column in columns if column.name == UNMET), None)
        if taken is not None:
            self._fail(f'RELAX adds a column named "{UNMET}"; rename yours with AS.', taken.expression.place)

    def _sort_key(self, key: SortKey, query: QueryGraph, scope: Scope) -> SortKey:
        columns = {column.name: column.expression for column in query.columns}
        expression = _with_columns(key.expression, columns, scope)
        expression = self._value(expression, scope)
        grouped = query.distinct or any(aggregates(column.expression) for column in query.columns)
        returned = set(columns.values())
        if grouped and not _made_of(expression, returned):
            self._fail("after DISTINCT or an aggregate, ORDER BY takes only what RETURN returns.", key.expression.place)
        if not grouped and aggregates(expression):
            self._fail("ORDER BY aggregates, but RETURN does not; return the aggregate.", key.expression.place)
        return SortKey(expression, key.descending)


def _with_columns(expression: Expression, columns: Mapping[str, Expression], scope: Scope) -> Expression:
    """Put in what the names of columns stand for."""
    if isinstance(expression, Variable) and expression.name in columns:
        return columns[expression.name]
    if isinstance(expression, PropertyOf):
        renamed = columns.get(expression.variable)
        if isinstance(renamed, Variable) and renamed.name in scope:
            return replace(expression, variable=renamed.name)
        return expression
    return rebuilt(expression, lambda part: _with_columns(part, columns, scope))


def _made_of(expression: Expression, parts: set[Expression]) -> bool:
    """Whether an expression is built from `parts` and constants alone."""
    if expression in parts:
        return True
    if isinstance(expression, Variable | PropertyOf | Subquery) or is_aggregate(expression):
        if isinstance(expression, PropertyOf):
            return Variable(expression.variable) in parts
        return False
    return all(_made_of(child, parts) for child in children(expression))
