"""Where graphs live: SQLite, the embedded default, and Neo4j."""

from __future__ import annotations

from .base import BuildingSummary, DescriptorTable, Store
from .opening import DEFAULT_URL, open_store

__all__ = ["DEFAULT_URL", "BuildingSummary", "DescriptorTable", "Store", "open_store"]
