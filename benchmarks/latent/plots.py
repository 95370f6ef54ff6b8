"""Curves in small multiples: a panel for each take and kind of targets, a line for each method."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from benchmarks.report import Row

INK = "#4b5563"
COLOURS = {
    "transport": "#d1662b",
    "suggested": "#d1662b",
    "poses alike": "#d1662b",
    "ridge": "#2f6fb5",
    "random": "#2f6fb5",
    "linear-Gaussian, loose": "#2f6fb5",
    "gpr": "#3a9d6a",
    "svr": "#8a5fb0",
    "cross-mapping": "#b59a2f",
    "sgplvm": "#6b7280",
    "paper": "#111827",
}
COLUMNS = 4


def curves(rows: Sequence[Row], along: str, label: str) -> str:
    """Return an SVG of `rms` along a column.

    Args:
        rows: with `take`, `targets`, `method`, `rms` and the column.
        along: the column.
        label: what it says below the axis.
    """
    panels = list(
        dict.fromkeys((str(row["take"]), str(row["targets"]), str(row.get("target_only", ""))) for row in rows)
    )
    columns = min(COLUMNS, len(panels))
    height = -(-len(panels) // columns)
    figure = Figure(figsize=(2.7 * columns, 2.4 * height + 0.5), layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.subplots(height, columns, squeeze=False).ravel()
    for axes in grid[len(panels) :]:
        axes.set_visible(False)
    for axes, (take, kind, other) in zip(grid, panels, strict=False):
        mine = [r for r in rows if (r["take"], r["targets"], r.get("target_only", "")) == (take, kind, other)]
        _panel(axes, mine, along)
        axes.set_title(f"{take}, {kind}" + (f" ({other})" if other else ""), loc="left", fontsize=8, color=INK)
        axes.set_xlabel(label, fontsize=7, color=INK)
    handles, labels = grid[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), fontsize=7, frameon=False)
    out = io.StringIO()
    with rc_context({"svg.hashsalt": "mien"}):
        figure.savefig(out, format="svg", metadata={"Date": None})
    return out.getvalue()


def _panel(axes: Axes, rows: Sequence[Row], along: str) -> None:
    for method in dict.fromkeys(str(row["method"]) for row in rows):
        mine = [row for row in rows if row["method"] == method]
        places: list[Any] = [row[along] for row in mine]
        values: list[Any] = [row["rms"] for row in mine]
        strong = COLOURS.get(method) == COLOURS["transport"]
        width = 2.0 if strong else 1.1
        axes.plot(
            places, values, color=COLOURS.get(method, INK), linewidth=width, marker="o", markersize=2.5, label=method
        )
    axes.set_ylim(bottom=0)
    axes.tick_params(labelsize=7, colors=INK)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
