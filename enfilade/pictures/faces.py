"""Faces of walls: straight lines in plan, from the points of upright planes of a labelled cloud."""

from __future__ import annotations

from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from enfilade.clouds import LabelledCloud
from enfilade.faces import WallFaces

from .frame import PageFrame

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]
Bool = NDArray[np.bool_]

_LEAST_UPRIGHT_M: Final = 0.15
"""Standard deviation of height from which on a plane is a wall."""
_LEAST_POINTS: Final = 30
_LEAST_FACE_M: Final = 0.30
_FLATTEST_M: Final = 0.04
"""Standard deviation across a face up to which it is a straight line in plan."""
_SLANT_COS: Final = float(np.cos(np.radians(15)))
_SNAP_M: Final = 0.04
"""A face that strays no more than this from the direction of the page is drawn along it."""
_LEAST_HALF_M: Final = 0.25
_MERGE_M: Final = 0.02
"""Faces along the page that lie so close to one another are one line."""


def upright_points(cloud: LabelledCloud) -> Bool:
    """``(N,)``: points on upright planes, which are walls where no object has them."""
    on_plane = cloud.plane >= 0
    plane, z = cloud.plane[on_plane], cloud.positions[on_plane, 2]
    size = int(plane.max(initial=-1)) + 1
    count = np.maximum(np.bincount(plane, minlength=size), 1)
    mean = np.bincount(plane, weights=z, minlength=size) / count
    variance = np.bincount(plane, weights=(z - mean[plane]) ** 2, minlength=size) / count
    upright = np.append(np.sqrt(variance) > _LEAST_UPRIGHT_M, False)
    return np.asarray(upright[cloud.plane] & (cloud.object < 0))


def wall_faces(cloud: LabelledCloud, frame: PageFrame) -> tuple[PageFrame, dict[int, WallFaces]]:
    """Fit a line to each room's points of each upright plane.

    Faces tell far better than outlines how a building lies, so the frame is turned to them.

    Returns
    -------
    PageFrame, dict
        The frame, turned so that most faces run along the page, and the faces in it by number of the room.
    """
    chosen = np.flatnonzero(upright_points(cloud) & (cloud.room >= 0))
    if not len(chosen):
        return frame, {}
    key = cloud.room[chosen].astype(np.int64) << 32 | cloud.plane[chosen]
    order = np.argsort(key, kind="stable")
    chosen, key = chosen[order], key[order]
    starts = np.flatnonzero(np.diff(key, prepend=-1))
    centre, along, across_std, span, count = _lines(frame.points(cloud.positions[chosen, :2]), starts)
    kept = (count >= _LEAST_POINTS) & (across_std <= _FLATTEST_M) & (span[:, 1] - span[:, 0] >= _LEAST_FACE_M)
    room = (key[starts] >> 32)[kept]
    edges = np.flatnonzero(np.diff(room, prepend=-1, append=-1)) if len(room) else np.empty(0, np.int64)
    squared = frame.squared(along[kept] * np.diff(span[kept]))
    turn = PageFrame(squared.angle - frame.angle, np.zeros(2))
    lines = _straightened(turn.directions(centre[kept]), turn.directions(along[kept]), span[kept], count[kept])
    return squared, {int(room[a]): WallFaces(*(part[a:b] for part in lines)) for a, b in pairwise(edges.tolist())}


def _lines(xy: F64, starts: I64) -> tuple[F64, F64, F64, F64, I64]:
    """Fit a line to each run of points: centre, direction, deviation across, span, number of points."""
    count = np.diff(starts, append=len(xy))
    centre = np.add.reduceat(xy, starts) / count[:, None]
    away = xy - np.repeat(centre, count, axis=0)
    xx, yy, both = (
        np.add.reduceat(product, starts) / count
        for product in (away[:, 0] ** 2, away[:, 1] ** 2, away[:, 0] * away[:, 1])
    )
    angle = np.arctan2(2 * both, xx - yy) / 2
    along = np.column_stack([np.cos(angle), np.sin(angle)])
    least = (xx + yy) / 2 - np.hypot((xx - yy) / 2, both)
    place = np.einsum("nd,nd->n", away, np.repeat(along, count, axis=0))
    span = np.column_stack([np.minimum.reduceat(place, starts), np.maximum.reduceat(place, starts)])
    return centre, along, np.sqrt(np.maximum(least, 0.0)), span, count


def _straightened(centre: F64, along: F64, span: F64, count: I64) -> tuple[F64, F64, F64]:
    """Turn faces that run nearly along the page exactly along it, and put those nearly in one line into one."""
    half = (span[:, 1] - span[:, 0]) / 2
    middle = centre + along * span.mean(axis=1)[:, None]
    centre, along = middle.copy(), along.copy()
    for axis in (0, 1):
        square = np.flatnonzero(
            (np.abs(along[:, 1 - axis]) * np.maximum(half, _LEAST_HALF_M) <= _SNAP_M)
            & (np.abs(along[:, axis]) > _SLANT_COS)
        )
        along[square] = np.eye(2)[axis]
        centre[square, 1 - axis] = _merged(centre[square, 1 - axis], count[square])
    return centre, along, np.column_stack([-half, half])


def _merged(offset: F64, count: I64) -> F64:
    """Put offsets that follow one another closely to their mean by number of points."""
    order = np.argsort(offset, kind="stable")
    group = np.empty(len(offset), np.int64)
    group[order] = np.cumsum(np.diff(offset[order], prepend=-np.inf) > _MERGE_M)
    mean = np.bincount(group, weights=offset * count) / np.maximum(np.bincount(group, weights=count), 1)
    return np.asarray(np.where(np.abs(mean[group] - offset) <= 2 * _MERGE_M, mean[group], offset))
