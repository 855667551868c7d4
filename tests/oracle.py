"""A second, plain reading of the question language, to hold the real one against.

It shares only the parser with it. Every node, opening and stored edge of a building becomes a node of one networkx
graph, so that VF2 finds monomorphisms of patterns with parallel edges; everything else is brute force: symmetries by
trying all permutations, overlap by comparing all pairs, paths by walking, distances by the formula.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations, permutations, product
from typing import Any

import networkx as nx
from oracle_relax import near_matches
from oracle_symmetry import description, edges_kept, own, same, same_where
from oracle_values import Values, compare, constraints_hold

from enfilade.queries.query_graph import EdgePattern, NodePattern, Pattern, QueryGraph
from enfilade.queries.syntax import Expression, PropertyOf, Subquery, Variable, children
from enfilade.schema.graph import BuildingGraph, Node

KINDS = {"DOOR": "door", "PASSAGE": "passage", "STAIRS": "stairs", "HATCH": "hatch", "WINDOW": "window"}
UNDIRECTED = ("NEIGHBOUR", "NEAR")

Found = dict[str, Any]
"""A match: names to nodes and edges, None where an option is missing."""


@dataclass(frozen=True)
class StoredEdge:
    """A stored edge as a thing of its own."""

    number: int
    type: str
    properties: tuple[tuple[str, Any], ...]


class Oracle:
    """Answers questions over buildings in memory."""

    def __init__(self, buildings: list[BuildingGraph]) -> None:
        self.buildings = buildings
        self.values = Values(buildings, self.subquery)
        self.wholes = {graph.building: _as_one_graph(graph) for graph in buildings}
        self.query: QueryGraph | None = None

    def rows(self, query: QueryGraph) -> list[tuple[Any, ...]]:
        """The answer, in order."""
        self.query = query
        self.combining = {name for p in (query.pattern, *query.optional) for name in _combining(p)}
        found = [match for graph in self.buildings for match in self.matches_in(query, graph)]
        scores = [(*self.values.score(match, self.likened()), *match.get("miss", ())) for match in found]
        matches = sorted(
            zip(scores, found, strict=True),
            key=lambda pair: (pair[0][2:], -pair[0][0], self.key(pair[1], named_only=False)),
        )
        if not query.keep_all:
            matches = self.without_overlap(matches)
        return self.values.table(query, matches, lambda match: self.key(match, named_only=True))

    def matches_in(self, query: QueryGraph, graph: BuildingGraph) -> list[Found]:
        if query.relax is None:
            found = self.extensions(query.pattern, {"": graph.building})
        else:
            found = near_matches(self, query, graph)
        for clause in query.optional:
            found = [extended for match in found for extended in self.option(clause, match)]
        if query.keep_all:
            return found
        return [match for match in found if self.is_smallest(match)]

    def option(self, clause: Pattern, match: Found) -> list[Found]:
        taken = {id(thing) for thing in match.values() if thing is not None}
        found = []
        for extended in self.extensions(clause, match):
            new = {name: thing for name, thing in extended.items() if name not in match}
            if not taken & {id(thing) for thing in new.values()} and self.segments_once(extended):
                found.append(extended)
        names = [own(clause, n.name) for n in clause.nodes] + [own(clause, e.name) for e in clause.edges if not e.hops]
        return found or [match | {name: None for name in names if name not in match}]

    # One pattern

    def extensions(self, pattern: Pattern, bound: Found) -> list[Found]:
        """Ways to find a pattern in the building of `bound`, its bound nodes where they are, its WHERE true."""
        names = {own(pattern, name) for name in _names(pattern)}
        fixed = {name: bound[name] for name in names if name in bound}
        if any(thing is None for thing in fixed.values()):
            return []
        found = []
        for reading in product(*(_readings(edge) for edge in pattern.edges)):
            for placed in self.placements(pattern, reading, fixed, bound[""]):
                match = bound | placed
                if self.holds(pattern, reading, match) and self.values.value(pattern.where, match) in (True, "all"):
                    found.append(match)
        return found

    def placements(self, pattern: Pattern, reading: Any, fixed: Found, building: str) -> Iterator[Found]:
        wanted = nx.DiGraph()
        for name, thing in fixed.items():
            wanted.add_node(name, test=lambda other, thing=thing: other is thing)
        for node in pattern.nodes:
            name = own(pattern, node.name)
            wanted.add_node(name, test=lambda thing, node=node: self.fits(node, thing, fixed, pattern))
        for edge, way in zip(pattern.edges, reading, strict=True):
            _add_edge(wanted, pattern, edge, way, self)
        whole = self.wholes[building]
        search = nx.isomorphism.DiGraphMatcher(whole, wanted, node_match=lambda a, b: b["test"](a["thing"]))
        keep = {own(pattern, n.name) for n in pattern.nodes} | {own(pattern, e.name) for e in pattern.edges}
        for mapping in search.subgraph_monomorphisms_iter():
            yield {b: whole.nodes[a]["thing"] for a, b in mapping.items() if b in keep}

    def fits(self, node: NodePattern, thing: Any, fixed: Found, pattern: Pattern) -> bool:
        name = own(pattern, node.name)
        if name in fixed:
            if thing is not fixed[name]:
                return False
        elif not isinstance(thing, Node):
            return False
        if node.label is not None and getattr(thing, "label", None) != node.label:
            return False
        if thing.label == "Object" and name not in self.combining and name not in fixed and len(segments(thing)) > 1:
            return False
        if node.likeness is not None and not self.values.is_like(thing, node.likeness):
            return False
        return constraints_hold(node, thing)

    def holds(self, pattern: Pattern, reading: Any, match: Found) -> bool:
        """What VF2 does not look at: arrows of stairs, paths, segments."""
        for edge in pattern.edges:
            left, right = (match[own(pattern, name)] for name in (edge.left, edge.right))
            if edge.direction != "-" and edge.types[0] in KINDS:
                low, high = (left, right) if edge.direction == ">" else (right, left)
                floors = (low.properties.get("floor_elevation"), high.properties.get("floor_elevation"))
                if compare("<", *floors) is not True:
                    return False
            if edge.hops and not self.is_path(edge, left, right, match[""]):
                return False
        names = {own(pattern, name) for name in _names(pattern)}
        return self.segments_once({name: thing for name, thing in match.items() if name in names})

    def segments_once(self, match: Found) -> bool:
        objects = {n: t for n, t in match.items() if isinstance(t, Node) and t.label == "Object"}
        joined = {frozenset(pair) for pair in _part_of_pairs(self.query)}
        return not any(
            segments(a) & segments(b)
            for (x, a), (y, b) in combinations(objects.items(), 2)
            if frozenset((x, y)) not in joined
        )

    def is_path(self, edge: EdgePattern, start: Node, end: Node, building: str) -> bool:
        steps = list(self.steps(edge, building))
        ways = [[start.id]]
        for length in range(1, edge.hops[1] + 1):
            ways = [[*way, b] for way in ways for a, b in steps if a == way[-1] and b not in way]
            if length >= edge.hops[0] and any(way[-1] == end.id for way in ways):
                return True
        return False

    def steps(self, edge: EdgePattern, building: str) -> Iterator[tuple[str, str]]:
        graph = next(graph for graph in self.buildings if graph.building == building)
        if edge.types == ("NEIGHBOUR",):
            pairs = [(e.source, e.target, e) for e in graph.of_type("NEIGHBOUR")]
        else:
            kinds = {KINDS.get(type) for type in edge.types}
            rooms: dict[str, list[str]] = {}
            for opens in graph.of_type("OPENS"):
                rooms.setdefault(opens.target, []).append(opens.source)
            pairs = [
                (*ends, graph.nodes[opening])
                for opening, ends in rooms.items()
                if len(ends) == 2 and (None in kinds or graph.nodes[opening].properties.get("kind") in kinds)
            ]
        for a, b, thing in pairs:
            if constraints_hold(edge, thing):
                yield from ((a, b), (b, a))

    def subquery(self, subquery: Subquery, match: Found) -> bool | int:
        """EXISTS and count, for the evaluation of conditions."""
        found = self.extensions(subquery.pattern, match)
        if subquery.kind == "exists":
            return bool(found)
        pattern = subquery.pattern
        names = [own(pattern, n.name) for n in pattern.nodes] + [own(pattern, e.name) for e in pattern.edges]
        free = [name for name in names if name not in match]
        turns = self.symmetries([pattern], free, lambda names: same_where(pattern.where, pattern.where, names))
        order = _order([pattern])
        kept = [m for m in found if all(_key(m, order, {}) <= _key(m, order, turn) for turn in turns)]
        likened = {own(pattern, n.name): n.likeness for n in pattern.nodes if n.likeness}
        ranked = sorted(kept, key=lambda m: (-self.values.score(m, likened)[0], _key(m, order, {})))
        return len(_best(ranked, likened, order, turns)) if likened else len(ranked)

    # Symmetry and overlap

    def likened(self) -> dict[str, Any]:
        patterns = (self.query.pattern, *self.query.optional)
        return {own(p, n.name): n.likeness for p in patterns for n in p.nodes if n.likeness is not None}

    def question_symmetries(self) -> list[dict[str, str]]:
        query = self.query
        patterns = [query.pattern, *query.optional]
        names = _order(patterns)

        def unchanged(turn: dict[str, str]) -> bool:
            columns = [column.expression for column in query.columns]
            return (
                all(same_where(p.where, p.where, turn) for p in patterns)
                and all(any(same(a, b, turn) for b in columns) for a in columns)
                and all(same(key.expression, key.expression, turn) for key in query.order)
            )

        return self.symmetries(patterns, names, unchanged)

    def symmetries(self, patterns: list[Pattern], free: list[str], unchanged: Any) -> list[dict[str, str]]:
        """All renamings of `free` that leave the patterns the same, and of which `unchanged` says that they do."""
        described = {name: description(patterns, name) for name in free}
        groups: dict[str, list[str]] = {}
        for name in free:
            groups.setdefault(described[name], []).append(name)
        found = []
        for images in product(*(permutations(group) for group in groups.values())):
            turn = {
                a: b
                for group, image in zip(groups.values(), images, strict=True)
                for a, b in zip(group, image, strict=True)
            }
            if all(edges_kept(pattern, turn) for pattern in patterns) and unchanged(turn):
                found.append(turn)
        return found

    def is_smallest(self, match: Found) -> bool:
        order = _order([self.query.pattern, *self.query.optional])
        return all(_key(match, order, {}) <= _key(match, order, turn) for turn in self.cached_symmetries())

    def cached_symmetries(self) -> list[dict[str, str]]:
        if getattr(self, "_for", None) is not self.query:
            self._for, self._turns = self.query, self.question_symmetries()
        return self._turns

    def key(self, match: Found, *, named_only: bool) -> Any:
        patterns = [self.query.pattern, *self.query.optional]
        order = _order(patterns)
        stored = {edge.name for pattern in patterns for edge in pattern.edges if not _opening_types(edge)}
        named = [name for name in order if "#" not in name and name not in stored]
        rest = [] if named_only else [name for name in order if name not in named]
        return _key(match, [*named, *rest], {})

    def without_overlap(self, ranked: list[tuple[Any, Found]]) -> list[tuple[Any, Found]]:
        likened = self.likened()
        if not likened:
            return ranked
        order = _order([self.query.pattern, *self.query.optional])
        kept = _best([match for _, match in ranked], likened, order, self.cached_symmetries())
        return [pair for pair in ranked if any(pair[1] is match for match in kept)]


def segments(thing: Node) -> set[str]:
    named = thing.properties.get("segments")
    building, _, numbers = thing.id.partition("/")
    return set(named) if named is not None else {f"{building}/{number}" for number in numbers.split("+")}


def _as_one_graph(graph: BuildingGraph) -> nx.DiGraph:
    whole = nx.DiGraph()
    for node in graph.nodes.values():
        whole.add_node(node.id, thing=node)
    for number, edge in enumerate(graph.edges):
        whole.add_node(number, thing=StoredEdge(number, edge.type, tuple(sorted(edge.properties.items(), key=str))))
        whole.add_edge(edge.source, number)
        whole.add_edge(number, edge.target)
    return whole


def _opening_types(edge: EdgePattern) -> frozenset[str]:
    return frozenset(type for type in edge.types if type in KINDS or type == "OPENING")


def _readings(edge: EdgePattern) -> list[tuple[str, frozenset[str], bool]]:
    """What an edge may be: an opening of some kinds, or a stored edge of a type, ahead or back."""
    if edge.hops:
        return [("path", frozenset(), False)]
    openings = _opening_types(edge)
    found = [("opening", openings, False)] if openings else []
    for type in edge.types:
        if type not in openings:
            ways = {"-": (False, True), ">": (False,), "<": (True,)}[edge.direction]
            found += [("stored", frozenset([type]), back) for back in ways]
    return found


def _add_edge(wanted: nx.DiGraph, pattern: Pattern, edge: EdgePattern, way: Any, oracle: Oracle) -> None:
    form, types, back = way
    left, right, name = (own(pattern, part) for part in (edge.left, edge.right, edge.name))
    if form == "path":
        return
    if form == "stored":
        (type,) = types

        def is_edge(thing: Any) -> bool:
            return isinstance(thing, StoredEdge) and thing.type == type and constraints_hold(edge, thing)

        wanted.add_node(name, test=is_edge)
        wanted.add_edge(*((name, left) if back else (left, name)))
        wanted.add_edge(*((right, name) if back else (name, right)))
        return
    kinds = {KINDS.get(type) for type in types}
    before = wanted.nodes[name]["test"] if name in wanted else lambda thing: True

    def is_opening(thing: Any) -> bool:
        if not isinstance(thing, Node) or thing.label != "Opening" or not constraints_hold(edge, thing):
            return False
        return before(thing) and (None in kinds or thing.properties.get("kind") in kinds)

    wanted.add_node(name, test=is_opening)
    for side, room in (("left", left), ("right", right)):
        wanted.add_node(f"{name} {side}", test=lambda t: isinstance(t, StoredEdge) and t.type == "OPENS")
        wanted.add_edge(room, f"{name} {side}")
        wanted.add_edge(f"{name} {side}", name)


def _names(pattern: Pattern) -> set[str]:
    """Names that a pattern mentions anywhere; those without a name are among its own nodes."""
    names = {node.name for node in pattern.nodes} | {edge.name for edge in pattern.edges if edge.named}
    return names | (set() if pattern.where is None else set(_mentioned(pattern.where)))


def _mentioned(expression: Expression) -> Iterator[str]:
    if isinstance(expression, Variable):
        yield expression.name
    if isinstance(expression, PropertyOf):
        yield expression.variable
    if isinstance(expression, Subquery):
        yield from (name for name in _names(expression.pattern) if not name.startswith("#"))
    for child in children(expression):
        yield from _mentioned(child)


def _combining(pattern: Pattern) -> Iterator[str]:
    for node in pattern.nodes:
        if node.likeness or any(entry.property in ("parts", "id", "segments") for entry in node.constraints):
            yield own(pattern, node.name)
    for edge in pattern.edges:
        if "PART_OF" in edge.types:
            yield from (own(pattern, edge.left), own(pattern, edge.right))
    if pattern.where is not None:
        yield from _combining_in(pattern.where)


def _combining_in(expression: Expression) -> Iterator[str]:
    if isinstance(expression, PropertyOf) and expression.name in ("parts", "id", "segments"):
        yield expression.variable
    if isinstance(expression, Subquery):
        yield from _combining(expression.pattern)
    for child in children(expression):
        yield from _combining_in(child)


def _part_of_pairs(query: QueryGraph) -> Iterator[tuple[str, str]]:
    todo: list[Any] = [query.pattern, *query.optional]
    while todo:
        thing = todo.pop()
        if isinstance(thing, Pattern):
            yield from ((own(thing, e.left), own(thing, e.right)) for e in thing.edges if "PART_OF" in e.types)
            todo += [] if thing.where is None else [thing.where]
        else:
            todo += [thing.pattern] if isinstance(thing, Subquery) else list(children(thing))


def _order(patterns: list[Pattern]) -> list[str]:
    """Nodes and named edges as they appear in the text, then the edges without a name, pattern by pattern."""
    order: list[str] = []
    for pattern in patterns:
        nodes = [node.name for node in pattern.nodes]
        for edge in pattern.edges:
            upto = nodes.index(edge.left) + 1
            order += [own(pattern, name) for name in nodes[:upto]]
            order += [edge.name] if edge.named else []
            order += [own(pattern, name) for name in nodes[: nodes.index(edge.right) + 1]]
        order += [own(pattern, name) for name in nodes]
        order += [own(pattern, edge.name) for edge in pattern.edges if not edge.hops]
    return list(dict.fromkeys(order))


def _key(match: Found, order: list[str], turn: dict[str, str]) -> Any:
    return [_rank(match.get(turn.get(name, name))) for name in order]


def _rank(thing: Any) -> Any:
    if thing is None:
        return (2, "")
    return (0, thing.id) if isinstance(thing, Node) else (1, thing.number)


def _best(ranked: list[Found], likened: dict[str, Any], order: list[str], turns: list[dict[str, str]]) -> list[Found]:
    """Matches that overlap no better one."""
    kept: list[Found] = []
    for match in ranked:
        if not any(_overlap(match, other, likened, order, turn) for other in kept for turn in ({}, *turns)):
            kept.append(match)
    return kept


def _overlap(a: Found, b: Found, likened: dict[str, Any], order: list[str], turn: dict[str, str]) -> bool:
    for name in order:
        mine, other = a.get(name), b.get(turn.get(name, name))
        if name in likened and mine is not None and other is not None:
            if not segments(mine) & segments(other):
                return False
        elif _node_only(mine) is not _node_only(other):
            return False
    return True


def _node_only(thing: Any) -> Any:
    return thing if isinstance(thing, Node) else None
