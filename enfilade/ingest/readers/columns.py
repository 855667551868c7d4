"""Chunks from columns of numbers, as PLY, PCD, LAS and PTX have them."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from enfilade.ingest.records import F64, U8, Chunk

from .placing import compacted, usable

INTENSITIES: Final = ("intensity", "scalar_intensity", "reflectance", "reflectivity", "i")
COLOURS: Final = (("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue"))


def chunk_of(positions: F64, intensity: NDArray[Any] | None, colour: U8 | None) -> Chunk:
    """Return a chunk of the points whose coordinates are finite; ``(n, 3)``, ``(n,)``, ``(n, 3)``."""
    kept = usable(positions)
    return Chunk(
        compacted(positions, kept),
        None if intensity is None else compacted(np.asarray(intensity, np.float32), kept),
        None if colour is None else compacted(colour, kept),
    )


def named_chunk(table: NDArray[np.void]) -> Chunk:
    """Return a chunk from a table whose columns have the usual names; ``x``, ``y`` and ``z`` must be there."""
    names = {name.lower(): name for name in table.dtype.names or ()}
    positions = np.stack([table[names[axis]] for axis in "xyz"], axis=1).astype(np.float64, copy=False)
    intensity = next((table[names[name]] for name in INTENSITIES if name in names), None)
    channels = next((c for c in COLOURS if set(c) <= set(names)), None)
    colour = None if channels is None else to_bytes(np.stack([table[names[c]] for c in channels], axis=1))
    return chunk_of(positions, intensity, colour)


def to_bytes(colour: NDArray[Any]) -> U8:
    """Bring colours to 0 to 255: whole numbers of 16 bits lose the lower half, fractions of 1 are scaled."""
    if colour.dtype == np.uint8:
        return np.asarray(colour, np.uint8)
    if colour.dtype.kind in "ui":
        return np.asarray(colour >> 8 if colour.dtype.itemsize > 1 else colour, np.uint8)
    return np.asarray(np.clip(np.nan_to_num(colour) * 255.0, 0.0, 255.0), np.uint8)
