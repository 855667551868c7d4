"""Commands on the points of a building: take out those of a node, measure nodes."""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray

from enfilade.cli.terminal import ERR, open_archive, print_table
from enfilade.clouds import LabelledCloud, write_cloud
from enfilade.errors import NotFoundError
from enfilade.schema.graph import BuildingGraph, Node
from enfilade.schema.ids import parse
from enfilade.stores.archive import Archive

MEASURES = {
    "Building": ("point_count", "scan_count"),
    "Storey": ("elevation", "height", "area"),
    "Room": ("area", "height", "floor_elevation", "ceiling_elevation", "point_count"),
    "Opening": ("kind", "width", "height", "sill", "area", "ray_count", "confidence"),
    "Object": ("size", "floor_offset", "point_count"),
}
UNITS = {"area": "m²", "point_count": "", "scan_count": "", "kind": "", "ray_count": "", "confidence": ""}


@click.command("extract")
@click.argument("node")
@click.option("-o", "--output", type=click.Path(dir_okay=False, path_type=Path), required=True)
@click.pass_context
def extract_command(ctx: click.Context, node: str, output: Path) -> None:
    """Write the points of a building, storey, room or object as PLY."""
    archive = open_archive(ctx)
    graph, cloud = _graph_and_cloud(archive, node)
    chosen = node_points(graph, cloud, graph.nodes[node])
    write_cloud(output, cloud.take(chosen))
    ERR.print(f"Wrote {np.count_nonzero(chosen):,} points of {node} to {output}", markup=False)


@click.command("measure")
@click.argument("node")
@click.argument("other", required=False)
@click.pass_context
def measure_command(ctx: click.Context, node: str, other: str | None) -> None:
    """Print the measures of a node, and how far it is from another."""
    archive = open_archive(ctx)
    rows: list[tuple[object, ...]] = []
    for each in (node,) if other is None else (node, other):
        found = _node(archive.store.read(parse(each).building), each)
        rows += [
            (each, name, found.properties[name], UNITS.get(name, "m"))
            for name in MEASURES[found.label]
            if name in found.properties
        ]
    if other is not None:
        rows += _distances(archive, node, other)
    print_table(("node", "measure", "value", "unit"), rows)


def node_points(graph: BuildingGraph, cloud: LabelledCloud, node: Node) -> NDArray[np.bool_]:
    """Return which points of a cloud belong to a node, ``(N,) bool``. Raises NotFoundError for an opening."""
    if node.label == "Building":
        return np.ones(len(cloud.positions), dtype=np.bool_)
    if node.label == "Opening":
        raise NotFoundError(f"The opening {node.id!r} is a hole and has no points; name a storey, room or object.")
    labels = {"Storey": cloud.storey, "Room": cloud.room, "Object": cloud.object}[node.label]
    segments = node.properties.get("segments", [node.id]) if node.label == "Object" else [node.id]
    return np.isin(labels, [number for segment in segments for number in parse(segment).numbers])


def _distances(archive: Archive, node: str, other: str) -> list[tuple[object, ...]]:
    centres = []
    for each in (node, other):
        found = _node(archive.store.read(parse(each).building), each)
        centre = found.properties.get("position", found.properties.get("centroid"))
        if centre is None:
            raise NotFoundError(f"{each!r} has no position to measure from; name a room, opening or object.")
        centres.append(np.asarray(centre, dtype=np.float64))
    difference = centres[1] - centres[0]
    pair = f"{node} – {other}"
    return [
        (pair, "distance", float(np.linalg.norm(difference)), "m"),
        (pair, "in plan", float(np.linalg.norm(difference[:2])), "m"),
        (pair, "in height", float(difference[2]), "m"),
    ]


def _graph_and_cloud(archive: Archive, node: str) -> tuple[BuildingGraph, LabelledCloud]:
    building = parse(node).building
    graph = archive.store.read(building)
    _node(graph, node)
    cloud = archive.cloud(building)
    if cloud is None:
        raise NotFoundError(f"The building {building!r} has no labelled cloud in {archive.clouds}; ingest it again.")
    return graph, cloud


def _node(graph: BuildingGraph, node: str) -> Node:
    if node not in graph.nodes:
        raise NotFoundError(f"There is no node {node!r} in the building {graph.building!r}.")
    return graph.nodes[node]
