"""Property values as they come from a store, as plain Python values."""

from __future__ import annotations

import json
from typing import Any

from enfilade.schema.counts import TOTAL
from enfilade.schema.definition import Kind
from enfilade.schema.sqlite import counts_of


def decoded(value: Any, kind: Kind) -> Any:
    """Return a property's value: lists as lists, a descriptor as its shares, a number of kind number as a float."""
    if value is None or kind in (Kind.TEXT, Kind.INTEGER):
        return value
    if kind is Kind.REAL:
        return float(value)
    if kind is Kind.DESCRIPTOR:
        return (counts_of(bytes(value)) / TOTAL).tolist()
    return json.loads(value) if isinstance(value, str) else list(value)
