"""From the parser's tree to the query graph: what a question says, not yet whether it makes sense."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import count
from typing import Any, Final

from lark import Token, Tree

from enfilade.errors import QuestionError

from .query_graph import (
    UNNAMED,
    Between,
    Column,
    Constraint,
    EdgePattern,
    Equal,
    Likeness,
    NodePattern,
    Pattern,
    QueryGraph,
    SortKey,
)
from .spelling import function_name, text_of, unquoted, without_blanks
from .syntax import (
    SCORES,
    Arithmetic,
    Call,
    Comparison,
    Expression,
    IsNull,
    ListOf,
    Literal,
    Logic,
    Membership,
    Negative,
    Not,
    Parameter,
    Place,
    PropertyOf,
    Subquery,
    TextTest,
    Variable,
    conjuncts,
)

Branch = Tree[Token]

MOST_HOPS: Final = 10
"""Longest path that can be asked for."""

TAIL: Final = ("order", "skip", "limit", "per_building", "relax")
"""Clauses after the columns, in any order, each once at most."""

_DIRECTIONS: Final = {"either": "-", "rightwards": ">", "leftwards": "<"}
_ARITHMETIC: Final = {"add": "+", "subtract": "-", "multiply": "*", "divide": "/", "modulo": "%", "raise_to": "^"}
_LOGIC: Final = {"or_": "OR", "and_": "AND", "xor": "XOR"}
_TEXT_TESTS: Final = {"starts_with": "STARTS WITH", "ends_with": "ENDS WITH", "contains": "CONTAINS"}
_CONSTANTS: Final = {"true": True, "false": False, "null": None}


class Builder:
    """Builds the query graph of one question.

    Parameters
    ----------
    text
        The question, for error messages and the names of columns.
    """

    def __init__(self, text: str) -> None:
        self._source = text

    def question(self, tree: Branch) -> QueryGraph:
        """Build a whole question."""
        matches = [part for part in _trees(tree) if part.data == "match"]
        pattern = self._pattern(matches)
        optional = tuple(self._pattern([part]) for part in _trees(tree) if part.data == "optional")
        returning = next(tree.find_data("returning"))
        words = {item.type for item in returning.children if isinstance(item, Token)}
        return QueryGraph(
            pattern=pattern,
            columns=tuple(self._column(part) for part in _trees(returning)),
            optional=optional,
            distinct="DISTINCT" in words,
            keep_all="ALL" in words,
            text=self._source,
            **self._tail([part for part in _trees(tree) if part.data in TAIL]),
        )

    def _tail(self, parts: Iterable[Branch]) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for part in parts:
            if part.data in found:
                word = part.data.upper().replace("_", " ")
                raise self._error(f"{word} stands twice; write it once.", part)
            if part.data == "order":
                found["order"] = tuple(self._sort_key(key) for key in _trees(part))
            else:
                found[part.data] = self._expression(_only(part))
        return found

    def _sort_key(self, tree: Branch) -> SortKey:
        return SortKey(self._expression(_trees(tree)[0]), _token(tree, "DESCENDING") is not None)

    def _column(self, tree: Branch) -> Column:
        value = _trees(tree)[0]
        alias = _token(tree, "NAME")
        written = self._source[value.meta.start_pos : value.meta.end_pos]
        return Column(unquoted(alias) if alias else without_blanks(written), self._expression(value))

    # Patterns

    def _pattern(self, clauses: list[Branch]) -> Pattern:
        nodes: dict[str, NodePattern] = {}
        edges: list[EdgePattern] = []
        numbers = count(1)
        for clause in clauses:
            for chain in _trees(next(_subtrees(clause, "parts"))):
                self._chain(chain, nodes, edges, numbers)
        wheres = [self._expression(_only(part)) for clause in clauses for part in _subtrees(clause, "where")]
        parts = tuple(part for where in wheres for part in conjuncts(where))
        where = wheres[0] if len(wheres) == 1 else Logic("AND", parts, place=parts[0].place) if parts else None
        return Pattern(tuple(nodes.values()), tuple(edges), where)

    def _chain(
        self, chain: Branch, nodes: dict[str, NodePattern], edges: list[EdgePattern], numbers: Iterator[int]
    ) -> None:
        first, *rest = _trees(chain)
        left = self._node(first, nodes, numbers)
        for edge, node in zip(rest[::2], rest[1::2], strict=True):
            right = self._node(node, nodes, numbers)
            edges.append(self._edge(edge, left, right))
            left = right

    def _node(self, tree: Branch, nodes: dict[str, NodePattern], numbers: Iterator[int]) -> str:
        name = self._name(tree) or f"{UNNAMED}{next(numbers)}"
        label = next(_subtrees(tree, "label"), None)
        likeness = next(_subtrees(tree, "likeness"), None)
        node = NodePattern(
            name,
            None if label is None else unquoted(_only_token(label)),
            self._constraints(tree),
            None if likeness is None else self._likeness(likeness),
            place=_place(tree),
        )
        nodes[name] = self._joined(nodes[name], node) if name in nodes else node
        return name

    def _joined(self, first: NodePattern, again: NodePattern) -> NodePattern:
        """Return what two mentions of a node say together."""
        if first.label and again.label and first.label != again.label:
            raise self._error(
                f'"{first.name}" is a {first.label} already and cannot be a {again.label}; use another name.',
                again.place,
            )
        if first.likeness and again.likeness:
            raise self._error(f'"{first.name}" has one LIKE already; say the other with like() in WHERE.', again.place)
        return NodePattern(
            first.name,
            first.label or again.label,
            first.constraints + again.constraints,
            first.likeness or again.likeness,
            place=first.place,
        )

    def _edge(self, tree: Branch, left: str, right: str) -> EdgePattern:
        detail = next(_subtrees(tree, "detail"), None)
        types = None if detail is None else next(_subtrees(detail, "types"), None)
        if detail is None or types is None:
            raise self._error("an edge needs a type in brackets, such as -[:DOOR]- or -[:CONTAINS]->.", tree)
        if tree.data == "both_ways":
            raise self._error("an edge has one arrow at most; write -[...]-, -[...]-> or <-[...]-.", tree)
        return EdgePattern(
            left,
            right,
            tuple(dict.fromkeys(unquoted(name) for name in types.scan_values(lambda _: True))),
            _DIRECTIONS[tree.data],
            self._constraints(detail),
            self._hops(detail),
            self._name(detail) or UNNAMED,
            place=_place(detail),
        )

    def _name(self, tree: Branch) -> str | None:
        token = _token(tree, "NAME")
        if token is None:
            return None
        name = unquoted(token)
        if name in SCORES or name.startswith(UNNAMED):
            raise self._error(f'"{name}" cannot name a node or an edge; use another name.', _token_place(token))
        return name

    def _hops(self, detail: Branch) -> tuple[int, int] | None:
        tree = next((part for part in _trees(detail) if part.data in ("exactly", "from_to", "at_most")), None)
        if tree is None:
            return None
        ends = [self._hop_number(token) for token in tree.children if isinstance(token, Token)]
        if len(ends) == 0 or (tree.data == "from_to" and len(ends) == 1):
            raise self._error("a path needs a greatest length; write *1..3, *..3 or *2.", tree)
        low, high = (1 if tree.data == "at_most" else ends[0]), ends[-1]
        if not 1 <= low <= high <= MOST_HOPS:
            raise self._error(
                f"a path of {low} to {high} edges cannot be asked for; its ends must rise from 1 up to {MOST_HOPS}.",
                tree,
            )
        return low, high

    def _hop_number(self, token: Token) -> int:
        if not token.isdigit() or len(token) > len(str(MOST_HOPS)):
            raise self._error(f"a path has 1 to {MOST_HOPS} edges, not {token}.", _token_place(token))
        return int(token)

    def _constraints(self, tree: Branch) -> tuple[Constraint, ...]:
        entries = next(_subtrees(tree, "map"), None)
        return () if entries is None else tuple(self._constraint(entry) for entry in _trees(entries))

    def _constraint(self, tree: Branch) -> Constraint:
        name, place = unquoted(_only_token(tree)), _place(tree)
        values = [self._expression(value) for value in _trees(tree)]
        if tree.data == "equal":
            return Equal(name, values[0], place=place)
        if tree.data == "up_to":
            return Between(name, None, values[0], place=place)
        return Between(name, values[0], values[1] if len(values) > 1 else None, place=place)

    def _likeness(self, tree: Branch) -> Likeness:
        reference, *rest = _trees(tree)
        found: dict[str, list[Expression]] = {}
        for part in rest:
            if part.data in found:
                raise self._error(f"{part.data.upper()} stands twice; write it once.", part)
            found[part.data] = [self._expression(value) for value in _trees(part)]
        at = found.get("at")
        return Likeness(
            self._expression(reference),
            found["within"][0] if "within" in found else None,
            (at[0], at[-1]) if at else None,
            place=_place(tree),
        )

    # Expressions

    def _expression(self, tree: Branch) -> Expression:
        method: Callable[[Branch], Expression] | None = getattr(self, f"_{tree.data}", None)
        return method(tree) if method else self._operation(tree)

    def _operation(self, tree: Branch) -> Expression:
        operands, place = tuple(self._expression(part) for part in _trees(tree)), _place(tree)
        kind = tree.data
        if kind in _CONSTANTS:
            return Literal(_CONSTANTS[kind], place=place)
        if kind in _LOGIC:
            return Logic(_LOGIC[kind], operands, place=place)
        if kind in _ARITHMETIC:
            return Arithmetic(_ARITHMETIC[kind], *operands, place=place)
        if kind in _TEXT_TESTS:
            return TextTest(_TEXT_TESTS[kind], *operands, place=place)
        return _UNARY[kind](operands, place)

    def _number(self, tree: Branch) -> Expression:
        return Literal(_number_of(_only_token(tree)), place=_place(tree))

    def _minus_number(self, tree: Branch) -> Expression:
        return Literal(-_number_of(_only_token(tree)), place=_place(tree))

    def _minus(self, tree: Branch) -> Expression:
        operand = self._expression(_only(tree))
        if isinstance(operand, Literal) and type(operand.value) in (int, float):
            return Literal(-operand.value, place=_place(tree))  # type: ignore[operator]
        return Negative(operand, place=_place(tree))

    def _text(self, tree: Branch) -> Expression:
        return Literal(self._unescaped(_only_token(tree)), place=_place(tree))

    def _unescaped(self, token: Token) -> str:
        try:
            return text_of(token)
        except ValueError as error:
            raise self._error(f"{error}.", _token_place(token)) from None

    def _parameter(self, tree: Branch) -> Expression:
        return Parameter(unquoted(_only_token(tree)[1:]), place=_place(tree))

    def _variable(self, tree: Branch) -> Expression:
        return Variable(unquoted(_only_token(tree)), place=_place(tree))

    def _property(self, tree: Branch) -> Expression:
        variable, name = (unquoted(token) for token in tree.children if isinstance(token, Token))
        return PropertyOf(variable, name, place=_place(tree))

    def _chained(self, tree: Branch) -> Expression:
        operands = [self._expression(part) for part in _trees(tree)]
        operators = [str(token) for token in tree.children if isinstance(token, Token)]
        place = _place(tree)
        parts = [Comparison(o, *operands[i : i + 2], place=place) for i, o in enumerate(operators)]
        return parts[0] if len(parts) == 1 else Logic("AND", tuple(parts), place=place)

    def _group(self, tree: Branch) -> Expression:
        return self._expression(_only(tree))

    def _star_call(self, tree: Branch) -> Expression:
        name = function_name(_only_token(tree))
        if name != "count":
            raise self._error(f"only count(*) takes a star, not {name}.", tree)
        return Call(name, (), place=_place(tree))

    def _call(self, tree: Branch) -> Expression:
        token = _token(tree, "NAME")
        assert token is not None
        name = function_name(token)
        arguments = tuple(self._expression(part) for part in _trees(tree))
        if name == "count" and not arguments:
            raise self._error("count needs what it counts: count(*) or count(a).", tree)
        return Call(name, arguments, _token(tree, "DISTINCT") is not None, place=_place(tree))

    def _object(self, tree: Branch) -> Expression:
        name = function_name(_only_token(tree))
        if name != "object":
            raise self._error(f"LIKE takes a file, $parameter or object('id'), not {name}().", tree)
        return Call(name, (self._expression(_trees(tree)[0]),), place=_place(tree))

    def _subquery(self, tree: Branch) -> Expression:
        kind = _only_token(tree).lower()
        if kind not in ("exists", "count"):
            raise self._error(f"braces follow EXISTS or count, not {_only_token(tree)}.", tree)
        return Subquery(kind, self._pattern([tree]), place=_place(tree))

    def _list(self, tree: Branch) -> Expression:
        return ListOf(tuple(self._expression(part) for part in _trees(tree)), place=_place(tree))

    def _error(self, message: str, where: Branch | Place | None) -> QuestionError:
        place = _place(where) if isinstance(where, Tree) else where
        if place is None:
            return QuestionError(message)
        return QuestionError(message, text=self._source, line=place.line, column=place.column)


_UNARY: Final[dict[str, Callable[[tuple[Expression, ...], Place | None], Expression]]] = {
    "not_": lambda operands, place: Not(operands[0], place=place),
    "plus": lambda operands, _: operands[0],
    "is_null": lambda operands, place: IsNull(operands[0], False, place=place),
    "is_not_null": lambda operands, place: IsNull(operands[0], True, place=place),
    "in_": lambda operands, place: Membership(*operands, place=place),
}


def _trees(tree: Branch) -> list[Branch]:
    return [child for child in tree.children if isinstance(child, Tree)]


def _subtrees(tree: Branch, kind: str) -> Iterator[Branch]:
    return (child for child in _trees(tree) if child.data == kind)


def _only(tree: Branch) -> Branch:
    (child,) = _trees(tree)
    return child


def _only_token(tree: Branch) -> Token:
    return next(child for child in tree.children if isinstance(child, Token))


def _token(tree: Branch, type: str) -> Token | None:
    return next((child for child in tree.children if isinstance(child, Token) and child.type == type), None)


def _place(tree: Branch) -> Place | None:
    return None if tree.meta.empty else Place(tree.meta.line, tree.meta.column, tree.meta.start_pos, tree.meta.end_pos)


def _token_place(token: Token) -> Place:
    return Place(token.line or 1, token.column or 1)


def _number_of(token: Token) -> int | float:
    return int(token) if token.isdigit() else float(token)
