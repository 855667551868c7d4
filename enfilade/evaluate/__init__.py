"""Predictions against ground truth, as numbers."""

from __future__ import annotations

from .evaluation import Evaluation, evaluate, evaluate_graphs

__all__ = ["Evaluation", "evaluate", "evaluate_graphs"]
