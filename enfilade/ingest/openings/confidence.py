"""How sure an opening is: logistic models of what speaks for it, whose weights are parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

Weights = Mapping[str, float]


@dataclass(frozen=True, slots=True)
class ConfidenceParameters:
    """Weights of the evidence, `constant` among them: confidence is ``1 / (1 + exp(-sum of weight times evidence))``.

    They were fitted with ``bench/confidence.py`` on the develop half of the generated buildings.

    Attributes
    ----------
    through_wall
        Doors, passages and windows that rays go through to another room.
    through_floor
        Stairs and hatches.
    closed
        Doors that no ray goes through, and doors to the outside.
    outside
        Windows to the outside.
    """

    through_wall: Weights = field(
        default_factory=lambda: {
            "constant": -0.73,
            "rays": 0.46,
            "framed": 0.46,
            "filled": 0.85,
            "both_sides": 1.86,
            "glazed": -1.01,
            "agreed": 0.73,
        }
    )
    through_floor: Weights = field(default_factory=lambda: {"constant": 2.2})
    closed: Weights = field(
        default_factory=lambda: {
            "constant": -0.85,
            "framed": 0.73,
            "leaf": 1.21,
            "passed": -0.87,
            "room_behind": 0.63,
            "glazed": 0.69,
        }
    )
    outside: Weights = field(
        default_factory=lambda: {"constant": -0.49, "framed": 0.84, "leaf": 2.33, "passed": -0.56, "glazed": 1.6}
    )


def probability(weights: Weights, evidence: Mapping[str, float]) -> float:
    """How sure an opening is, 0 to 1."""
    known = {"constant": 1.0, **evidence}
    total = sum(weight * known[name] for name, weight in weights.items())
    return float(1.0 / (1.0 + np.exp(-total)))
