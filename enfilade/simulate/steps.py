"""Stairs of a plan: steps, landings, balustrades, and the opening that they are."""

from __future__ import annotations

import numpy as np

from .plan import Run, Stairs
from .roofs import Roof
from .scene import Opening
from .shells import shell
from .solids import F64, Mesh, hexahedron, merge, wall

BALUSTRADE_M = (0.08, 0.9)
"""Thickness and height."""
_WAIST_M = 0.16


def stairs_mesh(stairs: Stairs) -> list[Mesh]:
    """Return the solids of stairs."""
    landings = [shell(plan, bottom, Roof(top)) for plan, bottom, top in stairs.landings]
    thickness, height = BALUSTRADE_M
    rails = [wall(a, b, thickness, (stairs.top, stairs.top + height)) for a, b in stairs.balustrades]
    return [*(steps(run) for run in stairs.runs), *landings, *rails]


def steps(run: Run) -> Mesh:
    """Return steps with a sloped underside, each a solid of its own."""
    length = float(np.hypot(*np.subtract(run.head, run.foot)))
    angle = np.degrees(np.arctan2(*np.subtract(run.head, run.foot)[::-1]))
    xs = np.linspace(0.0, length, run.step_count + 1)
    rise = (run.top - run.bottom) / run.step_count
    treads = rise * np.arange(1, run.step_count + 1)
    soffit = np.maximum(rise * np.arange(run.step_count + 1) - _WAIST_M, 0.0)
    ys = (-run.width / 2, run.width / 2)
    solids = (
        hexahedron([[xs[k + i], y, z] for i in (0, 1) for y in ys for z in (soffit[k + i], treads[k])])
        for k in range(run.step_count)
    )
    return merge(solids).turned(angle).moved([*run.foot, run.bottom])


def stairs_opening(stairs: Stairs, rooms: tuple[int, int], slab: tuple[float, float]) -> Opening:
    """Return the opening of stairs: the hole in the slab, which lies between two elevations."""
    heading = np.subtract(stairs.runs[0].head, stairs.runs[0].foot)
    heading = heading / np.linalg.norm(heading)
    frame: F64 = np.array([heading, [-heading[1], heading[0]]])
    local = np.array(stairs.well.exterior.coords) @ frame.T
    low, high = local.min(axis=0), local.max(axis=0)
    feet = [(*stairs.runs[0].foot, stairs.bottom), (*stairs.runs[-1].head, stairs.top)]
    return Opening(
        "stairs",
        None,
        np.array([*((low + high) / 2 @ frame), (slab[0] + slab[1]) / 2]),
        np.array([*frame[1], 0.0]),
        np.array([0.0, 0.0, 1.0]),
        float(high[1] - low[1]),
        float(high[0] - low[0]),
        slab[1] - slab[0],
        None,
        rooms,
        np.array(feet),
    )
