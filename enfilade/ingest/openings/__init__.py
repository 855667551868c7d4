"""Openings: doors, passages, windows, stairs and hatches, from rays and the holes that they go through (§5.2)."""

from enfilade.ingest.openings.find import find_openings
from enfilade.ingest.openings.parameters import OpeningParameters

__all__ = ["OpeningParameters", "find_openings"]
