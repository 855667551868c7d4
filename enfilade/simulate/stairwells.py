"""Stairs of generated buildings: two runs with a landing in a stairwell, or one run along the wall of a hall."""

from __future__ import annotations

import shapely
from shapely import Polygon

from .doors import Storey
from .drafting import Draft
from .layouts import HUB, STAIRWELL
from .plan import Run, Stairs
from .solids import Rectangle

_ARRIVAL_M = 1.35
_RUN_M = 2.35
_LANDING_M = 0.2
_FLIGHT_WIDTH_M = 1.0
_FOOT_M = 1.05
_FLIGHT_M = 4.0
_WELL_FROM_M = 0.8
_RISER_M = 0.18
_RAIL_M = 0.04
_WALL_M = 0.4


def stairs_between(lower: Storey, upper: Storey, *, topmost: bool) -> Stairs:
    """Return the stairs from one storey up to the next, whose stairwells or halls lie over one another."""
    low, high = _place(lower), _place(upper)
    rooms = (lower.names[low], upper.names[high])
    span = (lower.floors[low], upper.floors[high])
    if lower.drafts[low].use == STAIRWELL:
        return _two_runs(rooms, _box(lower.drafts[low]), span, topmost=topmost)
    return _one_run(rooms, _box(lower.drafts[low]), span, topmost=topmost)


def reserve_stairs(storey: Storey) -> None:
    """Keep doors and furniture out of the way of stairs, up or down."""
    place = _place(storey)
    draft = storey.drafts[place]
    storey.taken.append(_walls_beside(draft))
    storey.clear[place].append(
        draft.polygon if draft.use == STAIRWELL else _flights(draft).buffer(1.0, join_style="mitre")
    )


def _walls_beside(draft: Draft) -> Polygon:
    """Return where no door may be."""
    x0, y0, x1, y1 = _flights(draft).bounds
    if draft.use == STAIRWELL:
        return shapely.box(x0 - _WALL_M, y0, x1 + _WALL_M, y1 + _WALL_M)
    return shapely.box(x0, y1 - 0.1, x1, y1 + _WALL_M)


def _place(storey: Storey) -> int:
    uses = [draft.use for draft in storey.drafts]
    return uses.index(STAIRWELL) if STAIRWELL in uses else uses.index(HUB)


def _box(draft: Draft) -> Rectangle:
    x0, y0, x1, y1 = draft.polygon.bounds
    return x0, x1, y0, y1


def _flights(draft: Draft) -> Polygon:
    x0, x1, y0, y1 = _box(draft)
    if draft.use == STAIRWELL:
        return shapely.box(x0, y0 + _ARRIVAL_M, x1, y1)
    return shapely.box(x0 + _FOOT_M, y1 - _FLIGHT_WIDTH_M, x0 + _FOOT_M + _FLIGHT_M, y1)


def _two_runs(rooms: tuple[str, str], box: Rectangle, span: tuple[float, float], *, topmost: bool) -> Stairs:
    x0, x1, y0, y1 = box
    near, far = y0 + _ARRIVAL_M, y0 + _ARRIVAL_M + _RUN_M
    width = (x1 - x0 - 0.1) / 2
    left, right = x0 + width / 2, x1 - width / 2
    count = round((span[1] - span[0]) / _RISER_M / 2)
    middle = (span[0] + span[1]) / 2
    runs = (
        Run((left, near), (left, far), width, span[0], middle, count),
        Run((right, far), (right, near), width, middle, span[1], count),
    )
    landing = (shapely.box(x0, far, x1, y1), middle - _LANDING_M, middle)
    rail = (((x0, near - _RAIL_M), (x0 + width, near - _RAIL_M)),) if topmost else ()
    return Stairs(rooms, runs, shapely.box(x0, near, x1, y1), (landing,), rail)


def _one_run(rooms: tuple[str, str], box: Rectangle, span: tuple[float, float], *, topmost: bool) -> Stairs:
    x0, _, _, y1 = box
    foot, head, side = x0 + _FOOT_M, x0 + _FOOT_M + _FLIGHT_M, y1 - _FLIGHT_WIDTH_M
    start = foot + _WELL_FROM_M
    line = y1 - _FLIGHT_WIDTH_M / 2
    run = Run((foot, line), (head, line), _FLIGHT_WIDTH_M, *span, round((span[1] - span[0]) / _RISER_M))
    along = ((start, side - _RAIL_M), (head, side - _RAIL_M))
    across = ((start - _RAIL_M, side - 2 * _RAIL_M), (start - _RAIL_M, y1))
    well = shapely.box(start, side, head, y1)
    return Stairs(rooms, (run,), well, balustrades=(along, across) if topmost else (along,))
