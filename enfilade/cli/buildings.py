"""Commands on the buildings of a store: list, show, remove, export, import, copy."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path

import click
from rich.tree import Tree

from enfilade.cli.terminal import ERR, OUT, counted, open_archive, print_table, progress_bars, show_value
from enfilade.clouds import LabelledCloud, read_cloud
from enfilade.errors import EnfiladeError, InputError
from enfilade.schema.exchange import read_graphs, write_graph, write_graphs
from enfilade.schema.graph import BuildingGraph
from enfilade.stores.archive import copy_buildings

ROOM_COLUMNS = ("room", "name", "storey", "area m²", "height m", "floor m", "openings", "objects", "scans")


@click.command("buildings")
@click.option("--format", "form", type=click.Choice(["table", "json"]), default="table", show_default=True)
@click.pass_context
def buildings_command(ctx: click.Context, form: str) -> None:
    """List the buildings of the store."""
    summaries = open_archive(ctx).store.buildings()
    names = ("id", "name", "storeys", "rooms", "openings", "objects", "area", "ingested_at")
    rows = [[getattr(summary, name) for name in names] for summary in summaries]
    if form == "json":
        OUT.print_json(json.dumps([dict(zip(names, row, strict=True)) for row in rows]))
    else:
        print_table(names, rows)


@click.command("show")
@click.argument("building")
@click.option("--plan", type=click.Path(path_type=Path), help="Draw plans: a .png, .svg or .pdf file, or a folder.")
@click.option("--storey", help="Draw only this storey: its id, name or index.")
@click.option("--furniture", is_flag=True, help="Draw furniture too, lightly.")
@click.pass_context
def show_command(ctx: click.Context, building: str, plan: Path | None, storey: str | None, furniture: bool) -> None:
    """Show a building as tree, table of rooms and plans.

    `--plan hotel.png` draws a sheet a storey, hotel-s0.png and so on; a folder gets PNG and SVG of each.
    """
    if plan is None and (storey is not None or furniture):
        raise click.UsageError("--storey and --furniture say how to draw; name a file or a folder with --plan.")
    archive = open_archive(ctx)
    graph = archive.store.read(building)
    print_building(graph)
    if plan is not None:
        from enfilade.pictures.plan import draw_plans, without_outline

        for path in draw_plans(graph, plan, cloud=archive.cloud(building), storey=storey, furniture=furniture):
            ERR.print(f"Drew {path}", markup=False)
        missing = without_outline(graph)
        if missing:
            ERR.print(f"No outline is known of {counted(missing, 'room')}; drawn by bounds or centre.", markup=False)


def print_building(graph: BuildingGraph) -> None:
    """Print the tree building - storey - room, then the rooms as a table with what each holds."""
    children: dict[str, list[str]] = {}
    for edge in graph.edges:
        if edge.type in ("HAS_STOREY", "HAS_ROOM"):
            children.setdefault(edge.source, []).append(edge.target)
    openings = Counter(edge.source for edge in graph.of_type("OPENS"))
    contained = (edge for edge in graph.of_type("CONTAINS") if graph.nodes[edge.target].properties.get("parts", 1) == 1)
    segments = Counter(edge.source for edge in contained)
    tree = Tree(f"[bold]{_label(graph, graph.building)}")
    rows = []
    for storey in children.get(graph.building, []):
        branch = tree.add(_label(graph, storey))
        index = graph.nodes[storey].properties.get("index")
        for room in children.get(storey, []):
            given = graph.nodes[room].properties
            area, doors = show_value(given.get("area")), counted(openings[room], "opening")
            branch.add(f"{_label(graph, room)}  {area} m², {doors}")
            measures = (given.get(name) for name in ("area", "height", "floor_elevation"))
            scans = len(given.get("scans", ()))
            rows.append([room, given.get("name"), index, *measures, openings[room], segments[room], scans])
    OUT.print(tree)
    print_table(ROOM_COLUMNS, rows)


def _label(graph: BuildingGraph, node: str) -> str:
    from rich.markup import escape

    name = graph.nodes[node].properties.get("name")
    return escape(node if name in (None, node) else f"{node}  {name}")


@click.command("remove")
@click.argument("building")
@click.option("--yes", is_flag=True, help="Do not ask.")
@click.pass_context
def remove_command(ctx: click.Context, building: str, yes: bool) -> None:
    """Take a building out of the store, with its cloud."""
    archive = open_archive(ctx)
    if not yes and not click.confirm(f"Remove {building!r} from {archive.store.url}?", err=True):
        ERR.print("Nothing was removed.")
        ctx.exit(1)
    archive.remove(building)
    ERR.print(f"Removed {building}", markup=False)


@click.command("export")
@click.argument("building")
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="Folder, or a .json[l][.gz] file.")
@click.pass_context
def export_command(ctx: click.Context, building: str, output: Path) -> None:
    """Write a building as graph.json, with its cloud.ply beside it."""
    archive = open_archive(ctx)
    graph = archive.store.read(building)
    # The name of a file in this store's own folder says nothing elsewhere.
    graph.nodes[building].properties.pop("cloud", None)
    if output.suffix in (".json", ".jsonl", ".gz"):
        if output.suffix == ".json":
            write_graph(graph, output)
        else:
            write_graphs([graph], output)
        ERR.print(f"Wrote {output}", markup=False)
        return
    output.mkdir(parents=True, exist_ok=True)
    write_graph(graph, output / "graph.json")
    cloud = archive.cloud(building)
    if cloud is not None:
        from enfilade.clouds import write_cloud

        write_cloud(output / "cloud.ply", cloud)
    ERR.print(f"Wrote {output / 'graph.json'}" + (" and cloud.ply" if cloud is not None else ""), markup=False)


@click.command("import")
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.pass_context
def import_command(ctx: click.Context, files: tuple[Path, ...]) -> None:
    """Read graph files into the store.

    FILES are .json, .jsonl or .jsonl.gz, or folders with graph.json and cloud.ply.
    """
    archive = open_archive(ctx, create=True)
    count = 0
    try:
        for _ in archive.save_all(_read_files(files)):
            count += 1
    except EnfiladeError:
        if count:
            ERR.print(f"Imported {counted(count, 'building')}, then stopped.", markup=False)
        raise
    ERR.print(f"Imported {counted(count, 'building')} into {archive.store.url}", markup=False)


def _read_files(files: Iterable[Path]) -> Iterator[tuple[BuildingGraph, LabelledCloud | None]]:
    """Yield the graphs in files, a ``graph.json`` with the cloud beside it. Raises InputError where there is none."""
    for given in files:
        path = given / "graph.json" if given.is_dir() else given
        if not path.exists():
            raise InputError(f"There is no graph file {path}; name a .json, .jsonl or .jsonl.gz file or a folder.")
        cloud_path = path.with_name("cloud.ply")
        cloud = read_cloud(cloud_path) if path.name == "graph.json" and cloud_path.is_file() else None
        empty = True
        for graph in read_graphs(path):
            yield graph, cloud
            empty = False
        if empty:
            raise InputError(f"{path} holds no building.")


@click.command("copy")
@click.argument("buildings", nargs=-1)
@click.option("--to", "target", required=True, help="The store to copy into.")
@click.pass_context
def copy_command(ctx: click.Context, buildings: tuple[str, ...], target: str) -> None:
    """Copy buildings into another store; all, if none is named."""
    source = open_archive(ctx)
    destination = open_archive(ctx, create=True, url=target)
    with progress_bars() as bars:
        copied = copy_buildings(source, destination, buildings or None, progress=bars)
    ERR.print(f"Copied {counted(len(copied), 'building')} into {destination.store.url}", markup=False)
