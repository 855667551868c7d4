"""Scans that fit together pass; others are said, with the pair and by how much; unregistered ones are refused."""

from __future__ import annotations

import numpy as np
import pytest
from scanned_boxes import Box, scan

from enfilade.errors import InputError
from enfilade.ingest.records import Scan
from enfilade.ingest.registration import check_registration
from enfilade.ingest.surfels import make_surfels
from enfilade.ingest.thinning import thin

HALL = [
    Box((0.0, 0.0, 0.0), (9.0, 6.0, 2.8), place, name)
    for name, place in (("west", (2.0, 2.0, 1.5)), ("middle", (4.5, 4.0, 1.6)), ("eastern", (7.0, 2.5, 1.5)))
]


class Notes:
    def __init__(self) -> None:
        self.said: list[str] = []

    def start(self, stage: str, total: float | None = None) -> None:
        pass

    def advance(self, amount: float = 1.0) -> None:
        pass

    def note(self, sentence: str) -> None:
        self.said.append(sentence)


def seen(box: Box, shift: tuple[float, float, float] = (0.0, 0.0, 0.0), turn_deg: float = 0.0) -> Scan:
    """The whole hall from a place in it, then moved and turned about the scanner, as a wrong registration does."""
    right = scan(box, [box], None, spacing=0.05)
    (chunk,) = right.chunks
    c, s = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    points = (chunk.positions - right.scanner_position) @ turn.T + right.scanner_position + shift
    return Scan.of_points(box.name, "hall.e57", points, right.scanner_position + shift)


def said_of(*scans: Scan) -> list[str]:
    notes = Notes()
    cloud = thin(scans)
    check_registration(cloud, make_surfels(cloud), progress=notes)
    return notes.said


def test_scans_that_fit_are_not_talked_about() -> None:
    assert said_of(*(seen(box) for box in HALL)) == []
    assert said_of(seen(HALL[0])) == []


def test_usual_errors_of_registration_pass() -> None:
    west, middle, east = HALL
    moved = (
        seen(west, (0.015, 0.0, 0.0), 0.1),
        seen(middle, (0.0, -0.015, 0.0)),
        seen(east, (-0.009, 0.0, 0.012), -0.1),
    )
    assert said_of(*moved) == []


@pytest.mark.parametrize("shift", [(0.1, 0.0, 0.0), (0.0, 0.0, 0.12), (0.06, 0.08, 0.0)])
def test_scans_off_by_a_decimetre_are_said_with_the_pair_and_by_how_much(shift: tuple[float, float, float]) -> None:
    west, middle, east = HALL
    (sentence,) = said_of(seen(west), seen(middle, shift), seen(east))
    assert "'middle'" in sentence
    millimetres = int(sentence.split(" mm ")[0].split()[-1])
    assert millimetres == pytest.approx(1000 * np.linalg.norm(shift), abs=15)


def test_one_scan_far_off_is_said() -> None:
    parts = [
        Box((0.0, 0.0, 0.0), (9.0, 6.0, 2.8), (1.5 + 1.5 * x, 1.5 + 3.0 * y, 1.5), "s" * (2 * x + y + 1))
        for x in range(5)
        for y in (0, 1)
    ]
    scans = [seen(box) for box in parts]
    scans[4] = seen(parts[4], (0.0, 0.0, 0.0), 40.0)
    (sentence,) = said_of(*scans)
    assert f"'{parts[4].name}'" in sentence
    assert "do not fit together" in sentence


def test_scans_that_were_never_registered_are_refused() -> None:
    scans = []
    for number, box in enumerate(HALL):
        right = seen(box, (0.0, 0.0, 0.0), 35.0 * number)
        (chunk,) = right.chunks
        place = np.array([1e-3 * number, 0.0, 0.0])
        scans.append(Scan.of_points(box.name, "hall.e57", chunk.positions - right.scanner_position + place, place))
    with pytest.raises(
        InputError, match=r"the scans are not registered: scans '\w+' and '\w+' do not fit together: \d+ %"
    ):
        said_of(*scans)
