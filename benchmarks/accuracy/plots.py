"""The picture of an ablation: error and gain over each knob, in small multiples."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

from matplotlib import rc_context, rcParams
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from benchmarks.report import Row

INK, FAINT, ERROR, GAIN = "#4b5563", "#9ca3af", "#2f6fb5", "#d1662b"
AIM = (0.9, 1.1)
COLUMNS = 4
UNSWEPT = ("reference", "printed")


def sweep_sheet(rows: Sequence[Row]) -> str:
    """Return an SVG with a panel for each knob: mean vertex error above, mean gain below.

    Args:
        rows: one per setting: `knob`, `value`, `vertex_mm`, `gain`; and those of the
            knob `reference`, drawn as lines.
    """
    knobs = [knob for knob in dict.fromkeys(row["knob"] for row in rows) if knob not in UNSWEPT]
    references = {row["value"]: row for row in rows if row["knob"] == "reference"}
    height = -(-len(knobs) // COLUMNS)
    figure = Figure(figsize=(2.5 * COLUMNS, 2.9 * height), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(2 * height, COLUMNS, squeeze=False, height_ratios=[3, 2] * height)
    for axes in panels.ravel():
        axes.set_visible(False)
    for number, knob in enumerate(knobs):
        row, column = divmod(number, COLUMNS)
        mine = [r for r in rows if r["knob"] == knob]
        error, gain = panels[2 * row, column], panels[2 * row + 1, column]
        _curve(error, mine, "vertex_mm", ERROR)
        _curve(gain, mine, "gain", GAIN)
        error.set_title(knob, loc="left", fontsize=9, color=INK)
        error.set_xticklabels([])
        error.set_ylim(0, 1.1 * references["rbf"]["vertex_mm"])
        for name, style in (("rbf", "--"), ("floor", ":")):
            error.axhline(references[name]["vertex_mm"], color=FAINT, linestyle=style, linewidth=1)
        gain.axhspan(*AIM, color=GAIN, alpha=0.1, linewidth=0)
        gain.set_ylim(0, 1.4)
        if column == 0:
            error.set_ylabel("vertex error, mm", fontsize=8, color=INK)
            gain.set_ylabel("gain", fontsize=8, color=INK)
    return on_white(figure)


def _curve(axes: Axes, rows: Sequence[Row], key: str, colour: str) -> None:
    axes.set_visible(True)
    values: list[Any] = [row[key] for row in rows]
    axes.plot(range(len(rows)), values, color=colour, linewidth=1.5, marker="o", markersize=3.5)
    axes.set_xticks(range(len(rows)), [row["value"] for row in rows], fontsize=7)
    axes.set_xlim(-0.4, len(rows) - 0.6)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    axes.spines["bottom"].set_color(FAINT)
    axes.tick_params(colors=INK, labelsize=7, length=0)
    axes.grid(visible=True, axis="y", color=FAINT, alpha=0.3, linewidth=0.6)


def on_white(figure: Figure) -> str:
    """Return the figure as SVG text that is the same for the same numbers, on white."""
    rcParams["text.parse_math"] = False
    content = io.StringIO()
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": "mien", "font.family": "sans-serif"}):
        figure.savefig(content, format="svg", facecolor="white", metadata={"Date": None})
    return content.getvalue()
