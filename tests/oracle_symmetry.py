"""How the oracle sees that a renaming leaves a question the same: by comparing it part by part, trying all orders."""

from __future__ import annotations

from itertools import permutations

from enfilade.queries.query_graph import Pattern
from enfilade.queries.syntax import Call, Expression, PropertyOf, Subquery, Variable, children


def own(pattern: Pattern, name: str) -> str:
    """What has no name is a thing of its own pattern only, or of the one that this is made from."""
    return f"{name} {id(getattr(pattern, 'made_from', pattern))}" if name.startswith("#") else name


def description(patterns: list[Pattern], name: str) -> str:
    """What must be the same of two nodes or edges for one to take the place of the other."""
    said = []
    for number, pattern in enumerate(patterns):
        for node in pattern.nodes:
            if own(pattern, node.name) == name:
                at = [] if node.likeness is None else [node.likeness.reference, node.likeness.within, node.likeness.at]
                said.append(f"{number} {node.label} {sorted(map(repr, node.constraints))} {at}")
        said += [
            f"{number} {sorted(edge.types)} {sorted(map(repr, edge.constraints))} {edge.hops}"
            for edge in pattern.edges
            if own(pattern, edge.name) == name
        ]
    return str(said)


def edges_kept(pattern: Pattern, turn: dict[str, str]) -> bool:
    by_name = {own(pattern, edge.name): edge for edge in pattern.edges}
    for name, edge in by_name.items():
        image = by_name.get(turn.get(name, name))
        if image is None:
            return False
        ends = [turn.get(own(pattern, end), own(pattern, end)) for end in (edge.left, edge.right)]
        there = [own(pattern, end) for end in (image.left, image.right)]
        if edge.direction == "<":
            ends.reverse()
        if image.direction == "<":
            there.reverse()
        if (edge.direction == "-") != (image.direction == "-"):
            return False
        if ends != there and not (edge.direction == "-" and ends[::-1] == there):
            return False
    return True


def same_where(a: Expression | None, b: Expression | None, turn: dict[str, str]) -> bool:
    if a is None or b is None:
        return a is b
    return _alike_lists(_flat(a, "AND"), _flat(b, "AND"), turn)


def _flat(expression: Expression, operator: str) -> list[Expression]:
    if getattr(expression, "operator", None) == operator:
        return [part for child in children(expression) for part in _flat(child, operator)]
    return [expression]


def _alike_lists(a: list[Expression], b: list[Expression], turn: dict[str, str]) -> bool:
    """Whether each of one list has one like it in the other, and the other way round."""
    return all(any(same(x, y, turn) for y in b) for x in a) and all(any(same(x, y, turn) for x in a) for y in b)


def same(a: Expression, b: Expression, turn: dict[str, str]) -> bool:
    """Whether `a`, its names turned, says what `b` says."""
    operator = getattr(a, "operator", None)
    if operator in ("<", "<=", ">", ">=") and getattr(b, "operator", None) == {"<": ">", "<=": ">="}.get(
        operator, operator.replace(">", "<")
    ):
        return same(a.left, b.right, turn) and same(a.right, b.left, turn)
    if type(a) is not type(b) or operator != getattr(b, "operator", None):
        return False
    if operator in ("AND", "OR", "+", "*"):
        return _alike_in_number(_flat(a, operator), _flat(b, operator), turn)
    if operator in ("=", "<>") and same(a.left, b.right, turn) and same(a.right, b.left, turn):
        return True
    if isinstance(a, Variable):
        return turn.get(a.name, a.name) == b.name
    if isinstance(a, PropertyOf):
        return (turn.get(a.variable, a.variable), a.name) == (b.variable, b.name)
    if isinstance(a, Subquery):
        return a.kind == b.kind and _same_pattern(a.pattern, b.pattern, turn)
    if isinstance(a, Call) and (a.function, a.distinct) != (b.function, b.distinct):
        return False
    below, other = list(children(a)), list(children(b))
    if not below and not other:
        return a == b
    details = {k: v for k, v in vars(a).items() if isinstance(v, bool)} == {
        k: v for k, v in vars(b).items() if isinstance(v, bool)
    }
    return details and len(below) == len(other) and all(same(x, y, turn) for x, y in zip(below, other, strict=True))


def _alike_in_number(a: list[Expression], b: list[Expression], turn: dict[str, str]) -> bool:
    return len(a) == len(b) and any(all(same(x, y, turn) for x, y in zip(a, p, strict=True)) for p in permutations(b))


def _same_pattern(a: Pattern, b: Pattern, turn: dict[str, str]) -> bool:
    """Whether two inner patterns are the same up to the names of their own nodes."""
    own_a = [n.name for n in a.nodes if n.name not in turn] + [e.name for e in a.edges]
    own_b = [n.name for n in b.nodes if n.name not in turn.values()] + [e.name for e in b.edges]
    if len(own_a) != len(own_b):
        return False
    described = [description([a], own(a, name)) for name in own_a]
    for image in permutations(own_b):
        if [description([b], own(b, name)) for name in image] != described:
            continue
        names = turn | {own(a, x): own(b, y) for x, y in zip(own_a, image, strict=True)}
        plain = turn | dict(zip(own_a, image, strict=True))
        if _edges_match(a, b, names) and _outer_match(a, b, turn) and same_where(a.where, b.where, plain):
            return True
    return False


def _outer_match(a: Pattern, b: Pattern, turn: dict[str, str]) -> bool:
    said_a = {turn[n.name]: description([a], n.name) for n in a.nodes if n.name in turn}
    return said_a == {n.name: description([b], n.name) for n in b.nodes if n.name in turn.values()}


def _edges_match(a: Pattern, b: Pattern, names: dict[str, str]) -> bool:
    there = {own(b, e.name): e for e in b.edges}
    for edge in a.edges:
        image = there[names[own(a, edge.name)]]
        ends = [names.get(own(a, end), end) for end in (edge.left, edge.right)]
        other = [own(b, end) for end in (image.left, image.right)]
        if edge.direction == "<":
            ends.reverse()
        if image.direction == "<":
            other.reverse()
        undirected = edge.direction == image.direction == "-"
        if (edge.direction == "-") != (image.direction == "-"):
            return False
        if ends != other and not (undirected and ends[::-1] == other):
            return False
    return True
