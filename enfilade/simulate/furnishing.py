"""What stands in which kind of room."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from . import fittings, furniture
from .interiors import Interior
from .layouts import Generator
from .plan import Piece


def _size(random: Generator, low: float, high: float) -> float:
    return round(float(random.uniform(low, high)), 2)


def _chairs(room: Interior, random: Generator, table: Piece, width: float, depth: float) -> None:
    """Chairs along both long sides of a table, not all tucked in alike."""
    for side, turn in ((1, 0.0), (-1, 180.0)):
        count = max(1, int(width / 0.7))
        for k in range(count):
            x = (k + 0.5) * width / count - width / 2
            out = depth / 2 + 0.27 + max(0.0, float(random.normal(0.08, 0.1)))
            room.beside("chair", furniture.chair(), table, (x, side * out), turn)


def _dining(room: Interior, random: Generator) -> None:
    width, depth = _size(random, 1.2, 2.0), _size(random, 0.75, 0.95)
    table = room.anywhere("table", furniture.table(width, depth))
    if table is not None:
        _chairs(room, random, table, width, depth)
        if random.random() < 0.6:
            room.on_top("bowl", fittings.bin_bag(0.15, 0.12), table)


def _living(room: Interior, random: Generator) -> None:
    sofa = room.against_wall("sofa", furniture.sofa(_size(random, 1.5, 2.4)))
    if sofa is not None:
        room.beside("low table", fittings.low_table(_size(random, 0.8, 1.2)), sofa, (0.0, -1.15), 0.0)
    room.against_wall("sideboard", furniture.cabinet(_size(random, 1.2, 1.9), 0.42, _size(random, 0.45, 0.85)))
    room.against_wall("shelf", furniture.shelf(_size(random, 0.8, 1.4), 0.32, _size(random, 1.4, 2.1)))
    room.anywhere("floor lamp", fittings.floor_lamp(_size(random, 1.4, 1.8)))
    room.anywhere("armchair", furniture.sofa(0.9, 0.85))
    room.against_wall("plant", fittings.plant(_size(random, 0.8, 1.6)))


def _kitchen(room: Interior, random: Generator) -> None:
    row = room.against_wall("kitchen row", furniture.cabinet(_size(random, 1.8, 3.0), 0.6, 0.9))
    if row is not None:
        room.beside("fridge", fittings.fridge(), row, (float(row.mesh.bounds[1, 0]) + 0.33, 0.0), 0.0)
        room.on_top("kettle", fittings.bin_bag(0.1, 0.22), row, (0.4, 0.1))
        room.on_top("carton", fittings.carton(0.3, 0.25, 0.35), row, (-0.5, 0.1))
    for _ in range(2):
        room.against_wall("wall cupboard", fittings.wall_cupboard(_size(random, 0.6, 1.2)), height=1.42)
    _dining(room, random)


def _bedroom(room: Interior, random: Generator) -> None:
    bed = room.against_wall("bed", furniture.bed(_size(random, 0.9, 1.8)))
    if bed is not None:
        side = float(bed.mesh.bounds[1, 0]) + 0.27
        room.beside("bedside cabinet", furniture.cabinet(0.42, 0.38, 0.5), bed, (side, 0.8), 0.0)
    room.against_wall("wardrobe", furniture.wardrobe(_size(random, 1.0, 2.2), 0.6, _size(random, 1.9, 2.2)))
    table = room.against_wall("desk", fittings.desk(_size(random, 0.9, 1.3), 0.6))
    if table is not None:
        room.beside("chair", furniture.chair(), table, (0.0, -0.55), 180.0)
        room.on_top("books", fittings.books(), table, (0.2, 0.1))
    room.against_wall("picture", fittings.picture(_size(random, 0.5, 1.0)), height=1.4, gap=0.0)


def _office(room: Interior, random: Generator) -> None:
    for _ in range(2 + int(random.integers(3))):
        table = room.against_wall("desk", fittings.desk(_size(random, 1.2, 1.8), _size(random, 0.7, 0.85)))
        if table is not None:
            room.beside("office chair", fittings.office_chair(), table, (0.1, -0.62), 180.0)
            room.on_top("monitor", fittings.monitor(_size(random, 0.5, 0.75)), table, (0.0, 0.12))
            if random.random() < 0.6:
                room.on_top("books", fittings.books(_size(random, 0.2, 0.4)), table, (0.45, 0.1))
    room.against_wall("shelf", furniture.shelf(_size(random, 0.8, 1.2), 0.38, _size(random, 1.2, 2.1)))
    room.against_wall("cabinet", furniture.cabinet(_size(random, 0.8, 1.2), 0.45, _size(random, 0.7, 1.25)))


def _open_office(room: Interior, random: Generator) -> None:
    for _ in range(8):
        table = room.anywhere("desk", fittings.desk(1.6, 0.8))
        if table is not None:
            room.beside("office chair", fittings.office_chair(), table, (0.0, -0.7), 180.0)
            room.on_top("monitor", fittings.monitor(), table, (0.0, 0.15))
    _office(room, random)
    room.anywhere("plant", fittings.plant(1.4))


def _meeting(room: Interior, random: Generator) -> None:
    if random.random() < 0.3:
        table = room.anywhere("round table", fittings.round_table(_size(random, 0.5, 0.7)))
        if table is not None:
            _chairs(room, random, table, 0.8, 1.1)
    else:
        _dining(room, random)
    room.against_wall("screen", fittings.picture(_size(random, 1.2, 1.8), 1.0), height=1.0, gap=0.0)
    room.against_wall("sideboard", furniture.cabinet(1.4, 0.4, 0.75))


def _bath(room: Interior, random: Generator) -> None:
    room.against_wall(
        "basin", furniture.basin(_size(random, 0.5, 0.75), _size(random, 0.38, 0.52), _size(random, 0.8, 0.9))
    )
    room.against_wall("toilet", furniture.toilet())
    if random.random() < 0.5:
        room.against_wall("bathtub", furniture.bathtub(_size(random, 0.7, 0.8), _size(random, 1.5, 1.8)))
    else:
        room.against_wall("shower", fittings.shower(_size(random, 0.8, 0.95)))
    room.against_wall("cabinet", furniture.cabinet(0.6, 0.5, 0.85))


def _toilet(room: Interior, random: Generator) -> None:
    room.against_wall("toilet", furniture.toilet(_size(random, 0.34, 0.4)))
    room.against_wall("basin", furniture.basin(_size(random, 0.4, 0.5), 0.34, 0.84))


def _store(room: Interior, random: Generator) -> None:
    for _ in range(3):
        room.against_wall("shelf", furniture.shelf(_size(random, 0.8, 1.4), 0.4, _size(random, 1.5, 2.1)))
    _clutter(room, random, 4)


def _closet(room: Interior, random: Generator) -> None:
    room.against_wall("shelf", furniture.shelf(_size(random, 0.4, 0.6), 0.25, 1.6))
    _clutter(room, random, 1)


def _hall(room: Interior, random: Generator) -> None:
    room.against_wall("cabinet", furniture.cabinet(_size(random, 0.7, 1.1), 0.34, _size(random, 0.75, 1.1)))
    room.against_wall("bench", fittings.bench_seat(_size(random, 0.8, 1.4)))
    room.against_wall("plant", fittings.plant(_size(random, 0.8, 1.4), 0.22))
    room.against_wall("picture", fittings.picture(), height=1.5, gap=0.0)


def _clutter(room: Interior, random: Generator, count: int) -> None:
    for _ in range(count):
        if random.random() < 0.65:
            size = (_size(random, 0.25, 0.6), _size(random, 0.2, 0.45), _size(random, 0.15, 0.5))
            below = room.anywhere("carton", fittings.carton(*size))
            if below is not None and random.random() < 0.4:
                room.on_top("carton", fittings.carton(0.9 * size[0], 0.9 * size[1], 0.25), below)
        else:
            room.anywhere("bag", fittings.bin_bag(_size(random, 0.15, 0.3), _size(random, 0.3, 0.6)))


KINDS: Final[dict[str, Callable[[Interior, Generator], None]]] = {
    "Living room": _living,
    "Dining room": _dining,
    "Kitchen": _kitchen,
    "Bedroom": _bedroom,
    "Study": _office,
    "Office": _office,
    "Open office": _open_office,
    "Meeting room": _meeting,
    "Bath": _bath,
    "Toilet": _toilet,
    "Store": _store,
    "Closet": _closet,
    "Hall": _hall,
    "Corridor": _hall,
}
"""Kinds of rooms and what furnishes them."""


def furnish(room: Interior, kind: str, random: Generator, *, clutter: int = 0, mirror: bool = False) -> None:
    """Put into a room what its kind has in it."""
    if mirror:
        room.mirror(_size(random, 0.6, 1.4), _size(random, 0.8, 1.7), _size(random, 0.15, 0.5))
    if kind in KINDS:
        KINDS[kind](room, random)
    if kind not in ("Closet", "Stairwell", "Store"):
        room.against_wall(
            "radiator", fittings.radiator(_size(random, 0.6, 1.4), _size(random, 0.4, 0.7)), height=0.12, gap=0.03
        )
        if random.random() < 0.5:
            room.from_ceiling(
                "ceiling lamp", fittings.ceiling_lamp(_size(random, 0.25, 0.6), _size(random, 0.12, 0.25))
            )
    _clutter(room, random, clutter)
