"""Symmetries of a question: renamings of its nodes and edges that leave it the same question.

Matches that differ only by such a renaming are one match. The one kept has the smallest ids in order of appearance.
As the elements of a match are distinct, that is the same as one comparison a symmetry: of the first element that it
moves with the one it moves it to.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from enfilade.errors import UnsupportedError

from .binding import free_variables
from .canonical import canonical, described_edge, described_node, ends_between
from .kinds import Scope, scope_of, whole_scope
from .query_graph import EdgePattern, Pattern, QueryGraph
from .syntax import Expression, conjuncts

Symmetry = dict[str, str]
"""Where each element goes, by name: nodes and edges."""

MOST_SYMMETRIES: Final = 50_000
"""A question that needs all its symmetries and has more than this is refused."""

MOST_TRIES: Final = 200_000
"""Steps of a search for symmetries after which the question is refused."""


def order_of_appearance(pattern: Pattern) -> list[str]:
    """Names of nodes and named edges in the order of the text, then those of the other edges; paths are no elements."""
    nodes = [node.name for node in pattern.nodes]
    place = {name: i for i, name in enumerate(nodes)}
    order: dict[str, None] = {}
    for edge in pattern.edges:
        order |= dict.fromkeys(nodes[: place[edge.left] + 1])
        if edge.named:
            order[edge.name] = None
        order |= dict.fromkeys(nodes[: place[edge.right] + 1])
    order |= dict.fromkeys(nodes)
    return [*order, *(edge.name for edge in pattern.edges if edge.name not in order and edge.hops is None)]


def question_symmetries(query: QueryGraph) -> list[Symmetry]:
    """Symmetries of a whole question, without the identity: all where they are needed, else enough of them.

    Enough to tell which of symmetric matches to keep: for each element and each other that it can be exchanged with
    while all before it stay, one symmetry that does so. Ten like rooms have 45 of these and 3.6 million in all.
    """
    scope = whole_scope(query)
    patterns = [query.pattern, *query.optional]
    columns = [column.expression for column in query.columns]
    sides = [_Side(conjuncts(pattern.where)) for pattern in patterns]
    sides += [_Side(columns), *(_Side([key.expression]) for key in query.order)]
    search = _Search(patterns, {}, sides, scope)
    if query.optional or query.relax is not None or _likened(patterns):
        return search.all()
    return search.enough(order_of_appearance(query.pattern))


def inner_symmetries(pattern: Pattern, outer: Scope) -> list[Symmetry]:
    """Symmetries of the pattern of ``count { }``, as `question_symmetries`; what is outside stays where it is."""
    scope = scope_of(pattern, outer)
    search = _Search([pattern], outer, [_Side(conjuncts(pattern.where))], scope)
    own = [name for name in order_of_appearance(pattern) if name not in outer]
    return search.all() if _likened([pattern]) else search.enough(own)


def smaller_first(order: Sequence[str], symmetries: Sequence[Symmetry]) -> list[tuple[str, str]]:
    """Return pairs of elements of which the first must have the smaller id, for the match to be kept."""
    pairs: dict[tuple[str, str], None] = {}
    for symmetry in symmetries:
        first = next((name for name in order if symmetry.get(name, name) != name), None)
        if first is not None:
            pairs[first, symmetry[first]] = None
    return list(pairs)


def _likened(patterns: Sequence[Pattern]) -> bool:
    return any(node.likeness is not None for pattern in patterns for node in pattern.nodes)


@dataclass(frozen=True, slots=True)
class _Side:
    """Expressions that a symmetry may exchange with one another: a WHERE, the columns; each sort key is one alone."""

    expressions: Sequence[Expression]

    def under(self, names: Symmetry, scope: Scope) -> frozenset[str]:
        return frozenset(canonical(expression, names, scope) for expression in self.expressions)


@dataclass(frozen=True, slots=True)
class _Edge:
    """An edge with what it is, the clause that it stands in included."""

    pattern: EdgePattern
    what: str

    @property
    def ends(self) -> tuple[str, str]:
        return self.pattern.left, self.pattern.right

    def between(self, names: Symmetry) -> str:
        return f"{ends_between(self.pattern, names)} {self.what}"


class _Search:
    """Backtracking over the nodes, likes with likes; edges and conditions are looked at as soon as they can be."""

    def __init__(self, patterns: Sequence[Pattern], outer: Scope, sides: Sequence[_Side], scope: Scope) -> None:
        self._scope = scope
        self._edges = [
            _Edge(edge, f"{i} {described_edge(edge)}") for i, pattern in enumerate(patterns) for edge in pattern.edges
        ]
        self._sides = [(side, side.under({}, scope)) for side in sides]
        names: dict[str, str] = {}
        for i, pattern in enumerate(patterns):
            for node in pattern.nodes:
                if node.name not in outer:
                    names[node.name] = names.get(node.name, "") + f"{i}{described_node(node)}"
        self._edges_at = {name: [edge for edge in self._edges if name in edge.ends] for name in names}
        self._said_of = self._saying(names)
        self._colours = self._refined(names)
        self._tries = 0

    def all(self) -> list[Symmetry]:
        """Return every symmetry but the identity."""
        found = []
        for symmetry in self._symmetries({}):
            if any(name != other for name, other in symmetry.items()):
                found.append(symmetry)
            if len(found) > MOST_SYMMETRIES:
                raise self._too_many()
        return found

    def enough(self, order: Sequence[str]) -> list[Symmetry]:
        """Return one symmetry for each element and each image that it can have while all before it stay.

        From the last element to the first (Schreier, Sims): what was found for later ones leaves all before them where
        they are, and leads to most images of this one.
        """
        around = {name: f"node {colour}" for name, colour in self._colours.items()}
        around |= {edge.pattern.name: f"edge {edge.between(self._colours)}" for edge in self._edges}
        known: list[Symmetry] = []
        found: list[list[Symmetry]] = []
        for i, name in reversed(list(enumerate(order))):
            fixed = {before: before for before in order[:i]}
            reached = _spread({name: {}}, known)
            for image in order[i + 1 :]:
                if image not in reached and around[image] == around[name]:
                    new = next(self._symmetries({**fixed, name: image}), None)
                    if new is not None:
                        known.append(new)
                        reached = _spread(reached, known)
            found.append([reached[image] for image in order[i + 1 :] if image in reached])
        return [symmetry for level in reversed(found) for symmetry in level]

    def _saying(self, names: Collection[str]) -> dict[str, list[tuple[Expression, frozenset[str], frozenset[str]]]]:
        """By node: the expressions that speak of it, of which nodes each speaks, and the texts of its side.

        One that speaks of a named edge is looked at when all nodes are placed.
        """
        edges = {edge.pattern.name for edge in self._edges}
        said: dict[str, list[tuple[Expression, frozenset[str], frozenset[str]]]] = {name: [] for name in names}
        for side, texts in self._sides:
            for expression in side.expressions:
                free = set(free_variables(expression))
                for name in free & said.keys() if not free & edges else ():
                    said[name].append((expression, frozenset(free & said.keys()), texts))
        return said

    def _refined(self, colours: dict[str, str]) -> dict[str, str]:
        for _ in range(len(colours)):
            texts = {name: f"{colour}{self._around(name, colours)}" for name, colour in colours.items()}
            ranks = {text: f"<{i}>" for i, text in enumerate(sorted(set(texts.values())))}
            colours, before = {name: ranks[text] for name, text in texts.items()}, colours
            if len(set(colours.values())) == len(set(before.values())):
                break
        return colours

    def _around(self, name: str, colours: dict[str, str]) -> list[str]:
        """Return what a node is among: its edges, and what is said of it and others."""
        own = {**colours, name: "?"}
        edges = [edge.between(own) for edge in self._edges_at[name]]
        return sorted(edges + [canonical(expression, own, self._scope) for expression, _, _ in self._said_of[name]])

    def _symmetries(self, pinned: Symmetry) -> Iterator[Symmetry]:
        """Yield the symmetries under which the pinned elements go where they are pinned to."""
        names = sorted(self._colours, key=lambda name: name not in pinned)
        for nodes in self._placements(names, {}, pinned):
            yield from self._with_edges(nodes, pinned)

    def _placements(self, rest: Sequence[str], placed: Symmetry, pinned: Symmetry) -> Iterator[Symmetry]:
        self._tries += 1
        if self._tries > MOST_TRIES:
            raise self._too_many()
        if not rest:
            yield placed
            return
        name, *others = rest
        taken = set(placed.values())
        for image in [pinned[name]] if name in pinned else self._colours:
            if self._colours[image] == self._colours[name] and image not in taken:
                extended = {**placed, name: image}
                if self._keeps(name, image, extended):
                    yield from self._placements(others, extended, pinned)

    def _keeps(self, name: str, image: str, placed: Symmetry) -> bool:
        """Whether a node's edges to the placed nodes go to those of its image, and what is said of them stays said."""
        images = set(placed.values())
        here = [edge for edge in self._edges_at[name] if self._settled(edge, placed.keys())]
        there = [edge for edge in self._edges_at[image] if self._settled(edge, images)]
        if Counter(edge.between(placed) for edge in here) != Counter(edge.between({}) for edge in there):
            return False
        return all(
            canonical(expression, placed, self._scope) in texts
            for expression, about, texts in self._said_of[name]
            if about <= placed.keys()
        )

    def _settled(self, edge: _Edge, names: Collection[str]) -> bool:
        """Whether both ends of an edge are placed, or cannot be."""
        return all(end in names or end not in self._colours for end in edge.ends)

    def _with_edges(self, nodes: Symmetry, pinned: Symmetry) -> Iterator[Symmetry]:
        """Yield each way in which the edges go along; there are several where edges are parallel."""
        targets: dict[str, list[str]] = {}
        for edge in self._edges:
            targets.setdefault(edge.between({}), []).append(edge.pattern.name)
        choices = [(edge.pattern.name, targets[edge.between(nodes)]) for edge in self._edges]
        choices.sort(key=lambda choice: choice[0] not in pinned)
        for edges in _assigned(choices, pinned, {}):
            self._tries += 1
            if self._tries > MOST_TRIES:
                raise self._too_many()
            names = {**nodes, **edges}
            agrees = all(nodes.get(name, image) == image for name, image in edges.items())
            if agrees and all(side.under(names, self._scope) == texts for side, texts in self._sides):
                yield names

    @staticmethod
    def _too_many() -> UnsupportedError:
        return UnsupportedError("the question has too many symmetries; tell its nodes apart or say RETURN ALL.")


def _assigned(choices: Sequence[tuple[str, list[str]]], pinned: Symmetry, chosen: Symmetry) -> Iterator[Symmetry]:
    """Yield each way to give every name an image of its own among its choices."""
    if not choices:
        yield chosen
        return
    (name, images), *others = choices
    taken = set(chosen.values())
    for image in images:
        if image not in taken and pinned.get(name, image) == image:
            yield from _assigned(others, pinned, {**chosen, name: image})


def _spread(reached: dict[str, Symmetry], known: Sequence[Symmetry]) -> dict[str, Symmetry]:
    """Return a symmetry to each image that the known ones lead to from those reached."""
    reached = dict(reached)
    waiting = list(reached)
    while waiting:
        image = waiting.pop()
        for symmetry in known:
            following = symmetry.get(image, image)
            if following not in reached:
                reached[following] = _composed(reached[image], symmetry)
                waiting.append(following)
    return reached


def _composed(first: Symmetry, then: Symmetry) -> Symmetry:
    images = {name: first.get(name, name) for name in then}
    return {name: then.get(image, image) for name, image in images.items()}
