"""Loads a corpus into the stores, asks the list of questions there and of others, and prints Markdown.

``python bench/questions.py FOLDER --buildings 1000 --neo4j neo4j://neo4j@127.0.0.1:7687`` keeps the embedded store and
``questions-1000.json`` in FOLDER; a store with as many buildings is taken as it is. A question is asked ``--rounds``
times, an anchored one of another building each time; the first time is told apart, it has compiling and planning in it.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import statistics
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Final

from corpus import add_arguments, buildings, sources
from question_peers import Parameters, duckdb, expert, ladybug, vf2
from scale_questions import QUESTIONS, Asked

from enfilade.queries import answer
from enfilade.schema.graph import BuildingGraph
from enfilade.stores import Store, open_store
from enfilade.stores.base import in_batches

VF2_BUILDINGS: Final = 50
"""Buildings that VF2 is given; its time is told for as many as there are, which it grows with."""

PEERS: Final = ("duckdb", "ladybug", "vf2")

Ask = Callable[[Asked, Parameters], int]


@dataclass
class Times:
    """Milliseconds of one question at one place: the first time, the others, our CPU time; and the rows of each."""

    first: float = 0.0
    others: list[float] = field(default_factory=list)
    cpu: list[float] = field(default_factory=list)
    rows: list[int] = field(default_factory=list)
    error: str = ""

    @property
    def median(self) -> float:
        """Of the others, or the first where there are none."""
        return statistics.median(self.others) if self.others else self.first

    @property
    def least(self) -> float:
        """Of all."""
        return min([self.first, *self.others])


def load(store: Store, graphs: Iterable[BuildingGraph], count: int) -> dict[str, float]:
    """Write the corpus where it is not there yet; returns what it took, making the buildings left out."""
    if len(store.buildings()) == count:
        return {}
    rows, spent, cpu, half = 0, 0.0, 0.0, 0.0
    done = 0
    for batch in in_batches(graphs):
        start, begun = time.perf_counter(), time.process_time()
        store.write_all(batch)
        spent += time.perf_counter() - start
        cpu += time.process_time() - begun
        rows += sum(len(graph.nodes) + len(graph.edges) for graph in batch)
        done += len(batch)
        if done <= count / 2:
            half = spent
        print(f"{store.url}: {done} of {count}", end="\r", file=sys.stderr, flush=True)
    return {"rows": rows, "seconds": spent, "cpu_seconds": cpu, "seconds_of_the_first_half": half}


def our_way(store: Store) -> Ask:
    """Return what asks a store in our language."""

    def ask(asked: Asked, parameters: Parameters) -> int:
        given = {name: value for name, value in parameters.items() if name != "basin"}
        likenesses = {name: value for name, value in parameters.items() if name == "basin"}
        return len(answer(store, asked.text, parameters=given, likenesses=likenesses, timeout_s=120).rows)

    return ask


def measure(ask: Ask, asked: Asked, rounds: Sequence[Parameters]) -> Times:
    """Ask a question several times."""
    times = Times()
    for number, parameters in enumerate(rounds):
        start, begun = time.perf_counter(), time.process_time()
        try:
            times.rows.append(ask(asked, parameters))
        except Exception as error:
            times.error = str(error)[:100]
            return times
        spent = 1000 * (time.perf_counter() - start)
        times.cpu.append(1000 * (time.process_time() - begun))
        if number:
            times.others.append(spent)
        else:
            times.first = spent
    return times


def rounds_of(asked: Asked, store: Store, count: int, rounds: int, rng: random.Random) -> list[Parameters]:
    """Return the values of the parameters for each time a question is asked."""
    found: list[Parameters] = []
    for _ in range(rounds):
        building = f"b{rng.randrange(count):05d}"
        rooms = answer(store, "MATCH (r:Room {building: $b}) RETURN r", parameters={"b": building}).rows
        thing = f"{building}/o{rng.randrange(40)}"
        values = {
            "room": rng.choice(rooms)["r"],
            "building": building,
            "thing": thing,
            "basin": f"object:{thing}",
        }
        found.append({name: value for name, value in values.items() if f"${name}" in asked.text})
    return found


def asked_everywhere(
    places: Mapping[str, Ask], store: Store, count: int, rounds: int, only: Sequence[str]
) -> Iterator[tuple[Asked, dict[str, Times]]]:
    """Ask every question at every place that can say it."""
    rng = random.Random(0)
    for asked in QUESTIONS:
        values = rounds_of(asked, store, count, rounds, rng)
        if only and not any(word in f"{asked.kind} {asked.name}" for word in only):
            continue
        times = {}
        for place, ask in places.items():
            if _can_say(place, asked):
                times[place] = measure(ask, asked, values[:1] if place == "vf2" else values)
        print(asked.name, {place: round(t.median, 1) for place, t in times.items()}, file=sys.stderr, flush=True)
        yield asked, times


def _can_say(place: str, asked: Asked) -> bool:
    """Whether there is a version of a question for a place; Ladybug has rooms only, and is given no statistics."""
    rooms = asked.kind not in ("statistics", "likeness") and not any(
        word in asked.text for word in ("Object", "(o)", "$thing", "index", "[:NEIGHBOUR]")
    )
    possible = {"expert": bool(asked.cypher), "duckdb": bool(asked.sql), "ladybug": rooms, "vf2": asked.vf2}
    return possible.get(place, True)


def table(results: Mapping[str, Mapping[str, Times]], places: Sequence[str], count: int) -> str:
    """Return the times as Markdown, milliseconds: least, median, and the first; ≠ marks other rows than at the first.

    Where other programs run, the least is the nearest to what a question takes; the CPU time of what runs in this
    process is told behind, in brackets.
    """
    kinds = {asked.name: asked.kind for asked in QUESTIONS}
    lines = [["question", "kind", "rows", *places], ["---", "---", "---:", *["---:"] * len(places)]]
    for name, times in results.items():
        found = next(iter(times.values())).rows
        rows = f"{statistics.median(found):,.0f}" if found else "–"
        lines.append([name, kinds[name], rows, *(_cell(times.get(place), found, place, count) for place in places)])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _cell(times: Times | None, rows: Sequence[int], place: str, count: int) -> str:
    if times is None:
        return ""
    if times.error:
        return times.error.replace("|", "\\|")
    if place == "vf2":
        return f"{times.first * count / min(count, VF2_BUILDINGS):,.0f}"
    differs = " ≠" if list(times.rows) != list(rows) else ""
    cpu = f" ({statistics.median(times.cpu):,.1f})" if place == "sqlite" and times.cpu else ""
    return f"{times.least:,.1f} · {times.median:,.1f} · {times.first:,.0f}{cpu}{differs}"


def summary(results: Mapping[str, Mapping[str, Times]]) -> str:
    """Return the bars: medians of all anchored times, and the slowest whole-corpus pattern of four rooms."""
    anchored = [asked.name for asked in QUESTIONS if asked.kind == "anchored" and asked.name in results]
    four = [asked.name for asked in QUESTIONS if asked.kind == "whole corpus" and asked.name in results]
    lines = []
    for place in ("sqlite", "neo4j"):
        times = [t for name in anchored if place in results[name] for t in results[name][place].others]
        slowest = [(results[name][place].median, name) for name in four if place in results[name]]
        if times:
            median, least = statistics.median(times), min(times)
            lines.append(f"{place}: anchored, median {median:.1f} ms, from {least:.1f} to {max(times):.1f} ms")
        if slowest:
            lines.append(f"{place}: slowest pattern over the whole corpus {max(slowest)[0]:.0f} ms ({max(slowest)[1]})")
    return "\n".join(f"- {line}" for line in lines)


def loading(took: Mapping[str, float]) -> str:
    """Return what loading took as the end of a line."""
    rate = took["rows"] / took["seconds"]
    half, cpu = took["seconds_of_the_first_half"], took["cpu_seconds"]
    whole = f"{took['rows']:,} rows in {took['seconds']:.0f} s, {rate:,.0f} a second"
    return f"{whole}; the first half in {half:.0f} s; {cpu:.0f} s of our own CPU time"


def main(options: argparse.Namespace) -> None:
    """Load, ask, print."""
    count, folder = options.buildings, options.folder
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"corpus-{count}.db"
    stores = {"sqlite": open_store(f"sqlite:{path}")}
    if options.neo4j:
        stores["neo4j"] = open_store(options.neo4j)
    homes, models = sources(options)
    loaded = {n: load(s, buildings(range(count), homes, models, seed=options.seed), count) for n, s in stores.items()}
    places: dict[str, Ask] = {name: our_way(store) for name, store in stores.items()}
    if "neo4j" in stores:
        stores["neo4j"].rows("CALL db.awaitIndexes(300)", {})
        places["expert"] = expert(stores["neo4j"])
    if "duckdb" in options.peers:
        places["duckdb"] = duckdb(path)
    if "ladybug" in options.peers:
        places["ladybug"] = ladybug(path)
    if "vf2" in options.peers:
        places["vf2"] = vf2(list(buildings(range(min(count, VF2_BUILDINGS)), homes, models, seed=options.seed)))
    results: dict[str, dict[str, Times]] = {}
    for asked, times in asked_everywhere(places, stores["sqlite"], count, options.rounds, options.only):
        results[asked.name] = times
        kept = {name: {place: asdict(t) for place, t in found.items()} for name, found in results.items()}
        text = json.dumps({"buildings": count, "loaded": loaded, "results": kept}, indent=1)
        (folder / f"questions-{count}.json").write_text(text, encoding="utf-8")
    print(f"{count:,} buildings, {os.cpu_count()} cores\n")
    for name, took in loaded.items():
        if took:
            print(f"- {name}: {loading(took)}")
    print(f"{summary(results)}\n\n{table(results, list(places), count)}")


def _arguments() -> Any:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--buildings", type=int, default=1000)
    parser.add_argument("--neo4j", metavar="URL", help="a database that holds nothing or this corpus")
    parser.add_argument("--peers", nargs="*", choices=PEERS, default=PEERS)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--only", nargs="+", default=[], metavar="WORD", help="of kinds and names of questions")
    add_arguments(parser)
    return parser.parse_args()


if __name__ == "__main__":
    main(_arguments())
