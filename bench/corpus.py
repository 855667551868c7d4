"""Makes a corpus of many buildings: real homes with changed sizes, stacked into storeys, and furnished.

``python bench/corpus.py COUNT -o corpus.jsonl.gz`` writes it; ``bench/questions.py`` makes the same in memory, one
building at a time. A building is told by its number and the seed alone, so that the first thousand of ten thousand are
the thousand.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from pathlib import Path
from typing import Final

import numpy as np
from corpus_objects import Model, described_models, measured_models, scanned_again
from corpus_plans import Box, Home, PlanRoom, overlap, read_homes

from enfilade.descriptors import DEFAULT_LAYOUT
from enfilade.schema.checks import check
from enfilade.schema.exchange import write_graphs
from enfilade.schema.graph import BuildingGraph
from enfilade.schema.ids import object_id, opening_id, room_id, storey_id

DATA: Final = Path(__file__).parents[2] / "shared" / "data"

STOREYS: Final = (1, 1, 2, 2, 2, 3, 4)
"""How many a building has, each as likely."""

SEGMENTS: Final = 88
"""Mean number of single objects in a building; with the combinations of near ones there are about 100 objects."""

NEAR_M: Final = 0.5
PASSAGES: Final = 0.15
CLOSED: Final = 0.1
WINDOWS: Final = 0.7
COMBINED: Final = 0.25
"""Shares of doors that are passages, of doors that are closed, of rooms at the facade and of walls to a terrace with a
window, of near pairs that make a combination."""

LINKS: Final = {"hall": 3.0, None: 2.0, "living room": 1.5}
"""How much likelier stairs are in such a room than in another."""


@dataclass(frozen=True, slots=True)
class PlacedRoom:
    """A room of a building in the making."""

    id: str
    storey: int
    plan: PlanRoom
    box: Box


class Builder:
    """Makes one building.

    Parameters
    ----------
    number
        Which building; with the seed it decides everything.
    homes, models
        What to choose from.
    seed
        Of the whole corpus.
    """

    def __init__(self, number: int, homes: Sequence[Home], models: Sequence[Model], seed: int) -> None:
        self._rng = np.random.default_rng([seed, number])
        self._homes, self._models = homes, models
        self._number = number
        self._graph = BuildingGraph(f"b{number:05d}", descriptor_shape=DEFAULT_LAYOUT.shape)
        self._rooms: list[PlacedRoom] = []
        self._elevations: list[float] = []
        self._openings = 0

    def build(self) -> BuildingGraph:
        """Return the graph."""
        graph = self._graph
        graph.add_node(graph.building, "Building", name=f"Building {self._number}")
        elevation = 0.0
        for index in range(int(self._rng.choice(STOREYS))):
            height = round(float(self._rng.uniform(2.4, 3.4)), 2)
            self._add_storey(index, elevation, height)
            elevation += height + 0.3
        for lower, upper in pairwise(range(len(self._elevations))):
            graph.add_edge(storey_id(graph.building, lower), "BELOW", storey_id(graph.building, upper))
            self._join_storeys(lower)
        self._furnish()
        return graph

    def _add_storey(self, index: int, elevation: float, height: float) -> None:
        graph, home = self._graph, self._homes[int(self._rng.integers(len(self._homes)))]
        scale = float(self._rng.uniform(0.85, 1.2))
        id = storey_id(graph.building, index)
        area = round(sum(room.area for room in home.rooms) * scale**2, 2)
        graph.add_node(id, "Storey", name=f"Storey {index}", index=index, elevation=elevation, height=height, area=area)
        graph.add_edge(graph.building, "HAS_STOREY", id)
        self._elevations.append(elevation)
        x0, y0, _, _ = home.outline
        placed = []
        for room in home.rooms:
            box = tuple(round((v - o) * scale, 3) for v, o in zip(room.box, (x0, y0, x0, y0), strict=True))
            placed.append(self._add_room(index, room, (box[0], box[1], box[2], box[3]), scale, height))
            graph.add_edge(id, "HAS_ROOM", placed[-1].id)
        self._add_walls(home, placed, scale, height)
        self._add_doors(home, placed, scale)
        self._add_windows(home, placed)

    def _add_room(self, storey: int, plan: PlanRoom, box: Box, scale: float, height: float) -> PlacedRoom:
        number = len(self._rooms)
        floor = self._elevations[storey]
        x0, y0, x1, y1 = box
        own = round(height - float(self._rng.uniform(0.0, 0.3)), 3)
        room = PlacedRoom(room_id(self._graph.building, number), storey, plan, box)
        self._graph.add_node(
            room.id,
            "Room",
            name=f"{(plan.function or 'room').capitalize()} {number}",
            area=round(plan.area * scale**2, 2),
            floor_elevation=floor,
            ceiling_elevation=round(floor + own, 3),
            height=own,
            centroid=[(x0 + x1) / 2, (y0 + y1) / 2, floor],
            bounds=[x0, y0, floor, x1, y1, round(floor + own, 3)],
            outline=[[x0, y0, x1, y0, x1, y1, x0, y1]],
            seen_from="inside",
            function=plan.function,
            confidence=round(float(self._rng.uniform(0.7, 1.0)), 3),
        )
        self._rooms.append(room)
        return room

    def _add_walls(self, home: Home, placed: Sequence[PlacedRoom], scale: float, height: float) -> None:
        for wall in home.walls:
            a, b = (placed[number].id for number in wall.rooms)
            area = round(wall.length * scale * height, 2)
            self._graph.add_edge(a, "NEIGHBOUR", b, gap=round(wall.gap * scale, 3), area=area, planes=[])

    def _add_doors(self, home: Home, placed: Sequence[PlacedRoom], scale: float) -> None:
        for door in home.doors:
            rooms = [placed[number] for number in door.rooms]
            passage = self._rng.random() < PASSAGES
            closed = not passage and self._rng.random() < CLOSED
            width = min(max(door.width * scale, 0.6), 3.0)
            self._add_opening(
                rooms,
                "passage" if passage else "door",
                width,
                float(self._rng.uniform(1.95, 2.2)),
                lintel=0.0 if passage else 0.5,
                state="closed" if closed else "open",
            )

    def _add_windows(self, home: Home, placed: Sequence[PlacedRoom]) -> None:
        """Windows in rooms at the facade, and between a room and the terrace beside it."""
        outer = home.outline
        width, depth = outer[2] - outer[0], outer[3] - outer[1]
        for room, plan in zip(placed, home.rooms, strict=True):
            edge = min(abs(a - b) for a, b in zip(plan.box, outer, strict=True)) < 0.05 * max(width, depth)
            if edge and plan.function != "terrace" and self._rng.random() < WINDOWS:
                self._add_opening([room], "window", float(self._rng.uniform(0.6, 2.4)), 1.3, sill=0.9)
        for wall in home.walls:
            pair = [placed[number] for number in wall.rooms]
            outside = sum(room.plan.function == "terrace" for room in pair)
            if outside == 1 and self._rng.random() < WINDOWS:
                self._add_opening(pair, "window", float(self._rng.uniform(0.6, 2.4)), 1.3, sill=0.9)

    def _join_storeys(self, lower: int) -> None:
        """Add a flight of stairs and the slabs between two storeys."""
        below, above = ([room for room in self._rooms if room.storey == lower + k] for k in (0, 1))
        shared = {(a.id, b.id): overlap(a.box, b.box) for a in below for b in above}
        for (a, b), area in shared.items():
            if area >= 2.0:
                self._graph.add_edge(a, "NEIGHBOUR", b, gap=0.3, area=round(area, 2), planes=[])
        pairs = [(a, b) for a in below for b in above]
        weights = [shared[a.id, b.id] * LINKS.get(a.plan.function, 1) * LINKS.get(b.plan.function, 1) for a, b in pairs]
        pair = pairs[int(np.argmax(weights))]
        self._add_opening(pair, "stairs", 1.0, 2.0, orientation="vertical")

    def _add_opening(
        self,
        rooms: Sequence[PlacedRoom],
        kind: str,
        width: float,
        height: float,
        *,
        sill: float = 0.0,
        lintel: float | None = None,
        state: str | None = None,
        orientation: str = "horizontal",
    ) -> None:
        id = opening_id(self._graph.building, self._openings)
        self._openings += 1
        self._graph.add_node(
            id,
            "Opening",
            name=f"{kind.capitalize()} {self._openings - 1}",
            kind=kind,
            orientation=orientation,
            width=round(width, 3),
            height=round(height, 3),
            sill=sill,
            lintel=lintel,
            area=round(width * height, 3),
            ray_count=int(self._rng.integers(10, 5000)),
            state=state,
            confidence=round(float(self._rng.uniform(0.4, 1.0)), 3),
        )
        for room in rooms:
            self._graph.add_edge(room.id, "OPENS", id)

    def _furnish(self) -> None:
        areas = np.array([room.plan.area for room in self._rooms]) + 1.0
        total = int(self._rng.poisson(SEGMENTS))
        homes = np.sort(self._rng.choice(len(self._rooms), size=total, p=areas / areas.sum()))
        positions = self._rng.random((total, 2))
        chosen = self._rng.integers(len(self._models), size=total).tolist()
        places = []
        for number, found in enumerate(scanned_again(self._models, chosen, self._rng)):
            room = self._rooms[int(homes[number])]
            x0, y0, x1, y1 = room.box
            place = (x0 + positions[number, 0] * (x1 - x0), y0 + positions[number, 1] * (y1 - y0))
            places.append((place, found["size"]))
            self._add_object(room, (number,), place, found)
        self._combine(homes.tolist(), places)

    def _combine(self, rooms: Sequence[int], places: Sequence[tuple[tuple[float, float], list[float]]]) -> None:
        """Join what is near in a room, and make combinations of some of the pairs."""
        building = self._graph.building
        for a, b in combinations(range(len(places)), 2):
            if rooms[a] != rooms[b]:
                continue
            (one, size), (other, its) = places[a], places[b]
            between = float(np.hypot(one[0] - other[0], one[1] - other[1])) - (max(size[:2]) + max(its[:2])) / 2
            if between > NEAR_M:
                continue
            distance = round(max(between, 0.02), 3)
            self._graph.add_edge(object_id(building, a), "NEAR", object_id(building, b), distance=distance)
            if self._rng.random() < COMBINED:
                model = int(self._rng.integers(len(self._models)))
                (found,) = scanned_again(self._models, [model], self._rng)
                self._add_object(self._rooms[rooms[a]], (a, b), one, found)
                for segment in (a, b):
                    self._graph.add_edge(object_id(building, segment), "PART_OF", object_id(building, a, b))

    def _add_object(
        self, room: PlacedRoom, segments: tuple[int, ...], place: tuple[float, float], found: dict[str, object]
    ) -> None:
        id = object_id(self._graph.building, *segments)
        x, y = place
        self._graph.add_node(
            id,
            "Object",
            name="Object " + "+".join(map(str, segments)),
            segments=[object_id(self._graph.building, number) for number in segments],
            parts=len(segments),
            position=[round(x, 3), round(y, 3), self._elevations[room.storey]],
            **found,
        )
        self._graph.add_edge(room.id, "CONTAINS", id)


def buildings(
    numbers: range, homes: Sequence[Home], models: Sequence[Model], *, seed: int = 0
) -> Iterator[BuildingGraph]:
    """Yield buildings by number, each checked against the schema; none is kept."""
    for number in numbers:
        graph = Builder(number, homes, models, seed).build()
        check(graph)
        yield graph


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add what says how a corpus is made."""
    parser.add_argument("--plans", type=Path, default=DATA / "plans" / "cubicasa_dev.jsonl.gz", help="real homes")
    parser.add_argument(
        "--objects",
        nargs="+",
        default=[],
        metavar="SOURCE",
        help="graph files and stores to draw objects from",
    )
    parser.add_argument(
        "--meshes",
        type=Path,
        default=DATA / "meshes",
        help="meshes to describe where no SOURCE is named",
    )
    parser.add_argument("--seed", type=int, default=0)


def sources(arguments: argparse.Namespace) -> tuple[list[Home], list[Model]]:
    """Return homes and objects as the arguments name them."""
    models = measured_models(arguments.objects) if arguments.objects else described_models(arguments.meshes)
    return read_homes(arguments.plans), models


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", type=int, help="how many buildings")
    parser.add_argument("-o", "--output", type=Path, required=True, help="a .jsonl or .jsonl.gz file")
    add_arguments(parser)
    options = parser.parse_args()
    found = sources(options)
    write_graphs(buildings(range(options.count), *found, seed=options.seed), options.output)
