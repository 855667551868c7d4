"""The top 10 by likeness among a million objects: exact by bounds, by brute force, and by an approximate index.

``python bench/likeness.py FOLDER [--objects N] [--meshes FOLDER] [--measured STORE...] [--index] [--store N]`` keeps
the objects in FOLDER (3.4 kB each) and prints Markdown tables. ``--index`` compares with a graph index (HNSW) of faiss,
which is to be installed for it (``pip install 'enfilade[bench]'``); ``--store`` times questions to a store of N
objects, the first one too.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np
from corpus_objects import described_models, measured_models
from likeness_objects import described_objects, seen_again
from numpy.typing import NDArray

from enfilade.cache import CACHE_VARIABLE
from enfilade.descriptors import DEFAULT_LAYOUT, TOTAL, distances, mesh_views, read_shape
from enfilade.descriptors.bounds import rings_of
from enfilade.descriptors.nearest import DECIMALS, DescriptorTable, Nearest
from enfilade.schema.graph import BuildingGraph
from enfilade.stores import open_store

U16 = NDArray[np.uint16]
R = TypeVar("R")

MESHES: Final = Path(__file__).parents[2] / "shared" / "data" / "meshes"
TOP: Final = 10
CANDIDATES: Final = 100
"""What the index gives to be measured exactly."""
OBJECTS_A_BUILDING: Final = 100


def nearest_ten(views: U16, table: DescriptorTable) -> Nearest:
    """Search for the nearest ten, by bounds."""
    nearest = Nearest(views, table)
    nearest.best(TOP)
    return nearest


def brute_force(views: U16, table: DescriptorTable) -> NDArray[np.float64]:
    """Distances of the nearest ten, by measuring everything on all processors."""
    found = np.round(distances(views, table.counts, table.shape), DECIMALS)
    return np.sort(np.partition(found, TOP)[:TOP])


def timed(work: Callable[..., R], *arguments: Any) -> tuple[R, tuple[float, float]]:
    """Return what the work returns, and its wall and processor seconds."""
    start, busy = time.perf_counter(), time.process_time()
    done = work(*arguments)
    return done, (time.perf_counter() - start, time.process_time() - busy)


def compare(name: str, questions: Sequence[U16], table: DescriptorTable) -> None:
    """Ask every question both ways; print one line of the table."""
    rows = []
    for views in questions:
        search, fast = timed(nearest_ten, views, table)
        found, slow = timed(brute_force, views, table)
        assert np.array_equal(search.best(TOP)[1][:TOP], found), "the nearest by bounds are not those by brute force"
        rows.append((*fast, *slow, search.effort.distances, search.effort.bounds))
    wall, busy, brute, brute_busy, measured, bounds = map(np.array, zip(*rows, strict=True))
    print(
        f"| {name} | {1000 * np.median(wall):.0f} ({1000 * max(wall):.0f}) | {1000 * np.median(busy):.0f} "
        f"| {1000 * np.median(brute):.0f} | {1000 * np.median(brute_busy):.0f} "
        f"| {np.median(brute / wall):.0f} ({min(brute / wall):.0f}) | {np.median(brute_busy / busy):.0f} "
        f"| {np.median(bounds):,.0f} | {np.median(measured):,.0f} |",
        flush=True,
    )


def compare_index(objects: Sequence[U16], meshes: Sequence[U16], table: DescriptorTable) -> None:
    """Build an index of √-histograms and say how many of the exact ten it finds, and how fast."""
    import faiss

    vectors = _roots(table.rings)
    index = faiss.IndexHNSWFlat(vectors.shape[1], 32)
    index.hnsw.efConstruction, index.hnsw.efSearch = 80, 256
    _, (wall, busy) = timed(index.add, vectors)
    print(
        f"\nHNSW of faiss {faiss.__version__}, √ of the {vectors.shape[1]} bins summed over sectors, "
        f"M 32, efConstruction 80, efSearch 256: built in {wall:.0f} s ({busy:.0f} s of processor time).\n"
    )
    print("| question | ms | recall of the exact 10 | recall when the best 100 are measured exactly |")
    print("| --- | --- | --- | --- |")
    for name, questions in (("an object", objects), ("a mesh, 9 views", meshes)):
        walls, plain, measured = [], [], []
        for views in questions:
            exact = Nearest(views, table).best(TOP)[1][TOP - 1]
            start = time.perf_counter()
            apart, rows = index.search(_roots(_rings(views, table)), CANDIDATES)
            walls.append(time.perf_counter() - start)
            order = np.argsort(apart.ravel(), kind="stable")
            candidates = np.array(list(dict.fromkeys(rows.ravel()[order].tolist())))[:CANDIDATES]
            found = Nearest(views, table).of(candidates)
            plain.append(np.count_nonzero(found[:TOP] <= exact) / TOP)
            measured.append(np.count_nonzero(found <= exact) / TOP)
        print(
            f"| {name} | {1000 * np.median(walls):.1f} | {np.mean(plain):.2f} | {np.mean(measured):.2f} |", flush=True
        )


def _rings(views: U16, table: DescriptorTable) -> U16:
    return rings_of(np.atleast_2d(views), table.shape)


def _roots(rings: U16) -> NDArray[np.float32]:
    return np.asarray(np.sqrt(rings / TOTAL), dtype=np.float32)


# Questions to a store

ASK: Final = """
import sys, time
start = time.perf_counter()
import enfilade
with enfilade.connect(sys.argv[1]) as connection:
    for again in range(int(sys.argv[3])):
        began = time.perf_counter()
        result = connection.query(sys.argv[2], timeout_s=None)
        last = time.perf_counter() - began
print(f"{time.perf_counter() - start:.2f} {1000 * last:.0f}")
"""


def ask_store(models: U16, count: int, folder: Path, mesh: Path) -> None:
    """Time the first question to a store, and later ones, each in a process of its own."""
    url = f"sqlite:{folder / f'objects-{count}.db'}"
    _, (wall, _) = timed(_fill, url, models, count)
    print(f"\nA store of {count:,} objects in {count // OBJECTS_A_BUILDING:,} buildings, written in {wall:.0f} s.\n")
    texts = {"an object": "object('b7/o7')", "a mesh": f"'{mesh}'"}
    print("| process | question | whole process s | question ms |\n| --- | --- | --- | --- |")
    with tempfile.TemporaryDirectory(dir=folder) as cold:
        new = os.environ | {CACHE_VARIABLE: f"{cold}/cache", "NUMBA_CACHE_DIR": f"{cold}/numba"}
        for process, times in (("first on this machine", 1), ("next", 1), ("tenth question of one process", 10)):
            for name, like in texts.items():
                text = f"MATCH (a:Room)-[:CONTAINS]->(o:Object LIKE {like}) RETURN a, o, score LIMIT 10"
                done = subprocess.run(
                    [sys.executable, "-c", ASK, url, text, str(times)],
                    env=new,
                    capture_output=True,
                    text=True,
                    check=True,
                )
                print(f"| {process} | like {name} | {' | '.join(done.stdout.split())} |", flush=True)


def _fill(url: str, models: U16, count: int) -> None:
    with open_store(url) as store:
        if store.buildings():
            return
        for first in range(0, count, 10 * OBJECTS_A_BUILDING):
            rows = seen_again(models, 10 * OBJECTS_A_BUILDING, first)
            parts = rows.reshape(10, OBJECTS_A_BUILDING, -1)
            store.write_all([_building(first // OBJECTS_A_BUILDING + i, part) for i, part in enumerate(parts)])


def _building(number: int, counts: U16) -> BuildingGraph:
    graph = BuildingGraph(f"b{number}", descriptor_shape=DEFAULT_LAYOUT.shape)
    graph.add_node(graph.building, "Building")
    graph.add_node(f"{graph.building}/r0", "Room")
    for i, own in enumerate(counts):
        id = f"{graph.building}/o{i}"
        graph.add_node(id, "Object", parts=1, descriptor=own, foot_descriptor=own)
        graph.add_edge(f"{graph.building}/r0", "CONTAINS", id)
    return graph


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--meshes", type=Path, default=MESHES)
    parser.add_argument("--objects", type=int, default=1_000_000)
    parser.add_argument("--questions", type=int, default=10)
    parser.add_argument("--measured", nargs="*", default=[], help="stores or graph files with measured objects")
    parser.add_argument("--index", action="store_true")
    parser.add_argument("--store", type=int)
    given = parser.parse_args()
    files = sorted(given.meshes.glob("*/*.obj"))
    models = described_models(given.meshes) + (measured_models(given.measured) if given.measured else [])
    counts = np.stack([model.foot_descriptor for model in models])
    table = described_objects(counts, given.objects, given.folder)
    rng = np.random.default_rng(1)
    objects = [table.counts[row] for row in rng.integers(len(table.counts), size=given.questions)]
    chosen = [files[i] for i in rng.permutation(len(files))[: given.questions]]
    meshes = [mesh_views(read_shape(path)) for path in chosen]
    for views in (objects[0], meshes[0]):  # compiled before anything is timed
        Nearest(views, table).best(TOP)
        distances(views, table.counts[:4096], table.shape)
    print(f"{len(table.counts):,} objects made from {len(models):,} models; {os.cpu_count()} processors\n")
    print(
        "| like | ms (longest) | CPU ms | brute force ms | CPU ms | times faster (least) | by CPU | bounds | measured |"
    )
    print("|" + " --- |" * 9)
    compare("an object", objects, table)
    compare("a mesh, 9 views", meshes, table)
    if given.index:
        compare_index(objects, meshes, table)
    if given.store:
        ask_store(counts, given.store, given.folder, chosen[0])


if __name__ == "__main__":
    main()
