"""One match as a picture: where its rooms are, and the objects found next to the objects asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from enfilade.clouds import LabelledCloud
from enfilade.descriptors import DEFAULT_LAYOUT, Shape, best_turn, describe, mesh_views
from enfilade.errors import NotFoundError
from enfilade.schema.graph import BuildingGraph, Node
from enfilade.schema.ids import parse
from enfilade.schema.topology import Topology, topology

from .canvas import check_suffix, save, sheet
from .layers import (
    draw_graph,
    draw_masonry,
    draw_openings,
    draw_rooms,
    draw_scale,
    draw_stairs,
    draw_walls,
    wall_band,
    wall_points,
)
from .names import write_names
from .scene import Bounds, PlanScene, plan_scene
from .solid import Camera, render_mesh, render_points, span_of
from .style import FAINT_INK, HIGHLIGHT, OBJECT, halo, shortened, words

F64 = NDArray[np.float64]

_PANEL_IN: Final = (6.0, 4.6)
"""Greatest width of one panel, and of several."""
_TALLEST_IN: Final = 6.0
_IMAGE_IN: Final = 2.5
_CAPTION_IN: Final = 0.5
_GAP_IN: Final = 0.3
_HEAD_IN: Final = 1.0
_FOOT_IN: Final = 0.55
_AROUND_M: Final = 1.2
"""So much of the plan is shown around the rooms of the match."""
_MOST_OBJECTS: Final = 4
_PALE: Final = "#f3f4f6"


@dataclass(frozen=True, slots=True)
class FoundObject:
    """An object of the match: how the question calls it, its points where they are known, what was asked for."""

    column: str
    node: Node
    points: F64 | None
    asked: Shape | None


def draw_match(
    path: Path,
    graph: BuildingGraph,
    row: Mapping[str, Any],
    *,
    cloud: LabelledCloud | None = None,
    shapes: Mapping[str, Shape] | None = None,
    title: str | None = None,
) -> None:
    """Draw a match as PNG, SVG or PDF.

    On the left the rooms of the match on the plan, a panel a storey, with the ways between them; on the right each
    object found, turned as the shape asked for lies, next to that shape and at the same scale.

    Parameters
    ----------
    path
        File to write.
    graph
        The building that the match lies in.
    row
        The match: a value a column, nodes as their ids; ``score`` is written in the head.
    cloud
        The building's points, which show walls and objects.
    shapes
        What was asked for, by the column of the object.
    title
        Heading; "Match in BUILDING" if not given.

    Raises
    ------
    InputError
        If the suffix of the file is unknown.
    NotFoundError
        If the row names no room or object that has a place.
    StoreError
        If the file cannot be written.
    """
    check_suffix(path)
    ends = topology(graph)
    nodes = {column: graph.nodes[value] for column, value in row.items() if _is_node(graph, value)}
    columns = _room_columns(nodes, ends)
    scenes = [scene for scene in _scenes(graph, ends, columns) if scene.rooms.keys() & columns.keys()]
    if not scenes:
        raise NotFoundError("The match names no room or object with a place on a plan; return one to draw it.")
    objects = _found(nodes, cloud, shapes or {})
    figure = _draw(graph, scenes, columns, objects, wall_points(cloud))
    _write_head(figure, row, nodes, title or f"Match in {shortened(graph.building, 40)}")
    save(figure, path)


def _draw(
    graph: BuildingGraph,
    scenes: Sequence[PlanScene],
    columns: Mapping[str, str],
    objects: Sequence[FoundObject],
    walls: F64 | None,
) -> Figure:
    """Draw the panels of the plan and the images of the objects."""
    frame = _frame(scenes, columns)
    figure, panels, images, points_per_metre = _grid(len(scenes), len(objects), frame)
    for axes, scene in zip(panels, scenes, strict=True):
        _show(axes, frame)
        _draw_panel(axes, scene, columns, walls, points_per_metre)
        _mark_objects(axes, scene, objects, points_per_metre)
        _name_storey(axes, graph, scene.topology.storey_of[next(iter(scene.rooms))])
    draw_scale(panels[0], frame[0], frame[1] - 0.3 * 72 / points_per_metre, frame[2] - frame[0])
    for (left, right), found in zip(images, objects, strict=True):
        _draw_object(left, right, found)
    return figure


def _found(nodes: Mapping[str, Node], cloud: LabelledCloud | None, shapes: Mapping[str, Shape]) -> list[FoundObject]:
    """Return the first few objects of the match."""
    objects = [(column, node) for column, node in nodes.items() if node.label == "Object"][:_MOST_OBJECTS]
    return [FoundObject(column, node, _points(node, cloud), shapes.get(column)) for column, node in objects]


def _is_node(graph: BuildingGraph, value: object) -> bool:
    return isinstance(value, str) and value in graph.nodes


def _room_columns(nodes: Mapping[str, Node], ends: Topology) -> dict[str, str]:
    """Rooms to show by id, each with the columns that name it; rooms of objects have an empty text."""
    columns: dict[str, str] = {}
    for column, node in nodes.items():
        if node.label == "Room":
            columns[node.id] = f"{columns[node.id]}, {column}" if columns.get(node.id) else column
        elif node.label == "Object" and node.id in ends.room_of:
            columns.setdefault(ends.room_of[node.id], "")
    return columns


def _scenes(graph: BuildingGraph, ends: Topology, columns: Mapping[str, str]) -> list[PlanScene]:
    """Return a scene for each storey that has a room of the match, the lowest first."""
    storeys = {ends.storey_of[room] for room in columns if room in ends.storey_of}
    ordered = sorted(storeys, key=lambda storey: (graph.nodes[storey].properties.get("index", 0), storey))
    return [plan_scene(graph, [room for room, on in ends.storey_of.items() if on == storey]) for storey in ordered]


def _points(node: Node, cloud: LabelledCloud | None) -> F64 | None:
    """Return the points of an object, or None where there are none."""
    if cloud is None:
        return None
    numbers = [number for segment in node.properties.get("segments", [node.id]) for number in parse(segment).numbers]
    points = cloud.positions[np.isin(cloud.object, numbers)]
    return points if len(points) else None


def _frame(scenes: Sequence[PlanScene], columns: Mapping[str, str]) -> Bounds:
    """Return the part of the plan to show, the same on every storey: the rooms of the match and some way around."""
    rings = [ring for scene in scenes for id, room in scene.rooms.items() if id in columns for ring in room.rings]
    points = np.concatenate(rings)
    (x0, y0), (x1, y1) = points.min(axis=0) - _AROUND_M, points.max(axis=0) + _AROUND_M
    # Neither a corridor nor a tower makes a good picture.
    grow_x, grow_y = max(0.0, (y1 - y0) * 0.6 - (x1 - x0)) / 2, max(0.0, (x1 - x0) * 0.6 - (y1 - y0)) / 2
    return float(x0 - grow_x), float(y0 - grow_y), float(x1 + grow_x), float(y1 + grow_y)


def _grid(panels: int, objects: int, frame: Bounds) -> tuple[Figure, list[Axes], list[tuple[Axes, Axes]], float]:
    """Return a sheet with panels in a row, two images an object right of them, and how many points a metre has."""
    x0, y0, x1, y1 = frame
    scale = min(_PANEL_IN[min(panels, 2) - 1] / (x1 - x0), _TALLEST_IN / (y1 - y0))
    wide, high = (x1 - x0) * scale, (y1 - y0) * scale
    body = max(high, objects * (_IMAGE_IN + _CAPTION_IN))
    across = _GAP_IN + panels * (wide + _GAP_IN) + (2 * _IMAGE_IN + 2 * _GAP_IN if objects else 0.0)
    figure = sheet(across, body + _HEAD_IN + _FOOT_IN)
    low = _FOOT_IN + (body - high) / 2
    plans = [_axes(figure, _GAP_IN + n * (wide + _GAP_IN), low, wide, high) for n in range(panels)]
    start, step = _GAP_IN + panels * (wide + _GAP_IN) + _GAP_IN / 2, body / max(objects, 1)
    images = []
    for place in range(objects):
        low = _FOOT_IN + body - (place + 1) * step + (step - _IMAGE_IN - _CAPTION_IN) / 2
        left = _axes(figure, start, low, _IMAGE_IN, _IMAGE_IN)
        images.append((left, _axes(figure, start + _IMAGE_IN + _GAP_IN / 2, low, _IMAGE_IN, _IMAGE_IN)))
    return figure, plans, images, scale * 72


def _axes(figure: Figure, left: float, low: float, wide: float, high: float) -> Axes:
    """Add axes without a frame at a place in inches."""
    across, up = figure.get_size_inches()
    axes = figure.add_axes((left / across, low / up, wide / across, high / up))
    axes.axis("off")
    return axes


def _draw_panel(
    axes: Axes,
    scene: PlanScene,
    columns: Mapping[str, str],
    walls: F64 | None,
    points_per_metre: float,
) -> None:
    """Draw the rooms of the match on one storey, the rest of it pale."""
    chosen = {id: room for id, room in scene.rooms.items() if id in columns}
    others = [replace(room, tint=_PALE) for id, room in scene.rooms.items() if id not in columns]
    inner = (opening for opening in scene.openings if len(opening.rooms) > 1 and set(opening.rooms) <= columns.keys())
    ways = tuple(opening for opening in inner if opening.kind != "window")
    match = replace(scene, rooms=chosen, openings=ways, neighbours=())
    draw_masonry(axes, scene)
    draw_rooms(axes, others, outlined=False)
    draw_rooms(axes, chosen.values(), outlined=walls is None)
    if walls is not None:
        draw_walls(axes, walls, wall_band(scene))
    draw_openings(axes, match, widths=True)
    draw_graph(axes, match, node_pt=5.0)
    draw_stairs(axes, match, size_m=15 / points_per_metre)
    write_names(axes, chosen.values(), points_per_metre, largest_pt=9.0, prefixes=columns)


def _show(axes: Axes, frame: Bounds) -> None:
    x0, y0, x1, y1 = frame
    axes.set_xlim(x0, x1)
    axes.set_ylim(y0, y1)
    axes.set_autoscale_on(False)
    border = Rectangle((x0, y0), x1 - x0, y1 - y0, facecolor="none", edgecolor=FAINT_INK, linewidth=0.6, clip_on=False)
    border.set_zorder(9)
    axes.add_patch(border)


def _name_storey(axes: Axes, graph: BuildingGraph, storey: str) -> None:
    name = graph.nodes[storey].properties.get("name") or storey.split("/", 1)[1]
    axes.set_title(shortened(str(name)), loc="left", pad=4, fontsize=8.5, color=FAINT_INK, parse_math=False)


def _mark_objects(axes: Axes, scene: PlanScene, objects: Sequence[FoundObject], points_per_metre: float) -> None:
    """Show the objects of this storey as seen from above, with the names that the question gives them."""
    for found in objects:
        if scene.topology.room_of.get(found.node.id) not in scene.rooms:
            continue
        top = _seen_from_above(found)
        if top is None:
            continue
        size = 1.2 if found.points is not None else 60
        axes.scatter(top[:, 0], top[:, 1], s=size, color=HIGHLIGHT, linewidth=0, zorder=4.5)
        x, y = top[:, 0].max(), top[:, 1].max()
        style = words(10, color=HIGHLIGHT, weight="bold", zorder=8, path_effects=halo(2.5))
        axes.text(x + 5 / points_per_metre, y + 5 / points_per_metre, found.column, **style)


def _seen_from_above(found: FoundObject) -> F64 | None:
    """Return ``(n, 2)`` points of an object, or its position, or None where it has no place."""
    if found.points is not None:
        return found.points[:: 1 + len(found.points) // 3000, :2]
    position = found.node.properties.get("position")
    return None if position is None else np.asarray(position, dtype=np.float64)[None, :2]


def _draw_object(left: Axes, right: Axes, found: FoundObject) -> None:
    """Render what was found and what was asked for, at one scale."""
    points = found.points
    if points is not None and found.asked is not None:
        points = _turned(points, found.asked)
    known = [cloud for cloud in (points, None if found.asked is None else found.asked.vertices) if cloud is not None]
    if not known:
        return
    camera = Camera(span_of(*known))
    if points is not None:
        left.imshow(render_points(points, camera, HIGHLIGHT))
        name = shortened(str(found.node.properties.get("name") or found.node.id))
        _caption(left, f"found: {found.column}", f"{name}, {len(points):,} points")
    if found.asked is not None:
        asked = found.asked
        mesh = render_mesh(asked.vertices, asked.triangles, camera, OBJECT) if asked.is_mesh else None
        right.imshow(render_points(asked.vertices, camera, OBJECT) if mesh is None else mesh)
        _caption(right, "asked for", shortened(asked.name))


def _turned(points: F64, asked: Shape) -> F64:
    """Turn an object about the vertical as the shape lies, as the distance of their descriptors does."""
    counts = describe(points, float(points[:, 2].min()))
    angle = best_turn(mesh_views(asked), counts, DEFAULT_LAYOUT.shape)
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    return np.asarray(points @ turn.T)


def _caption(axes: Axes, first: str, second: str) -> None:
    axes.text(0.5, 1.035, first, transform=axes.transAxes, **words(9.5, weight="bold", va="bottom"))
    axes.text(0.5, 1.02, second, transform=axes.transAxes, **words(8, color=FAINT_INK, va="top"))


def _write_head(figure: Figure, row: Mapping[str, Any], nodes: Mapping[str, Node], title: str) -> None:
    left, height = 0.25 / figure.get_figwidth(), figure.get_figheight()
    score = row.get("score")
    heading = f"{title}  ·  score {score:.3f}" if isinstance(score, (int, float)) else title
    figure.text(left, 1 - 0.32 / height, heading, **words(13, ha="left", weight="bold"))
    named = "     ".join(f"{column}: {_named(node)}" for column, node in nodes.items())
    figure.text(left, 1 - 0.6 / height, named, **words(8.5, ha="left", color=FAINT_INK))


def _named(node: Node) -> str:
    name, area = shortened(str(node.properties.get("name") or node.id)), node.properties.get("area")
    known = f"{name} ({node.id})" if name != node.id else name
    return f"{known}, {area:.1f} m²" if area is not None and node.label == "Room" else known
