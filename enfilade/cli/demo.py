"""``enfilade demo``: the whole way, from a model to pictures of matches, on the built-in building."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import click

from enfilade.cli.buildings import print_building
from enfilade.cli.scans import ingest_one
from enfilade.cli.terminal import ERR, OUT, open_archive, print_table, progress_bars
from enfilade.queries.result import Result
from enfilade.stores.archive import Archive

BUILDING: Final = "demo"
QUESTION: Final = """\
MATCH (a:Room {area: 10..20})-[:DOOR]-(b:Room {area: 10..20}),
      (a)-[:STAIRS]-(:Room),
      (b)-[:CONTAINS]->(o:Object LIKE $basin)
RETURN a, a.area, b, b.area, o, score
ORDER BY score DESC LIMIT 3"""


@click.command("demo")
@click.option("--folder", type=click.Path(file_okay=False, path_type=Path), default=Path("demo"), show_default=True)
@click.pass_context
def demo_command(ctx: click.Context, folder: Path) -> None:
    """Go the whole way on the built-in building.

    Simulates its scans, ingests them, asks the paper's kind of question and draws the answers.
    """
    archive = open_archive(ctx, create=True)
    folder.mkdir(parents=True, exist_ok=True)
    scans, basin = folder / "demo.e57", folder / "basin.obj"
    _heading("1. A virtual laser scanner stands in every room of the built-in building")
    _simulate(scans, basin)
    _heading("2. The scans become a graph")
    ingest_one(archive, BUILDING, [scans])
    print_building(archive.store.read(BUILDING))
    _heading(
        "3. Two rooms of 10 to 20 m² joined by a door, one with stairs, the other holding something like this basin"
    )
    OUT.print(QUESTION, markup=False)
    (folder / "question.cypher").write_text(QUESTION + "\n", encoding="utf-8")
    result = _ask(archive, basin)
    _heading("4. Pictures")
    _draw(archive, folder, basin, result)


def _heading(text: str) -> None:
    OUT.print(f"\n[bold]{text}[/bold]")


def _simulate(scans: Path, basin: Path) -> None:
    from enfilade.simulate import basin_mesh, demo_scene, simulate, write_obj

    with progress_bars() as bars:
        simulate(demo_scene(), scans, progress=bars)
    write_obj(basin, basin_mesh())
    ERR.print(f"Wrote {scans}, {scans.with_suffix('.truth')}/ and {basin}", markup=False)


def _ask(archive: Archive, basin: Path) -> Result:
    from enfilade.queries import answer

    result = answer(archive.store, QUESTION, likenesses={"basin": basin})
    print_table(result.columns, [[row[column] for column in result.columns] for row in result.rows])
    return result


def _draw(archive: Archive, folder: Path, basin: Path, result: Result) -> None:
    from enfilade.descriptors import read_shape
    from enfilade.pictures.match import draw_match
    from enfilade.pictures.plan import draw_storeys

    graph, cloud = archive.store.read(BUILDING), archive.cloud(BUILDING)
    with progress_bars() as bars:
        bars.start("plans")
        drawn = list(draw_storeys(graph, folder / "plan.png", cloud=cloud))
        bars.start("matches", total=len(result.rows))
        for number, row in enumerate(result.rows, start=1):
            path = folder / f"match-{number}.png"
            draw_match(path, graph, row, cloud=cloud, shapes={"o": read_shape(basin)}, title=f"Match {number}")
            drawn.append(path)
            bars.advance()
    OUT.print("\n".join(str(path) for path in drawn), markup=False)
