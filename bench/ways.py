"""Ways to compare shapes with scanned objects: ours, the paper's, steps between them, and other descriptors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from furnished import Model
from numpy.typing import NDArray
from peers import PEERS, Peer
from scanned import Target

from enfilade.descriptors import (
    DEFAULT_LAYOUT,
    PAPER_LAYOUT,
    Layout,
    Shape,
    describe_votes,
    distances,
    gather_votes,
    seen_of,
)

F64 = NDArray[np.float64]
CELL_M: Final = DEFAULT_LAYOUT.cell_m


@dataclass(frozen=True, slots=True)
class Way:
    """A descriptor of Eqs. 8-10 in one of its forms.

    Attributes
    ----------
    layout
        The bins.
    on_foot
        Whether a mesh is compared foot on foot, or with its foot on the floor.
    sides
        Whether a mesh is asked with what a scanner would see from each side, too, or as a whole only.
    pairs
        Whether pairs of sides at right angles are asked with, too.
    """

    layout: Layout = DEFAULT_LAYOUT
    on_foot: bool = True
    sides: bool = True
    pairs: bool = False

    def ask(self, views: Views) -> NDArray[np.uint16]:
        """``(V, bins)`` descriptors of a mesh."""
        return np.concatenate([describe_votes(view, (0.0,), self.layout) for view in views.of(self)])

    def keep(self, target: Target, *, on_foot: bool) -> NDArray[np.uint16]:
        """``(bins,)`` descriptor of an object."""
        votes = gather_votes(target.points, self.layout.cell_m)[0]
        base = float(target.points[:, 2].min()) if on_foot else target.floor
        return np.asarray(describe_votes(votes, (base,), self.layout)[0])


class Views:
    """What is seen of a mesh whose foot is at 0, gathered once for all ways."""

    def __init__(self, model: Model) -> None:
        seen = seen_of(Shape(model.name, model.mesh.vertices, model.mesh.triangles))
        self.whole = seen[-1]
        self._sides = [gather_votes(side, CELL_M) for side in seen[:-1]]
        self._whole = gather_votes(self.whole, CELL_M)[0]

    def of(self, way: Way) -> Sequence[F64]:
        """Votes of each view that a way asks with."""
        if way.layout.cell_m != CELL_M:
            return [gather_votes(self.whole, way.layout.cell_m)[0]]
        sides = [votes for votes, _ in self._sides] if way.sides else []
        return [*sides, *(self._pairs() if way.pairs else []), self._whole]

    def _pairs(self) -> list[F64]:
        quarter = max(1, len(self._sides) // 4)
        both = [(side, self._sides[i - quarter]) for i, side in enumerate(self._sides)]
        return [gather_votes(np.concatenate([a[0], b[0]]), CELL_M, np.concatenate([a[1], b[1]]))[0] for a, b in both]


OURS: Final = "Enfilade"
PRINTED: Final = "Eqs. 8-11 as printed"
_SLICES: Final = replace(PAPER_LAYOUT, slices=1, slice_height_m=100.0)
_COARSE: Final = replace(DEFAULT_LAYOUT, shell_width_m=0.15, interpolate=False, exponent=1.0)

COMPARED: Final[Mapping[str, Way | Peer]] = {
    OURS: Way(),
    PRINTED: Way(PAPER_LAYOUT, on_foot=False, sides=False),
    "the same, foot on foot": Way(PAPER_LAYOUT, sides=False),
    "the same, shells and sectors only": Way(_SLICES, on_foot=False, sides=False),
    **PEERS,
}

STEPS: Final[Mapping[str, Way | Peer]] = {
    "Eqs. 8-11, 5 cm cells vote, no annulus weight": Way(
        replace(PAPER_LAYOUT, cell_m=CELL_M, annulus_weight=False), on_foot=False, sides=False
    ),
    "12 x 8 x 16 bins of 15 cm": Way(_COARSE, on_foot=False, sides=False),
    "+ sides and pairs of sides": Way(_COARSE, on_foot=False, pairs=True),
    "+ foot on foot (the first version)": Way(_COARSE, pairs=True),
    "+ votes shared by bins, no box filter": Way(replace(_COARSE, interpolate=True), pairs=True),
    "+ exponent": Way(replace(_COARSE, interpolate=True, exponent=DEFAULT_LAYOUT.exponent), pairs=True),
    "+ shells of 10 cm": Way(pairs=True),
    "+ no pairs (Enfilade)": Way(),
}

CHANGES: Final[Mapping[str, Way | Peer]] = {
    "foot on the floor (AT 0)": Way(on_foot=False),
    "the whole only": Way(sides=False),
    "votes not shared, box filter": Way(replace(DEFAULT_LAYOUT, interpolate=False)),
    "exponent 1": Way(replace(DEFAULT_LAYOUT, exponent=1.0)),
    "exponent 0.5": Way(replace(DEFAULT_LAYOUT, exponent=0.5)),
    "slices of 10 cm": Way(replace(DEFAULT_LAYOUT, slices=18, slice_height_m=0.1)),
    "slices of 20 cm": Way(replace(DEFAULT_LAYOUT, slices=9, slice_height_m=0.2)),
    "shells of 8 cm": Way(replace(DEFAULT_LAYOUT, shell_width_m=0.08)),
    "shells of 12 cm": Way(replace(DEFAULT_LAYOUT, shell_width_m=0.12)),
    "12 shells": Way(replace(DEFAULT_LAYOUT, shells=12)),
    "12 sectors": Way(replace(DEFAULT_LAYOUT, sectors=12)),
    "24 sectors": Way(replace(DEFAULT_LAYOUT, sectors=24)),
}


def measure(way: Way | Peer, views: Sequence[Views], targets: Sequence[Target], asked: Sequence[int]) -> list[F64]:
    """Distances of all targets to each mesh, and to each of the targets that ask.

    Returns
    -------
    ``(meshes, targets)`` and ``(asked, targets)`` arrays.
    """
    if isinstance(way, Peer):
        vectors = np.stack([way.describe(target.points) for target in targets])
        asking = [way.describe(view.whole) for view in views]
        apart = (np.stack([way.apart(one, vectors) for one in some]) for some in (asking, vectors[list(asked)]))
        return list(apart)
    on_floor = np.stack([way.keep(target, on_foot=False) for target in targets])
    kept = np.stack([way.keep(target, on_foot=True) for target in targets]) if way.on_foot else on_floor
    meshes = [distances(way.ask(view), kept, way.layout.shape) for view in views]
    return [np.stack(meshes), np.stack([distances(on_floor[i], on_floor, way.layout.shape) for i in asked])]
