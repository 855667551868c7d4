"""Edge types that a question may use, what they join, and what a name in a question stands for."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Final

from enfilade.schema.definition import (
    DOORLIKE_KINDS,
    EDGE_PROPERTIES,
    EDGES,
    NODE_PROPERTIES,
    Property,
)

OPENING_EDGES: Final = {**{kind.upper(): kind for kind in DOORLIKE_KINDS}, "OPENING": None}
"""Edges between two rooms that stand for room, opening, room; the kind of the opening, None for any."""

CLIMBING: Final = ("STAIRS", "HATCH")
"""Opening edges whose arrow leads up."""

EDGE_TYPES: Final = (*OPENING_EDGES, *EDGES)
"""All edge types of a question, as it spells them."""

COMBINING: Final = ("parts", "id", "segments")
"""Properties of an object whose mention in a condition asks for combinations too."""


def end_labels(type: str, direction: str) -> Iterator[tuple[str, str]]:
    """Labels of the left and the right node that an edge may have as it is written."""
    pairs = (("Room", "Room"),) if type in OPENING_EDGES else EDGES[type].ends
    for source, target in pairs:
        if direction in ("-", ">"):
            yield source, target
        if direction in ("-", "<"):
            yield target, source


def may_point(type: str) -> bool:
    """Whether an arrow on the edge means something."""
    return type in CLIMBING if type in OPENING_EDGES else EDGES[type].directed


@dataclass(frozen=True, slots=True)
class Meaning:
    """What a name in a question stands for: a node of a label, or an edge of one of several types."""

    label: str | None
    types: tuple[str, ...] = ()

    @property
    def is_node(self) -> bool:
        """Whether it is a node; the opening behind an edge is one."""
        return self.label is not None

    def properties(self) -> dict[str, Property]:
        """Properties that may be asked of it, by name."""
        if self.label is not None:
            return NODE_PROPERTIES[self.label]
        return shared_properties(self.types)

    def __str__(self) -> str:
        return self.label or "|".join(self.types)


def edge_meaning(types: Iterable[str]) -> Meaning:
    """Meaning of a named edge; all types are either openings or stored edges."""
    types = tuple(types)
    return Meaning("Opening") if set(types) <= set(OPENING_EDGES) else Meaning(None, types)


def shared_properties(types: Iterable[str]) -> dict[str, Property]:
    """Properties that edges of all these types have, by name."""
    tables = [NODE_PROPERTIES["Opening"] if type in OPENING_EDGES else EDGE_PROPERTIES[type] for type in types]
    return {name: found for name, found in tables[0].items() if all(name in table for table in tables)}
