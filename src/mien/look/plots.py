"""Diagrams of a retargeting, in one calm style.

Each function returns a matplotlib figure drawn without a display or any shared state;
`as_svg` and `as_png` turn it into what a page embeds.  In SVG the ink takes the
colour of the page's text, so diagrams read on light and dark paper.
"""

from __future__ import annotations

import io
import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mien.core import Clip, InputError, MissingPackage
from mien.core.arrays import Floats, Ints, floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK, FAINT = "#4b5563", "#9ca3af"
COLOURS = ("#2f6fb5", "#d1662b", "#3a8f5d", "#a8487f", "#8a6d1f", "#6a5acd")
ORIGINAL, INITIAL, PERSONALISED = "#9ca3af", "#d1662b", "#2f6fb5"
KEY_FRAME = "#d1662b"

REGIONS: Mapping[str, str] = {
    "brows": r"brow",
    "eyes": r"eye|lid|blink|squint|pupil",
    "jaw and mouth": r"jaw|mouth|lip|chin|tongue|viseme|smile|dimple|pucker",
    "cheeks and nose": r"cheek|nose|sneer|nasolabial|nostril",
}
"""Which words in a channel's name put it into which group of curves."""


def weight_curves(clip: Clip, count: int = 12, title: str = "") -> Figure:
    """Draw the most active channels over time, grouped by region and labelled at their ends.

    Args:
        clip: the animation; frames not tracked leave gaps.
        count: how many channels, by standard deviation.
        title: words above.

    Raises:
        InputError: the clip has no frame or no channel.
    """
    if not len(clip) or not clip.names:
        raise InputError("there are no curves to draw: the clip has no frames or no channels.")
    tracked = np.isfinite(clip.values).all(axis=1)
    spread = clip.values[tracked].std(axis=0) if tracked.any() else np.zeros(len(clip.names))
    active = [int(k) for k in np.argsort(-spread, kind="stable")[:count]]
    groups = {region: [k for k in active if region_of(clip.names[k]) == region] for region in (*REGIONS, "other")}
    shown = {region: ks for region, ks in groups.items() if ks}
    figure = _figure(8.0, 0.7 + 1.5 * len(shown), title)
    time = np.arange(len(clip)) / clip.fps
    panels = figure.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (region, channels) in zip(panels, shown.items(), strict=True):
        _calm(axes, region)
        for i, k in enumerate(channels):
            axes.plot(time, clip.values[:, k], color=COLOURS[i % len(COLOURS)], linewidth=1.2)
        for i, k in enumerate(channels):
            place = 1 - (i + 0.5) / max(len(channels), 4)
            axes.text(
                1.01,
                place,
                clip.names[k],
                transform=axes.transAxes,
                va="center",
                fontsize=8,
                color=COLOURS[i % len(COLOURS)],
            )
        axes.margins(x=0)
    panels[-1].set_xlabel("time [s]", color=INK, fontsize=9)
    return figure


def similarity_matrix(similarity: Floats, names: Sequence[str], keys: Sequence[int] = (), fps: float = 1.0) -> Figure:
    """Draw how similar each frame is to each shape, key frames marked (Ribera et al. 2017, fig. 7).

    A line marks each key frame, a dot on it the shape it resembles most.

    Args:
        similarity: `(K, F)` of shape and frame.
        names: of the `K` shapes.
        keys: the key frames.
        fps: frames per second, for the time axis.

    Raises:
        InputError: shapes disagree or a key frame does not exist.
    """
    values = floats(similarity, (len(names), None), "the similarity matrix")
    if not values.size:
        raise InputError("the similarity matrix is empty; there is nothing to draw.")
    figure = _figure(8.0, 0.9 + 0.16 * len(names), "")
    axes = figure.subplots()
    seconds = values.shape[1] / fps
    image = axes.imshow(
        values, aspect="auto", cmap="Blues", vmin=0, vmax=1, extent=(0, seconds, len(names) - 0.5, -0.5)
    )
    for frame in _inside(keys, values.shape[1]):
        moment = (frame + 0.5) / fps
        axes.axvline(moment, color=KEY_FRAME, linewidth=0.6, alpha=0.7)
        best = int(values[:, frame].argmax())
        axes.plot(moment, best, marker="o", markersize=4, color=KEY_FRAME, markeredgecolor="white")
    _calm(axes, "")
    axes.grid(False)
    axes.set_yticks(range(len(names)), names, fontsize=7)
    axes.set_xlabel("time [s]" if fps != 1 else "frame", color=INK, fontsize=9)
    bar = figure.colorbar(image, ax=axes, fraction=0.025, pad=0.015)
    bar.outline.set_visible(False)
    bar.ax.tick_params(labelsize=8, colors=INK, length=0)
    return figure


def cumulative_correlation(
    total: Floats, peaks: Sequence[int], fps: float = 1.0, threshold: float | None = None
) -> Figure:
    """Draw the similarity summed over shapes with its peaks, where key frames lie (Ribera et al. 2017, fig. 8).

    Args:
        total: `(F,)` the sum per frame.
        peaks: the frames chosen.
        fps: frames per second, for the time axis.
        threshold: a level to mark.

    Raises:
        InputError: a peak lies outside the clip.
    """
    values = floats(total, (None,), "the cumulative correlation")
    chosen = _inside(peaks, len(values))
    figure = _figure(8.0, 2.2, "")
    axes = figure.subplots()
    _calm(axes, "cumulative correlation")
    axes.plot(np.arange(len(values)) / fps, values, color=COLOURS[0], linewidth=1.2)
    axes.plot(
        chosen / fps,
        values[chosen],
        linestyle="none",
        marker="o",
        markersize=4.5,
        color=KEY_FRAME,
        markeredgecolor="white",
    )
    if threshold is not None:
        axes.axhline(threshold, color=FAINT, linewidth=0.8, linestyle=(0, (4, 3)))
    axes.margins(x=0)
    axes.set_xlabel("time [s]" if fps != 1 else "frame", color=INK, fontsize=9)
    return figure


def fit_error(fit_mm: Floats, fps: float, title: str = "") -> Figure:
    """Draw the fit error per frame with its root mean square; gaps are frames where nothing was fitted.

    Args:
        fit_mm: `(F,)` [mm].
        fps: frames per second.
        title: words above.
    """
    values = floats(fit_mm, (None,), "the fit error", nan=True)
    seen = values[np.isfinite(values)]
    figure = _figure(8.0, 2.2, title)
    axes = figure.subplots()
    _calm(axes, "fit error [mm]")
    axes.fill_between(np.arange(len(values)) / fps, 0, values, color=COLOURS[0], alpha=0.18, linewidth=0)
    axes.plot(np.arange(len(values)) / fps, values, color=COLOURS[0], linewidth=1.0)
    if seen.size:
        mean = float(np.sqrt((seen**2).mean()))
        axes.axhline(mean, color=KEY_FRAME, linewidth=1)
        axes.text(
            1.01,
            mean,
            f"RMS {mean:.2f}",
            transform=axes.get_yaxis_transform(),
            va="center",
            fontsize=8,
            color=KEY_FRAME,
        )
    axes.margins(x=0)
    axes.set_ylim(bottom=0)
    axes.set_xlabel("time [s]", color=INK, fontsize=9)
    return figure


def bars(values: Mapping[str, float], label: str, right: float | None = None, title: str = "") -> Figure:
    """Draw one bar per shape, the largest first, such as gains or evidence.

    Args:
        values: a number per name; NaN is drawn as missing.
        label: what the numbers are, with their unit.
        right: the value that would be right, marked with a line (1 for gains).
        title: words above.

    Raises:
        InputError: there is nothing to draw.
    """
    if not values:
        raise InputError(f"there are no bars to draw for {label!r}.")
    ordered = sorted(values.items(), key=lambda item: (np.isnan(item[1]), -np.nan_to_num(item[1]), item[0]))
    figure = _figure(6.0, 0.9 + 0.19 * len(ordered), title)
    axes = figure.subplots()
    _calm(axes, "")
    axes.grid(visible=False, axis="y")
    places = np.arange(len(ordered))
    lengths = np.array([value for _, value in ordered])
    axes.barh(places, np.nan_to_num(lengths), height=0.66, color=COLOURS[0], alpha=0.85)
    for place, value in zip(places, lengths, strict=True):
        text = "no value" if np.isnan(value) else f"{value:.2f}"
        axes.annotate(
            text, (np.nan_to_num(value), place), (3, 0), textcoords="offset points", va="center", fontsize=7, color=INK
        )
    if right is not None:
        axes.axvline(right, color=KEY_FRAME, linewidth=1)
    axes.set_yticks(places, [name for name, _ in ordered], fontsize=8)
    axes.set_ylim(len(ordered) - 0.4, -0.6)
    axes.set_xlabel(label, color=INK, fontsize=9)
    return figure


def sparse_blendshapes(
    neutral: Floats, shapes: Sequence[str], original: Floats, initial: Floats, personalised: Floats, columns: int = 4
) -> Figure:
    """Draw a few shapes as the markers see them, in front view (Ribera et al. 2017, fig. 17).

    Args:
        neutral: `(M, 3)` marker positions [m].
        shapes: `S` names.
        original: `(S, M, 3)` displacements of the generic shape [m].
        initial: the same for the initial guess.
        personalised: the same for the personalised shape.
        columns: panels in a row.

    Raises:
        InputError: shapes of the arrays disagree, or there is nothing to draw.
    """
    count, markers = len(shapes), len(neutral)
    sets = [floats(d, (count, markers, 3), "sparse blendshapes") for d in (original, initial, personalised)]
    if not count or not markers:
        raise InputError("there are no sparse blendshapes to draw.")
    columns = min(columns, count)
    rows = -(-count // columns)
    figure = _figure(2.2 * columns, 2.5 * rows + 0.5, "")
    from matplotlib.lines import Line2D

    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    x, y = neutral[:, 0], neutral[:, 1]
    names = ("original", "initial guess", "personalised")
    for number, axes in enumerate(panels):
        axes.set_axis_off()
        if number >= count:
            continue
        axes.set_title(shapes[number], fontsize=9, color=INK)
        axes.scatter(x, y, s=3, color=FAINT, linewidths=0)
        for deltas, colour in zip(sets, (ORIGINAL, INITIAL, PERSONALISED), strict=True):
            dx, dy = deltas[number, :, 0], deltas[number, :, 1]
            axes.quiver(x, y, dx, dy, angles="xy", scale_units="xy", scale=1, width=0.007, color=colour, alpha=0.9)
        reach = np.concatenate([neutral[None], *(neutral + deltas[number][None] for deltas in sets)])[..., :2].reshape(
            -1, 2
        )
        (left, low), (right, high) = reach.min(axis=0), reach.max(axis=0)
        pad = 0.06 * max(right - left, high - low, 1e-9)
        axes.set(xlim=(left - pad, right + pad), ylim=(low - pad, high + pad), aspect="equal")
    lines = [Line2D([], [], color=colour, linewidth=2) for colour in (ORIGINAL, INITIAL, PERSONALISED)]
    figure.legend(lines, names, loc="outside lower center", ncols=3, frameon=False, fontsize=9, labelcolor=INK)
    return figure


def region_of(name: str) -> str:
    """Return the region of the face a channel's name speaks of, or `other`."""
    return next((region for region, words in REGIONS.items() if re.search(words, name.lower())), "other")


def as_svg(figure: Figure) -> str:
    """Return the figure as an `<svg>` element whose ink is the page's text colour."""
    from matplotlib import rc_context

    content = io.StringIO()
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": "mien"}):
        figure.savefig(content, format="svg", transparent=True, metadata={"Date": None})
    svg = content.getvalue()
    return svg[svg.index("<svg") :].replace(INK, "currentColor").replace("DejaVu Sans", "inherit")


def as_png(figure: Figure, dpi: int = 150) -> bytes:
    """Return the figure as the content of a PNG file on white."""
    content = io.BytesIO()
    figure.savefig(content, format="png", dpi=dpi, facecolor="white")
    return content.getvalue()


def _figure(width: float, height: float, title: str) -> Figure:
    try:
        from matplotlib import rcParams
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        raise MissingPackage("a diagram", "matplotlib", "look") from None
    rcParams["text.parse_math"] = False  # names of shapes are not formulas, whatever signs they hold
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    if title:
        figure.suptitle(title, fontsize=11, color=INK, x=0.01, ha="left")
    return figure


def _inside(frames: Sequence[int], count: int) -> Ints:
    chosen = np.asarray(frames, dtype=np.int64)
    for frame in chosen[(chosen < 0) | (chosen >= count)]:
        raise InputError(f"key frame {frame} does not exist; there are frames 0 … {count - 1}.")
    return chosen


def _calm(axes: Axes, label: str) -> None:
    """Take away all lines that say nothing."""
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    axes.spines["bottom"].set_color(FAINT)
    axes.tick_params(colors=INK, labelsize=8, length=0)
    axes.grid(visible=True, axis="both", color=FAINT, alpha=0.25, linewidth=0.6)
    axes.set_axisbelow(True)
    if label:
        axes.set_title(label, loc="left", fontsize=9, color=INK)
