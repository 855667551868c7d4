"""Keys of nodes: ``hotel``, ``hotel/s0``, ``hotel/r12``, ``hotel/p7``, ``hotel/o31``, ``hotel/o31+o32``."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass
from typing import Final

from enfilade.errors import GraphError

MAX_BUILDING_LENGTH: Final = 200
MAX_SEGMENTS: Final = 3

_LETTERS: Final = {"Storey": "s", "Room": "r", "Opening": "p", "Object": "o"}
_LABELS: Final = {letter: label for label, letter in _LETTERS.items()}
_NUMBER: Final = r"(?:0|[1-9][0-9]{0,17})"
_LOCAL: Final = re.compile(rf"([srp]){_NUMBER}|(o){_NUMBER}(?:\+o{_NUMBER}){{0,{MAX_SEGMENTS - 1}}}")


@dataclass(frozen=True, slots=True)
class Key:
    """A node's key, taken apart.

    Attributes
    ----------
    building
        Id of the building.
    label
        Label of the node.
    numbers
        The node's number; of a combination the numbers of its segments; of a building nothing.
    """

    building: str
    label: str
    numbers: tuple[int, ...]


def check_building(building: object) -> str:
    """Return a building's id unchanged, or raise GraphError where it cannot be one."""
    if not isinstance(building, str):
        raise GraphError(f"a building's id is a text, not {type(building).__name__}")
    if not 1 <= len(building) <= MAX_BUILDING_LENGTH:
        raise GraphError(f"a building's id has 1 to {MAX_BUILDING_LENGTH} characters, not {len(building)}")
    if "/" in building:
        raise GraphError(f'the building\'s id "{building}" has a slash; use another character')
    if any(unicodedata.category(character) in ("Cc", "Cs") for character in building):
        raise GraphError(f"the building's id {building!a} has a control character; leave it out")
    return building


def storey_id(building: str, number: int) -> str:
    """Key of a storey: ``hotel/s0``."""
    return f"{building}/s{number}"


def room_id(building: str, number: int) -> str:
    """Key of a room: ``hotel/r12``."""
    return f"{building}/r{number}"


def opening_id(building: str, number: int) -> str:
    """Key of an opening: ``hotel/p7``."""
    return f"{building}/p{number}"


def object_id(building: str, *segments: int) -> str:
    """Key of a segment or of a combination of segments: ``hotel/o31``, ``hotel/o31+o32``."""
    return f"{building}/" + "+".join(f"o{number}" for number in segments)


def parse(id: str) -> Key:
    """Take a key apart; raises GraphError where it is none."""
    building, slash, local = id.partition("/")
    check_building(building)
    if not slash:
        return Key(building, "Building", ())
    found = _LOCAL.fullmatch(local)
    if found is None:
        raise GraphError(f'"{id}" is no key of a node; keys look like ID, ID/s0, ID/r12, ID/p7, ID/o31, ID/o31+o32')
    numbers = tuple(int(part[1:]) for part in local.split("+"))
    if len(set(numbers)) != len(numbers):
        raise GraphError(f'the key "{id}" names a segment twice')
    return Key(building, _LABELS[found[1] or found[2]], numbers)
