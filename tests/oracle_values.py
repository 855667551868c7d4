"""The oracle's own reading of expressions, scores and tables; no value comes from the package's evaluation."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable
from typing import Any

import numpy as np

from enfilade.descriptors import TOTAL
from enfilade.queries.query_graph import EdgePattern, Equal, NodePattern, QueryGraph
from enfilade.queries.syntax import Call, Expression, Literal, PropertyOf, Variable, children
from enfilade.schema.graph import BuildingGraph, Node

AGGREGATES = ("count", "avg", "min", "max", "sum", "collect", "stDev", "stDevP", "percentileCont", "percentileDisc")


def compare(operator: str, a: Any, b: Any) -> bool | None:
    """Cypher's comparison; None is unknown."""
    if a is None or b is None:
        return None
    if isinstance(a, Node):
        a, b = a.id, b.id
    if isinstance(a, str) != isinstance(b, str) or isinstance(a, bool) != isinstance(b, bool):
        return {"=": False, "<>": True}.get(operator)
    results = {"=": a == b, "<>": a != b}
    if operator in results:
        return results[operator]
    return {"<": a < b, "<=": a <= b, ">": a > b, ">=": a >= b}[operator]


def constraints_hold(pattern: NodePattern | EdgePattern, thing: Any) -> bool:
    properties = dict(thing.properties)
    if isinstance(thing, Node):
        properties["id"] = thing.id
    for entry in pattern.constraints:
        value = properties.get(entry.property)
        if isinstance(entry, Equal):
            if compare("=", value, entry.value.value) is not True:
                return False
        elif value is None or not (
            (entry.low is None or value >= entry.low.value) and (entry.high is None or value <= entry.high.value)
        ):
            return False
    return True


def distance(p: np.ndarray, q: np.ndarray, shape: tuple[int, int, int]) -> float:
    """Eq. 11 with min: symmetric χ², least over the turns of the sectors."""
    p, q = (np.asarray(x, dtype=float).reshape(shape) / TOTAL for x in (p, q))
    found = []
    for shift in range(shape[2]):
        turned = np.roll(q, shift, axis=2)
        total = p + turned
        terms = np.divide((p - turned) ** 2, total, out=np.zeros_like(total), where=total > 0)
        found.append(math.fsum(terms.ravel()))
    return min(found)


class Values:
    """Values of expressions in matches."""

    def __init__(self, buildings: list[BuildingGraph], subquery: Callable[..., Any]) -> None:
        self.objects = {n.id: (n, graph) for graph in buildings for n in graph.of_label("Object")}
        self.subquery = subquery

    def distance_to(self, thing: Node, reference: Call) -> float | None:
        """Distance of an object from ``object('id')``, or None."""
        example, graph = self.objects[reference.arguments[0].value]
        own = self.objects[thing.id][1]
        shapes = (own.descriptor_shape, graph.descriptor_shape)
        p, q = (node.properties.get("descriptor") for node in (thing, example))
        if p is None or q is None or shapes[0] != shapes[1]:
            return None
        return round(distance(p, q, graph.descriptor_shape), 12)

    def is_like(self, thing: Node, likeness: Any) -> bool:
        found = self.distance_to(thing, likeness.reference)
        return found is not None and (likeness.within is None or found <= likeness.within.value)

    def score(self, match: dict[str, Any], likened: dict[str, Any]) -> tuple[float, float]:
        """Score and mean score."""
        total = 0.0
        for name, likeness in likened.items():
            if match[name] is None:
                total += 2.0 if likeness.within is None else likeness.within.value
            else:
                total += self.distance_to(match[name], likeness.reference)
        return round(-total, 6) + 0.0, round(-total / max(1, len(likened)), 6) + 0.0

    def value(self, expression: Expression | None, match: dict[str, Any], scores: Any = (0, 0)) -> Any:
        """Value of an expression; ``"all"`` where there is no condition."""
        if expression is None:
            return "all"
        kind = type(expression).__name__
        if kind == "Literal":
            return expression.value
        if kind == "Variable":
            if expression.name in ("score", "mean_score"):
                return scores[expression.name == "mean_score"]
            return match[expression.name]
        if kind == "PropertyOf":
            return _property(match[expression.variable], expression.name)
        if kind == "Subquery":
            return self.subquery(expression, match)
        if kind == "Call":
            thing = match[expression.arguments[0].name]
            return None if thing is None else self.distance_to(thing, expression.arguments[1])
        parts = [self.value(child, match, scores) for child in children(expression)]
        return _combined(kind, expression, parts)

    # Tables

    def table(self, query: QueryGraph, matches: list[Any], named: Any) -> list[tuple[Any, ...]]:
        """Rows of the answer, from matches in their default order with their scores."""
        columns = [column.expression for column in query.columns]
        aggregated = any(map(_aggregates, columns))
        if aggregated:
            rows = [(values, None, None) for values in self.groups(columns, matches)]
        else:
            rows = [(tuple(_shown(self.value(e, m, s)) for e in columns), s, m) for s, m in matches]
            if query.distinct:
                seen: dict[str, Any] = {}
                for row in rows:
                    seen.setdefault(repr(row[0]), row)
                rows = list(seen.values())

        def key(row: Any) -> Any:
            values, scores, match = row
            first: list[Any] = [scores[2:]] if scores else []
            for wanted in query.order:
                if aggregated:
                    value = values[_column_of(wanted.expression, query)]
                else:
                    value = self.value(_resolved(wanted.expression, query), match, scores)
                first.append(sort_key(value, wanted.descending))
            if aggregated or query.distinct:
                score = [sort_key(values[i], True) for i, e in enumerate(columns) if e == Variable("score")]
                return (first, score, [sort_key(value, False) for value in values])
            score = [] if query.order else [-scores[0]]
            return (first, score, named(match), [sort_key(value, False) for value in values])

        rows.sort(key=key)
        if query.per_building is not None:
            rows = _first_of_each(rows, query.per_building.value)
        start = query.skip.value if query.skip else 0
        rows = rows[start : start + query.limit.value if query.limit else None]
        if query.relax is None:
            return [row[0] for row in rows]
        return [(*values, match["unmet"]) for values, _, match in rows]

    def groups(self, columns: list[Expression], matches: list[Any]) -> list[tuple[Any, ...]]:
        keys = [e for e in columns if not _aggregates(e)]
        groups: dict[str, list[Any]] = {} if keys else {"": []}
        for scores, match in matches:
            group = repr([_shown(self.value(e, match, scores)) for e in keys]) if keys else ""
            groups.setdefault(group, []).append((scores, match))
        return [
            tuple(
                self.aggregate(e, group) if _aggregates(e) else _shown(self.value(e, group[0][1], group[0][0]))
                for e in columns
            )
            for group in groups.values()
        ]

    def aggregate(self, call: Expression, group: list[Any]) -> Any:
        assert isinstance(call, Call)
        if not call.arguments:
            return len(group)
        values = [_shown(self.value(call.arguments[0], match, scores)) for scores, match in group]
        values = [value for value in values if value is not None]
        if call.distinct:
            values = [value for i, value in enumerate(values) if value not in values[:i]]
        if call.function in ("count", "collect"):
            return len(values) if call.function == "count" else values
        if call.function == "sum":
            return sum(values) if all(isinstance(v, int) for v in values) else math.fsum(values)
        if not values:
            return None
        if call.function == "stDev":
            return statistics.stdev(values) if len(values) > 1 else 0.0
        if call.function == "stDevP":
            return statistics.pstdev(values)
        if call.function == "percentileDisc":
            return np.quantile(values, call.arguments[1].value, method="inverted_cdf").item()
        if call.function == "percentileCont":
            return float(np.quantile(values, call.arguments[1].value))
        return {"avg": statistics.fmean, "min": min, "max": max}[call.function](values)


def sort_key(value: Any, descending: bool) -> Any:
    """Missing values last, both ways."""
    if value is None:
        return (1, 0, [])
    if isinstance(value, Node):
        value = value.id
    if isinstance(value, list):
        items = [(-1,) if descending and item is None else sort_key(item, descending) for item in value]
        return (0, 3, items + [(0.5,)] * descending)  # inside a list what is missing is the greatest
    if isinstance(value, str):
        letters = [ord(letter) for letter in value]
        return (0, 0, [-number for number in letters] + [1] if descending else letters)
    return (0, 2, [-value if descending else value])


def _property(thing: Any, name: str) -> Any:
    if thing is None:
        return None
    if isinstance(thing, Node):
        return thing.id if name == "id" else thing.properties.get(name)
    return dict(thing.properties).get(name)


def _shown(value: Any) -> Any:
    return value.id if isinstance(value, Node) else value


def _combined(kind: str, expression: Any, parts: list[Any]) -> Any:
    if kind == "Comparison":
        return compare(expression.operator, *parts)
    if kind == "Not":
        return None if parts[0] is None else not parts[0]
    if kind == "Logic":
        return _logic(expression.operator, parts)
    if kind == "IsNull":
        return (parts[0] is not None) if expression.negated else (parts[0] is None)
    if kind == "ListOf":
        return parts
    if kind == "Negative":
        return None if parts[0] is None else -parts[0]
    if None in parts and not (kind == "Membership" and parts[1] is not None):
        return None
    if kind == "Membership":
        found = [compare("=", parts[0], item) for item in parts[1]]
        return True if True in found else None if None in found else False
    if kind == "TextTest":
        left, right = parts
        return {"STARTS WITH": left.startswith, "ENDS WITH": left.endswith, "CONTAINS": left.__contains__}[
            expression.operator
        ](right)
    return _arithmetic(expression.operator, *parts)


def _logic(operator: str, parts: list[Any]) -> Any:
    if operator == "XOR":
        return None if None in parts else parts.count(True) % 2 == 1
    if operator == "AND":
        return False if False in parts else None if None in parts else True
    return True if True in parts else None if None in parts else False


def _arithmetic(operator: str, a: Any, b: Any) -> Any:
    if operator == "+":
        return a + b
    if operator == "-":
        return a - b
    if operator == "*":
        return a * b
    if operator == "^":
        return float(a) ** float(b)
    if isinstance(a, int) and isinstance(b, int):
        return math.trunc(a / b) if operator == "/" else a - b * math.trunc(a / b)
    return a / b if operator == "/" else math.fmod(a, b)


def _aggregates(expression: Expression) -> bool:
    return isinstance(expression, Call) and expression.function in AGGREGATES


def _resolved(expression: Expression, query: QueryGraph) -> Expression:
    """What ORDER BY means by the name of a column."""
    if isinstance(expression, Variable):
        return next((c.expression for c in query.columns if c.name == expression.name), expression)
    return expression


def _column_of(expression: Expression, query: QueryGraph) -> int:
    wanted = _resolved(expression, query)
    return next(i for i, column in enumerate(query.columns) if column.expression == wanted)


def _first_of_each(rows: list[Any], count: int) -> list[Any]:
    kept: list[Any] = []
    for row in rows:
        if sum(_building(other) == _building(row) for other in kept) < count:
            kept.append(row)
    return kept


def _building(row: Any) -> str:
    return str(row[2][""])


__all__ = ["Literal", "PropertyOf", "Values", "compare", "constraints_hold", "distance", "sort_key"]
