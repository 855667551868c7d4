"""Damaged scan files of every format: scans or one sentence, whatever the bytes are; quickly, in bounded memory."""

from __future__ import annotations

import random
import resource
from pathlib import Path

import numpy as np
import pytest
from scan_writers import Station, write_e57, write_las, write_pcd, write_ply, write_positions, write_ptx

from enfilade.errors import InputError
from enfilade.ingest.readers import ReadingParameters, read_scans

RNG = np.random.default_rng(0)
PLACE = np.array([1.0, 2.0, 3.0])
TWO = [
    Station(
        RNG.uniform(-2.0, 2.0, (60, 3)) + PLACE + number,
        PLACE + number,
        0.3,
        f"Scan {number}",
        RNG.integers(0, 200, 60).astype(float),
        RNG.integers(0, 256, (60, 3), dtype=np.uint8),
    )
    for number in range(2)
]
MAKERS = {
    "a.e57": lambda path: write_e57(path, *TWO),
    "a.ptx": lambda path: write_ptx(path, *TWO),
    "text.ply": lambda path: write_ply(path, TWO[0], "ascii"),
    "binary.ply": lambda path: write_ply(path, TWO[0]),
    "text.pcd": lambda path: write_pcd(path, TWO[0], "ascii"),
    "binary.pcd": lambda path: write_pcd(path, TWO[0]),
    "packed.pcd": lambda path: write_pcd(path, TWO[0], "binary_compressed"),
    "a.las": lambda path: write_las(path, TWO[0]),
    "a.laz": lambda path: write_las(path, TWO[0]),
}
HUGE = [
    b"\xff" * 8,
    bytes(8),
    (1 << 62).to_bytes(8, "little"),
    (1 << 31).to_bytes(8, "little"),
    b"\x00\x00\xc0\x7f" * 2,
]
TRIALS = {"a.laz": 6}
USUAL_TRIALS = 40
MOST_MEMORY_KB = 1_000_000  # over what the process has held before


def mutated(whole: bytes, chance: random.Random) -> bytes:
    """Bits turned, digits changed, numbers made huge, pieces lost, doubled or zeroed, the end cut off."""
    text = bytearray(whole)
    way = chance.choice(["bits", "head", "digits", "huge", "lost", "twice", "zero", "cut", "junk"])
    start = chance.randrange(len(text))
    stop = min(len(text), start + chance.randrange(1, 200))
    if way == "bits":
        for _ in range(chance.randrange(1, 20)):
            text[chance.randrange(len(text))] ^= 1 << chance.randrange(8)
    elif way == "head":
        text[chance.randrange(min(400, len(text)))] = chance.randrange(256)
    elif way == "digits":
        digits = [at for at in range(min(4000, len(text))) if 48 <= text[at] <= 57]
        for _ in range(chance.randrange(1, 6)):
            if digits:
                text[chance.choice(digits)] = chance.choice(b"0123456789-.ex")
    elif way == "huge":
        text[start : start + 8] = chance.choice(HUGE)
    elif way == "junk":
        text[start:stop] = chance.randbytes(stop - start)
    else:
        piece = text[start:stop]
        text[start:stop] = {"lost": b"", "twice": piece * 2, "zero": bytes(len(piece)), "cut": b""}[way]
        if way == "cut":
            del text[start:]
    return bytes(text)


@pytest.mark.parametrize("name", MAKERS)
def test_damaged_files_give_scans_or_one_sentence(name: str, tmp_path: Path) -> None:
    path = MAKERS[name](tmp_path / name)
    whole = path.read_bytes()
    positions = write_positions(tmp_path / "positions.csv", [(name, PLACE)]) if not name.endswith(".ptx") else None
    chance = random.Random(name)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    said = []
    for _ in range(TRIALS.get(name, USUAL_TRIALS)):
        path.write_bytes(mutated(whole, chance))
        try:
            for scan in read_scans([path], ReadingParameters("m", "z"), positions=positions):
                assert np.isfinite(scan.scanner_position).all()
                for chunk in scan.chunks:
                    assert np.isfinite(chunk.positions).all()
        except InputError as error:
            said.append(str(error))
    assert said
    assert [sentence for sentence in said if name not in sentence or "\n" in sentence] == []
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < MOST_MEMORY_KB
