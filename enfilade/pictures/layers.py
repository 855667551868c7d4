"""The layers of a plan, from the floor up: walls, rooms, openings, the graph, names, scale."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch, Polygon, Rectangle
from matplotlib.path import Path
from numpy.typing import NDArray
from shapely import Point, unary_union

from enfilade.clouds import LabelledCloud

from .scene import PlannedOpening, PlannedRoom, PlanScene
from .style import FAINT_INK, INK, MASONRY, OPENING_COLOURS, PAPER, THRESHOLD, WALL, halo, shortened, words

F64 = NDArray[np.float64]

_WALL_CELL_M: Final = 0.03
_LEAST_UPRIGHT_M: Final = 0.15
"""Standard deviation of height from which on a plane is a wall."""
_STEPS: Final = 4
_ONE_WELL_M: Final = 1.5
"""Stairs this close in plan share a sign."""
_THICKEST_WALL_M: Final = 0.7
_RIM_M: Final = 0.12
_WALL_BAND_M: Final = (0.5, 2.0)
"""Heights over the floor between which a wall leaves its print."""


def wall_points(cloud: LabelledCloud | None) -> F64 | None:
    """Return the points of upright planes, ``(n, 3)``; None without a cloud."""
    if cloud is None:
        return None
    return cloud.positions[(cloud.plane >= 0) & _upright(cloud)[cloud.plane]]


def draw_walls(axes: Axes, walls: F64, band: tuple[float, float]) -> None:
    """Show the points of walls between two heights as a faint print."""
    inside = (walls[:, 2] > band[0]) & (walls[:, 2] < band[1])
    x, y = walls[inside, 0], walls[inside, 1]
    if len(x) == 0:
        return
    x0, x1, y0, y1 = x.min(), x.max(), y.min(), y.max()
    bins = [max(1, int((x1 - x0) / _WALL_CELL_M)), max(1, int((y1 - y0) / _WALL_CELL_M))]
    counts, _, _ = np.histogram2d(x, y, bins=bins, range=[[x0, x1 + 1e-6], [y0, y1 + 1e-6]])
    strength = np.clip(counts.T / max(1.0, np.percentile(counts[counts > 0], 80)), 0, 1) ** 0.6
    image = np.empty((*strength.shape, 4))
    image[..., :3], image[..., 3] = to_rgb(WALL), 0.75 * strength
    axes.imshow(image, origin="lower", extent=(x0, x1, y0, y1), zorder=2.5, interpolation="antialiased", aspect="equal")


def wall_band(scene: PlanScene) -> tuple[float, float]:
    """Return the heights between which the walls of a scene leave their print; all where no floor is known."""
    floors = [room.node.properties.get("floor_elevation") for room in scene.rooms.values()]
    known = [floor for floor in floors if floor is not None]
    floor = float(np.median(known)) if known else np.nan
    return (floor + _WALL_BAND_M[0], floor + _WALL_BAND_M[1]) if known else (-np.inf, np.inf)


def _upright(cloud: LabelledCloud) -> NDArray[np.bool_]:
    """Whether each plane stands upright, by the spread of its heights; the last entry is for no plane."""
    on_plane = cloud.plane >= 0
    plane, z = cloud.plane[on_plane], cloud.positions[on_plane, 2]
    size = int(plane.max(initial=-1)) + 1
    count = np.maximum(np.bincount(plane, minlength=size), 1)
    mean = np.bincount(plane, weights=z, minlength=size) / count
    variance = np.bincount(plane, weights=(z - mean[plane]) ** 2, minlength=size) / count
    return np.append(np.sqrt(variance) > _LEAST_UPRIGHT_M, False)


def draw_masonry(axes: Axes, scene: PlanScene) -> None:
    """Tint what lies between rooms closer together than walls are thick, and a rim around them."""
    rooms = unary_union([room.polygon.buffer(0) for room in scene.rooms.values()])
    outer = rooms.buffer(_THICKEST_WALL_M / 2)
    solid = outer.buffer(_RIM_M - _THICKEST_WALL_M / 2, join_style="mitre").difference(rooms)
    for part in getattr(solid, "geoms", [solid]):
        rings = [np.asarray(ring.coords)[:, :2] for ring in (part.exterior, *part.interiors)]
        path = Path.make_compound_path(*(Path(ring, closed=True) for ring in rings))
        axes.add_patch(PathPatch(path, facecolor=MASONRY, edgecolor="none", zorder=0.5))


def draw_rooms(axes: Axes, rooms: Iterable[PlannedRoom], *, outlined: bool, alpha: float = 1.0) -> None:
    """Fill each room with its tint; `outlined` where no cloud shows the walls."""
    for room in rooms:
        path = Path.make_compound_path(*(Path(ring, closed=True) for ring in room.rings))
        line = 1.6 if outlined else 0.6
        edge = WALL if outlined else FAINT_INK
        axes.add_patch(PathPatch(path, facecolor=room.tint, edgecolor=edge, linewidth=line, alpha=alpha, zorder=1))


def draw_openings(axes: Axes, scene: PlanScene, *, widths: bool) -> None:
    """Mark openings by kind, each as wide as it is and in its wall's direction; `widths` writes the width beside."""
    for opening in scene.openings:
        if not opening.upright or opening.kind in ("stairs", "hatch"):
            continue
        _draw_threshold(axes, scene, opening)
        _draw_bar(axes, opening)
        if opening.kind in ("door", "passage"):
            ticks = [(end - 0.12 * opening.across, end + 0.12 * opening.across) for end in opening.ends]
            axes.add_collection(LineCollection(ticks, colors=_colour(opening), linewidths=1.2, zorder=3))
            if widths:
                _write_width(axes, opening)


def _colour(opening: PlannedOpening) -> str:
    return OPENING_COLOURS.get(opening.kind, INK)


def _draw_threshold(axes: Axes, scene: PlanScene, opening: PlannedOpening) -> None:
    """Clear the wall between the two rooms where one can walk."""
    here = Point(opening.position)
    gaps = [float(here.distance(scene.rooms[room].polygon)) for room in opening.rooms if room in scene.rooms]
    gaps = [gap for gap in gaps if gap < _THICKEST_WALL_M]
    if opening.kind not in ("door", "passage") or opening.closed or not gaps:
        return
    depth = max(gaps) + 0.02
    first, last = opening.ends
    away = depth * opening.across
    corners = np.array([first - away, last - away, last + away, first + away])
    axes.add_patch(Polygon(corners, closed=True, facecolor=THRESHOLD, edgecolor="none", zorder=0.8))


def _draw_bar(axes: Axes, opening: PlannedOpening) -> None:
    """Draw the opening's line: solid for a door, dashed for a closed one, dotted for a passage, double for a window."""
    ends, colour = opening.ends, _colour(opening)
    if opening.kind == "window":
        for offset in (-0.05, 0.05):
            line = (ends + offset * opening.across).T
            axes.add_line(Line2D(*line, color=colour, linewidth=1.4, zorder=3))
    elif opening.kind == "passage":
        axes.add_line(Line2D(*ends.T, color=colour, linewidth=1.2, zorder=3, dashes=(2, 2)))
    else:
        under = PAPER if opening.closed else colour
        axes.add_line(Line2D(*ends.T, color=under, linewidth=3.2, zorder=3, solid_capstyle="butt"))
        dashes = (1, 0.7) if opening.closed else (None, None)
        axes.add_line(Line2D(*ends.T, color=colour, linewidth=3.2, zorder=3.1, dashes=dashes, dash_capstyle="butt"))


def _write_width(axes: Axes, opening: PlannedOpening) -> None:
    x, y = opening.position + 0.28 * opening.across
    angle = np.degrees(np.arctan2(opening.along[1], opening.along[0]))
    readable = (angle + 90) % 180 - 90
    more = {"rotation": readable, "rotation_mode": "anchor", "zorder": 6, "path_effects": halo(1.4)}
    axes.text(x, y, f"{opening.width:.2f}", **words(5.5, color=_colour(opening), **more))


def draw_stairs(axes: Axes, scene: PlanScene, size_m: float) -> None:
    """Mark stairs and hatches by a flight of steps that rises to the right, and say where they lead."""
    for flight in _flights(scene):
        first = flight[0]
        colour = OPENING_COLOURS[first.kind]
        corner = first.position - size_m / 2
        square = (float(corner[0]), float(corner[1]))
        axes.add_patch(Rectangle(square, size_m, size_m, facecolor=PAPER, edgecolor=colour, linewidth=1.2, zorder=5))
        axes.add_line(Line2D(*(corner + _flight() * size_m).T, color=colour, linewidth=1.3, zorder=5.1))
        where = dict.fromkeys(filter(None, (_leading(scene, opening) for opening in flight)))
        style = words(6.5, color=colour, va="top", zorder=6, path_effects=halo())
        axes.text(first.position[0], corner[1] - 0.08 * size_m, "\n".join(where), **style)


def _flights(scene: PlanScene) -> list[list[PlannedOpening]]:
    """Stairs and hatches, those that lie over one another together."""
    groups: list[list[PlannedOpening]] = []
    for opening in scene.openings:
        if opening.kind not in ("stairs", "hatch"):
            continue
        over = (group for group in groups if np.hypot(*(group[0].position - opening.position)) < _ONE_WELL_M)
        group = next(over, None)
        if group is None:
            groups.append([opening])
        else:
            group.append(opening)
    return groups


def _flight() -> F64:
    """Return the line of a flight of steps within the unit square."""
    level = np.repeat(np.linspace(0.15, 0.85, _STEPS + 1), 2)
    return np.column_stack([level[:-1], level[1:]])


def _leading(scene: PlanScene, opening: PlannedOpening) -> str:
    """Say up or down to which room of another storey; to another room of the plan nothing needs saying."""
    here = [room for room in opening.rooms if room in scene.rooms]
    there = [room for room in opening.rooms if room not in scene.rooms]
    if not here or not there:
        return ""
    nodes = scene.graph.nodes
    floors = [nodes[room].properties.get("floor_elevation") for room in (here[0], there[0])]
    name = shortened(str(nodes[there[0]].properties.get("name") or there[0].split("/", 1)[1]))
    if floors[0] is None or floors[1] is None:
        return f"to {name}"
    return f"up to {name}" if floors[1] > floors[0] else f"down to {name}"


def draw_graph(axes: Axes, scene: PlanScene, *, node_pt: float) -> None:
    """Lay the graph over the plan: rooms as nodes, ways through openings as edges, neighbours faint."""
    place = {key: room.place for key, room in scene.rooms.items()}
    beside = [np.array([place[a], place[b]]) for a, b in scene.neighbours]
    axes.add_collection(
        LineCollection(beside, colors=FAINT_INK, linewidths=0.5, linestyles=(0, (1, 3)), alpha=0.7, zorder=4)
    )
    for opening in scene.openings:
        if opening.kind == "window":
            continue
        ways = [np.array([place[room], opening.position]) for room in opening.rooms if room in place]
        style = (0, (3, 2)) if opening.closed else "solid"
        axes.add_collection(LineCollection(ways, colors=INK, linewidths=0.9, linestyles=style, alpha=0.75, zorder=4.2))
    if place:
        x, y = np.array(list(place.values())).T
        axes.scatter(x, y, s=node_pt**2, facecolor=INK, edgecolor=PAPER, linewidth=0.9, zorder=7)


def draw_scale(axes: Axes, x: float, y: float, span_m: float) -> None:
    """Draw a scale bar of a round length, about a sixth of the plan."""
    length = max(step for step in (0.5, 1, 2, 5, 10, 20, 50, 100) if step <= max(span_m / 6, 0.5))
    thick = span_m * 0.006
    for part, colour in enumerate((INK, PAPER)):
        corner = (x + part * length / 2, y)
        axes.add_patch(
            Rectangle(corner, length / 2, thick, facecolor=colour, edgecolor=INK, linewidth=0.7, clip_on=False)
        )
    axes.text(x + length + thick * 2, y + thick / 2, f"{length:g} m", **words(7, ha="left", clip_on=False))
