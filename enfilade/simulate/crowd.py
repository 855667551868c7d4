"""People who stand about while the scanner turns."""

from __future__ import annotations

import numpy as np

from .casting import Caster
from .solids import F64, Mesh, block, cylinder, lathe, merge

_NEAREST_M, _FARTHEST_M = 0.9, 6.0
_WIDE_M = 0.35
_TRIES = 20
_LOOK_DOWN_M = 2.5


class Crowd:
    """Places in a building where people can stand."""

    def __init__(self, building: Mesh) -> None:
        self._building = Caster(building)

    def about(self, station: F64, mean: float, generator: np.random.Generator) -> Mesh | None:
        """Put people, `mean` of them on average, where the scanner sees them; None for none asked."""
        if mean <= 0:
            return None
        feet = self._places(station, generator)[: generator.poisson(mean)]
        return merge(
            person(float(generator.uniform(1.55, 1.95))).turned(float(generator.uniform(0, 360))).moved(foot)
            for foot in feet
        )

    def _places(self, station: F64, generator: np.random.Generator) -> F64:
        """``(K, 3)`` places on the floor that are in sight and free, in random order."""
        angle = generator.uniform(0, 2 * np.pi, _TRIES)
        reach = generator.uniform(_NEAREST_M, _FARTHEST_M, _TRIES)
        chest = station + np.column_stack([reach * np.cos(angle), reach * np.sin(angle), np.full(_TRIES, -0.2)])
        drop = self._building.cast(chest, np.tile([0.0, 0.0, -1.0], (_TRIES, 1)))[0]
        free = ~self._building.blocked(np.broadcast_to(station, chest.shape), chest) & (drop < _LOOK_DOWN_M)
        free &= self._building.distance(chest) > _WIDE_M
        feet: F64 = chest[free] - np.column_stack([np.zeros((free.sum(), 2)), drop[free]])
        return feet


def person(height: float = 1.75) -> Mesh:
    """Return a person who stands on z = 0: legs, trunk, arms and head."""
    trunk = lathe([(0.0, 0.8), (0.5, 0.8), (0.44, 1.05), (0.55, 1.35), (0.2, 1.47), (0.0, 1.5)], 12)
    head = lathe([(0.0, 1.48), (0.07, 1.5), (0.1, 1.6), (0.09, 1.7), (0.0, 1.75)], 12)
    legs = [cylinder((side * 0.1, 0.0), 0.075, 0.0, 0.85, sides=8) for side in (-1, 1)]
    arms = [block((side * 0.25, 0.0), (0.09, 0.1), 0.75, 1.4) for side in (-1, 1)]
    body = merge([trunk.scaled([0.36, 0.24, 1.0]), head, *legs, *arms])
    return body.scaled([1.0, 1.0, height / 1.75])
