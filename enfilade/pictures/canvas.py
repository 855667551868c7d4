"""The sheet that pictures are drawn on, and how it becomes a file."""

from __future__ import annotations

import warnings
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Final

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from enfilade.atomic import replacing
from enfilade.errors import InputError, StoreError

from .style import PAPER

SUFFIXES: Final = (".png", ".svg", ".pdf")
_DPI: Final = 160
_METADATA: Final = {".png": {"Software": None}, ".svg": {"Date": None}, ".pdf": {"CreationDate": None}}


def sheet(width_in: float, height_in: float) -> Figure:
    """Return an empty figure that belongs to nobody else (no pyplot)."""
    figure = Figure(figsize=(width_in, height_in), dpi=_DPI, facecolor=PAPER)
    FigureCanvasAgg(figure)
    return figure


def check_suffix(path: Path) -> None:
    """Raise InputError where a picture of that kind cannot be written."""
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"{path} cannot be drawn: a picture is a file that ends in {', '.join(SUFFIXES)}.")


def _settings() -> AbstractContextManager[None]:
    """Set what all pictures share; letters stay letters in an SVG, to be searched, copied and edited."""
    return mpl.rc_context({"svg.hashsalt": "enfilade", "svg.fonttype": "none"})


def save(figure: Figure, path: Path) -> None:
    """Write a figure; the same drawing gives the same bytes.

    Raises
    ------
    InputError
        If the suffix is none of `SUFFIXES`.
    StoreError
        If the file cannot be written.
    """
    check_suffix(path)
    suffix = path.suffix.lower()
    try:
        with warnings.catch_warnings(), _settings(), replacing(path) as file:
            # A name in a script that the font lacks shows as boxes; that is no reason to speak up.
            warnings.filterwarnings("ignore", message="Glyph .* missing from font")
            figure.savefig(file, format=suffix[1:], metadata=_METADATA[suffix])
    except OSError as error:
        raise StoreError(f"{path} cannot be written: {error.strerror or error}.") from error
