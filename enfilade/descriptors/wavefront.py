"""Vertices and faces of Wavefront OBJ files, polygons of any size included (Open3D leaves out all but triangles)."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from enfilade.errors import InputError

from .polygons import fan


def read_obj(path: Path) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Read positions and triangles; faces of more corners become fans.

    Returns
    -------
    tuple
        ``(n, 3) float64`` vertices and ``(m, 3) int32`` triangles, either of which may be empty.

    Raises
    ------
    InputError
        If a line cannot be understood or a face names a vertex that is not there.
    """
    vertices: list[list[float]] = []
    triangles: list[tuple[int, int, int]] = []
    for number, words in _statements(path):
        try:
            if words[0] == "v":
                vertices.append([float(word) for word in words[1:4]])
                if len(words) < 4:
                    raise ValueError("a vertex has three coordinates")
            elif words[0] == "f":
                triangles += fan([_index(word, len(vertices)) for word in words[1:]])
        except (ValueError, IndexError) as error:
            raise InputError(f"{path} cannot be read: line {number} is damaged ({' '.join(words)[:60]}).") from error
    return np.array(vertices).reshape(-1, 3), np.array(triangles, np.int32).reshape(-1, 3)


def _statements(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Line number and words of each line that says something; a backslash joins lines."""
    text = path.read_text(encoding="utf-8", errors="replace").replace("\\\n", "  ")
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.split("#", 1)[0].split()
        if words:
            yield number, words


def _index(word: str, count: int) -> int:
    """Vertex index, from 0, of a corner such as ``7``, ``7/1/3`` or ``-1``, the last vertex so far."""
    given = int(word.split("/", 1)[0])
    index = given - 1 if given > 0 else count + given
    if given == 0 or not 0 <= index < count:
        raise IndexError(f"there is no vertex {given}")
    return index
