"""A plan of a storey with the graph drawn over it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from enfilade.clouds import LabelledCloud
from enfilade.errors import NotFoundError
from enfilade.schema.graph import BuildingGraph, Node

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
from .scene import PlanScene, plan_scene
from .style import FAINT_INK, INK, OPENING_COLOURS, shortened, words

F64 = NDArray[np.float64]

_LONG_SIDE_IN: Final = 9.0
_LARGEST_IN: Final = 20.0
_IN_PER_M: Final = 0.4
"""A large building gets a larger sheet, so that its scale stays about 1:100."""
_MOST_IN_PER_M: Final = 1.6
_MARGIN_M: Final = 0.6
_HEAD_IN: Final = 0.7
_FOOT_IN: Final = 0.65
_SCALE_IN: Final = 2.0
_SAMPLE_IN: Final = 1.0
"""Room for the scale bar, and for each sample of the legend; the legend has two lines where they do not fit in one."""
_WIDTHS_PT_PER_M: Final = 24.0
"""From this scale on the widths of doors are written beside them."""


def draw_storeys(graph: BuildingGraph, path: Path, *, cloud: LabelledCloud | None = None) -> list[Path]:
    """Draw each storey that has a room with a place; ``plan.png`` becomes ``plan-s0.png``, ``plan-s1.png``, ...

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
    drawn, walls = [], wall_points(cloud)
    for storey in sorted(graph.of_label("Storey"), key=lambda node: (node.properties.get("index", 0), node.id)):
        scene = plan_scene(graph, [room.id for room in graph.targets(storey.id, "HAS_ROOM")])
        if scene.rooms:
            drawn.append(path.with_name(f"{path.stem}-{storey.id.rsplit('/', 1)[-1]}{path.suffix}"))
            _draw(scene, drawn[-1], _title(graph, storey), walls)
    if not drawn:
        raise NotFoundError(f"The building {graph.building!r} has no room with an outline or a centre to draw.")
    return drawn


def draw_plan(
    graph: BuildingGraph,
    path: Path,
    *,
    storey: str | None = None,
    cloud: LabelledCloud | None = None,
    title: str | None = None,
) -> None:
    """Draw a plan as PNG, SVG or PDF.

    Parameters
    ----------
    graph
        The building.
    path
        File to write.
    storey
        Id of the storey; the lowest one if not given.
    cloud
        Gives the print of the walls; without it rooms are outlined.
    title
        Instead of the names of building and storey.

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
    node = _storey(graph, storey)
    scene = plan_scene(graph, [room.id for room in graph.targets(node.id, "HAS_ROOM")])
    if not scene.rooms:
        raise NotFoundError(f"The storey {node.id!r} has no room with an outline or a centre to draw.")
    _draw(scene, path, title or _title(graph, node), wall_points(cloud))


def _storey(graph: BuildingGraph, storey: str | None) -> Node:
    storeys = {node.id: node for node in graph.of_label("Storey")}
    if storey is None and storeys:
        return min(storeys.values(), key=lambda node: (node.properties.get("index", 0), node.id))
    if storey is None or storey not in storeys:
        known = ", ".join(storeys) or "none"
        raise NotFoundError(f"There is no storey {storey!r} in {graph.building!r}; it has {known}.")
    return storeys[storey]


def _title(graph: BuildingGraph, storey: Node) -> str:
    building = graph.nodes[graph.building].properties.get("name") if graph.building in graph.nodes else None
    name = storey.properties.get("name") or storey.id.split("/", 1)[1]
    return f"{shortened(str(building or graph.building), 40)} · {shortened(str(name), 40)}"


def _draw(scene: PlanScene, path: Path, title: str, walls: F64 | None) -> None:
    figure, axes, points_per_metre = plan_axes(scene)
    draw_masonry(axes, scene)
    draw_rooms(axes, scene.rooms.values(), outlined=walls is None)
    if walls is not None:
        draw_walls(axes, walls, wall_band(scene))
    draw_openings(axes, scene, widths=points_per_metre >= _WIDTHS_PT_PER_M)
    draw_graph(axes, scene, node_pt=5.0 if points_per_metre >= _WIDTHS_PT_PER_M else 3.6)
    draw_stairs(axes, scene, size_m=15 / points_per_metre)
    write_names(axes, scene.rooms.values(), points_per_metre, largest_pt=9.0)
    _write_head(figure, scene, title)
    _draw_foot(figure, axes, scene)
    save(figure, path)


def plan_axes(scene: PlanScene) -> tuple[Figure, Axes, float]:
    """Return a sheet for a plan, its axes in metres, and how many points a metre has on paper."""
    x0, y0, x1, y1 = scene.bounds
    width, height = x1 - x0 + 2 * _MARGIN_M, y1 - y0 + 2 * _MARGIN_M
    long_side = max(width, height)
    scale = min(max(_LONG_SIDE_IN / long_side, _IN_PER_M), _LARGEST_IN / long_side, _MOST_IN_PER_M)
    across, up = max(width * scale, 6.5), height * scale
    figure = sheet(across, up + _HEAD_IN + _FOOT_IN)
    total = up + _HEAD_IN + _FOOT_IN
    axes = figure.add_axes((0.0, _FOOT_IN / total, 1.0, up / total))
    slack = (across / scale - width) / 2
    axes.set_xlim(x0 - _MARGIN_M - slack, x1 + _MARGIN_M + slack)
    axes.set_ylim(y0 - _MARGIN_M, y1 + _MARGIN_M)
    axes.set_aspect("equal")
    axes.set_autoscale_on(False)
    axes.axis("off")
    return figure, axes, scale * 72


def _write_head(figure: Figure, scene: PlanScene, title: str) -> None:
    height = figure.get_figheight()
    areas = [room.node.properties.get("area") for room in scene.rooms.values()]
    known = [area for area in areas if area is not None]
    counts = f"{len(scene.rooms)} room{'s' if len(scene.rooms) != 1 else ''}"
    line = f"{counts}, {sum(known):,.0f} m²" if known else counts
    figure.text(0.25 / figure.get_figwidth(), 1 - 0.3 / height, title, **words(13, ha="left", weight="bold"))
    figure.text(0.25 / figure.get_figwidth(), 1 - 0.56 / height, line, **words(8.5, ha="left", color=FAINT_INK))


def _draw_foot(figure: Figure, axes: Axes, scene: PlanScene) -> None:
    """Draw scale and legend under the plan."""
    x0, x1 = axes.get_xlim()
    y0, _ = axes.get_ylim()
    scale = figure.get_figwidth() / (x1 - x0)
    draw_scale(axes, x0 + 0.27 / scale, y0 - 0.38 / scale, x1 - x0)
    handles = _legend(scene)
    figure.legend(
        handles=handles,
        loc="lower right",
        ncols=min(len(handles), max(1, int((figure.get_figwidth() - _SCALE_IN) / _SAMPLE_IN))),
        frameon=False,
        fontsize=7,
        labelcolor=INK,
        handlelength=1.8,
        columnspacing=1.3,
        bbox_to_anchor=(1 - 0.1 / figure.get_figwidth(), 0.12 / figure.get_figheight()),
    )


def _legend(scene: PlanScene) -> list[Line2D]:
    """Return a sample of each thing that the plan has."""
    kinds = {(opening.kind, opening.closed and opening.kind == "door") for opening in scene.openings}
    samples: dict[tuple[str, bool], dict[str, Any]] = {
        ("door", False): {"linewidth": 3.2, "label": "door"},
        ("door", True): {"linewidth": 3.2, "label": "closed door", "dashes": (1, 0.7)},
        ("passage", False): {"linewidth": 1.2, "label": "passage", "dashes": (2, 2)},
        ("window", False): {"linewidth": 1.4, "label": "window"},
        ("stairs", False): {"marker": "s", "linestyle": "none", "mfc": "none", "label": "stairs"},
        ("hatch", False): {"marker": "s", "linestyle": "none", "mfc": "none", "label": "hatch"},
    }
    handles = [Line2D([], [], color=OPENING_COLOURS[key[0]], **style) for key, style in samples.items() if key in kinds]
    handles.append(Line2D([], [], color=INK, linewidth=0.9, marker="o", markersize=4, label="room and way"))
    if scene.neighbours:
        handles.append(Line2D([], [], color=FAINT_INK, linewidth=0.7, dashes=(1, 3), label="neighbours"))
    return handles
