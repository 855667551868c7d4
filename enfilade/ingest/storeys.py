"""Storeys: rooms binned by floor elevation (§4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .records import Room, Storey


@dataclass(frozen=True, slots=True)
class StoreyParameters:
    """When two floors are of one storey.

    Attributes
    ----------
    bin_m
        Greatest difference between the floors of one storey.
    """

    bin_m: float = 1.2


def find_storeys(rooms: Sequence[Room], parameters: StoreyParameters = StoreyParameters()) -> tuple[Storey, ...]:
    """Bin rooms by floor elevation, from the lowest up.

    The rooms are taken in order of elevation, so that the bins do not depend on the rooms' numbers. A storey's
    elevation is that at which half of its floor area lies below.
    """
    bins: list[list[Room]] = []
    for room in sorted(rooms, key=lambda room: (room.floor_elevation, room.number)):
        if bins and room.floor_elevation - bins[-1][0].floor_elevation <= parameters.bin_m:
            bins[-1].append(room)
        else:
            bins.append([room])
    return tuple(
        Storey(index, _median_elevation(bin), tuple(sorted(room.number for room in bin)))
        for index, bin in enumerate(bins)
    )


def _median_elevation(rooms: Sequence[Room]) -> float:
    below = np.cumsum([room.area for room in rooms])
    return rooms[int(np.searchsorted(below, below[-1] / 2.0))].floor_elevation
