"""The oracle's near misses: every way to place the nodes and some of the edges, every condition tested on each."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from typing import Any

from oracle_symmetry import _flat, own
from oracle_values import constraints_hold

from enfilade.queries.query_graph import EdgePattern, Equal, NodePattern, Pattern, QueryGraph

Found = dict[str, Any]


def near_matches(oracle: Any, query: QueryGraph, graph: Any) -> list[Found]:
    """Matches with as many conditions unmet as RELAX says; ``unmet`` and ``miss`` stand among their names."""
    pattern, most = query.pattern, query.relax.value
    found = []
    for size in range(most + 1):
        for missing in combinations(pattern.edges, size):
            for match in oracle.extensions(_bare(pattern, missing), {"": graph.building}):
                for edge in missing:
                    if not edge.hops:
                        match.setdefault(own(pattern, edge.name), None)
                said = list(_tested(oracle, pattern, missing, match))
                unmet = [number for number, far in said if far is not None]
                if len(unmet) <= most:
                    far = round(sum(far for _, far in said if far is not None), 6)
                    found.append((match | {"unmet": unmet, "miss": (len(unmet), far)}, set(map(id, missing))))
    return [
        match
        for match, missing in found
        if not any(
            other_missing < missing
            and len(other["unmet"]) <= len(match["unmet"])
            and all(other[name] is thing for name, thing in match.items() if name in _kept(pattern, missing))
            for other, other_missing in found
        )
    ]


def _kept(pattern: Pattern, missing: set[int]) -> set[str]:
    nodes = {own(pattern, node.name) for node in pattern.nodes}
    return nodes | {own(pattern, edge.name) for edge in pattern.edges if id(edge) not in missing}


def _bare(pattern: Pattern, missing: tuple[EdgePattern, ...]) -> Pattern:
    nodes = tuple(
        replace(
            node,
            label=_label(node, pattern),
            constraints=(),
            likeness=node.likeness and replace(node.likeness, within=None),
        )
        for node in pattern.nodes
    )
    edges = tuple(
        edge if edge.hops else replace(edge, constraints=())
        for edge in pattern.edges
        if not any(edge is other for other in missing)
    )
    made = Pattern(nodes, edges)
    object.__setattr__(made, "made_from", pattern)
    return made


def _label(node: NodePattern, pattern: Pattern) -> str:
    """The label stays when the edges that tell it go; here only storeys have none of their own."""
    assert node.label or any("HAS_STOREY" in e.types and e.right == node.name for e in pattern.edges)
    return node.label or "Storey"


def _tested(oracle: Any, pattern: Pattern, missing: tuple[EdgePattern, ...], match: Found) -> Any:
    """Yield for each condition its number and how far off it is, None where it holds."""
    number = -1
    for node in pattern.nodes:
        thing = match[own(pattern, node.name)]
        for entry in node.constraints:
            number += 1
            holds = constraints_hold(replace(node, constraints=(entry,)), thing)
            yield number, None if holds else _off(entry, _value(thing, entry.property))
        if node.likeness is not None and node.likeness.within is not None:
            number += 1
            excess = oracle.values.distance_to(thing, node.likeness.reference) - node.likeness.within.value
            yield number, None if excess <= 0 else excess
    for edge in pattern.edges:
        number += 1
        is_missing = any(edge is other for other in missing)
        yield number, 1.0 if is_missing else None
        for entry in edge.constraints if not edge.hops else ():
            number += 1
            if not is_missing:
                thing = match[own(pattern, edge.name)]
                holds = constraints_hold(replace(edge, constraints=(entry,)), thing)
                yield number, None if holds else _off(entry, _value(thing, entry.property))
    for part in _flat(pattern.where, "AND") if pattern.where is not None else ():
        number += 1
        yield number, None if _evaluated(oracle, part, match) is True else _off_part(oracle, part, match)


def _value(thing: Any, name: str) -> Any:
    return thing.id if name == "id" else dict(thing.properties).get(name)


def _evaluated(oracle: Any, expression: Any, match: Found) -> Any:
    try:
        return oracle.values.value(expression, match)
    except ZeroDivisionError:
        return None


def _off_part(oracle: Any, part: Any, match: Found) -> float:
    if type(part).__name__ != "Comparison" or part.operator == "<>":
        return 1.0
    return _relative(*(_evaluated(oracle, side, match) for side in (part.left, part.right)))


def _off(entry: Any, value: Any) -> float:
    if isinstance(entry, Equal):
        return _relative(value, entry.value.value)
    return min(_relative(value, end.value) for end in (entry.low, entry.high) if end is not None)


def _relative(a: Any, b: Any) -> float:
    if isinstance(a, bool | str) or isinstance(b, bool | str) or a is None or b is None or not hasattr(a, "real"):
        return 1.0
    return 0.0 if a == b else min(1.0, abs(a - b) / max(abs(a), abs(b)))
