"""Positions in PCD files, ASCII and binary (Open3D's reader may crash on damaged ones)."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from enfilade.errors import InputError

_TYPES: Final = {"F": "f", "I": "i", "U": "u"}
_LONGEST_HEADER: Final = 20_000


def read_pcd(path: Path) -> NDArray[np.float64]:
    """Read positions.

    Returns
    -------
    numpy.ndarray
        ``(n, 3) float64``; points with a coordinate that is not a number, which PCD uses for "nothing seen", left out.

    Raises
    ------
    InputError
        If the file is damaged, compressed or has no positions.
    """
    content = path.read_bytes()
    try:
        header, start = _header(content)
        points = _points(header, content[start:])
    except (KeyError, ValueError, TypeError, IndexError, OverflowError, MemoryError) as error:
        raise InputError(f"{path} cannot be read: it is damaged, or no PCD file with x, y and z.") from error
    if points is None:
        raise InputError(f"{path} is a compressed PCD file; save it as binary or ascii.")
    return points[np.isfinite(points).all(axis=1)]


def _header(content: bytes) -> tuple[dict[str, list[str]], int]:
    """Words of each header line by its first word, and where the points begin."""
    start = content.index(b"\nDATA ", 0, _LONGEST_HEADER)
    end = content.index(b"\n", start + 1) + 1
    lines = [line.split() for line in content[:end].decode("ascii", errors="replace").splitlines()]
    return {words[0]: words[1:] for words in lines if words}, end


def _points(header: dict[str, list[str]], body: bytes) -> NDArray[np.float64] | None:
    """Return the positions, or None where they are compressed."""
    names, form = header["FIELDS"], header["DATA"][0]
    counts = [int(count) for count in header.get("COUNT", ["1"] * len(names))]
    total = int(header["POINTS"][0])
    if form == "ascii":
        columns = np.cumsum([0, *counts])
        table = np.loadtxt(body.decode("ascii").splitlines(), ndmin=2, max_rows=total)
        return np.column_stack([table[:, columns[names.index(axis)]] for axis in "xyz"])
    if form != "binary":
        return None
    types = [f"<{_TYPES[kind]}{int(size)}" for kind, size in zip(header["TYPE"], header["SIZE"], strict=True)]
    # Padding fields share a name, so each is called by its place.
    fields = [(f"f{place}", type, (count,)) for place, (type, count) in enumerate(zip(types, counts, strict=True))]
    records = np.frombuffer(body, dtype=np.dtype(fields), count=total)
    return np.column_stack([records[f"f{names.index(axis)}"][:, 0] for axis in "xyz"]).astype(np.float64)
