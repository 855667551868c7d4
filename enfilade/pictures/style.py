"""Colours and letters of all pictures."""

from __future__ import annotations

from typing import Any, Final

from matplotlib import patheffects

PAPER: Final = "#ffffff"
INK: Final = "#22282f"
FAINT_INK: Final = "#7b8794"
WALL: Final = "#3d4650"
MASONRY: Final = "#dce0e5"
THRESHOLD: Final = "#fbfbfc"

ROOM_TINTS: Final = (
    "#cfe3f5",  # blue
    "#fbe3c8",  # orange
    "#d3ecdf",  # green
    "#f6d9e4",  # rose
    "#efeec4",  # yellow
    "#dcd8f0",  # violet
    "#d0ecef",  # cyan
    "#e9ddd0",  # sand
)
"""Tints that stay apart for colour-blind eyes next to one another: they differ in lightness as well as hue."""

OPENING_COLOURS: Final = {
    "door": "#d55e00",
    "passage": "#009e73",
    "window": "#56b4e9",
    "stairs": "#7a3e9d",
    "hatch": "#7a3e9d",
}
"""Okabe and Ito's palette, which colour-blind people tell apart; stairs in a violet of the same strength."""

HIGHLIGHT: Final = "#d55e00"
OBJECT: Final = "#0072b2"


def halo(width: float = 2.0) -> list[patheffects.AbstractPathEffect]:
    """Return the effect that keeps text readable on lines and points."""
    return [patheffects.withStroke(linewidth=width, foreground=PAPER, alpha=0.85)]


def words(size: float, **more: Any) -> dict[str, Any]:
    """Return how text is set: size in points, names taken literally."""
    return {"fontsize": size, "color": INK, "parse_math": False, "ha": "center", "va": "center", **more}


def shortened(text: str, length: int = 24) -> str:
    """Return a name in one line, cut with an ellipsis where it is longer."""
    line = " ".join(text.split())
    return line if len(line) <= length else line[: length - 1].rstrip() + "…"
