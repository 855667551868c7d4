"""A million described objects to search: measured ones, turned, half hidden, with something beside them.

Each is one of the models: a mesh as a scanner sees it from one side, or an object that an ingest made of simulated
scans. It is turned by some sectors; each bin is multiplied by a factor of its own, log-normal with the deviation
`SPREAD`; with even chance up to six neighbouring sectors are emptied, for what hides it; with a chance of 0.3 up to a
fifth of another model is added, for what stands beside it; then it is quantised. Blocks of rows have seeds of their
own, so that the first of a million are the same as the first of ten thousand.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from enfilade.atomic import replacing
from enfilade.descriptors import DEFAULT_LAYOUT, TOTAL
from enfilade.descriptors.bounds import blocks_of, rings_of
from enfilade.descriptors.nearest import DescriptorTable

U16 = NDArray[np.uint16]

SPREAD: Final = 0.4
MOST_HIDDEN: Final = 6
BESIDE: Final = 0.3
MOST_BESIDE: Final = 0.2
BLOCK: Final = 10_000
"""Objects of one seed."""


def described_objects(models: U16, count: int, folder: Path) -> DescriptorTable:
    """Return a table of so many objects, mapped from files in a folder, made where they are not there.

    Parameters
    ----------
    models
        ``(m, bins)`` counts of what they are made from.
    count
        A multiple of `BLOCK`.
    folder
        For some 3.4 kB an object.
    """
    folder.mkdir(parents=True, exist_ok=True)
    shape = DEFAULT_LAYOUT.shape
    path = folder / f"objects-{count}-{len(models)}.counts"
    if not path.exists():
        with replacing(path) as file:
            for seed in range(count // BLOCK):
                file.write(seen_again(models, BLOCK, seed).tobytes())
    counts = np.memmap(path, np.uint16, "r", shape=(count, DEFAULT_LAYOUT.bins))
    rings = np.concatenate([rings_of(counts[first : first + BLOCK], shape) for first in range(0, count, BLOCK)])
    return DescriptorTable(shape, counts, rings, blocks_of(rings, shape), np.ones(count, dtype=np.bool_))


def seen_again(models: U16, count: int, seed: int) -> U16:
    """Return so many objects ``(count, bins)``, the same for a seed every time."""
    found = np.empty((count, models.shape[1]), dtype=np.uint16)
    _draw(models, DEFAULT_LAYOUT.sectors, np.random.default_rng(seed), found)
    return found


@njit(cache=True, nogil=True)
def _draw(models: U16, sectors: int, rng: np.random.Generator, found: U16) -> None:
    bins = models.shape[1]
    values = np.empty(bins)
    for i in range(found.shape[0]):
        model, other = models[rng.integers(0, len(models))], models[rng.integers(0, len(models))]
        turn, other_turn = rng.integers(0, sectors), rng.integers(0, sectors)
        hidden = rng.integers(0, MOST_HIDDEN + 1) if rng.random() < 0.5 else 0
        share = rng.random() * MOST_BESIDE if rng.random() < BESIDE else 0.0
        for b in range(bins):
            ring, sector = b - b % sectors, b % sectors
            own = float(model[ring + (sector + turn) % sectors]) if sector >= hidden else 0.0
            beside = float(other[ring + (sector + other_turn) % sectors]) * share
            values[b] = (own + beside) * np.exp(SPREAD * rng.normal()) if own + beside > 0 else 0.0
        if values.sum() == 0.0:  # all of it was hidden
            values[:] = model
        _quantise(values, found[i])


@njit(cache=True, nogil=True)
def _quantise(values: NDArray[np.float64], counts: U16) -> None:
    """Round down to counts; what is left goes to the fullest bin."""
    scale = TOTAL / values.sum()
    left = TOTAL
    for b in range(len(values)):
        counts[b] = int(values[b] * scale)
        left -= counts[b]
    counts[np.argmax(values)] += left
