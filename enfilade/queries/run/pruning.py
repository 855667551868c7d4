"""Which matches stay: one of each set of symmetric ones, no two that overlap; and what each scores."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import combinations
from typing import Any, Final

from enfilade.queries.examples import Examples, number_of
from enfilade.queries.query_graph import Likeness, Pattern
from enfilade.queries.symmetry import Symmetry

from .matches import Element, Match

GREATEST_DISTANCE: Final = 2.0
"""What an optional node that is missing costs without a limit."""

_SCORE_DECIMALS: Final = 6

Likened = Mapping[str, Likeness]


def likened_nodes(patterns: Iterable[Pattern]) -> dict[str, Likeness]:
    """Nodes with LIKE, by name."""
    return {node.name: node.likeness for p in patterns for node in p.nodes if node.likeness is not None}


def scored(matches: list[Match], likened: Likened, examples: Examples) -> list[Match]:
    """Set the score of each match: the sum of its distances, turned negative, and the mean."""
    for name, likeness in likened.items() if matches else ():
        examples.ranking(likeness).measure(id for match in matches if (id := match.id_of(name)) is not None)
    for match in matches:
        total = sum(_distance(match, name, likeness, examples) for name, likeness in likened.items())
        match.score = score_of(total)
        match.mean_score = score_of(total / max(len(likened), 1))
    return matches


def score_of(distance: float) -> float:
    """Return the score that a sum of distances, or their mean, is."""
    return round(-distance, _SCORE_DECIMALS) + 0.0  # not -0.0


def _distance(match: Match, name: str, likeness: Likeness, examples: Examples) -> float:
    id = match.id_of(name)
    if id is not None:
        distance = examples.ranking(likeness).distance(id)
        assert distance is not None, "the matches hold only objects that are like the example"
        return distance
    return GREATEST_DISTANCE if likeness.within is None else number_of(likeness.within)


def ids_key(match: Match, names: Sequence[str]) -> tuple[tuple[int, Any], ...]:
    """Return what the ids of elements sort by; a missing one comes last."""
    return tuple(_rank(match.elements.get(name)) for name in names)


def one_of_each(matches: Iterable[Match], order: Sequence[str], symmetries: Sequence[Symmetry]) -> list[Match]:
    """Keep, of matches that differ only by a symmetry, the one with the smallest ids in order of appearance."""
    return [match for match in matches if all(_is_smaller(match, order, symmetry) for symmetry in symmetries)]


def _is_smaller(match: Match, order: Sequence[str], symmetry: Symmetry) -> bool:
    for name in order:
        own, image = match.elements.get(name), match.elements.get(symmetry.get(name, name))
        if own is not image:
            return _rank(own) < _rank(image)
    return True


def _rank(element: Element | None) -> tuple[int, Any]:
    """Return an id as one that any other can be compared with."""
    if element is None:
        return 2, ""
    return (0 if element.is_node else 1), element.id


def without_overlap(
    matches: list[Match], order: Sequence[str], likened: Likened, symmetries: Sequence[Symmetry]
) -> list[Match]:
    """Keep the best of matches that agree but for likened objects that share segments (§6.2, §7)."""
    ranked = sorted(matches, key=lambda match: (match.rank, ids_key(match, order)))
    objects = [name for name in order if name in likened]
    nodes = [name for name in order if name not in likened]
    kept: list[Match] = []
    seen: dict[Any, list[list[frozenset[str]]]] = {}
    for match in ranked:
        own = [_segments(match, name) for name in objects]
        if any(_share(own, other) for key in _keys(match, nodes, own) for other in seen.get(key, ())):
            continue
        kept.append(match)
        for image in ({}, *symmetries):
            turned = [_segments(match, image.get(name, name)) for name in objects]
            for key in _keys(match, [image.get(name, name) for name in nodes], turned):
                seen.setdefault(key, []).append(turned)
    return kept


def _segments(match: Match, name: str) -> frozenset[str]:
    element = match.elements[name]
    return frozenset([""]) if element is None else element.segments


def _keys(match: Match, nodes: Sequence[str], segments: Sequence[frozenset[str]]) -> Iterator[Any]:
    """Where to look for matches that may overlap: all other nodes, and one segment of the first object."""
    rest = tuple(_node_id(match, name) for name in nodes)
    yield from ((rest, segment) for segment in segments[0])


def _node_id(match: Match, name: str) -> Any:
    """Return a node's id; which edge it is makes no other match here."""
    element = match.elements.get(name)
    return element.id if element is not None and element.is_node else None


def _share(own: Sequence[frozenset[str]], other: Sequence[frozenset[str]]) -> bool:
    return all(a & b for a, b in zip(own, other, strict=True))


def is_apart(match: Match, names: Iterable[str], others: Iterable[str]) -> bool:
    """Whether no element behind `names` is one behind `others`."""
    taken = {_rank(match.elements[name]) for name in others if match.elements.get(name) is not None}
    return not any(_rank(match.elements[name]) in taken for name in names if match.elements.get(name) is not None)


def uses_segments_once(match: Match, objects: Iterable[str], joined: Iterable[frozenset[str]]) -> bool:
    """Whether no two objects share a segment, but those that the question joins by PART_OF."""
    allowed = set(joined)
    present = [(name, match.elements[name]) for name in objects if match.elements.get(name) is not None]
    for (a, first), (b, second) in combinations(present, 2):
        assert first is not None
        assert second is not None
        if frozenset((a, b)) not in allowed and first.segments & second.segments:
            return False
    return True
