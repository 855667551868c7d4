"""Commands on scans: ingest them, simulate them, compare what came out with the truth."""

from __future__ import annotations

import glob
import json
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from enfilade.cli.terminal import ERR, OUT, counted, open_archive, print_table, progress_bars
from enfilade.errors import EnfiladeError, InputError, NotFoundError
from enfilade.stores.archive import Archive

if TYPE_CHECKING:
    from enfilade.evaluate import Evaluation
    from enfilade.simulate import Scene

PATH = click.Path(path_type=Path)


@click.command("ingest")
@click.argument("scans", nargs=-1, required=True, type=PATH)
@click.option("--building", help="Id: all SCANS are one building. Without it each argument is one, named after it.")
@click.option("--name", help="What people call the building, any text; without it its id.")
@click.option("--rooms", "grouping", type=PATH, help="CSV `scan,room` that overrides the automatic grouping.")
@click.option("--positions", type=PATH, help="CSV `scan,x,y,z` or `file,x,y,z`: where scanners stood.")
@click.option("--trajectory", type=PATH, multiple=True, help="Text `time,x,y,z`: the way of the scanner of LAS files.")
@click.option("--units", type=click.Choice(["auto", "m", "mm", "cm", "ft", "in"]), default="auto", show_default=True)
@click.option(
    "--up", type=click.Choice(["auto", "z", "y"]), default="auto", show_default=True, help="The axis upwards."
)
@click.pass_context
def ingest_command(
    ctx: click.Context,
    scans: tuple[Path, ...],
    building: str | None,
    name: str | None,
    grouping: Path | None,
    positions: Path | None,
    trajectory: tuple[Path, ...],
    units: str,
    up: str,
) -> None:
    """Turn registered scans into a graph in the store.

    SCANS are E57, PTX, PLY, PCD, LAS or LAZ files, folders of them, or patterns. One building that fails does not stop
    the others; the exit status is 1 if any failed.
    """
    from enfilade.schema.ids import check_building

    jobs = {building: list(scans)} if building is not None else _one_each(scans)
    of_one = {"--rooms": grouping, "--name": name, "--positions": positions, "--trajectory": trajectory or None}
    given = [option for option, value in of_one.items() if value is not None]
    if len(jobs) > 1 and given:
        raise click.UsageError(f"{given[0]} goes with one building; say with --building that all is one.")
    for id in jobs:
        check_building(id)
    archive = open_archive(ctx, create=True)
    inputs: dict[str, Any] = {"name": name, "grouping": grouping, "positions": positions, "trajectory": trajectory}
    failed = 0
    for id, paths in jobs.items():
        try:
            ingest_one(archive, id, paths, units=units, up=up, **inputs)
        except EnfiladeError as error:
            if ctx.obj["debug"]:
                raise
            click.echo(f"Error: {id}: {error}", err=True)
            failed += 1
    ctx.exit(1 if failed else 0)


def ingest_one(
    archive: Archive,
    building: str,
    scans: list[Path],
    *,
    name: str | None = None,
    grouping: Path | None = None,
    positions: Path | None = None,
    trajectory: tuple[Path, ...] = (),
    units: str = "auto",
    up: str = "auto",
) -> None:
    """Ingest one building with bars, and say in a line what it became."""
    from enfilade.ingest.parameters import Parameters
    from enfilade.ingest.pipeline import ingest
    from enfilade.ingest.readers import ReadingParameters

    with progress_bars() as bars:
        result = ingest(
            scans,
            building=building,
            name=name,
            parameters=Parameters(reading=ReadingParameters(units=units, up=up)),
            rooms_csv=grouping,
            positions_csv=positions,
            trajectory=trajectory,
            progress=bars,
        )
        bars.start("store")
        archive.save(result.graph, result.cloud)
    # Combinations of segments are further nodes for likeness, not further things in the rooms.
    single = [node for node in result.graph.nodes.values() if node.properties.get("parts", 1) == 1]
    count = Counter(node.label for node in single)
    said = ", ".join(counted(count[label], label.lower()) for label in ("Storey", "Room", "Opening", "Object"))
    ERR.print(f"{building}: {said}, in {archive.store.url}", markup=False)


def _one_each(scans: tuple[Path, ...]) -> dict[str, list[Path]]:
    jobs: dict[str, list[Path]] = {}
    for path in scans:
        if glob.has_magic(str(path)) and not path.exists():
            raise click.UsageError(f"{path} is a pattern of files; say with --building which building they are.")
        name = path.resolve().name if path.is_dir() else path.stem
        if name in jobs:
            raise click.UsageError(f"Two of the arguments would be the building {name!r}; use --building.")
        jobs[name] = [path]
    return jobs


@click.command("simulate")
@click.argument("model", type=PATH, required=False)
@click.option("-o", "--output", type=PATH, required=True, help="NAME.e57; the truth goes to NAME.truth/ beside it.")
@click.option("--generate", "number", type=click.IntRange(1), help="Scan the generated building of this number.")
@click.option("--faults", type=click.Choice(["light", "medium", "heavy"]), help="How badly the scans were made.")
@click.option("--seed", type=int, help="Seed of noise and closed doors; 1, or the number of a generated building.")
@click.option("--step", type=click.FloatRange(0.02, 5.0), help="Angle between rays, degrees.")
@click.option("--closed", type=click.FloatRange(0.0, 1.0), help="Share of an IFC model's doors that are closed.")
@click.option("--positions", type=PATH, help="CSV `x,y,z` of scanner positions in a mesh.")
def simulate_command(
    model: Path | None,
    output: Path,
    number: int | None,
    faults: str | None,
    seed: int | None,
    step: float | None,
    closed: float | None,
    positions: Path | None,
) -> None:
    """Scan a building model with a virtual laser scanner.

    MODEL is an IFC file or a mesh (OBJ, PLY, STL); without it the built-in demo building is scanned, or with --generate
    one of any number of generated buildings.
    """
    from dataclasses import replace

    from enfilade.simulate import FAULTS, Parameters, Scanner, generate, simulate

    if output.suffix.lower() != ".e57":
        raise InputError(f"The output {output} has to end in .e57.")
    if number is not None and model is not None:
        raise click.UsageError("--generate makes a building; leave MODEL out.")
    with progress_bars() as bars:
        bars.start("model")
        if number is None:
            parameters = Parameters(replace(FAULTS[faults] if faults else Scanner(), seed=1 if seed is None else seed))
            scene, said = _scene(model, parameters.scanner.seed, closed, positions), ""
        else:
            _refuse_others(closed, positions)
            made = generate(number, faults=faults)
            scene, parameters, said = made.scene, made.parameters, f": {made.name}, {made.description}"
        scanner = parameters.scanner if step is None else replace(parameters.scanner, angular_step_deg=step)
        scanner = scanner if seed is None else replace(scanner, seed=seed)
        simulate(scene, output, parameters=replace(parameters, scanner=scanner), progress=bars)
    ERR.print(f"Wrote {output} and {output.with_suffix('.truth')}/{said}", markup=False)


def _refuse_others(closed: float | None, positions: Path | None) -> None:
    if closed is not None or positions is not None:
        raise click.UsageError("--closed goes with an IFC model, --positions with a mesh; not with --generate.")


def _scene(model: Path | None, seed: int, closed: float | None, positions: Path | None) -> Scene:
    from enfilade.simulate import demo_scene, ifc_scene, mesh_scene

    is_ifc = model is not None and model.suffix.lower() == ".ifc"
    if closed is not None and not is_ifc:
        raise click.UsageError("--closed goes with an IFC model.")
    if positions is not None and (model is None or is_ifc):
        raise click.UsageError("--positions goes with a mesh.")
    if model is None:
        return demo_scene()
    if is_ifc:
        return ifc_scene(model, seed=seed) if closed is None else ifc_scene(model, closed_share=closed, seed=seed)
    return mesh_scene(model, stations=positions)


@click.command("evaluate")
@click.argument("prediction", type=PATH)
@click.argument("truth", type=PATH)
@click.option("--format", "form", type=click.Choice(["table", "json"]), default="table", show_default=True)
@click.option("--pictures", type=PATH, help="Folder for truth beside prediction, a sheet a storey, faults marked.")
@click.pass_context
def evaluate_command(ctx: click.Context, prediction: Path, truth: Path, form: str, pictures: Path | None) -> None:
    """Compare a graph and its cloud with the truth.

    Both are folders with graph.json and cloud.ply; PREDICTION may also be the id of a building in the store. Or both
    are folders of many buildings: NAME/ or NAME.exported/ in PREDICTION, NAME.truth/ or NAME/ in TRUTH.
    """
    if not (truth / "graph.json").is_file() and truth.is_dir():
        ctx.exit(_evaluate_many(prediction, truth, form, pictures))
    found = _evaluate_one(ctx, prediction, truth)
    if form == "json":
        OUT.print_json(json.dumps(found.to_dict()))
    else:
        print_table(("what", "value"), found.to_table())
        if faults := found.to_fault_table():
            print_table(("fault", "which", "why"), faults)
    if pictures is not None:
        _draw(found, pictures, "evaluation")


def _evaluate_one(ctx: click.Context, prediction: Path, truth: Path) -> Evaluation:
    from enfilade.evaluate import evaluate, evaluate_graphs

    # A folder may happen to be called like a building: `enfilade demo` makes one.
    if (prediction / "graph.json").is_file() or (prediction.is_dir() and len(prediction.parts) > 1):
        return evaluate(prediction, truth)
    from enfilade.clouds import read_cloud
    from enfilade.schema.exchange import read_graph

    archive = open_archive(ctx)
    building = str(prediction)
    graph = archive.store.read(building)
    cloud = read_cloud(archive.cloud_path(building))
    return evaluate_graphs(graph, cloud, read_graph(truth / "graph.json"), read_cloud(truth / "cloud.ply"))


def _evaluate_many(prediction: Path, truth: Path, form: str, pictures: Path | None) -> int:
    """Print figures of all buildings and in total; return the exit status, 1 if any failed."""
    from enfilade.evaluate import evaluate_many, pair_folders, pool
    from enfilade.evaluate.many import COLUMNS, cause_rows, pooled_figures, summary_rows
    from enfilade.evaluate.tables import figure_rows

    folders = pair_folders(prediction, truth)
    records: dict[str, dict[str, Any]] = {}
    with progress_bars() as bars:
        bars.start("evaluate", len(folders))
        for outcome in evaluate_many(folders):
            records[outcome.name] = outcome.to_dict()
            if pictures is not None and outcome.evaluation is not None:
                _draw(outcome.evaluation, pictures, outcome.name)
            bars.advance()
    if form == "json":
        OUT.print_json(json.dumps({"buildings": records, "total": pool(records)}))
    else:
        print_table(COLUMNS, summary_rows(records))
        print_table(("building", "commonest faults"), cause_rows(records))
        print_table(("in all", "value"), figure_rows(pooled_figures(records)))
    return 1 if any("error" in record for record in records.values()) else 0


def _draw(found: Evaluation, folder: Path, name: str) -> None:
    """Draw truth beside prediction; a building without outlines says so and stops nothing."""
    from enfilade.pictures import draw_evaluation

    try:
        drawn = draw_evaluation(found, folder, name=name)
    except NotFoundError as error:
        ERR.print(f"{name}: {error}", markup=False)
    else:
        ERR.print(f"Wrote {', '.join(map(str, drawn))}", markup=False)
