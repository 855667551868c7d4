"""Shape descriptors of objects and their distance (§6.2), reachable from ingest, stores and queries alike."""

from __future__ import annotations

from enfilade.schema.counts import TOTAL, quantise

from .distance import best_turn, distances
from .histogram import describe, describe_votes, gather_votes
from .layout import DEFAULT_LAYOUT, PAPER_LAYOUT, Layout
from .shapes import Shape, read_shape
from .views import Viewing, mesh_views, sample_surface, seen_of

__all__ = [
    "DEFAULT_LAYOUT",
    "PAPER_LAYOUT",
    "TOTAL",
    "Layout",
    "Shape",
    "Viewing",
    "best_turn",
    "describe",
    "describe_votes",
    "distances",
    "gather_votes",
    "mesh_views",
    "quantise",
    "read_shape",
    "sample_surface",
    "seen_of",
]
