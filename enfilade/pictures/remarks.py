"""What a sheet says in words: title block and notes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np

from .leaves import SWING_NOTE, WIDEST_DOOR_M, leaved
from .paper import Sheet
from .storey_plan import StoreyPlan, Surroundings
from .style import shortened
from .titleblock import Titles

_MOST_STAIRS: Final = 6


def titles(around: Surroundings, plan: StoreyPlan, paper: Sheet) -> Titles:
    """Return the title block of a storey's sheet."""
    graph = around.graph
    building = graph.nodes[graph.building].properties if graph.building in graph.nodes else {}
    given = plan.node.properties
    rows = [
        ("storey", f"{given['index']} of {_last(around)}" if "index" in given else None),
        ("elevation", f"{round(given['elevation'], 2) + 0.0:+.2f} m" if "elevation" in given else None),
        ("rooms", _rooms(plan)),
        ("scans", _scans(building)),
        ("ingested", str(building["ingested_at"])[:10] if "ingested_at" in building else None),
        ("scale", f"1:{paper.scale} on {paper.name}"),
    ]
    known = tuple((word, value) for word, value in rows if value is not None)
    name = str(given.get("name") or plan.node.id.split("/", 1)[1])
    return Titles(str(building.get("name") or graph.building), name, known)


def _last(around: Surroundings) -> int:
    return max((node.properties.get("index", 0) for node in around.graph.of_label("Storey")), default=0)


def _rooms(plan: StoreyPlan) -> str:
    areas = [room.node.properties.get("area") for room in plan.scene.rooms.values()]
    known = [area for area in areas if area is not None]
    count = f"{len(areas)} room{'s' if len(areas) != 1 else ''}"
    return f"{count}, {sum(known):,.1f} m²" if known else count


def _scans(building: dict[str, object]) -> str | None:
    count = building.get("scan_count")
    return None if count is None else f"{count}"


def remarks(around: Surroundings, plan: StoreyPlan) -> list[str]:
    """Return what must be said about a sheet, a sentence each."""
    return list(_about_walls(around, plan)) + list(_about_openings(plan)) + list(_about_rooms(around, plan))


def _about_walls(around: Surroundings, plan: StoreyPlan) -> Iterable[str]:
    thick = f"{100 * plan.outer_m:.0f} cm"
    if around.grid is None:
        yield f"Walls after the outlines of rooms, there is no cloud; outer walls drawn {thick} thick."
    else:
        yield f"Walls after the scanned faces; of outer walls only the inside was seen, drawn {thick} thick."
    if not plan.walls.unseen.is_empty:
        yield "Dotted edges: no wall was seen there."
    if around.frame.angle:
        turned = np.degrees(around.frame.angle)
        way = "anticlockwise" if turned > 0 else "clockwise"
        yield f"Turned by {abs(turned):.1f}° {way} against the axes of the scans; north is not known."


def _about_openings(plan: StoreyPlan) -> Iterable[str]:
    kinds = {one.opening.kind for one in plan.gaps}
    if plan.leaves:
        yield SWING_NOTE
        yield "Leaves as scanned: open at 90°, ajar at 30°, closed within the wall. Triangle: door to the outside."
    if any(one.opening.kind == "door" and not leaved(one) for one in plan.gaps):
        yield f"Openings over {WIDEST_DOOR_M:.1f} m wide have no leaf drawn, only their lintel, dashed."
    if any(one.opening.doubtful for one in plan.gaps):
        yield "Dashed doors and windows: doubtful."
    if "window" in kinds and any(
        float(one.opening.node.properties.get("sill", 0)) >= 1.2 for one in plan.gaps if one.opening.kind == "window"
    ):
        yield "Dashed panes: the sill is above the cut, 1.2 m over the floor."
    yield from _where_stairs_lead(plan)
    if any(not flight.measured for stairs in plan.stairs for flight in stairs.flights):
        yield "Dashed stairs: only the hole is known, not which way they rise."


def _where_stairs_lead(plan: StoreyPlan) -> Iterable[str]:
    said = []
    for stairs in plan.stairs:
        there = [room for room in stairs.opening.rooms if room not in plan.scene.rooms]
        if there and stairs.upward is not None:
            name = plan.scene.graph.nodes[there[0]].properties.get("name") or there[0].split("/", 1)[1]
            said.append(f"{'up' if stairs.upward else 'down'} to {shortened(str(name))}")
    if said:
        more = f" and {len(said) - _MOST_STAIRS} more" if len(said) > _MOST_STAIRS else ""
        yield f"Stairs {', '.join(dict.fromkeys(said[:_MOST_STAIRS]))}{more}."


def _about_rooms(around: Surroundings, plan: StoreyPlan) -> Iterable[str]:
    rooms = plan.scene.rooms.values()
    if any("scan_positions" in room.node.properties for room in rooms):
        yield "Crosses: positions of the scanner."
    missing = [room.name for room in rooms if not room.outlined]
    if missing:
        yield f"No outline is known of {len(missing)} of {len(rooms)} rooms: drawn by bounds or centres, without walls."
    if plan.voids:
        yield "Crossed out: a room of a storey below reaches through this one."
