"""Furniture as light outlines, from the points of objects, or from their sizes."""

from __future__ import annotations

from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPoint
from shapely.geometry.base import BaseGeometry

from enfilade.clouds import LabelledCloud
from enfilade.schema.graph import Node
from enfilade.schema.ids import parse

from .frame import PageFrame
from .pen import DASHED, FINE_MM, SOLID, Pen
from .scene import PlanScene
from .style import FAINT_INK
from .thinning import thinned

F64 = NDArray[np.float64]

_CELL_M: Final = 0.05
_HOLLOW: Final = 0.25
"""How far an outline follows the hollows of a shape: 0 closely, 1 not at all."""
_OVERHEAD_M: Final = 1.5
_TOLERANCE_M: Final = 0.02
_LAYER: Final = 2.0


def object_outlines(cloud: LabelledCloud, frame: PageFrame) -> dict[int, BaseGeometry]:
    """Return what the points of each object cover in plan, by its number."""
    chosen = np.flatnonzero(cloud.object >= 0)
    chosen = chosen[np.argsort(cloud.object[chosen], kind="stable")]
    xy, number = frame.points(cloud.positions[chosen, :2]), cloud.object[chosen]
    starts = np.flatnonzero(np.diff(number, prepend=-1))
    ends = np.append(starts[1:], len(number))
    return {int(number[a]): _outline(thinned(xy[a:b], _CELL_M)) for a, b in zip(starts, ends, strict=True)}


def _outline(cells: F64) -> BaseGeometry:
    hull = shapely.concave_hull(MultiPoint(cells), ratio=_HOLLOW)
    return hull.buffer(_CELL_M / 2, join_style="mitre").simplify(_TOLERANCE_M)


def draw_furniture(pen: Pen, scene: PlanScene, outlines: dict[int, BaseGeometry] | None) -> None:
    """Draw the segments of the rooms of a storey; dashed what hangs overhead."""
    for node in scene.graph.of_label("Object"):
        if scene.topology.room_of.get(node.id) not in scene.rooms or node.properties.get("parts", 1) != 1:
            continue
        key = parse(node.id)
        shape = outlines.get(key.numbers[0]) if outlines is not None else _extent(node, scene.frame)
        if shape is not None:
            overhead = float(node.properties.get("floor_offset", 0.0)) > _OVERHEAD_M
            style = DASHED if overhead else SOLID
            pen.area(
                shape,
                layer=_LAYER,
                fill="none",
                edge=FAINT_INK,
                weight=FINE_MM,
                style=style,
                gid=f"object-o{key.numbers[0]}",
            )


def _extent(node: Node, frame: PageFrame) -> BaseGeometry | None:
    """Return an object's extent along the axes of the scans as a rectangle, None where it is unknown."""
    if "position" not in node.properties or "size" not in node.properties:
        return None
    half = np.asarray(node.properties["size"][:2], dtype=np.float64) / 2
    corners = np.asarray(node.properties["position"][:2]) + half * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    return shapely.Polygon(frame.points(corners))
