"""Labels of the nodes that a question leaves without one, from what its edges can join."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NoReturn

from enfilade.schema.definition import NODES

from .query_graph import EdgePattern, Pattern
from .syntax import Place
from .vocabulary import end_labels

Fail = Callable[[str, Place | None], NoReturn]


def inferred_labels(pattern: Pattern, known: Mapping[str, str | None], fail: Fail) -> dict[str, str]:
    """Return the label of each node of a pattern.

    Parameters
    ----------
    pattern
        Nodes with or without labels.
    known
        Labels of names that mean something already.
    fail
        Called with a sentence and a place where no label, or more than one, is possible.
    """
    possible = {node.name: _first_guess(node.label, known.get(node.name)) for node in pattern.nodes}
    for node in pattern.nodes:
        if not possible[node.name]:
            fail(f'"{node.name}" is a {known[node.name]}, not a {node.label}; use another name.', node.place)
    narrowed = True
    while narrowed:
        narrowed = any(_narrow(edge, possible, fail) for edge in pattern.edges)
    for node in pattern.nodes:
        if len(possible[node.name]) > 1:
            options = ", ".join(label for label in NODES if label in possible[node.name])
            fail(f"this node needs a label: its edges leave {options} possible.", node.place)
    return {name: next(iter(labels)) for name, labels in possible.items()}


def _first_guess(written: str | None, known: str | None) -> set[str]:
    labels = set(NODES) if written is None else {written}
    return labels if known is None else labels & {known}


def _narrow(edge: EdgePattern, possible: dict[str, set[str]], fail: Fail) -> bool:
    """Leave the edge's ends only labels that fit; returns whether there were others."""
    left, right = possible[edge.left], possible[edge.right]
    joined = {pair for type in edge.types for pair in end_labels(type, edge.direction)}
    pairs = {(a, b) for a, b in joined if a in left and b in right}
    if not pairs:
        ways = " or ".join(sorted(f"{a} to {b}" for a, b in joined))
        fail(f"{'|'.join(edge.types)} leads from {ways} here, which its nodes are not.", edge.place)
    possible[edge.left], possible[edge.right] = {a for a, _ in pairs}, {b for _, b in pairs}
    return (left, right) != (possible[edge.left], possible[edge.right])
