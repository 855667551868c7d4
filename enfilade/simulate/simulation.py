"""From a scene to a file of scans with the truth beside it."""

from __future__ import annotations

import csv
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from enfilade.clouds import write_cloud
from enfilade.errors import InputError
from enfilade.progress import Progress, Silent
from enfilade.schema.exchange import write_graph

from .crowd import Crowd
from .e57 import scan_file
from .locate import Locator
from .scanner import Scanner, Tracer
from .scene import OUTSIDE, Scene
from .solids import F64
from .stations import Setup, find_stations
from .truth import TruthCloud, truth_graph

_SILENT = Silent()


@dataclass(frozen=True, slots=True)
class Parameters:
    """How to scan: `scanner` is the instrument, `setup` where it is set up."""

    scanner: Scanner = field(default_factory=Scanner)
    setup: Setup = field(default_factory=Setup)


def simulate(
    scene: Scene,
    out: Path,
    *,
    parameters: Parameters | None = None,
    grouping: bool = True,
    progress: Progress = _SILENT,
) -> Path:
    """Scan a scene, write the scans and the truth.

    Parameters
    ----------
    scene
        What stands there.
    out
        The E57 file to write; the truth goes to a folder of the same name that ends in ``.truth``: ``graph.json``,
        ``cloud.ply`` and, if `grouping`, ``grouping.csv`` with the room that each scan stands in.
    parameters
        Scanner and its set-up; the same parameters give the same points.

    Returns
    -------
    Path
        `out`.

    Raises
    ------
    InputError
        If no place for the scanner is found, nothing is seen from one, or a file cannot be written.
    """
    chosen = parameters or Parameters()
    progress.start("positions")
    stations = _stations(scene, chosen)
    locator = Locator(scene.rooms)
    names = [f"Scan {number:03d}" for number in range(1, len(stations) + 1)]
    truth = TruthCloud(scene, locator)
    crowd = Crowd(scene.mesh)
    tracer = Tracer(scene, chosen.scanner)
    progress.start("scan", total=len(stations))
    with scan_file(out) as write:
        for index, (name, station) in enumerate(zip(names, stations, strict=True)):
            generator = np.random.default_rng([chosen.scanner.seed, index])
            people = crowd.about(station, chosen.scanner.people, generator)
            scan = tracer.scan(name, station, generator, people)
            if not len(scan.local):
                raise InputError(f"{scene.name}: the scanner sees nothing at {np.round(station, 2).tolist()}; move it")
            write(scan)
            truth.add(scan)
            progress.advance()
    scan_rooms = dict(zip(names, locator.rooms_of(stations).tolist(), strict=True))
    progress.start("truth")
    _write_truth(scene, truth, scan_rooms, out, grouping=grouping)
    return out


def _stations(scene: Scene, parameters: Parameters) -> F64:
    found = find_stations(scene, parameters.setup) if scene.stations is None else scene.stations
    stations = np.concatenate([found, scene.outdoors])
    if not len(stations):
        raise InputError(f"{scene.name}: no room has a free place for the scanner; give its positions")
    return stations


def _write_truth(scene: Scene, truth: TruthCloud, scan_rooms: dict[str, int], out: Path, *, grouping: bool) -> None:
    folder = out.with_suffix(".truth")
    folder.mkdir(exist_ok=True)
    cloud = truth.finish()
    write_cloud(folder / "cloud.ply", cloud)
    write_graph(truth_graph(scene, out.stem, cloud, scan_rooms), folder / "graph.json")
    if grouping:
        rows = [(name, room) for name, room in scan_rooms.items() if room != OUTSIDE]
        with (folder / "grouping.csv").open("w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows([("scan", "room"), *rows])
