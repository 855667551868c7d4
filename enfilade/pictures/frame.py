"""The page's frame: plans are turned so that most walls run along the page, and far-off coordinates come near."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

F64 = NDArray[np.float64]

_LEAST_TURN_DEG: Final = 0.75
"""A building that lies this straight, by its outlines, is left as it is."""
_LEAST_FACE_TURN_DEG: Final = 0.05
"""The same by its faces, which are measured far better."""
_SQUARE_DEG: Final = 4.0


@dataclass(frozen=True, slots=True)
class PageFrame:
    """How the building lies on the page.

    Attributes
    ----------
    angle
        Radians that the plan is turned by, anticlockwise.
    centre
        ``(2,)`` point of the scans' coordinates that becomes the origin, metres.
    """

    angle: float
    centre: F64

    def points(self, xy: F64) -> F64:
        """Bring ``(..., 2)`` points of the scans' coordinates onto the page, metres."""
        return self.directions(xy - self.centre)

    def directions(self, xy: F64) -> F64:
        """Turn ``(..., 2)`` directions."""
        if self.angle == 0.0:
            return np.asarray(xy, dtype=np.float64)
        c, s = np.cos(self.angle), np.sin(self.angle)
        return np.asarray(xy @ np.array([[c, s], [-s, c]]), dtype=np.float64)

    def squared(self, faces: F64) -> PageFrame:
        """Return the frame in which ``(n, 2)`` faces, directions times lengths on the page, run along the page best."""
        if not len(faces):
            return self
        first = _lie(faces)
        off = (np.angle(faces[:, 0] + 1j * faces[:, 1]) - first + np.pi / 4) % (np.pi / 2) - np.pi / 4
        square = np.abs(off) < np.radians(_SQUARE_DEG)
        lie = _lie(faces[square]) if square.any() else first
        angle = (self.angle - lie + np.pi / 4) % (np.pi / 2) - np.pi / 4
        return PageFrame(angle if abs(np.degrees(angle)) >= _LEAST_FACE_TURN_DEG else 0.0, self.centre)


AS_SCANNED: Final = PageFrame(0.0, np.zeros(2))
"""Neither turned nor moved."""


def page_frame(rings: Iterable[F64]) -> PageFrame:
    """Return the frame in which the walls of all rooms together run along the page, turned by 45° at most.

    The angle is the mean direction of the rings' edges by length, four quarters taken as one.
    """
    closed = [np.vstack([ring, ring[:1]]) for ring in rings]
    if not closed:
        return AS_SCANNED
    corners = np.concatenate(closed)
    centre = np.round((corners.min(axis=0) + corners.max(axis=0)) / 2)
    edges = np.concatenate([np.diff(ring, axis=0) for ring in closed])
    angle = -_lie(edges)
    return PageFrame(angle if abs(np.degrees(angle)) >= _LEAST_TURN_DEG else 0.0, centre)


def _lie(edges: F64) -> float:
    """Mean direction of ``(n, 2)`` edges, radians, four quarters taken as one: within 45° of the axes."""
    along = edges[:, 0] + 1j * edges[:, 1]
    # A long edge tells its direction better than many short ones, which follow a raster.
    mean = np.sum(np.abs(along) ** 2 * np.exp(4j * np.angle(along)))
    return float(np.angle(mean)) / 4 if abs(mean) > 0 else 0.0
