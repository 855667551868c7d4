"""Figures and faults as rows for people."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final

from .faults import Fault
from .opening_figures import KindFigures
from .rooms import ApartFigures
from .summary import AllFigures

_MOST_FAULTS: Final = 12

Row = tuple[str, Any]


def figure_rows(found: AllFigures) -> list[Row]:
    """Return rows of (what, value)."""
    return [
        *_room_rows(found),
        *_measure_rows(found),
        *_door_rows(found),
        *_connection_rows(found),
        *_object_rows(found),
        *_calibration_rows(found),
    ]


def fault_rows(faults: Iterable[Fault]) -> list[tuple[str, str, str]]:
    """Return a row (what, which, why) a fault, sort by sort; of more than a dozen of a sort the number of the rest."""
    sorts: dict[str, list[Fault]] = {}
    for fault in faults:
        sorts.setdefault(fault.what, []).append(fault)
    rows: list[tuple[str, str, str]] = []
    for what, some in sorts.items():
        rows += [(what, fault.name, fault.why) for fault in some[:_MOST_FAULTS]]
        if len(some) > _MOST_FAULTS:
            rows.append((what, f"and {len(some) - _MOST_FAULTS} more", ""))
    return rows


def _room_rows(found: AllFigures) -> list[Row]:
    rooms, storeys = found.rooms, found.storeys
    return [
        ("rooms, predicted of true", f"{rooms.predicted} of {rooms.true}"),
        ("rooms, F1 at IoU .5", rooms.f1_at_50),
        ("rooms, F1 at IoU .7", rooms.f1_at_70),
        ("rooms, mean IoU", rooms.mean_iou),
        ("rooms, adjusted Rand index", rooms.ari),
        ("rooms split", rooms.split_count),
        ("rooms merged", rooms.merged_count),
        ("rooms with stairs, found", f"{rooms.stair_rooms_found} of {rooms.stair_rooms}"),
        ("rooms seen from outside, found and marked", _apart(rooms.unscanned)),
        ("stair wells, found", _apart(rooms.stair_wells, marked=False)),
        ("roof spaces, found", _apart(rooms.roof_spaces, marked=False)),
        ("rooms, F1 at IoU .5 with all of these", rooms.f1_of_all),
        ("storeys, predicted of true", f"{storeys.predicted} of {storeys.true}"),
        ("storeys, rooms on the right one", storeys.rooms_right),
    ]


def _measure_rows(found: AllFigures) -> list[Row]:
    measures = found.measures
    return [
        ("area, median and 90 % relative error", (measures.area_error, measures.area_error_at_90)),
        ("floor elevation, median and 90 % error (m)", (measures.floor_error_m, measures.floor_error_at_90_m)),
        ("height, median error (m)", measures.height_error_m),
    ]


def _door_rows(found: AllFigures) -> list[Row]:
    openings = found.openings
    return [
        ("openings, predicted of true", f"{openings.predicted} of {openings.true}"),
        ("openings, precision", openings.precision),
        ("openings, recall", openings.recall),
        ("openings, kind right", openings.kinds_right),
        ("openings, median error of width, height, sill, position (m)", _errors(openings.open)),
        ("ajar doors, found; said ajar", f"{_found(openings.ajar)}; {openings.ajar_marked}"),
        ("closed doors, found; said closed", f"{_found(openings.closed)}; {openings.closed_marked}"),
        ("closed doors, median confidence of those found", openings.closed_confidence),
        ("closed doors, invented", openings.closed.invented),
        *([("doors of unsaid state, found", _found(openings.unstated))] if openings.unstated.true else []),
        *_kind_rows("doors to the outside", openings.outside),
        *_kind_rows("windows", openings.windows),
        *_kind_rows("stairs and hatches", openings.stairs),
        ("doors to rooms seen from outside, found; invented", _found_invented(openings.apart)),
    ]


def _kind_rows(what: str, figures: KindFigures) -> list[Row]:
    rows: list[Row] = [(f"{what}, found; invented", _found_invented(figures))]
    if figures.found:
        rows.append((f"{what}, median error of width, height, sill, position (m)", _errors(figures)))
    return rows


def _connection_rows(found: AllFigures) -> list[Row]:
    ways, neighbours = found.connectivity, found.neighbours
    return [
        ("connectivity, F1 of room pairs", ways.f1),
        ("connectivity, reachable pairs, true and predicted", (ways.true_reachable, ways.predicted_reachable)),
        ("connectivity, pairs of which reachable is right", ways.reachable_right),
        ("neighbours, F1 of room pairs", neighbours.f1),
        ("neighbours, precision and recall", (neighbours.precision, neighbours.recall)),
        ("neighbours, median error of the gap (m)", neighbours.gap_error_m),
    ]


def _object_rows(found: AllFigures) -> list[Row]:
    objects = found.objects
    return [
        ("objects, found", objects.found),
        ("objects, mean IoU", objects.mean_iou),
        ("objects, segments for true ones", f"{objects.predicted} for {objects.true}"),
        ("objects, ghosts", objects.ghosts),
    ]


def _calibration_rows(found: AllFigures) -> list[Row]:
    rows: list[Row] = []
    for what, calibration in (("openings", found.calibration.openings), ("rooms", found.calibration.rooms)):
        errors = (calibration.expected_error, calibration.brier)
        rows.append((f"confidence of {what}, calibration error and Brier score", errors))
        said = (f"{b['from']:.1f}: {b['right']:.2f} of {b['count']}" for b in calibration.bins)
        rows.append((f"confidence of {what}, share right by what was said", "; ".join(said) or None))
    return rows


def _errors(figures: KindFigures) -> tuple[float | None, ...]:
    return (figures.width_error_m, figures.height_error_m, figures.sill_error_m, figures.position_error_m)


def _found(figures: KindFigures) -> str:
    return f"{figures.found} of {figures.true}"


def _found_invented(figures: KindFigures) -> str:
    return f"{_found(figures)}; {figures.invented}"


def _apart(figures: ApartFigures, *, marked: bool = True) -> str | None:
    if not figures.true:
        return None
    return f"{figures.found} of {figures.true}" + (f"; {figures.marked}" if marked else "")
