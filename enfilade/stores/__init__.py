"""Where graphs live: SQLite, the embedded default, and Neo4j."""

from __future__ import annotations

from .base import BuildingDescriptors, BuildingSummary, Store
from .opening import DEFAULT_URL, open_store

__all__ = ["DEFAULT_URL", "BuildingDescriptors", "BuildingSummary", "Store", "open_store"]
