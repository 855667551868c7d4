"""A pattern spelled out for a store: openings as nodes, one edge type an edge, and everything that must differ.

An edge that may be of several stored types makes several expansions; their matches together are those of the pattern.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise, product

from enfilade.schema.definition import EDGES

from .binding import free_variables
from .kinds import Scope
from .query_graph import Constraint, EdgePattern, Likeness, NodePattern, Pattern, QueryGraph
from .syntax import PropertyOf, Subquery, walk
from .vocabulary import COMBINING, OPENING_EDGES, end_labels


@dataclass(frozen=True, slots=True)
class Point:
    """A node to be found, or one that is given from outside.

    `single` asks for single segments only.
    """

    name: str
    label: str
    constraints: tuple[Constraint, ...] = ()
    likeness: Likeness | None = None
    single: bool = False
    given: bool = False


@dataclass(frozen=True, slots=True)
class Link:
    """A stored edge to be found, from `source` to `target`, or also the other way if `either`.

    `hidden` edges join a room to the opening behind ``-[:DOOR]-``; nothing is asked of them.
    """

    name: str
    type: str
    source: str
    target: str
    either: bool = False
    constraints: tuple[Constraint, ...] = ()
    hidden: bool = False


@dataclass(frozen=True, slots=True)
class Route:
    """A path of `low` to `high` openings of some kinds (None: any), or of neighbours, between two rooms."""

    left: str
    right: str
    kinds: tuple[str, ...] | None
    neighbours: bool
    low: int
    high: int
    constraints: tuple[Constraint, ...]


@dataclass(frozen=True, slots=True)
class Expansion:
    """What a store is asked for.

    Attributes
    ----------
    points, links, routes
        Nodes, edges, paths.
    kinds
        Kinds that an opening may have, by name.
    climbs
        Pairs of rooms of which the second has the higher floor.
    apart
        Pairs of names that must not be the same node or edge.
    exclusive
        Pairs of objects that must share no segment.
    together
        Pairs of nodes that must lie in one building, though no edge joins them.
    """

    points: tuple[Point, ...]
    links: tuple[Link, ...]
    routes: tuple[Route, ...]
    kinds: dict[str, tuple[str, ...]]
    climbs: tuple[tuple[str, str], ...]
    apart: tuple[tuple[str, str], ...]
    exclusive: tuple[tuple[str, str], ...]
    together: tuple[tuple[str, str], ...]


def expansions(
    pattern: Pattern,
    outer: Scope,
    combining: frozenset[str],
    beside: str | None = None,
    sharing: frozenset[frozenset[str]] = frozenset(),
) -> list[Expansion]:
    """Spell out a pattern.

    Parameters
    ----------
    pattern
        Resolved and bound.
    outer
        What the names from outside mean; the nodes among them are given.
    combining
        Names of objects that may be combinations.
    beside
        A node from outside in whose building the matches lie, where the pattern names none.
    sharing
        Pairs of objects that may share segments, beside those that the pattern joins by PART_OF.
    """
    given = given_nodes(pattern, outer)
    choices = product(*(_readings(edge, pattern) for edge in pattern.edges))
    return [_Spelling(pattern, outer, combining, given, beside, sharing).out(choice) for choice in choices]


def given_nodes(pattern: Pattern, outer: Scope) -> tuple[str, ...]:
    """Names of the nodes from outside that a pattern mentions anywhere, in order."""
    names = [node.name for node in pattern.nodes]
    names += [] if pattern.where is None else list(free_variables(pattern.where))
    return tuple(name for name in dict.fromkeys(names) if name in outer and outer[name].is_node)


def combining_objects(query: QueryGraph) -> frozenset[str]:
    """Names of objects that are likened, joined by PART_OF, or have a condition on parts, id or segments."""
    return frozenset(name for pattern in (query.pattern, *query.optional) for name in _combining(pattern))


def _combining(pattern: Pattern) -> Iterator[str]:
    for node in pattern.nodes:
        if node.likeness is not None or any(c.property in COMBINING for c in node.constraints):
            yield node.name
    for edge in pattern.edges:
        if "PART_OF" in edge.types:
            yield from (edge.left, edge.right)
    for part in () if pattern.where is None else walk(pattern.where):
        if isinstance(part, PropertyOf) and part.name in COMBINING:
            yield part.variable
        if isinstance(part, Subquery):
            yield from _combining(part.pattern)


def _readings(edge: EdgePattern, pattern: Pattern) -> list[tuple[str, ...]]:
    """Types that one expansion may read an edge as: all openings at once, stored types one by one."""
    openings = tuple(type for type in edge.types if type in OPENING_EDGES)
    left, right = pattern.node(edge.left), pattern.node(edge.right)
    assert left is not None
    assert right is not None
    labels = (str(left.label), str(right.label))
    stored = [(type,) for type in edge.types if type not in OPENING_EDGES]
    readings = [openings, *stored] if openings else stored
    return [types for types in readings if labels in end_labels(types[0], edge.direction)]


class _Spelling:
    """One expansion in the making."""

    def __init__(
        self,
        pattern: Pattern,
        outer: Scope,
        combining: frozenset[str],
        given: Sequence[str],
        beside: str | None,
        sharing: frozenset[frozenset[str]],
    ) -> None:
        self._pattern = pattern
        self._outer = outer
        self._combining = combining
        self._beside = beside
        self._sharing = sharing
        self._points = {name: self._given_point(name) for name in given}
        for node in pattern.nodes:
            self._points[node.name] = self._point(node)
        self._links: list[Link] = []
        self._routes: list[Route] = []
        self._kinds: dict[str, tuple[str, ...]] = {}
        self._climbs: list[tuple[str, str]] = []

    def out(self, readings: Iterable[tuple[str, ...]]) -> Expansion:
        for edge, types in zip(self._pattern.edges, readings, strict=True):
            self._add_edge(edge, types)
        points = tuple(self._points.values())
        return Expansion(
            points,
            tuple(self._links),
            tuple(self._routes),
            self._kinds,
            tuple(self._climbs),
            (*_apart(points), *_parallel(self._links)),
            tuple(self._exclusive(points)),
            tuple(self._together(points)),
        )

    def _given_point(self, name: str) -> Point:
        label = self._outer[name].label
        assert label is not None
        return Point(name, label, given=True)

    def _point(self, node: NodePattern) -> Point:
        assert node.label is not None
        given = node.name in self._outer
        single = node.label == "Object" and node.name not in self._combining and not given
        return Point(node.name, node.label, node.constraints, node.likeness, single, given)

    def _add_edge(self, edge: EdgePattern, types: tuple[str, ...]) -> None:
        is_opening = types[0] in OPENING_EDGES
        if edge.hops is not None:
            kinds = _kinds(types) if is_opening else None
            self._routes.append(Route(edge.left, edge.right, kinds, not is_opening, *edge.hops, edge.constraints))
        elif is_opening:
            self._add_opening(edge, types)
        else:
            self._add_link(edge, types[0])

    def _add_opening(self, edge: EdgePattern, types: tuple[str, ...]) -> None:
        known = self._points.get(edge.name, Point(edge.name, "Opening"))
        self._points[edge.name] = Point(edge.name, "Opening", (*known.constraints, *edge.constraints))
        kinds = _kinds(types)
        if kinds is not None:
            self._kinds[edge.name] = kinds
        for side, room in (("left", edge.left), ("right", edge.right)):
            self._links.append(Link(f"{edge.name} {side}", "OPENS", room, edge.name, hidden=True))
        if edge.direction != "-":
            self._climbs.append((edge.left, edge.right) if edge.direction == ">" else (edge.right, edge.left))

    def _add_link(self, edge: EdgePattern, type: str) -> None:
        source, target = (edge.right, edge.left) if edge.direction == "<" else (edge.left, edge.right)
        ends = (self._points[source].label, self._points[target].label)
        if ends not in EDGES[type].ends:
            source, target = target, source
        either = edge.direction == "-" and ends[0] == ends[1]
        self._links.append(Link(edge.name, type, source, target, either, edge.constraints))

    def _exclusive(self, points: Sequence[Point]) -> Iterator[tuple[str, str]]:
        """Pairs of objects, one of which may be a combination, that the question does not join by PART_OF."""
        joined = {frozenset((link.source, link.target)) for link in self._links if link.type == "PART_OF"}
        joined |= self._sharing
        for a, b in combinations([point for point in points if point.label == "Object"], 2):
            may_share = a.name in self._combining or b.name in self._combining
            if may_share and not (a.given and b.given) and frozenset((a.name, b.name)) not in joined:
                yield a.name, b.name

    def _together(self, points: Sequence[Point]) -> Iterator[tuple[str, str]]:
        """Tie the parts of a pattern that no edge joins; a path does not lead a store to its other end."""
        part = {point.name: point.name for point in points}
        ties = [(link.source, link.target) for link in self._links]
        given = [point.name for point in points if point.given]
        for a, b in (*ties, *pairwise(given)):
            old, new = part[b], part[a]
            part = {name: new if root == old else root for name, root in part.items()}
        first: dict[str, str] = {}
        for name, root in part.items():
            first.setdefault(root, name)
        ends = list(first.values())
        if self._beside is not None and not given:
            ends.insert(0, self._beside)
        yield from pairwise(ends)


def _kinds(types: Iterable[str]) -> tuple[str, ...] | None:
    kinds = [OPENING_EDGES[type] for type in types]
    return None if None in kinds else tuple(kind for kind in kinds if kind is not None)


def _apart(points: Sequence[Point]) -> Iterator[tuple[str, str]]:
    for a, b in combinations(points, 2):
        if a.label == b.label and not (a.given and b.given):
            yield a.name, b.name


def _parallel(links: Sequence[Link]) -> Iterator[tuple[str, str]]:
    """Pairs of edges that could be the same stored one."""
    for a, b in combinations(links, 2):
        same = (a.source, a.target) == (b.source, b.target)
        turned = (a.either or b.either) and (a.source, a.target) == (b.target, b.source)
        if a.type == b.type and (same or turned):
            yield a.name, b.name
