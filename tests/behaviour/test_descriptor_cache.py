"""The descriptors that are kept at hand are those in the store, whatever happens to the files or around them."""

from __future__ import annotations

import json
import multiprocessing
import os
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from enfilade.descriptors import quantise
from enfilade.schema.graph import BuildingGraph
from enfilade.stores import BuildingDescriptors, Store, open_store
from enfilade.stores import descriptor_cache as caches
from enfilade.stores import descriptor_files as files
from enfilade.stores.described import FLOOR, FOOT, Described
from enfilade.stores.descriptor_cache import DescriptorCache

SHAPE = (3, 1, 2)
Objects = dict[str, dict[str, list[int]]]


def building(name: str, numbers: Sequence[int], seed: int = 0, shape: tuple[int, int, int] = SHAPE) -> BuildingGraph:
    """A building of objects, every third without a descriptor, every other without the second one."""
    rng = np.random.default_rng(seed)
    graph = BuildingGraph(name, descriptor_shape=shape)
    graph.add_node(name, "Building")
    for number in numbers:
        object = graph.add_node(f"{name}/o{number}" + (f"+o{number + 1}" if number % 4 == 3 else ""), "Object")
        floor, foot = (quantise(rng.integers(0, 9, int(np.prod(shape))) + 0.01) for _ in range(2))
        if number % 3:
            object.properties["descriptor"] = floor
        if number % 2:
            object.properties["foot_descriptor"] = foot
    return graph


def stored(graphs: Sequence[BuildingGraph]) -> Objects:
    found: Objects = {}
    for graph in graphs:
        for node in graph.of_label("Object"):
            own = {kind: node.properties.get(name) for kind, name in ((FLOOR, "descriptor"), (FOOT, "foot_descriptor"))}
            if any(counts is not None for counts in own.values()):
                found[node.id] = {kind: counts.tolist() for kind, counts in own.items() if counts is not None}
    return found


def kept(described: Described) -> Objects:
    found: Objects = {}
    for objects in described.objects:
        for kind in (FLOOR, FOOT):
            table = objects.table(kind)
            rows = np.flatnonzero(table.valid)
            ids = objects.ids_of(rows)
            for id, row in zip(ids, rows.tolist(), strict=True):
                assert objects.row_of(id) == row
                found.setdefault(id, {})[kind] = table.counts[row].tolist()
                sums = table.counts[row].reshape(-1, objects.shape[2]).sum(axis=1).tolist()
                assert table.rings[row].tolist() == sums
                assert objects.shape != SHAPE or table.blocks[row].tolist() == [sums[0] + sums[1], sums[2]]
    return found


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "cache"


def test_it_follows_the_store(store: Store, folder: Path) -> None:
    cache = DescriptorCache(store, folder)
    assert cache.current().objects == []
    graphs = {name: building(name, range(9), seed) for seed, name in enumerate(("a", "b", "ü"))}
    store.write_all(list(graphs.values()))
    assert kept(cache.current()) == stored(list(graphs.values()))
    graphs["b"] = building("b", range(2, 7), 5)
    graphs["c"] = building("c", [1, 2], 6, (1, 1, 3))
    graphs["d"] = building("d", [])
    store.write_all([graphs["b"], graphs["c"], graphs["d"]])
    changed = cache.current()
    assert changed.read_anew == 3
    assert kept(changed) == stored(list(graphs.values()))
    store.remove("a")
    del graphs["a"]
    after = cache.current()
    assert after.read_anew == 0
    assert kept(after) == stored(list(graphs.values()))
    assert kept(DescriptorCache(store, folder).current()) == stored(list(graphs.values()))
    assert DescriptorCache(store, folder).current().read_anew == 0


def test_unknown_objects_have_no_row(sqlite_store: Store, folder: Path) -> None:
    sqlite_store.write(building("a", [1, 3]))
    (objects,) = DescriptorCache(sqlite_store, folder).current().objects
    assert objects.row_of("a/o1") is not None
    for id in ("a/o3", "a/o9", "b/o1", "a", "a/", "", "a/r1", "a/nonsense", "a/o3+o3"):
        assert objects.row_of(id) is None, id


def test_a_building_written_again_with_the_same_content_is_read_again(sqlite_store: Store, folder: Path) -> None:
    cache = DescriptorCache(sqlite_store, folder)
    sqlite_store.write(building("a", [1]))
    cache.current()
    sqlite_store.write(building("a", [1]))
    assert cache.current().read_anew == 1


def manifest_of(folder: Path) -> Path:
    (path,) = folder.glob("*/manifest.json")
    return path


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def rename_store(manifest: Path) -> None:
    document = json.loads(manifest.read_text(encoding="utf-8"))
    manifest.write_text(json.dumps(document | {"store": "sqlite:/other.db"}), encoding="utf-8")


DAMAGES: dict[str, Any] = {
    "no manifest": lambda own: (own / "manifest.json").unlink(),
    "half a manifest": lambda own: cut(own / "manifest.json"),
    "another manifest": lambda own: (own / "manifest.json").write_text("[]", encoding="utf-8"),
    "another format": lambda own: (own / "manifest.json").write_text('{"format": 0}', encoding="utf-8"),
    "another store": lambda own: rename_store(own / "manifest.json"),
    "half a file": lambda own: cut(next(own.glob("*/floor"))),
    "an empty file": lambda own: next(own.glob("*/numbers")).write_bytes(b""),
    "no file": lambda own: next(own.glob("*/foot-rings")).unlink(),
    "no folder": lambda own: [shutil.rmtree(path) for path in own.iterdir() if path.is_dir()],
    "nothing at all": lambda own: shutil.rmtree(own),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_files_are_made_again(sqlite_store: Store, folder: Path, damage: str) -> None:
    graphs = [building("a", range(7)), building("b", range(5), 1)]
    sqlite_store.write_all(graphs)
    DescriptorCache(sqlite_store, folder).current()

    DAMAGES[damage](manifest_of(folder).parent)

    assert kept(DescriptorCache(sqlite_store, folder).current()) == stored(graphs)
    assert DescriptorCache(sqlite_store, folder).current().read_anew == 0


def test_what_a_killed_writer_left_counts_as_nothing(sqlite_store: Store, folder: Path) -> None:
    graphs = [building("a", range(7))]
    sqlite_store.write_all(graphs)
    cache = DescriptorCache(sqlite_store, folder)
    cache.current()
    for path in manifest_of(folder).parent.glob("*/*"):
        path.write_bytes(path.read_bytes() + b"left over")
    assert kept(DescriptorCache(sqlite_store, folder).current()) == stored(graphs)
    graphs.append(building("b", range(5), 1))
    sqlite_store.write(graphs[1])
    assert kept(cache.current()) == stored(graphs)


def test_files_of_a_store_that_is_gone_are_cleared_away(tmp_path: Path, folder: Path) -> None:
    for name in ("a", "b", "c"):
        with open_store(f"sqlite:{tmp_path / name}.db") as store:
            store.write(building("x", [1]))
            DescriptorCache(store, folder).current()
            (tmp_path / "a.db").unlink(missing_ok=True)
    assert len(list(folder.glob("*/manifest.json"))) == 2


def test_it_goes_on_where_it_was_broken_off(sqlite_store: Store, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(caches, "ROWS_BETWEEN_SAVES", 1)
    graphs = [building(name, [1, 2], seed) for seed, name in enumerate("abcd")]
    sqlite_store.write_all(graphs)
    left = iter(range(2))

    def give_up() -> None:
        if next(left, None) is None:
            raise TimeoutError

    with pytest.raises(TimeoutError):
        DescriptorCache(sqlite_store, folder).current(give_up)
    again = DescriptorCache(sqlite_store, folder).current()
    assert again.read_anew == 2
    assert kept(again) == stored(graphs)


@pytest.mark.parametrize("obstacle", ["a file", "no space"])
def test_without_a_folder_nothing_is_lost(
    sqlite_store: Store, folder: Path, obstacle: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if obstacle == "a file":
        folder.write_text("in the way", encoding="utf-8")
    else:

        def full(*_: object) -> None:
            raise OSError(28, "No space left on device")

        monkeypatch.setattr(files.os, "fsync", full)
    graphs = [building("a", range(7)), building("b", range(5), 1), building("c", [1], 2, (1, 1, 3))]
    sqlite_store.write_all(graphs)
    cache = DescriptorCache(sqlite_store, folder)
    assert kept(cache.current()) == stored(graphs)
    sqlite_store.remove("b")
    graphs[0] = building("a", range(3), 9)
    sqlite_store.write(graphs[0])
    assert kept(cache.current()) == stored([graphs[0], graphs[2]])
    assert cache.current().read_anew == 0


def test_rows_of_buildings_that_are_gone_are_cleared_away(
    sqlite_store: Store, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(files, "LEAST_DEAD_ROWS", 2)
    graphs = [building(name, range(6), seed) for seed, name in enumerate("abc")]
    sqlite_store.write_all(graphs)
    cache = DescriptorCache(sqlite_store, folder)
    mapped = cache.current()
    before = sum(path.stat().st_size for path in folder.glob("*/*/*"))
    for round in range(4):
        graphs[0] = building("a", range(6), 10 + round)
        sqlite_store.write(graphs[0])
        assert kept(cache.current()) == stored(graphs)
    sqlite_store.remove("b")
    sqlite_store.remove("c")
    assert kept(cache.current()) == stored(graphs[:1])
    assert sum(path.stat().st_size for path in folder.glob("*/*/*")) < before
    assert len([path for path in folder.glob("*/*") if path.is_dir()]) == 1
    assert "c/o1" in kept(mapped)  # who looked before sees what was there


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.lists(
        st.tuples(st.sampled_from("abc"), st.none() | st.lists(st.integers(0, 9), max_size=4, unique=True)),
        max_size=12,
    ),
    st.integers(0, 3),
)
def test_any_row_of_writings_and_removals(
    tmp_path_factory: pytest.TempPathFactory,
    monkeypatch: pytest.MonkeyPatch,
    changes: list[tuple[str, list[int] | None]],
    least: int,
) -> None:
    monkeypatch.setattr(files, "LEAST_DEAD_ROWS", least)
    folder = tmp_path_factory.mktemp("changes")
    present: dict[str, BuildingGraph] = {}
    with open_store(f"sqlite:{folder / 'a.db'}") as store:
        cache = DescriptorCache(store, folder / "cache")
        for seed, (name, numbers) in enumerate(changes):
            if numbers is not None:
                present[name] = building(name, numbers, seed, SHAPE if seed % 3 else (1, 2, 2))
                store.write(present[name])
            elif name in present:
                del present[name]
                store.remove(name)
            if seed % 2:
                assert kept(cache.current()) == stored(list(present.values()))
        assert kept(cache.current()) == stored(list(present.values()))
        assert kept(DescriptorCache(store, folder / "cache").current()) == stored(list(present.values()))


def look(url: str, folder: Path, times: int) -> int:
    """What another process does: look again and again, and check that every building is whole."""
    with open_store(url) as store:
        for _ in range(times):
            (objects,) = DescriptorCache(store, folder).current().objects
            table = objects.table(FLOOR)
            ids = objects.ids_of(np.flatnonzero(table.valid))
            per_building = {name: [id for id in ids if id.startswith(f"{name}/")] for name in "abc"}
            assert {len(own) for own in per_building.values()} <= {2, 4}, per_building
            rows = np.flatnonzero(table.valid)
            assert (table.counts[rows].sum(axis=1) == 61440).all()
    return os.getpid()


def test_many_processes_look_while_one_writes(
    sqlite_store: Store, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sizes = ([1, 2], [1, 2, 4, 5])
    sqlite_store.write_all([building(name, sizes[0]) for name in "abc"])
    with multiprocessing.get_context("spawn").Pool(3) as pool:
        looking = [pool.apply_async(look, (sqlite_store.url, folder, 40)) for _ in range(3)]
        number = 0
        while not all(one.ready() for one in looking):
            number += 1
            sqlite_store.write(building("abc"[number % 3], sizes[number % 2], number))
        assert all(one.get() for one in looking)
    assert number > 3


class OldStore:
    """A store whose buildings tell no revision, as one written by an older Enfilade."""

    identity = "old"

    def __init__(self, store: Store) -> None:
        self._store = store

    def revisions(self) -> dict[str, str | None]:
        return dict.fromkeys(self._store.revisions())

    def descriptors(self, buildings: Sequence[str]) -> Iterator[BuildingDescriptors]:
        yield from self._store.descriptors(buildings)


def test_without_revisions_everything_is_read_each_time(sqlite_store: Store, folder: Path) -> None:
    graphs = [building("a", range(7)), building("b", range(5), 1)]
    sqlite_store.write_all(graphs)
    cache = DescriptorCache(OldStore(sqlite_store), folder)  # type: ignore[arg-type]
    assert kept(cache.current()) == stored(graphs)
    assert cache.current().read_anew == 2
