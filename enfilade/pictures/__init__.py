"""Plans, matches and evaluations as pictures."""

from __future__ import annotations

from .evaluation import draw_evaluation
from .match import draw_match
from .plan import draw_plan, draw_storeys

__all__ = ["draw_evaluation", "draw_match", "draw_plan", "draw_storeys"]
