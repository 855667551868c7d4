"""Plans of storeys as an architect would draw them, a sheet each, at a true scale."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray

from enfilade.clouds import LabelledCloud
from enfilade.errors import NotFoundError
from enfilade.schema.graph import BuildingGraph, Node

from .canvas import check_suffix, save
from .furniture import draw_furniture
from .leaves import draw_door, draw_lintel, draw_passage, draw_window, leaved
from .lettering import LINE, MM_PER_PT, SMALLER, Label, place_labels
from .paper import Sheet, choose_sheet, lay_out
from .pen import DASHED, DOTTED, FINE_MM, SEEN_MM, Pen
from .remarks import remarks, titles
from .scene import Bounds, outline_rings
from .steps import draw_hatch, draw_stairs
from .storey_plan import StoreyPlan, Surroundings, plan_storeys, surroundings
from .style import FAINT_INK, INK, PAPER, shortened
from .titleblock import band_mm, draw_band

F64 = NDArray[np.float64]

_SCAN_MM: Final = 1.1
_FLOOR, _VOID, _WALL, _UNSEEN, _SCAN, _NAME = 1.0, 1.5, 3.6, 3.8, 5.0, 6.0


def draw_storeys(
    graph: BuildingGraph, path: Path, *, cloud: LabelledCloud | None = None, furniture: bool = False
) -> list[Path]:
    """Draw each storey that has a room with a place; ``plan.png`` becomes ``plan-s0.png``, ``plan-s1.png``, ...

    All sheets have one scale, one size and one angle, so that they can be laid over one another.

    Returns
    -------
    list of Path
        The files, the lowest storey first.

    Raises
    ------
    InputError, NotFoundError, StoreError
        As `draw_plan`.
    """
    check_suffix(path)
    return _draw_each(graph, _storeys(graph), [path], cloud, furniture=furniture)


def draw_plans(
    graph: BuildingGraph,
    target: Path,
    *,
    cloud: LabelledCloud | None = None,
    storey: str | None = None,
    furniture: bool = False,
) -> list[Path]:
    """Draw all storeys or one, into files named after `target`, or as PNG and SVG into it where it is a folder.

    A target without a suffix is a folder, made where missing; the files in it are named after the building.

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    InputError, NotFoundError, StoreError
        As `draw_plan`.
    """
    if target.is_dir() or not target.suffix:
        name = re.sub(r"[^\w.-]+", "_", graph.building)
        paths = [target / f"{name}.png", target / f"{name}.svg"]
    else:
        check_suffix(target)
        if storey is not None:
            draw_plan(graph, target, storey=storey, cloud=cloud, furniture=furniture)
            return [target]
        paths = [target]
    storeys = _storeys(graph) if storey is None else [find_storey(graph, storey)]
    return _draw_each(graph, storeys, paths, cloud, furniture=furniture)


def _draw_each(
    graph: BuildingGraph,
    storeys: Sequence[Node],
    paths: Sequence[Path],
    cloud: LabelledCloud | None,
    *,
    furniture: bool,
) -> list[Path]:
    """Draw storeys, each into a file beside every path, named after it and the storey."""
    around = surroundings(graph, cloud, furniture=furniture)
    plans = plan_storeys(around, storeys)
    if not plans:
        raise NotFoundError(f"The building {graph.building!r} has no room with an outline or a centre to draw.")
    files = [
        [path.with_name(f"{path.stem}-{plan.node.id.rsplit('/', 1)[-1]}{path.suffix}") for path in paths]
        for plan in plans
    ]
    _draw_sheets(around, plans, files)
    return [file for beside in files for file in beside]


def without_outline(graph: BuildingGraph) -> int:
    """Count the rooms of which no outline is known."""
    return sum(not outline_rings(room.properties) for room in graph.of_label("Room"))


def draw_plan(
    graph: BuildingGraph,
    path: Path,
    *,
    storey: str | None = None,
    cloud: LabelledCloud | None = None,
    title: str | None = None,
    furniture: bool = False,
) -> None:
    """Draw a plan as PNG, SVG or PDF.

    Parameters
    ----------
    graph
        The building.
    path
        File to write.
    storey
        Id, name or index of the storey; the lowest one if not given.
    cloud
        Shows where walls and stairs are; without it the outlines in the graph have to do.
    title
        Instead of the building's name.
    furniture
        Whether to draw objects too, lightly.

    Raises
    ------
    InputError
        If the suffix of the file is unknown.
    NotFoundError
        If there is no such storey, or no room in it has a place.
    StoreError
        If the file cannot be written.
    """
    check_suffix(path)
    node = find_storey(graph, storey)
    around = surroundings(graph, cloud, furniture=furniture)
    plans = plan_storeys(around, [node])
    if not plans:
        raise NotFoundError(f"The storey {node.id!r} has no room with an outline or a centre to draw.")
    _draw_sheets(around, plans, [[path]], title=title)


def _storeys(graph: BuildingGraph) -> list[Node]:
    return sorted(graph.of_label("Storey"), key=lambda node: (node.properties.get("index", 0), node.id))


def find_storey(graph: BuildingGraph, storey: str | None) -> Node:
    """Return a storey by id, the part of it after the slash, name or index; the lowest one for None.

    Raises
    ------
    NotFoundError
        If there is none such.
    """
    storeys = _storeys(graph)
    if storey is None and storeys:
        return storeys[0]
    for node in storeys:
        if storey in (node.id, node.id.split("/", 1)[1]):
            return node
    for name in ("name", "index"):
        for node in storeys:
            if str(node.properties.get(name)) == storey:
                return node
    known = ", ".join(node.id for node in storeys) or "none"
    raise NotFoundError(f"There is no storey {storey!r} in {graph.building!r}; it has {known}.")


def _draw_sheets(
    around: Surroundings,
    plans: Sequence[StoreyPlan],
    files: Sequence[Sequence[Path]],
    *,
    title: str | None = None,
) -> None:
    """Draw plans on sheets of one size and scale, each into its files."""
    bounds = _around([plan.bounds for plan in plans])
    paper, labels = _fit(around, plans, bounds)
    for plan, beside, placed in zip(plans, files, labels, strict=True):
        figure, pen, millimetres = lay_out(paper, bounds)
        _draw(pen, plan, placed, around)
        heading = titles(around, plan, paper)
        if title is not None:
            heading = replace(heading, building=title)
        listed = [label for label in placed if label.number is not None]
        draw_band(millimetres, paper, heading, remarks(around, plan), listed)
        for file in beside:
            save(figure, file)


def _around(bounds: Sequence[Bounds]) -> Bounds:
    low, high = np.array(bounds)[:, :2].min(axis=0), np.array(bounds)[:, 2:].max(axis=0)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def _fit(around: Surroundings, plans: Sequence[StoreyPlan], bounds: Bounds) -> tuple[Sheet, list[list[Label]]]:
    """Choose paper and scale so that plan, notes and the list of small rooms have their places."""
    band = 0.0
    while True:
        paper = choose_sheet(bounds, band)
        labels = [_labels(plan, paper) for plan in plans]
        needed = max(
            band_mm(titles(around, plan, paper), remarks(around, plan), _count_listed(placed), paper.width_mm)
            for plan, placed in zip(plans, labels, strict=True)
        )
        if needed <= band:
            return paper, labels
        band = needed


def _count_listed(labels: Sequence[Label]) -> int:
    return sum(label.number is not None for label in labels)


def _labels(plan: StoreyPlan, paper: Sheet) -> list[Label]:
    rooms, arm = list(plan.scene.rooms.values()), _SCAN_MM / paper.mm_per_m
    crosses = [
        shapely.box(*(place - arm), *(place + arm))
        for room in rooms
        for place in plan.scene.frame.points(scan_places(room.node.properties))
    ]
    return place_labels(rooms, plan.lines, plan.obstacles, paper.mm_per_m, crosses)


def _draw(pen: Pen, plan: StoreyPlan, labels: Sequence[Label], around: Surroundings) -> None:
    """Draw a storey from the floor up."""
    for room in plan.scene.rooms.values():
        edge = "none" if room.outlined else FAINT_INK
        pen.area(
            room.polygon, layer=_FLOOR, fill=PAPER, edge=edge, weight=SEEN_MM, style=DASHED, gid=f"room-{room.local}"
        )
    _draw_voids(pen, plan)
    pen.area(plan.walls.solid, layer=_WALL, fill=INK, edge=INK, weight=FINE_MM, gid="walls")
    unseen = [np.asarray(line.coords) for line in plan.walls.unseen.geoms]
    pen.lines(unseen, layer=_UNSEEN, weight=SEEN_MM, style=DOTTED, gid="unseen")
    if around.furniture:
        draw_furniture(pen, plan.scene, around.outlines)
    _draw_openings(pen, plan)
    _mark_scans(pen, plan)
    for label in labels:
        _write_label(pen, label)


def _draw_openings(pen: Pen, plan: StoreyPlan) -> None:
    for one in plan.gaps:
        if one.opening.kind == "window":
            draw_window(pen, one)
        elif one.opening.kind == "passage":
            draw_passage(pen, one)
        elif not leaved(one):
            draw_lintel(pen, one)
        else:
            draw_door(pen, one, plan.leaves[one.opening.node.id])
    for stairs in plan.stairs:
        draw_stairs(pen, stairs, plan.scene)
    for opening in plan.scene.openings:
        if opening.kind == "hatch":
            draw_hatch(pen, opening, opening.node.id.split("/", 1)[1])


def _draw_voids(pen: Pen, plan: StoreyPlan) -> None:
    """Cross out where a room below reaches through this storey."""
    for void in plan.voids:
        x0, y0, x1, y1 = void.shape.bounds
        cross = shapely.MultiLineString([[(x0, y0), (x1, y1)], [(x0, y1), (x1, y0)]]).intersection(void.shape)
        pen.area(void.shape, layer=_VOID, fill=PAPER, edge=INK, weight=FINE_MM, style=DASHED)
        pen.lines(
            [np.asarray(part.coords) for part in shapely.get_parts(cross) if part.geom_type == "LineString"],
            layer=_VOID,
            weight=FINE_MM,
            style=DASHED,
        )
        name = plan.scene.graph.nodes[void.room].properties.get("name") or void.room.split("/", 1)[1]
        paper = {"facecolor": PAPER, "edgecolor": "none", "pad": 0.6}
        place = np.array(void.shape.representative_point().coords[0])
        pen.write(place, f"void over\n{shortened(str(name))}", 6.5, layer=_NAME, bbox=paper)


def _mark_scans(pen: Pen, plan: StoreyPlan) -> None:
    """Mark where the scanner stood by small crosses."""
    arm = _SCAN_MM / pen.mm_per_m
    for room in plan.scene.rooms.values():
        places = scan_places(room.node.properties)
        if len(places):
            arms = np.array([[(-arm, 0), (arm, 0)], [(0, -arm), (0, arm)]])
            crosses = [place + line for place in plan.scene.frame.points(places) for line in arms]
            pen.lines(crosses, layer=_SCAN, weight=FINE_MM, colour=FAINT_INK, gid=f"scans-{room.local}")


def scan_places(properties: Mapping[str, object]) -> F64:
    """``(n, 2)`` where the scans of a room stand."""
    given = np.asarray(properties.get("scan_positions", ()), dtype=np.float64)
    return given.reshape(-1, 3)[:, :2] if given.size % 3 == 0 else np.empty((0, 2))


def _write_label(pen: Pen, label: Label) -> None:
    if label.number is not None:
        pen.write(
            label.place, str(label.number), label.size_pt, layer=_NAME, weight="bold", gid=f"label-{label.room.local}"
        )
        return
    line = LINE * label.size_pt * MM_PER_PT / pen.mm_per_m
    top = label.place[1] + line * (len(label.names) + SMALLER * len(label.more)) / 2
    for place, name in enumerate(label.names):
        spot = np.array([label.place[0], top - line * (place + 0.5)])
        pen.write(
            spot,
            name,
            label.size_pt,
            layer=_NAME,
            weight="bold",
            gid=f"label-{label.room.local}" if place == 0 else None,
        )
    for place, text in enumerate(label.more):
        spot = np.array([label.place[0], top - line * (len(label.names) + SMALLER * (place + 0.5))])
        pen.write(spot, text, SMALLER * label.size_pt, layer=_NAME)
