"""From scans to one building's graph: the stages, in order, by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from enfilade.clouds import LabelledCloud
from enfilade.errors import InputError
from enfilade.progress import Progress, Silent
from enfilade.schema.graph import BuildingGraph

from .assembly import Findings, assemble_cloud, assemble_graph
from .glimpses import add_glimpsed_rooms
from .grouping_table import read_grouping
from .groups import group_scans
from .inside import keep_inside
from .measures import measure_rooms
from .neighbours import find_neighbours
from .objects import find_objects
from .openings import find_openings
from .parameters import Parameters
from .planes import find_planes
from .plans import draw_plans
from .provenance import provenance
from .readers import read_scans, scan_files
from .records import Groups, Planes, Room, RoomLabels, Surfels, ThinnedCloud
from .registration import check_registration
from .rooms import label_rooms
from .sparse import extend_planes
from .stopwatch import Stopwatch
from .storeys import find_storeys
from .surfels import make_surfels
from .thinning import thin

_DEFAULTS: Final = Parameters()
_SILENT: Final = Silent()


@dataclass(frozen=True, slots=True)
class Ingested:
    """One building as the stages found it.

    Attributes
    ----------
    graph, cloud
        What goes into the store and beside it.
    timings
        Seconds that each stage took, by its name, in order.
    """

    graph: BuildingGraph
    cloud: LabelledCloud
    timings: Mapping[str, float]


def ingest(
    sources: Sequence[Path],
    *,
    building: str,
    name: str | None = None,
    parameters: Parameters = _DEFAULTS,
    rooms_csv: Path | None = None,
    positions_csv: Path | None = None,
    trajectory: Sequence[Path] = (),
    progress: Progress = _SILENT,
) -> Ingested:
    """Turn the registered scans of one building into its graph and its labelled cloud.

    Parameters
    ----------
    sources
        Scan files, folders of them, or patterns.
    building
        Id of the building.
    name
        What people call it, any text; its id if None.
    parameters
        Parameters of all stages.
    rooms_csv
        Grouping table (``scan,room``) that overrides the automatic groups in whole or in part.
    positions_csv
        Table of scanner positions (``scan,x,y,z`` or ``file,x,y,z``) for scans whose files have none.
    trajectory
        Files of the way of a moving scanner (time, x, y, z), for LAS and LAZ.
    progress
        Hears of every stage.

    Raises
    ------
    InputError
        A scan file, a folder or the table cannot be used; the message names it and the cause.
    """
    watch = Stopwatch(progress)
    files = scan_files(sources)

    watch.start("read and thin")
    scans = read_scans(files, parameters.reading, positions=positions_csv, trajectory=trajectory, progress=watch)
    cloud = thin(scans, parameters.thinning, progress=watch)
    tables = [table for table in (rooms_csv, positions_csv, *trajectory) if table is not None]
    with ThreadPoolExecutor(1) as worker:  # the files are hashed meanwhile
        made_from = worker.submit(provenance, files, tables, parameters)
        found = _findings(cloud, files, rooms_csv, parameters, watch)
        watch.start("graph")
        labelled = assemble_cloud(found)
    said = building if name is None else name
    graph = assemble_graph(building, said, found, parameters.descriptors.shape, made_from.result())
    return Ingested(graph, labelled, watch.stop())


def _findings(
    cloud: ThinnedCloud, files: Sequence[Path], rooms_csv: Path | None, parameters: Parameters, watch: Stopwatch
) -> Findings:
    """Find in the thinned cloud what the graph is made of."""
    watch.start("surfels")
    surfels = make_surfels(cloud, parameters.surfels)
    watch.start("planes")
    with ThreadPoolExecutor(1) as worker:  # patches are grown one after the other, which leaves processors free
        checked = worker.submit(check_registration, cloud, surfels, parameters.registration, progress=watch)
        planes = find_planes(surfels, parameters.planes)
        checked.result()
    surfels, planes = extend_planes(cloud, surfels, planes, parameters.sparse)
    _need(planes.bitmaps, files, "no walls, floors or ceilings")
    watch.start("groups")
    given = read_grouping(rooms_csv, cloud.scan_names, cloud.read_as) if rooms_csv is not None else None
    groups = group_scans(planes, cloud.scanner_positions, given, parameters.groups)
    labels, rooms = _rooms(cloud, surfels, planes, groups, parameters, watch)
    _need(rooms, files, "no room")
    storeys = find_storeys(rooms, parameters.storeys)
    watch.start("neighbours")
    neighbours = find_neighbours(surfels, planes, labels, rooms, parameters.neighbours)
    watch.start("openings")
    openings = find_openings(cloud, surfels, planes, labels, rooms, neighbours, parameters.openings)
    watch.start("objects")
    objects = find_objects(
        cloud, surfels, planes, labels, rooms, parameters.objects, parameters.descriptors, openings=openings
    )
    return Findings(cloud, surfels, planes, labels, rooms, storeys, neighbours, openings, objects)


def _rooms(
    cloud: ThinnedCloud, surfels: Surfels, planes: Planes, groups: Groups, parameters: Parameters, watch: Stopwatch
) -> tuple[RoomLabels, tuple[Room, ...]]:
    """Find the rooms: by diffusion of labels (Eqs. 1-6), put right by what their plans hold, and measured (§4)."""
    watch.start("rooms", 1.0)
    labels = label_rooms(surfels, planes, groups, parameters.rooms, progress=watch)
    watch.start("measures")
    drafts = draw_plans(cloud, surfels, planes, labels, parameters.plans, by_floors=False)
    labels = keep_inside(surfels, labels, drafts, parameters.inside)
    labels = add_glimpsed_rooms(
        surfels,
        planes,
        labels,
        drafts,
        cloud.scanner_positions,
        parameters.glimpses,
        viewpoints=groups.viewpoints,
    )
    plans = draw_plans(cloud, surfels, planes, labels, parameters.plans)
    return labels, measure_rooms(cloud, surfels, labels, plans)


def _need(found: Sequence[object], files: Sequence[Path], what: str) -> None:
    """Refuse scans that show nothing which a graph could be made of."""
    if not found:
        names = ", ".join(str(file) for file in files[:3]) + (", ..." if len(files) > 3 else "")
        raise InputError(f"the scans of {names} show {what}: are they of a building's inside, registered, in metres?")
