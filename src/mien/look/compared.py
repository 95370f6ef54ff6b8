"""Diagrams that set methods side by side: a figure with its spread, and what accuracy costs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np

from mien.core import InputError
from mien.core.arrays import Floats
from mien.look.plots import COLOURS, FAINT, INK, KEY_FRAME, _calm, _figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST = 3.0
"""A panel ends at this many times the median, so that one method far off does not hide how the others differ."""


class Spread(Protocol):
    """A figure over several tries."""

    @property
    def mean(self) -> float:
        """Of them."""
        ...

    @property
    def std(self) -> float:
        """Standard deviation."""
        ...


def spreads(rows: Mapping[str, Mapping[str, Spread]], label: str, right: float, columns: int = 3) -> Figure:
    """Draw a figure of many methods in several scenes, a panel each: a dot and its deviation.

    Args:
        rows: by scene and method.
        label: what the figure is.
        right: the value that would be right, marked with a line.
        columns: panels in a row.

    Raises:
        InputError: there is nothing to draw.
    """
    methods = list(dict.fromkeys(method for of in rows.values() for method in of))
    if not methods:
        raise InputError(f"there is nothing to draw for {label!r}.")
    columns = min(columns, len(rows))
    height = -(-len(rows) // columns)
    figure = _figure(3.4 * columns + 1.0, height * (0.75 + 0.19 * len(methods)) + 0.5, "")
    panels = figure.subplots(height, columns, sharey=True, squeeze=False)
    for axes in panels.ravel()[len(rows) :]:
        axes.set_visible(False)
    places = np.arange(len(methods))
    for axes, (scene, of) in zip(panels.ravel(), rows.items(), strict=False):
        _calm(axes, scene)
        axes.set_title(scene, loc="left", fontsize=8, color=INK)
        means, deviations = (
            np.array([getattr(of[m], part) if m in of else np.nan for m in methods]) for part in ("mean", "std")
        )
        limit = _end(means, deviations, right)
        inside = means <= limit
        axes.errorbar(
            means[inside],
            places[inside],
            xerr=deviations[inside],
            fmt="o",
            markersize=4,
            color=COLOURS[0],
            elinewidth=1.2,
        )
        for place, mean in zip(places[means > limit], means[means > limit], strict=True):
            axes.annotate(f"{mean:.3g} →", (limit, place), ha="right", va="center", fontsize=7, color=KEY_FRAME)
        axes.axvline(right, color=KEY_FRAME, linewidth=1)
        axes.set_xlim(min(0.0, right) - 0.02 * limit, limit)
        axes.set_yticks(places, methods, fontsize=8)
        axes.set_ylim(len(methods) - 0.4, -0.6)
    figure.supxlabel(label, color=INK, fontsize=9)
    return figure


def _end(means: Floats, deviations: Floats, right: float) -> float:
    """Return where a panel ends: behind all that is shown, or at `MOST` times the median."""
    if not np.isfinite(means).any():
        return 1.0
    shown = min(1.05 * float(np.nanmax(means + deviations)), MOST * float(np.nanmedian(means)))
    return max(shown, 1.2 * right, 1e-6)


def trade(points: Sequence[tuple[str, float, float]], across: str, up: str) -> Figure:
    """Draw what accuracy costs: a small dot for each result, a large one with its name for each method's median.

    Args:
        points: name, cost and error.
        across: what the cost is.
        up: what the error is.

    Raises:
        InputError: there is nothing to draw.
    """
    known = [p for p in points if np.isfinite(p[1]) and np.isfinite(p[2])]
    if not known:
        raise InputError("there is nothing to draw: no result has both a cost and an error.")
    figure = _figure(8.0, 4.6, "")
    axes = figure.subplots()
    _calm(axes, "")
    for number, name in enumerate(dict.fromkeys(p[0] for p in known)):
        colour = COLOURS[number % len(COLOURS)]
        costs, errors = (np.array([p[i] for p in known if p[0] == name], dtype=np.float64) for i in (1, 2))
        axes.plot(costs, errors, linestyle="none", marker=".", markersize=4, color=colour, alpha=0.35)
        middle = (float(np.median(costs)), float(np.median(errors)))
        axes.plot(*middle, marker="o", markersize=6, color=colour, markeredgecolor="white")
        axes.annotate(name, middle, (5, 3), textcoords="offset points", fontsize=8, color=colour)
    axes.set_xscale("log")
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set_ylim(bottom=0)
    axes.set_xlabel(across, color=INK, fontsize=9)
    axes.set_ylabel(up, color=INK, fontsize=9)
    axes.spines["left"].set_visible(True)
    axes.spines["left"].set_color(FAINT)
    return figure
