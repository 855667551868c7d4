"""Why an opening was missed or invented, as far as the comparison can tell."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from .correspondence import Cells
from .faults import Fault
from .holes import DOORS, NEAR_M, REACH_M, STAIRS, Hole, Places
from .matching import Matching
from .openings import Verdict, Verdicts

_HARDLY_SEEN_M2: Final = 1.0
"""Around a door both sides of its wall have several square metres."""
_BESIDE_M: Final = 0.5
_SPOT_M: Final = 0.1
"""Surface is measured in cubes of this side, so that a thin cloud is no less of it."""

Reason = tuple[str, str, tuple[Hole, ...]]


@dataclass(frozen=True)
class _Scene:
    """What a cause is looked for in."""

    found: Places
    true: Places
    matching: Matching
    verdicts: Verdicts
    cells: Cells


def opening_faults(
    verdicts: Verdicts, found: Sequence[Hole], true: Sequence[Hole], matching: Matching, cells: Cells
) -> Iterator[Fault]:
    """Yield openings that were missed, invented, or said to be in another state, each with its likeliest cause."""
    scene = _Scene(Places(found), Places(true), matching, verdicts, cells)
    for verdict in (verdicts.doors, verdicts.outside, verdicts.windows, verdicts.stairs):
        for here, there in verdict.pairs if verdict is verdicts.doors else ():
            if here.closed and there.state == "open":
                yield _fault(
                    verdict,
                    "missed",
                    "truth",
                    there,
                    ("said_closed", f"{here.name} is there, but said closed", (here,)),
                )
        for hole in verdict.missed:
            yield _fault(verdict, "missed", "truth", hole, _why_missed(scene, verdict, hole))
        for hole in verdict.invented:
            yield _fault(verdict, "invented", "prediction", hole, _why_invented(scene, verdict, hole))


def _fault(verdict: Verdict, fault: str, side: str, hole: Hole, reason: Reason) -> Fault:
    cause, why, others = reason
    kind = f"closed {verdict.kind}" if verdict.kind == "door" and hole.closed else verdict.kind
    return Fault("opening", fault, side, hole.id, hole.name, cause, why, kind, tuple(other.id for other in others))


def _why_missed(scene: _Scene, verdict: Verdict, hole: Hole) -> Reason:
    near = scene.found.about(hole, NEAR_M if verdict.kind != "stairs" else 2 * NEAR_M)
    lost = _rooms_lost(scene.matching, hole)
    if lost:
        there = [other for other in near if other.distance(hole) <= REACH_M and other.kind in _alike(hole)]
        return "rooms_not_found", lost + (f"; {there[0].name} is at its place" if there else ""), tuple(there[:1])
    free = [other for other in near if other.id not in scene.verdicts.right]
    at_place = [other for other in free if other.distance(hole) <= REACH_M]
    for other in at_place:
        if other.kind in _alike(hole):
            return "wrong_rooms", _wrong_rooms(scene.matching, other, "said to lead"), (other,)
    if at_place:
        other = at_place[0]
        return "wrong_kind", f"{other.name} is at its place, said to be a {other.kind or 'thing of no kind'}", (other,)
    off = [other for other in free if other.joins == hole.joins and other.kind in _alike(hole)]
    if off:
        return "off", f"{off[0].name} is {_off(off[0], hole)}", (off[0],)
    seen = _seen_m2(scene.cells, hole)
    if seen < _HARDLY_SEEN_M2:
        said = f"only {seen:.1f} m² of surface was seen within {_around_m(hole):.1f} m"
        return "hardly_seen", f"nothing at its place; {said}", ()
    if near:
        return "none_there", f"nothing at its place; the nearest is {near[0].name}, {_off(near[0], hole)}", (near[0],)
    return "none_near", "no opening within 1 m of it", ()


def _why_invented(scene: _Scene, verdict: Verdict, hole: Hole) -> Reason:
    near = scene.true.about(hole, NEAR_M)
    at_place = [other for other in near if other.distance(hole) <= REACH_M]
    for other in at_place:
        if other.kind in _alike(hole) and other.joins == hole.joins:
            return "twice", f"{other.name} was found already", (other,)
    strangers = [room for room in hole.rooms if room is None]
    alike = [other for other in at_place if other.kind in _alike(hole)]
    if strangers:
        place = f"; {alike[0].name} is at its place" if alike else ""
        return "rooms_not_found", f"a room at its end is no true room{place}", tuple(alike[:1])
    if alike:
        return "wrong_rooms", _wrong_rooms(scene.matching, alike[0], "and leads"), (alike[0],)
    if at_place:
        return "wrong_kind", f"{at_place[0].name} is there, a {at_place[0].kind}", (at_place[0],)
    off = [other for other in near if other.joins == hole.joins and other.kind in _alike(hole)]
    if off:
        return "off", f"{off[0].name} is {_off(off[0], hole)}", (off[0],)
    if not hole.rooms:
        return "no_rooms", "it leads to no room", ()
    if near:
        return "none_there", f"nothing at its place; the nearest is {near[0].name}, {_off(near[0], hole)}", (near[0],)
    return "none_near", "no opening within 1 m of it", ()


def _alike(hole: Hole) -> tuple[str, ...]:
    """Kinds that may be the same opening."""
    return DOORS if hole.kind in DOORS else STAIRS if hole.kind in STAIRS else (hole.kind,)


def _wrong_rooms(matching: Matching, other: Hole, verb: str) -> str:
    """Say that another opening is at the place, and where it leads, in terms of true rooms."""
    ends = ["no true room" if room is None else matching.truth.name(room) for room in other.rooms]
    if len(ends) == 2:
        return f"{other.name} is there, {verb} from {ends[0]} to {ends[1]}"
    return f"{other.name} is there, {verb} from {ends[0] if ends else 'no room'} outside"


def _rooms_lost(matching: Matching, hole: Hole) -> str:
    """Say which rooms at an opening's ends have no match, and what became of them."""
    said = []
    for room in hole.rooms:
        if room is None or room in matching.predicted_of:
            continue
        name = matching.truth.name(room)
        if room in matching.merged_into:
            said.append(f"{name} was merged into {matching.prediction.name(matching.merged_into[room])}")
        else:
            said.append(f"{name} was {'split' if room in matching.split else 'not found'}")
    return ", ".join(said)


def _off(other: Hole, hole: Hole) -> str:
    """Say how far two openings are apart, and whether it is their heights."""
    assert other.position is not None
    assert hole.position is not None
    apart = np.abs(other.position - hole.position)
    distance = float(np.linalg.norm(apart))
    height = f", {apart[2]:.2f} m of it in height" if apart[2] > distance / 2 else ""
    return f"{distance:.2f} m off{height}"


def _around_m(hole: Hole) -> float:
    """Return how far from its centre the surface about an opening reaches: half a metre beyond its corners."""
    return float(np.hypot(hole.properties.get("width", 1.0), hole.properties.get("height", 2.0))) / 2 + _BESIDE_M


def _seen_m2(cells: Cells, hole: Hole) -> float:
    """Area of true surface about an opening, m²."""
    if hole.position is None:
        return float("inf")
    reach = _around_m(hole)
    near = cells.positions[np.abs(cells.positions[:, 0] - hole.position[0]) <= reach]
    near = near[np.linalg.norm(near - hole.position, axis=1) <= reach]
    return float(len(np.unique(np.floor(near / _SPOT_M), axis=0))) * _SPOT_M**2
