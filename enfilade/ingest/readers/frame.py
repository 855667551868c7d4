"""The unit and the vertical axis of scans: found from how scanners stand in rooms, or set by the user."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import chain
from typing import Final

import numpy as np

from enfilade.ingest.records import F64, Chunk, Scan

UNITS: Final = {"m": 1.0, "mm": 0.001, "cm": 0.01, "ft": 0.3048, "in": 0.0254}
"""Metres of each unit."""
UPS: Final = {"z": 2, "y": 1}
AUTO: Final = "auto"

_NAMES: Final = {"m": "metres", "mm": "millimetres", "cm": "centimetres", "ft": "feet", "in": "inches"}
_LOOK_POINTS: Final = 2_000_000
_SAMPLE: Final = 20_000
_FEWEST: Final = 50
_STEEP: Final = 0.5
_NADIR: Final = 0.94
_SCANNER_M, _SCANNER_SPREAD = 1.6, 0.35
_ROOM_M, _LOWER_SPREAD, _HIGHER_SPREAD = 2.8, 0.3, 0.8
_WORST: Final = -8.0
_BLIND_CONE: Final = 6.0
_DEFAULT_LEAD: Final = 4.0


@dataclass(frozen=True, slots=True)
class Frame:
    """What brings the scans' coordinates to metres with z up."""

    unit: str = "m"
    up: str = "z"

    @property
    def is_plain(self) -> bool:
        """Whether the scans are so already."""
        return self == Frame()

    def apply(self, positions: F64) -> F64:
        """Return positions, ``(..., 3)``, in metres with z up; y up is turned about x."""
        scaled = positions * UNITS[self.unit]
        return scaled if self.up == "z" else np.stack([scaled[..., 0], -scaled[..., 2], scaled[..., 1]], axis=-1)


@dataclass(frozen=True, slots=True)
class _Look:
    """How a scanner stands, by one axis: its height over what is below, that to what is above, in file units.

    `is_blind` says that it sees nothing straight below, as a scanner on a tripod does not.
    """

    drop: float
    rise: float
    is_blind: bool


def in_metres(scans: Iterable[Scan], units: str, up: str, say: Callable[[str], None]) -> Iterator[Scan]:
    """Yield the scans in metres with z up.

    Parameters
    ----------
    scans
        In the coordinates of the files.
    units, up
        A key of `UNITS` and of `UPS`, or ``auto``: scanners stand some 1.6 m over floors, in rooms of some 2.8 m, and
        on tripods see nothing straight below. Metres and z up lead, so that only what clearly contradicts them is
        taken for something else.
    say
        Hears what was found, where it is not metres with z up.
    """
    source = iter(scans)
    if AUTO not in (units, up):
        frame, first = Frame(units, up), []
    else:
        first = _first(source)
        frame = _found(first, units, up)
        _tell(frame, units, up, say)
    everything = chain(first, source)
    return everything if frame.is_plain else (_moved(scan, frame) for scan in everything)


def _first(source: Iterator[Scan]) -> list[Scan]:
    """Take the first scans into memory, as many as there is need to look at; the last may go on in its file."""
    taken: list[Scan] = []
    left = _LOOK_POINTS
    for scan in source:
        chunks: list[Chunk] = []
        rest = iter(scan.chunks)
        for chunk in rest:
            chunks.append(chunk)
            left -= len(chunk.positions)
            if left <= 0:
                break
        is_whole = left > 0
        taken.append(
            Scan(scan.name, scan.source, chunks if is_whole else _Resumed(chunks, rest), scan.scanner_position)
        )
        if not is_whole:
            break
    return taken


@dataclass(slots=True)
class _Resumed:
    """Chunks in memory, and then those still in the file."""

    known: list[Chunk]
    rest: Iterator[Chunk]

    def __iter__(self) -> Iterator[Chunk]:
        return chain(self.known, self.rest)


def _known(scan: Scan) -> list[Chunk]:
    return scan.chunks.known if isinstance(scan.chunks, _Resumed) else list(scan.chunks)


def _found(scans: list[Scan], units: str, up: str) -> Frame:
    """Return the frame in which the scanners stand most like scanners."""
    samples = [_sample(scan) for scan in scans]
    looks = {axis: [_look(sample, UPS[axis]) for sample in samples] for axis in UPS}
    likelihood = {
        Frame(unit, axis): _likelihood(looks, unit, axis)
        for unit in (UNITS if units == AUTO else (units,))
        for axis in (UPS if up == AUTO else (up,))
    }
    default = Frame("m" if units == AUTO else units, "z" if up == AUTO else up)
    likelihood[default] += _DEFAULT_LEAD
    return max(likelihood, key=lambda frame: (likelihood[frame], frame == default))


def _sample(scan: Scan) -> F64:
    """``(n, 3)`` some of the points as seen from the scanner, the same whatever the chunks."""
    known = _known(scan)
    if not known:
        return np.empty((0, 3))
    positions = np.concatenate([chunk.positions for chunk in known])
    step = -(-len(positions) // _SAMPLE) or 1
    return positions[::step] - scan.scanner_position


def _look(sample: F64, axis: int) -> _Look | None:
    """Look down and up along an axis; None where too little is seen below."""
    distance = np.linalg.norm(sample, axis=1)
    seen = distance > 0.0
    height = sample[seen, axis]
    steepness = height / distance[seen]
    below, above = -height[steepness < -_STEEP], height[steepness > _STEEP]
    if len(below) < _FEWEST:
        return None
    rise = float(np.quantile(above, 0.8)) if len(above) >= _FEWEST else 0.0
    is_blind = bool(np.count_nonzero(steepness < -_NADIR) < 0.0005 * len(height))
    return _Look(float(np.quantile(below, 0.8)), rise, is_blind)


def _likelihood(looks: dict[str, list[_Look | None]], unit: str, axis: str) -> float:
    """Log likelihood of the scanners' heights and of their blind cones."""
    (other,) = (name for name in looks if name != axis)
    total, seen, blind = 0.0, 0, 0
    for look, across in zip(looks[axis], looks[other], strict=True):
        if look is None:
            continue
        metres = UNITS[unit]
        total += max(-0.5 * (np.log(look.drop * metres / _SCANNER_M) / _SCANNER_SPREAD) ** 2, _WORST)
        if look.rise > 0.0:
            over = np.log((look.drop + look.rise) * metres / _ROOM_M)
            total += max(-0.5 * (over / (_HIGHER_SPREAD if over > 0.0 else _LOWER_SPREAD)) ** 2, _WORST)
        seen += 1
        blind += across is not None and look.is_blind and not across.is_blind
    return float(total) + _BLIND_CONE * blind / max(seen, 1)


def _tell(frame: Frame, units: str, up: str, say: Callable[[str], None]) -> None:
    if units == AUTO and frame.unit != "m":
        say(
            f"by the heights of scanners and rooms the scans are in {_NAMES[frame.unit]}, and were brought to metres; "
            "--units m takes them as they are"
        )
    if up == AUTO and frame.up != "z":
        say(
            f"by the heights of scanners and rooms {frame.up} is up in the scans, and they were turned so that z is; "
            "--up z takes them as they are"
        )


def _moved(scan: Scan, frame: Frame) -> Scan:
    chunks = (Chunk(frame.apply(chunk.positions), chunk.intensity, chunk.colour) for chunk in scan.chunks)
    return Scan(scan.name, scan.source, chunks, frame.apply(scan.scanner_position))
