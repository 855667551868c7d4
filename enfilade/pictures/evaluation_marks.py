"""What a sheet of an evaluation shows of one storey: rooms, openings and objects, each with a verdict."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from enfilade.evaluate import Evaluation, Fault
from enfilade.evaluate.sides import Side, label, number_of
from enfilade.schema.graph import Node
from enfilade.schema.ids import parse

F64 = NDArray[np.float64]


class Verdict(Enum):
    """What became of a thing."""

    RIGHT = "right"
    MISSED = "missed"
    INVENTED = "invented"
    WRONG_ROOMS = "wrong rooms"
    SAID_CLOSED = "said closed"
    NOT_ASKED = "not asked"


@dataclass(frozen=True, slots=True)
class RoomMark:
    """A room: its rings ``(K, 2)``, its names, its tint by number (None where it has no match), and its verdict."""

    rings: tuple[F64, ...]
    name: str
    tint: int | None
    verdict: Verdict


@dataclass(frozen=True, slots=True)
class OpeningMark:
    """An opening: ``(2,)`` centre, ``(2,)`` unit vector along it in plan, its kind, width and verdict."""

    position: F64
    along: F64
    kind: str
    width: float
    verdict: Verdict


@dataclass(frozen=True, slots=True)
class ObjectMark:
    """An object: lower left corner and size in plan, and its verdict."""

    corner: F64
    size: F64
    verdict: Verdict


@dataclass(frozen=True, slots=True)
class NumberMark:
    """The number of a fault in the list below the plans, where it is, and whether that is a room."""

    position: F64
    number: int
    on_room: bool


@dataclass(frozen=True, slots=True)
class Half:
    """One of the two plans of a sheet."""

    title: str
    rooms: tuple[RoomMark, ...] = ()
    openings: tuple[OpeningMark, ...] = ()
    objects: tuple[ObjectMark, ...] = ()
    numbers: tuple[NumberMark, ...] = ()


@dataclass(frozen=True, slots=True)
class EvaluationSheet:
    """One storey: truth, prediction and the numbered faults."""

    name: str
    truth: Half
    prediction: Half
    faults: tuple[str, ...]


def evaluation_sheets(found: Evaluation) -> Iterator[EvaluationSheet]:
    """Yield a sheet for each storey of the truth, and for each predicted one that stands for none of these."""
    comparison = found.comparison
    sides = {"truth": comparison.matching.truth, "prediction": comparison.matching.prediction}
    halves = {side: _Half(found, side) for side in sides}
    for there, here in _storeys(sides["truth"], sides["prediction"], comparison.storeys):
        storeys = {"truth": there, "prediction": here}
        shown = [fault for fault in _worth_a_number(found.faults) if _on(sides, storeys, fault)]
        numbered = list(enumerate(shown, start=1))
        truth, prediction = (
            halves[side].of(storeys[side], [(n, fault) for n, fault in numbered if fault.side == side])
            for side in ("truth", "prediction")
        )
        lines = tuple(f"{n}  {fault.what}: {fault.name}: {fault.why}" for n, fault in numbered)
        yield EvaluationSheet(_sheet_name(there, here), truth, prediction, lines)


class _Half:
    """Makes the marks of one side, storey by storey."""

    def __init__(self, found: Evaluation, side: str) -> None:
        comparison = found.comparison
        self._name = side
        self._is_truth = side == "truth"
        self._matching = comparison.matching
        self._side = self._matching.truth if self._is_truth else self._matching.prediction
        self._tints = {pair[0 if self._is_truth else 1]: k for k, pair in enumerate(sorted(self._matching.pairs))}
        self._openings = _opening_verdicts(found, side)
        self._objects = _object_verdicts(found, side)

    def of(self, storey: int | None, faults: list[tuple[int, Fault]]) -> Half:
        """Return the marks on a storey, None for a sheet without this side."""
        rooms = [room for room, number in self._side.storeys.items() if number == storey]
        numbers = [(n, self._place(fault), fault.subject == "room") for n, fault in faults]
        return Half(
            self._title(storey),
            tuple(mark for room in rooms if (mark := self._room(room)) is not None),
            tuple(self._opening_marks(set(rooms))),
            tuple(self._object_marks(set(rooms))),
            tuple(NumberMark(place, n, on_room) for n, place, on_room in numbers if place is not None),
        )

    def _title(self, storey: int | None) -> str:
        if storey is None:
            return f"{self._name}: no such storey"
        node = self._side.graph.nodes.get(f"{self._side.graph.building}/s{storey}")
        return f"{self._name}: {label(node) if node else f's{storey}'}"

    def _room(self, room: int) -> RoomMark | None:
        rings = _rings(self._side.rooms[room])
        if not rings:
            return None
        matching, tint = self._matching, self._tints.get(room)
        name = self._side.name(room)
        if tint is not None and not self._is_truth:
            name = f"r{room} is {matching.truth.name(matching.true_of[room])}"
        asked = room in matching.asked if self._is_truth else room not in matching.not_asked
        lost = Verdict.MISSED if self._is_truth else Verdict.INVENTED
        verdict = Verdict.RIGHT if tint is not None else lost if asked else Verdict.NOT_ASKED
        return RoomMark(rings, name, tint, verdict)

    def _opening_marks(self, rooms: set[int]) -> Iterator[OpeningMark]:
        for node in self._side.graph.of_label("Opening"):
            position, given = node.properties.get("position"), node.properties
            if position is not None and rooms & set(self._side.rooms_of(node.id)):
                normal = np.asarray(given.get("normal", (0.0, 0.0, 1.0)), dtype=float)[:2]
                length = float(np.linalg.norm(normal))
                along = np.array([-normal[1], normal[0]]) / length if length > 0.5 else np.zeros(2)
                verdict = self._openings.get(node.id, Verdict.NOT_ASKED)
                width = float(given.get("width", 0.0))
                yield OpeningMark(np.array(position[:2]), along, str(given.get("kind", "")), width, verdict)

    def _object_marks(self, rooms: set[int]) -> Iterator[ObjectMark]:
        for node in self._side.graph.of_label("Object"):
            room = self._side.topology.room_of.get(node.id)
            position, size = node.properties.get("position"), np.array(node.properties.get("size", (0.1, 0.1))[:2])
            single = len(parse(node.id).numbers) == 1
            if single and position is not None and room is not None and number_of(room) in rooms:
                verdict = self._objects.get(number_of(node.id), Verdict.NOT_ASKED)
                yield ObjectMark(np.array(position[:2]) - size / 2, size, verdict)

    def _place(self, fault: Fault) -> F64 | None:
        node = self._side.graph.nodes.get(fault.id)
        return None if node is None else _place(node)


def _opening_verdicts(found: Evaluation, side: str) -> dict[str, Verdict]:
    """Return the verdict on each opening of a side that is judged at all."""
    verdicts = found.comparison.verdicts
    right = (pair[1 if side == "truth" else 0] for verdict in verdicts.all for pair in verdict.pairs)
    told = {hole.id: Verdict.RIGHT for hole in right}
    sorts = {"missed": Verdict.MISSED, "invented": Verdict.INVENTED}
    causes = {
        "wrong_rooms": Verdict.WRONG_ROOMS,
        "rooms_not_found": Verdict.WRONG_ROOMS,
        "said_closed": Verdict.SAID_CLOSED,
    }
    for fault in found.faults:
        if fault.subject == "opening" and fault.side == side:
            told[fault.id] = causes.get(fault.cause, sorts[fault.fault]) if fault.others else sorts[fault.fault]
    return told


def _object_verdicts(found: Evaluation, side: str) -> dict[int, Verdict]:
    furnishings = found.comparison.furnishings
    if side == "truth":
        missed = set(furnishings.missed)
        return {n: Verdict.MISSED if n in missed else Verdict.RIGHT for n in furnishings.best}
    ghosts = {node.id for node in furnishings.ghosts}
    nodes = furnishings.prediction.graph.of_label("Object")
    return {number_of(node.id): Verdict.INVENTED if node.id in ghosts else Verdict.RIGHT for node in nodes}


def _worth_a_number(faults: Iterable[Fault]) -> list[Fault]:
    """Rooms and openings have numbers; objects are many and small, and speak by their symbols."""
    return [fault for fault in faults if fault.subject in ("room", "opening")]


def _on(sides: Mapping[str, Side], storeys: Mapping[str, int | None], fault: Fault) -> bool:
    """Whether a fault lies on the storey of a sheet, or on the lowest one that it touches."""
    where = sides[fault.side]
    rooms: tuple[int, ...] = (number_of(fault.id),) if fault.subject == "room" else where.rooms_of(fault.id)
    levels = [where.storeys[room] for room in rooms if room in where.storeys]
    return bool(levels) and min(levels) == storeys[fault.side]


def _storeys(truth: Side, prediction: Side, same: Mapping[int, int]) -> list[tuple[int | None, int | None]]:
    """Pairs of storeys, by height."""
    pairs: list[tuple[int | None, int | None]] = [(there, same.get(there)) for there in _by_height(truth)]
    return pairs + [(None, here) for here in _by_height(prediction) if here not in same.values()]


def _by_height(side: Side) -> list[int]:
    nodes = {number_of(node.id): node for node in side.graph.of_label("Storey")}
    used = set(side.storeys.values())
    return sorted(used, key=lambda n: (nodes[n].properties.get("index", n) if n in nodes else n, n))


def _sheet_name(there: int | None, here: int | None) -> str:
    return f"s{there}" if there is not None else f"predicted-s{here}"


def _rings(room: Node) -> tuple[F64, ...]:
    """Outline, or bounds where there is none; empty where there are none, either."""
    outline: Any = room.properties.get("outline") or []
    rings = tuple(np.reshape(np.asarray(ring, dtype=float), (-1, 2)) for ring in outline)
    if rings and len(rings[0]) >= 3:
        return rings
    bounds = room.properties.get("bounds")
    if bounds is None:
        return ()
    x0, y0, _, x1, y1, _ = bounds
    return (np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)]),)


def _place(node: Node) -> F64 | None:
    """Where a node's number goes."""
    for property in ("position", "centroid"):
        if property in node.properties:
            return np.asarray(node.properties[property][:2], dtype=float)
    rings = _rings(node) if node.label == "Room" else ()
    return rings[0].mean(axis=0) if rings else None
