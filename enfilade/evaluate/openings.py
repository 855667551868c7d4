"""Which predicted door, passage, window or stairs is which true one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from .holes import DOORS, REACH_M, STAIRS, Hole, Places, pair_holes


@dataclass(frozen=True)
class Verdict:
    """Openings of one kind: which true one is which predicted one, and what is left over on either side.

    Attributes
    ----------
    kind
        ``door``, ``outside door``, ``window``, ``stairs``, ``door to an unscanned room``.
    pairs
        (predicted, true), in order of the truth.
    missed
        True ones without a partner that counts.
    invented
        Predicted ones that are not there.
    """

    kind: str
    pairs: tuple[tuple[Hole, Hole], ...] = ()
    missed: tuple[Hole, ...] = ()
    invented: tuple[Hole, ...] = ()

    @property
    def true(self) -> list[Hole]:
        """All true ones."""
        return [*(true for _, true in self.pairs), *self.missed]


@dataclass(frozen=True)
class Verdicts:
    """All openings, judged.

    Attributes
    ----------
    doors
        Between two scanned rooms, in any state. `missed` has an open one that the prediction says is closed, too.
    outside, windows, stairs, apart
        The others; see `OpeningFigures`.
    excused
        Predicted openings that nothing can be said of: they lie at a true opening that is not asked for.
    """

    doors: Verdict
    outside: Verdict
    windows: Verdict
    stairs: Verdict
    apart: Verdict
    excused: tuple[Hole, ...] = field(default=())

    @property
    def all(self) -> tuple[Verdict, ...]:
        """All kinds."""
        return (self.doors, self.outside, self.windows, self.stairs, self.apart)

    @property
    def right(self) -> frozenset[str]:
        """Keys of predicted openings that are there."""
        return frozenset(found.id for verdict in self.all for found, _ in verdict.pairs)


def judge_openings(found: Sequence[Hole], true: Sequence[Hole]) -> Verdicts:
    """Decide which predicted opening is which true one."""
    inner = [hole for hole in true if hole.kind in DOORS and len(hole.rooms) == 2 and not hole.apart]
    outer = [hole for hole in true if hole.kind in DOORS and len(hole.rooms) == 1 and not hole.apart]
    beyond = [hole for hole in true if hole.kind in DOORS and hole.apart]
    said = [hole for hole in found if hole.kind in DOORS and not hole.apart]
    pairs = pair_holes([hole for hole in said if len(hole.rooms) == 2], inner, agree=_same_state)
    loose = _without([hole for hole in said if len(hole.rooms) == 2], pairs.values())
    elsewhere = Places([*outer, *beyond])
    excused = [hole for hole in loose if None in hole.rooms and elsewhere.about(hole, REACH_M)]
    doors = _verdict("door", pairs, inner, _without(loose, excused))
    outside, at_apart = _judge_outside(said, excused, outer, Places(beyond))
    windows = _judge("window", found, true, ("window",), REACH_M)
    stairs = _judge("stairs", found, true, STAIRS, float("inf"))
    apart = _judge_apart(found, beyond)
    used = {hole.id for hole, _ in outside.pairs}
    return Verdicts(
        doors,
        outside,
        windows,
        stairs,
        apart,
        tuple(hole for hole in [*excused, *at_apart] if hole.id not in used),
    )


def _same_state(found: Hole, true: Hole) -> bool:
    return true.state is None or found.closed == true.closed


def _judge(kind: str, found: Sequence[Hole], true: Sequence[Hole], kinds: Sequence[str], reach_m: float) -> Verdict:
    """Pair all openings of some kinds that no unscanned room is at; those at an unscanned one are left out."""
    asked = [
        hole for hole in true if hole.kind in kinds and not hole.apart and (kind != "stairs" or len(hole.rooms) == 2)
    ]
    said = [hole for hole in found if hole.kind in kinds and not hole.apart]
    pairs = pair_holes(said, asked, reach_m=reach_m)
    excuses = Places(hole for hole in true if hole.kind in kinds and hole.apart)
    loose = _without(said, pairs.values())
    return _verdict(kind, pairs, asked, [hole for hole in loose if not excuses.about(hole, REACH_M)])


def _judge_outside(
    said: Sequence[Hole], excused: Sequence[Hole], outer: Sequence[Hole], beyond: Places
) -> tuple[Verdict, list[Hole]]:
    """Pair doors to the outside; a predicted room out there counts as the outside. Also those at unscanned rooms."""
    single = [hole for hole in said if len(hole.rooms) < 2]
    outdoors = [
        Hole(hole.id, hole.name, hole.properties, tuple(room for room in hole.rooms if room is not None))
        for hole in excused
    ]
    pairs = pair_holes([*single, *outdoors], outer)
    loose = _without(single, pairs.values())
    at_apart = [hole for hole in loose if beyond.about(hole, REACH_M)]
    return _verdict("outside door", pairs, outer, _without(loose, at_apart)), at_apart


def _judge_apart(found: Sequence[Hole], beyond: Sequence[Hole]) -> Verdict:
    """Doors to rooms without a scan: at the right place, from a scanned room."""
    asked = [hole for hole in beyond if len(hole.rooms) == 2]
    said = [hole for hole in found if hole.kind in DOORS and hole.apart]
    places, taken, pairs = Places(asked), set[str](), dict[str, Hole]()
    for hole in said:
        near = [
            true for true in places.about(hole, REACH_M) if true.id not in taken and set(true.rooms) & set(hole.rooms)
        ]
        if near:
            taken.add(near[0].id)
            pairs[near[0].id] = hole
    return _verdict("door to an unscanned room", pairs, asked, _without(said, pairs.values()))


def _verdict(kind: str, pairs: dict[str, Hole], true: Sequence[Hole], invented: Iterable[Hole]) -> Verdict:
    return Verdict(
        kind,
        tuple((pairs[hole.id], hole) for hole in true if hole.id in pairs),
        tuple(hole for hole in true if hole.id not in pairs),
        tuple(invented),
    )


def _without(holes: Sequence[Hole], gone: Iterable[Hole]) -> list[Hole]:
    ids = {hole.id for hole in gone}
    return [hole for hole in holes if hole.id not in ids]
