"""Figure 8: the error of the layered model and of each layer alone."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from benchmarks.paper_figures.layers.performances import Performance
from benchmarks.report import Row
from mien.io.files import written_whole
from mien.retargeting.layers.comparison import Comparison, compare_layers

COLOURS = {"layered": "#111827", "emotion": "#d1662b", "speech": "#2f6fb5", "blink": "#3a9d6a"}
INK = "#4b5563"
SHOWN = 600
"""Frames of each take that the plot shows."""


def reconstruction(takes: Sequence[Performance], folder: Path) -> list[Row]:
    """Plot the errors over time to `figure8.png` and return their means and shares."""
    compared = [compare_layers(take.decomposer(), take.moved, take.fps) for take in takes]
    _plot(takes, compared, folder / "figure8.png")
    return [row for take, found in zip(takes, compared, strict=True) for row in _rows(take, found)]


def _rows(take: Performance, found: Comparison) -> list[Row]:
    figures = found.figures()
    shared: Row = {"take": take.name, "frames": len(take.moved)}
    layered = shared | {
        "model": "layered",
        "rms mm": figures["layered_mm"],
        "frames below all": figures["frames_layered_below_all"],
    }
    alone = [
        shared
        | {
            "model": f"{name} only",
            "rms mm": figures[name]["mean_mm"],
            "frames layered below": figures[name]["frames_layered_below"],
            "mean ratio": figures[name]["mean_ratio"],
        }
        for name in found.alone
    ]
    return [layered, *alone]


def _plot(takes: Sequence[Performance], compared: Sequence[Comparison], path: Path) -> None:
    figure = Figure(figsize=(10, 1.6 * len(takes) + 0.4), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(len(takes), 1, squeeze=False).ravel()
    for axes, take, found in zip(panels, takes, compared, strict=True):
        for name, error in {**found.alone, "layered": found.layered}.items():
            axes.plot(error[:SHOWN], color=COLOURS[name], linewidth=1.4 if name == "layered" else 0.8, label=name)
        axes.set_title(take.name, loc="left", fontsize=8, color=INK)
        axes.set_ylabel("RMS, mm", fontsize=7, color=INK)
        axes.set_xlim(0, min(SHOWN, len(take.moved)) - 1)
        axes.set_ylim(bottom=0)
        axes.tick_params(labelsize=7, colors=INK)
        for side in ("top", "right"):
            axes.spines[side].set_visible(False)
    panels[-1].set_xlabel("frame", fontsize=7, color=INK)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=4, fontsize=8, frameon=False)
    with written_whole(path) as temporary:
        figure.savefig(temporary, format="png", dpi=110, facecolor="white")
