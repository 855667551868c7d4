"""Truth beside prediction, a sheet a storey, with the faults marked, numbered and listed."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch, Rectangle
from matplotlib.path import Path as Outline
from shapely import Polygon

from enfilade.errors import NotFoundError
from enfilade.evaluate import Evaluation

from .canvas import save, sheet
from .evaluation_marks import EvaluationSheet, Half, ObjectMark, OpeningMark, RoomMark, Verdict, evaluation_sheets
from .style import FAINT_INK, INK, PAPER, ROOM_TINTS, halo, shortened, words

_PANEL_IN: Final = (8.0, 9.0)
"""Widest and highest a plan may be; a plan is at least half as wide."""
_MARGIN_M: Final = 0.8
_HEAD_IN: Final = 1.0
_LEGEND_IN: Final = 0.75
_LINE_IN: Final = 0.15
_MOST_LINES: Final = 60
_LETTERS_PER_IN: Final = 17.5

_COLOURS: Final = {
    Verdict.RIGHT: "#009e73",
    Verdict.MISSED: "#c4123f",
    Verdict.INVENTED: "#d55e00",
    Verdict.WRONG_ROOMS: "#7a3e9d",
    Verdict.SAID_CLOSED: "#0072b2",
    Verdict.NOT_ASKED: FAINT_INK,
}
_MARKERS: Final = {
    Verdict.RIGHT: ("o", 4.0),
    Verdict.MISSED: ("X", 9.0),
    Verdict.INVENTED: ("^", 8.5),
    Verdict.WRONG_ROOMS: ("D", 7.0),
    Verdict.SAID_CLOSED: ("s", 7.0),
    Verdict.NOT_ASKED: (".", 3.0),
}
_HATCHES: Final = {Verdict.MISSED: "xxx", Verdict.INVENTED: "///", Verdict.NOT_ASKED: "..."}
_LINES_PT: Final = {"window": 1.2, "door": 3.2}


@dataclass(frozen=True, slots=True)
class _Frame:
    """Bounds of both plans, metres, and inches a metre."""

    x0: float
    y0: float
    x1: float
    y1: float
    scale: float

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of a plan on paper, inches."""
        return (self.x1 - self.x0) * self.scale, (self.y1 - self.y0) * self.scale


def draw_evaluation(found: Evaluation, folder: Path, *, name: str = "evaluation", suffix: str = ".png") -> list[Path]:
    """Draw truth beside prediction, ``evaluation-s0.png`` for storey s0 of the truth.

    Returns
    -------
    list of Path
        The files, the lowest storey first, predicted storeys that stand for no true one last.

    Raises
    ------
    NotFoundError
        If no storey has a room with an outline or bounds.
    InputError, StoreError
        If the suffix is unknown, or a file cannot be written.
    """
    drawn = []
    for plans in evaluation_sheets(found):
        if plans.truth.rooms or plans.prediction.rooms:
            drawn.append(folder / f"{name}-{plans.name}{suffix}")
            _draw(plans, found, drawn[-1])
    if not drawn:
        raise NotFoundError("Neither truth nor prediction has a room with a storey and an outline to draw.")
    return drawn


def _draw(plans: EvaluationSheet, found: Evaluation, path: Path) -> None:
    frame = _frame(plans)
    width, height = frame.size
    across = 2 * width + 0.6
    lines = _wrapped(plans.faults, across)
    foot = _LEGEND_IN + _LINE_IN * (len(lines) + 1)
    figure = sheet(across, height + _HEAD_IN + foot)
    total = figure.get_figheight()
    for k, half in enumerate((plans.truth, plans.prediction)):
        place = ((0.2 + k * (width + 0.2)) / across, foot / total, width / across, height / total)
        _draw_half(_axes(figure, place, frame), half, frame)
        figure.text(place[0], 1 - 0.85 / total, half.title, **words(10, ha="left", weight="bold"))
    figure.text(0.2 / across, 1 - 0.37 / total, _headline(found), **words(9.5, ha="left", linespacing=1.5))
    _draw_legend(figure, foot)
    for k, line in enumerate(lines):
        top = (foot - _LEGEND_IN - _LINE_IN * (k + 0.5)) / total
        figure.text(0.2 / across, top, line, **words(7.5, ha="left"))
    save(figure, path)


def _headline(found: Evaluation) -> str:
    rooms, openings = found.rooms, found.openings
    return (
        f"{shortened(found.comparison.matching.truth.graph.building, 40)}   "
        f"rooms F1 {rooms.f1_at_50:.2f} / {rooms.f1_at_70:.2f}\n"
        f"open doors {openings.open.found} of {openings.true}, {openings.open.invented} invented   "
        f"windows {openings.windows.found} of {openings.windows.true}, {openings.windows.invented} invented   "
        f"objects {found.objects.found_count} of {found.objects.true}, {found.objects.ghosts} ghosts"
    )


def _wrapped(faults: tuple[str, ...], width_in: float) -> list[str]:
    letters = int(width_in * _LETTERS_PER_IN)
    lines = [line for fault in faults for line in textwrap.wrap(fault, letters, subsequent_indent="     ")]
    if len(lines) > _MOST_LINES:
        return [*lines[:_MOST_LINES], f"... {len(lines) - _MOST_LINES} lines more; the table and JSON have all"]
    return lines or ["no fault of rooms or openings on this storey"]


def _frame(plans: EvaluationSheet) -> _Frame:
    """Return the frame that holds the rooms of both sides; both are drawn to the same scale."""
    rings = [room.rings[0] for half in (plans.truth, plans.prediction) for room in half.rooms]
    corners = np.concatenate(rings)
    (x0, y0), (x1, y1) = corners.min(axis=0) - _MARGIN_M, corners.max(axis=0) + _MARGIN_M
    scale = min(_PANEL_IN[0] / (x1 - x0), _PANEL_IN[1] / (y1 - y0))
    slack = max(0.0, (_PANEL_IN[0] / 2 / scale - (x1 - x0)) / 2)
    return _Frame(x0 - slack, y0, x1 + slack, y1, scale)


def _axes(figure: Figure, place: tuple[float, float, float, float], frame: _Frame) -> Axes:
    axes = figure.add_axes(place)
    axes.set_xlim(frame.x0, frame.x1)
    axes.set_ylim(frame.y0, frame.y1)
    axes.set_aspect("equal")
    axes.set_autoscale_on(False)
    axes.axis("off")
    return axes


def _draw_half(axes: Axes, half: Half, frame: _Frame) -> None:
    for room in half.rooms:
        _draw_room(axes, room)
    for piece in half.objects:
        axes.add_patch(_object_patch(piece))
    for room in half.rooms:
        _write_name(axes, room, frame)
    for opening in half.openings:
        _draw_opening(axes, opening)
    for mark in half.numbers:
        axes.annotate(
            str(mark.number),
            (mark.position[0], mark.position[1]),
            xytext=(0, 16) if mark.on_room else (7, 7),
            textcoords="offset points",
            zorder=9,
            bbox={"boxstyle": "circle,pad=0.22", "fc": INK, "ec": PAPER, "lw": 0.8},
            **words(6.5, color=PAPER, weight="bold"),
        )


def _room_style(verdict: Verdict, tint: int | None) -> dict[str, Any]:
    if tint is not None:
        return {"facecolor": ROOM_TINTS[tint % len(ROOM_TINTS)], "edgecolor": INK, "linewidth": 1.0}
    colour = _COLOURS[verdict]
    return {"facecolor": PAPER, "edgecolor": colour, "linewidth": 1.6, "hatch": _HATCHES.get(verdict, "")}


def _draw_room(axes: Axes, room: RoomMark) -> None:
    parts = [Outline(np.vstack([ring, ring[:1]]), closed=True) for ring in room.rings if len(ring) >= 3]
    style = _room_style(room.verdict, room.tint)
    axes.add_patch(PathPatch(Outline.make_compound_path(*parts), zorder=1, **style))


def _write_name(axes: Axes, room: RoomMark, frame: _Frame) -> None:
    polygon = Polygon(room.rings[0]).buffer(0)
    place = polygon.representative_point() if not polygon.is_empty else None
    if place is None:
        return
    width_in = (polygon.bounds[2] - polygon.bounds[0]) * frame.scale
    name = "\n".join(textwrap.wrap(shortened(room.name, 44), max(8, int(width_in * _LETTERS_PER_IN))))
    axes.text(place.x, place.y, name, zorder=6, path_effects=halo(), **words(7))


def _object_patch(piece: ObjectMark) -> Rectangle:
    verdict = piece.verdict
    colour = _COLOURS[verdict] if verdict is not Verdict.RIGHT else FAINT_INK
    dashes = {Verdict.MISSED: (0, (3, 1.5)), Verdict.INVENTED: (0, (1, 1))}.get(verdict, "-")
    hatch = {Verdict.MISSED: "\\\\\\\\", Verdict.INVENTED: None}.get(verdict)
    width_pt = 0.6 if verdict in (Verdict.RIGHT, Verdict.NOT_ASKED) else 1.1
    style: dict[str, Any] = {"edgecolor": colour, "linewidth": width_pt, "linestyle": dashes, "hatch": hatch}
    return Rectangle((piece.corner[0], piece.corner[1]), *piece.size, fill=False, zorder=3, **style)


def _draw_opening(axes: Axes, opening: OpeningMark) -> None:
    ends = opening.position + np.outer((-0.5, 0.5), opening.along) * opening.width
    colour = _COLOURS[opening.verdict]
    width_pt = _LINES_PT["window" if opening.kind == "window" else "door"]
    axes.plot(*ends.T, color=PAPER, linewidth=width_pt + 2, solid_capstyle="butt", zorder=4)
    axes.plot(*ends.T, color=colour, linewidth=width_pt, solid_capstyle="butt", zorder=5)
    marker, size = _MARKERS[opening.verdict]
    stairs = opening.kind in ("stairs", "hatch")
    if stairs:
        axes.plot(*opening.position, marker="s", markersize=14, mfc="none", mec=colour, mew=1.6, zorder=5)
    axes.plot(*opening.position, marker=marker, markersize=size, color=colour, mec=PAPER, mew=0.6, zorder=7)


def _draw_legend(figure: Figure, foot: float) -> None:
    figure.legend(
        handles=_samples(),
        loc="upper left",
        ncols=max(3, int(figure.get_figwidth() / 1.75)),
        frameon=False,
        fontsize=7,
        labelcolor=INK,
        columnspacing=1.2,
        bbox_to_anchor=(0.1 / figure.get_figwidth(), (foot - 0.02) / figure.get_figheight()),
    )


def _samples() -> list[Artist]:
    """Return a sample of each thing that a sheet may have."""
    openings = [
        Line2D([], [], color=_COLOURS[v], marker=_MARKERS[v][0], markersize=_MARKERS[v][1] * 0.8, label=label)
        for v, label in (
            (Verdict.RIGHT, "opening found"),
            (Verdict.MISSED, "opening missed"),
            (Verdict.INVENTED, "opening invented"),
            (Verdict.WRONG_ROOMS, "there, but wrong rooms"),
            (Verdict.SAID_CLOSED, "there, but said closed"),
            (Verdict.NOT_ASKED, "opening not asked"),
        )
    ]
    kinds = [
        Line2D([], [], color=INK, linewidth=_LINES_PT["door"], label="door, passage"),
        Line2D([], [], color=INK, linewidth=_LINES_PT["window"], label="window"),
        Line2D([], [], color=INK, marker="s", markersize=8, mfc="none", linestyle="none", label="stairs, hatch"),
    ]
    rooms = [Patch(**_room_style(Verdict.RIGHT, 0), label="rooms of one colour match")] + [
        Patch(**_room_style(verdict, None), label=f"room {verdict.value}")
        for verdict in (Verdict.MISSED, Verdict.INVENTED, Verdict.NOT_ASKED)
    ]
    objects = []
    for verdict, label in (
        (Verdict.RIGHT, "object"),
        (Verdict.MISSED, "object missed"),
        (Verdict.INVENTED, "ghost object"),
    ):
        patch = _object_patch(ObjectMark(np.zeros(2), np.ones(2), verdict))
        patch.set_label(label)
        objects.append(patch)
    return [*openings, *kinds, *rooms, *objects]
