"""The band under a plan: scale bar, notes, the list of small rooms, and the title block."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from matplotlib.path import Path
from numpy.typing import NDArray
from shapely import box

from .lettering import Label, text_width_mm
from .paper import MARGIN_MM, Sheet
from .pen import CUT_MM, FINE_MM, Pen
from .style import FAINT_INK, INK, PAPER, shortened

F64 = NDArray[np.float64]

_BLOCK_MM: Final = 86.0
_PAD_MM: Final = 2.5
_HEAD_MM: Final = 14.5
_ROW_MM: Final = 3.6
_NOTE_MM: Final = 2.5
_BAR_MM: Final = 9.5
_NOTE_PT: Final = 5.2
_ROW_PT: Final = 6.2
_LIST_PT: Final = 6.0
_LIST_MM: Final = 3.0
_COLUMN_MM: Final = 50.0
_MOST_ROWS: Final = 30
_KEY_MM: Final = 20.0
_LAYER: Final = 8.0


@dataclass(frozen=True, slots=True)
class Titles:
    """What the title block says.

    Attributes
    ----------
    building, storey
        Names.
    rows
        Pairs of a word and its value.
    """

    building: str
    storey: str
    rows: tuple[tuple[str, str], ...]


def notes_width_mm(width_mm: float) -> float:
    """Width of the notes on paper of a width."""
    return width_mm - 2 * MARGIN_MM - _BLOCK_MM - 2 * _PAD_MM


def wrapped(notes: Sequence[str], width_mm: float) -> list[str]:
    """Break notes into lines."""
    lines: list[str] = []
    for note in notes:
        line = ""
        for word in note.split():
            longer = f"{line} {word}".strip()
            if line and text_width_mm(longer, _NOTE_PT) > width_mm:
                lines.append(line)
                longer = "   " + word
            line = longer
        lines.append(line)
    return lines


def band_mm(titles: Titles, notes: Sequence[str], listed: int, width_mm: float) -> float:
    """Return how high the band must be for what it holds."""
    block = _HEAD_MM + _ROW_MM * len(titles.rows) + _PAD_MM
    said = _BAR_MM + _NOTE_MM * len(wrapped(notes, notes_width_mm(width_mm))) + 2 * _PAD_MM
    return max(block, said) + _list_mm(listed, width_mm)


def _columns(width_mm: float) -> int:
    return max(1, int((width_mm - 2 * MARGIN_MM - _PAD_MM) / _COLUMN_MM))


def _list_mm(listed: int, width_mm: float) -> float:
    rows = min(_MOST_ROWS, -(-listed // _columns(width_mm)))
    return rows * _LIST_MM + 2 * _PAD_MM if rows else 0.0


def draw_band(pen: Pen, paper: Sheet, titles: Titles, notes: Sequence[str], listed: Sequence[Label]) -> None:
    """Draw frame and band; the pen draws millimetres."""
    left, low = MARGIN_MM, MARGIN_MM
    right, top = paper.width_mm - MARGIN_MM, paper.height_mm - MARGIN_MM
    pen.area(box(left, low, right, top), layer=_LAYER, fill="none", edge=INK, weight=CUT_MM)
    list_mm = _list_mm(len(listed), paper.width_mm)
    above = low + paper.band_mm - list_mm
    divide = right - _BLOCK_MM
    pen.lines([np.array([(left, above), (right, above)]), np.array([(divide, low), (divide, above)])], layer=_LAYER)
    _draw_titles(pen, titles, divide, above, right)
    _draw_scale(pen, paper, left + _PAD_MM, above - _PAD_MM)
    _write_notes(pen, wrapped(notes, notes_width_mm(paper.width_mm)), left + _PAD_MM, above - _PAD_MM - _BAR_MM)
    if listed:
        pen.lines([np.array([(left, above + list_mm), (right, above + list_mm)])], layer=_LAYER)
        _write_list(pen, listed, paper.width_mm, above + list_mm - _PAD_MM)


def _draw_titles(pen: Pen, titles: Titles, left: float, top: float, right: float) -> None:
    x, room = left + _PAD_MM, right - left - 2 * _PAD_MM
    _write(pen, x, top - 4.2, fitted(titles.building, 9.5, room, bold=True), 9.5, weight="bold")
    _write(pen, x, top - 9.8, fitted(titles.storey, 8.5, room, bold=True), 8.5)
    pen.lines([np.array([(left, top - _HEAD_MM + 1), (right, top - _HEAD_MM + 1)])], layer=_LAYER, weight=FINE_MM)
    for place, (word, value) in enumerate(titles.rows):
        y = top - _HEAD_MM - _ROW_MM * (place + 0.5) + 0.4
        _write(pen, x, y, word, _ROW_PT, color=FAINT_INK)
        _write(pen, x + _KEY_MM, y, fitted(value, _ROW_PT, room - _KEY_MM), _ROW_PT)


def fitted(text: str, size_pt: float, width_mm: float, *, bold: bool = False) -> str:
    """Return a text in one line, cut where it is wider than its place."""
    line = " ".join(text.split())
    length = len(line)
    while length > 1 and text_width_mm(shortened(line, length), size_pt, bold=bold) > width_mm:
        length = min(length - 1, int(length * 0.97))
    return shortened(line, length)


def _draw_scale(pen: Pen, paper: Sheet, left: float, top: float) -> None:
    """Draw a bar of five parts, each a round length, and say the scale."""
    part = next(step for step in (0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000) if step * paper.mm_per_m >= 9.0)
    wide, y, thick = part * paper.mm_per_m, top - 4.4, 1.4
    count = 3 if 5 * wide > 70 else 5
    for place in range(count):
        corner = left + place * wide
        bar = Path(
            [(corner, y), (corner + wide, y), (corner + wide, y + thick), (corner, y + thick), (corner, y)], closed=True
        )
        pen.path(bar, layer=_LAYER, fill=INK if place % 2 == 0 else PAPER, weight=FINE_MM)
    for place in range(count + 1):
        unit = " m" if place == count else ""
        pen.write(
            np.array([left + place * wide, top - 1.2]),
            f"{part * place:g}{unit}",
            5.5,
            layer=_LAYER,
            ha="left" if place == 0 else "center",
        )
    _write(pen, left + count * wide + 9, y + thick / 2, f"1:{paper.scale} on {paper.name}", 7.5, weight="bold")


def _write_notes(pen: Pen, lines: Sequence[str], left: float, top: float) -> None:
    for place, line in enumerate(lines):
        _write(pen, left, top - _NOTE_MM * (place + 0.5), line, _NOTE_PT, color=FAINT_INK)


def _write_list(pen: Pen, listed: Sequence[Label], width_mm: float, top: float) -> None:
    """Write number, name and what is known of the rooms whose names found no place."""
    columns = _columns(width_mm)
    rows = min(_MOST_ROWS, -(-len(listed) // columns))
    shown = listed if len(listed) <= rows * columns else listed[: rows * columns - 1]
    for place, label in enumerate(shown):
        column, row = divmod(place, rows)
        x, y = MARGIN_MM + _PAD_MM + column * _COLUMN_MM, top - _LIST_MM * (row + 0.5)
        pen.write(np.array([x + 6.0, y]), str(label.number), _LIST_PT, layer=_LAYER, ha="right", weight="bold")
        text = ", ".join([" ".join(label.names), *label.more])
        _write(pen, x + 7.5, y, fitted(text, _LIST_PT, _COLUMN_MM - 9.5), _LIST_PT)
    if len(shown) < len(listed):
        x, y = MARGIN_MM + _PAD_MM + (columns - 1) * _COLUMN_MM, top - _LIST_MM * (rows - 0.5)
        _write(pen, x + 7.5, y, f"and {len(listed) - len(shown)} more", _LIST_PT)


def _write(pen: Pen, x: float, y: float, text: str, size: float, **more: Any) -> None:
    pen.write(np.array([x, y]), text, size, layer=_LAYER, ha="left", **more)
