"""Plans, clouds and matches as pictures."""

from __future__ import annotations

from .match import draw_match
from .plan import draw_plan, draw_storeys

__all__ = ["draw_match", "draw_plan", "draw_storeys"]
