"""Predictions against ground truth, as numbers and reasons."""

from __future__ import annotations

from .evaluation import Comparison, Evaluation, evaluate, evaluate_graphs
from .faults import Fault
from .many import Outcome, evaluate_many, pair_folders, pool, summary_rows

__all__ = [
    "Comparison",
    "Evaluation",
    "Fault",
    "Outcome",
    "evaluate",
    "evaluate_graphs",
    "evaluate_many",
    "pair_folders",
    "pool",
    "summary_rows",
]
