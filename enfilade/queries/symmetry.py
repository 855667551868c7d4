"""Symmetries of a question: renamings of its nodes and edges that leave it the same question.

Matches that differ only by such a renaming are one match. The one kept has the smallest ids in order of appearance.
As the elements of a match are distinct, that is the same as one comparison a symmetry: of the first element that it
moves with the one it moves it to.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import permutations, product
from typing import Final

from enfilade.errors import UnsupportedError

from .binding import free_variables
from .canonical import canonical, described_node, edge_between
from .kinds import Scope, scope_of, whole_scope
from .query_graph import EdgePattern, Pattern, QueryGraph
from .syntax import Expression, conjuncts

Symmetry = dict[str, str]
"""Where each element goes, by name: nodes and edges."""

MOST_SYMMETRIES: Final = 50_000
"""A question with more symmetries than this is refused."""


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
    """Symmetries of a whole question, without the identity."""
    scope = whole_scope(query)
    sides = [_conditions(pattern, scope) for pattern in (query.pattern, *query.optional)]
    columns = [column.expression for column in query.columns]
    sides.append(lambda names: frozenset(canonical(e, names, scope) for e in columns))
    sides.append(lambda names: [(canonical(k.expression, names, scope), k.descending) for k in query.order])
    single = [e for p in (query.pattern, *query.optional) for e in conjuncts(p.where)]
    hints = [*single, *columns, *(key.expression for key in query.order)]
    return _Search([query.pattern, *query.optional], {}, hints, sides, scope).run()


def inner_symmetries(pattern: Pattern, outer: Scope) -> list[Symmetry]:
    """Symmetries of the pattern of ``count { }``, without the identity; what is outside stays where it is."""
    scope = scope_of(pattern, outer)
    return _Search([pattern], outer, list(conjuncts(pattern.where)), [_conditions(pattern, scope)], scope).run()


def smaller_first(order: Sequence[str], symmetries: Sequence[Symmetry]) -> list[tuple[str, str]]:
    """Return pairs of elements of which the first must have the smaller id, for the match to be kept."""
    pairs: dict[tuple[str, str], None] = {}
    for symmetry in symmetries:
        first = next((name for name in order if symmetry.get(name, name) != name), None)
        if first is not None:
            pairs[first, symmetry[first]] = None
    return list(pairs)


def _conditions(pattern: Pattern, scope: Scope) -> Callable[[Symmetry], object]:
    parts = conjuncts(pattern.where)
    return lambda names: frozenset(canonical(part, names, scope) for part in parts)


@dataclass(frozen=True, slots=True)
class _Edge:
    """An edge with the clause that it stands in."""

    clause: int
    pattern: EdgePattern

    def between(self, names: Symmetry) -> str:
        return f"{self.clause} {edge_between(self.pattern, names)}"


class _Search:
    """Backtracking over the nodes, likes with likes; the conditions are looked at when all are placed."""

    def __init__(
        self,
        patterns: Sequence[Pattern],
        outer: Scope,
        hints: Sequence[Expression],
        sides: Sequence[Callable[[Symmetry], object]],
        scope: Scope,
    ) -> None:
        self._edges = [_Edge(i, edge) for i, pattern in enumerate(patterns) for edge in pattern.edges]
        self._sides = [(side, side({})) for side in sides]
        names: dict[str, str] = {}
        for i, pattern in enumerate(patterns):
            for node in pattern.nodes:
                if node.name in outer:
                    continue
                names[node.name] = names.get(node.name, "") + f"{i}{described_node(node)}"
        self._colours = self._refined({name: f"{text}{_alone(name, hints, scope)}" for name, text in names.items()})
        self._found: list[Symmetry] = []

    def run(self) -> list[Symmetry]:
        self._place(list(self._colours), {})
        return [found for found in self._found if any(name != other for name, other in found.items())]

    def _refined(self, colours: dict[str, str]) -> dict[str, str]:
        for _ in range(len(colours)):
            around = {
                name: sorted(e.between(colours) for e in self._edges if name in (e.pattern.left, e.pattern.right))
                for name in colours
            }
            texts = {name: f"{colour}{around[name]}" for name, colour in colours.items()}
            ranks = {text: f"<{i}>" for i, text in enumerate(sorted(set(texts.values())))}
            colours = {name: ranks[text] for name, text in texts.items()}
        return colours

    def _place(self, rest: list[str], placed: Symmetry) -> None:
        if not rest:
            self._finish(placed)
            return
        name, *others = rest
        taken = set(placed.values())
        for image, colour in self._colours.items():
            if colour == self._colours[name] and image not in taken:
                extended = {**placed, name: image}
                if self._keeps_edges(extended):
                    self._place(others, extended)

    def _keeps_edges(self, placed: Symmetry) -> bool:
        """Whether the edges among the placed nodes go to edges among their images."""
        images = set(placed.values())
        free = self._colours.keys()
        here = [e for e in self._edges if _settled(e, placed.keys(), free)]
        there = [e for e in self._edges if _settled(e, images, free)]
        return Counter(e.between(placed) for e in here) == Counter(e.between({}) for e in there)

    def _finish(self, nodes: Symmetry) -> None:
        for edges in self._edge_images(nodes):
            names = {**nodes, **edges}
            agrees = all(nodes.get(name, image) == image for name, image in edges.items())
            if agrees and all(side(names) == unchanged for side, unchanged in self._sides):
                self._found.append(names)
            if len(self._found) > MOST_SYMMETRIES:
                raise UnsupportedError(
                    f"the question has more than {MOST_SYMMETRIES} symmetries; tell its nodes apart or say RETURN ALL."
                )

    def _edge_images(self, nodes: Symmetry) -> Iterator[Symmetry]:
        """Each way in which edges go to edges; there are several where edges are parallel."""
        targets: dict[str, list[str]] = {}
        for edge in self._edges:
            targets.setdefault(edge.between({}), []).append(edge.pattern.name)
        sources: dict[str, list[str]] = {}
        for edge in self._edges:
            sources.setdefault(edge.between(nodes), []).append(edge.pattern.name)
        choices = [permutations(targets[key]) for key in sources]
        for chosen in product(*choices):
            yield {
                name: image
                for names, images in zip(sources.values(), chosen, strict=True)
                for name, image in zip(names, images, strict=True)
            }


def _settled(edge: _Edge, names: Collection[str], free: Collection[str]) -> bool:
    """Whether both ends of an edge are placed, or cannot be."""
    return all(end in names or end not in free for end in (edge.pattern.left, edge.pattern.right))


def _alone(name: str, expressions: Sequence[Expression], scope: Scope) -> list[str]:
    """Return what is said of one node alone: nodes of which other things are said are no likes."""
    return sorted({canonical(e, {name: "?"}, scope) for e in expressions if set(free_variables(e)) == {name}})
