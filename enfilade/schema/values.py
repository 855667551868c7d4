"""What a property may hold: one check a kind, each returning what is wrong or None."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np

from enfilade.schema.counts import TOTAL
from enfilade.schema.definition import Kind, Property

MAX_DEPTH: Final = 50
"""How deep lists and mappings may lie in one another."""

MAX_INDEXED_LENGTH: Final = 1000
"""Characters of a text that the stores keep in an index; Neo4j's index takes no entry above 8 kB."""

_INT64: Final = 2**63


def fault_of(value: Any, property: Property) -> str | None:
    """Say what is wrong with a property's value, as the end of a sentence, or None."""
    fault = _FAULTS[property.kind](value)
    if fault:
        return fault
    if property.values and value not in property.values:
        return f"must be one of {', '.join(property.values)}, not {shown(value)}"
    if property.length and len(value) != property.length:
        return f"must have {property.length} numbers, not {len(value)}"
    if property.indexed and property.kind is Kind.TEXT and len(value) > MAX_INDEXED_LENGTH:
        return f"must have at most {MAX_INDEXED_LENGTH} characters, not {len(value)}"
    return None


def plain_fault(value: Any) -> str | None:
    """Say what keeps a value from being written as JSON and read again unchanged, or None."""
    waiting = [(value, 0)]
    while waiting:
        item, depth = waiting.pop()
        if depth > MAX_DEPTH:
            return f"holds lists or mappings more than {MAX_DEPTH} deep in one another"
        if isinstance(item, dict):
            if not all(isinstance(key, str) for key in item):
                return "holds a mapping with a key that is no text"
            waiting.extend((part, depth + 1) for pair in item.items() for part in pair)
        elif isinstance(item, list):
            waiting.extend((part, depth + 1) for part in item)
        elif fault := _plain_scalar_fault(item):
            return fault
    return None


def shown(value: Any) -> str:
    """Return a value as it may stand in a sentence: short, on one line."""
    text = ascii(value)
    return text if len(text) <= 40 else f"{text[:37]}..."


def _plain_scalar_fault(value: Any) -> str | None:
    if value is None or isinstance(value, bool | int):
        return None
    if isinstance(value, str):
        return _text_fault(value)
    if isinstance(value, float):
        return _real_fault(value)
    return f"holds a {type(value).__name__}, which JSON cannot"


def _text_fault(value: Any) -> str | None:
    if not isinstance(value, str):
        return f"must be a text, not {shown(value)}"
    try:
        value.encode()
    except UnicodeEncodeError:
        return f"holds half a character (a lone surrogate): {shown(value)}"
    return None


def _integer_fault(value: Any) -> str | None:
    if isinstance(value, bool) or not isinstance(value, int):
        return f"must be a whole number, not {shown(value)}"
    if not -_INT64 <= value < _INT64:
        return f"must be a number of at most 64 bits, not {shown(value)}"
    return None


def _real_fault(value: Any) -> str | None:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return f"must be a number, not {shown(value)}"
    if isinstance(value, int):
        return _integer_fault(value)
    return None if math.isfinite(value) else f"must be a finite number, not {value}"


def _rings_fault(value: Any) -> str | None:
    if not isinstance(value, list):
        return f"must be a list of rings, not {shown(value)}"
    for ring in value:
        fault = _list_of(_real_fault)(ring)
        if fault:
            return fault
        if len(ring) % 2:
            return f"must have rings of x y pairs; one has {len(ring)} numbers"
    return None


def _mapping_fault(value: Any) -> str | None:
    return plain_fault(value) if isinstance(value, dict) else f"must be a mapping, not {shown(value)}"


def _descriptor_fault(value: Any) -> str | None:
    if not isinstance(value, np.ndarray) or value.dtype != np.uint16 or value.ndim != 1:
        return "must be a flat array of uint16 counts"
    total = int(value.sum(dtype=np.int64))
    return None if total == TOTAL else f"must have counts that sum to {TOTAL}, not {total}"


def _list_of(element_fault: Callable[[Any], str | None]) -> Callable[[Any], str | None]:
    def fault(value: Any) -> str | None:
        if not isinstance(value, list):
            return f"must be a list, not {shown(value)}"
        return next((f"has an element that {found}" for found in map(element_fault, value) if found), None)

    return fault


_FAULTS: Final[dict[Kind, Callable[[Any], str | None]]] = {
    Kind.TEXT: _text_fault,
    Kind.INTEGER: _integer_fault,
    Kind.REAL: _real_fault,
    Kind.TEXTS: _list_of(_text_fault),
    Kind.INTEGERS: _list_of(_integer_fault),
    Kind.REALS: _list_of(_real_fault),
    Kind.RINGS: _rings_fault,
    Kind.MAPPING: _mapping_fault,
    Kind.DESCRIPTOR: _descriptor_fault,
}
