"""A question in, ranked matches out."""

from __future__ import annotations

from .answering import answer
from .connection import Connection
from .parse import parse
from .query_graph import (
    Between,
    Column,
    EdgePattern,
    Equal,
    Likeness,
    NodePattern,
    Pattern,
    QueryGraph,
    SortKey,
)
from .result import Result

__all__ = [
    "Between",
    "Column",
    "Connection",
    "EdgePattern",
    "Equal",
    "Likeness",
    "NodePattern",
    "Pattern",
    "QueryGraph",
    "Result",
    "SortKey",
    "answer",
    "parse",
]
