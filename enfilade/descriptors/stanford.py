"""Meshes and clouds in PLY files."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from plyfile import PlyData, PlyElementParseError, PlyHeaderParseError, PlyParseError

from enfilade.errors import InputError

from .polygons import fan

_CORNERS: Final = ("vertex_indices", "vertex_index")


def read_ply(path: Path) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Read positions and triangles; faces of more corners become fans.

    Returns
    -------
    tuple
        ``(n, 3) float64`` vertices and ``(m, 3) int32`` triangles, none for a cloud.

    Raises
    ------
    InputError
        If the file is damaged or has no positions.
    """
    try:
        elements = {element.name: element for element in PlyData.read(str(path)).elements}
        vertices = np.column_stack([elements["vertex"][axis] for axis in "xyz"]).astype(np.float64)
        triangles = _triangles(elements["face"]) if "face" in elements else []
        return vertices.reshape(-1, 3), np.array(triangles, np.int32).reshape(-1, 3)
    except (PlyParseError, PlyElementParseError, PlyHeaderParseError, UnicodeDecodeError) as error:
        raise InputError(f"{path} cannot be read as PLY: {error}.") from error
    except (KeyError, ValueError, TypeError, OverflowError, MemoryError) as error:
        raise InputError(f"{path} cannot be read as PLY: it is damaged or its vertices have no x, y, z.") from error


def _triangles(faces: Any) -> list[tuple[int, int, int]]:
    """Triangles of the faces, whichever of the two usual names their corners have."""
    name = next(prop.name for prop in faces.properties if prop.name in _CORNERS)
    return [triangle for corners in faces[name] for triangle in fan([int(corner) for corner in corners])]
