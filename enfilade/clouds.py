"""The labelled cloud: a building's thinned points with storey, room, object, plane and scan.

Written as binary little endian PLY, ``x y z`` double in the scans' own coordinates, then int32 ``storey room
object plane scan``: the numbers of the ids (``r12`` is 12), -1 for none. Sorted by room, then object, so that
one room or object is one contiguous read.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

LABELS: Final = ("storey", "room", "object", "plane", "scan")


@dataclass(frozen=True, slots=True)
class LabelledCloud:
    """Points and what each belongs to.

    Attributes
    ----------
    positions
        ``(N, 3) float64``, metres, in the scans' own coordinates.
    storey, room, object, plane, scan
        ``(N,) int32``, numbers of the ids, -1 for none.
    """

    positions: NDArray[np.float64]
    storey: NDArray[np.int32]
    room: NDArray[np.int32]
    object: NDArray[np.int32]
    plane: NDArray[np.int32]
    scan: NDArray[np.int32]
