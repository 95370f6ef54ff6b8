"""Figures 6 and 7: the layers' weights over time, and when the mouth speaks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from benchmarks.paper_figures.layers.performances import SPOKEN, Performance, spoken, studio
from benchmarks.paper_figures.layers.reconstruction import COLOURS, INK
from benchmarks.paper_figures.layers.talking import arkit_actor, fitted, in_arkit, seen, sentence
from benchmarks.report import Row
from mien.core import Markers
from mien.core.arrays import Floats
from mien.io.files import written_whole
from mien.look.portrait import Portrait
from mien.look.sheet import telling_frames
from mien.retargeting.layers import LayeredRetargeter
from mien.vocabularies.expressions import VISEMES

LIPS = {
    "rounded": ("mouth_funnel_dl", "mouth_funnel_dr", "mouth_pucker_l", "mouth_pucker_r", "mouth_oh_c", "mouth_oo_c"),
    "closed": ("mouth_press_l", "mouth_press_r"),
    "sucked in": ("mouth_suck_dl", "mouth_suck_dr", "mouth_suck_ul", "mouth_suck_ur"),
    "jaw open": ("mouth_stretch_c",),
}
"""The studio's shapes that say how the lips are held."""
LEAST = 0.05
"""Shapes that stay below this are not used."""
ROUND = ("viseme_O", "viseme_U", "viseme_RR")


def weight_plot(take: Performance, folder: Path, frames: int = 300) -> None:
    """Picture the weights over the frames of a take that move the most, below some of these: `figure7.png`."""
    effort = np.abs(np.diff(take.weights, axis=0)).sum(axis=1)
    begin = int(np.argmax(np.convolve(effort, np.ones(frames), "valid")))
    found = take.decomposer().decompose(take.moved[begin : begin + frames], take.fps)
    chosen = telling_frames(take.weights[begin : begin + frames], 8)
    sitter = Portrait.of(take.rig, size=(180, 180))
    figure = Figure(figsize=(11, 6.2), layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(4, len(chosen), height_ratios=[1.6, 1, 1, 1])
    for column, frame in enumerate(chosen):
        axes = figure.add_subplot(grid[0, column])
        axes.imshow(sitter.picture(take.weights[begin + frame]))
        axes.set_title(f"frame {begin + frame}", fontsize=8, color=INK)
        axes.axis("off")
    for row, region in enumerate(take.face.regions.names, start=1):
        axes = figure.add_subplot(grid[row, :])
        names = [layer.name for layer in take.face.layers]
        axes.stackplot(
            np.arange(len(found.weights)), found.weights[:, row - 1].T, colors=[COLOURS[n] for n in names], labels=names
        )
        for frame in chosen:
            axes.axvline(frame, color="white", linewidth=0.8)
        axes.set_xticks(chosen, [str(begin + frame) for frame in chosen])
        axes.set(xlim=(0, len(found.weights) - 1), ylim=(0, 1), yticks=(0, 1))
        axes.set_ylabel(region, fontsize=8, color=INK)
        axes.tick_params(labelsize=7, colors=INK)
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=3, fontsize=8, frameon=False)
    with written_whole(folder / "figure7.png") as temporary:
        figure.savefig(temporary, format="png", dpi=110, facecolor="white")


def speech_rows(folder: Path | None) -> list[Row]:
    """Return how the weight of speech at the mouth goes with rounded and closed lips.

    On recorded speech the studio's own shapes say when lips are round or closed (the recordings
    come without their sound); on the built-in sentence the script does.
    """
    rows: list[Row] = []
    for closure in (0.0, None, 1.0):
        speaker = fitted("actor", closure)
        for name in SPOKEN if folder is not None else ():
            assert folder is not None
            clip = spoken(folder, name)
            weight = _mouth(speaker, seen(in_arkit(clip), arkit_actor()))
            held: list[Floats] = []
            for kind, group in LIPS.items():
                level = studio(folder, name, (group,))[:, 0]
                if level.max() > LEAST:
                    held.append(level / level.max() if kind in ("rounded", "closed") else 0 * level)
                    rows.append(_row(name, closure, kind, weight, level, max(LEAST, float(np.quantile(level, 0.75)))))
            rows.append(_row(name, closure, "rounded or closed", weight, np.sum(held, axis=0), 0.5))
        script = sentence()
        weight = _mouth(speaker, seen(script))
        for kind, names in (("rounded", ROUND), ("any viseme", tuple(VISEMES))):
            level = script.channels(names).max(axis=1)
            rows.append(_row("the built-in sentence", closure, kind, weight, level, 0.4))
    return rows


def _mouth(speaker: LayeredRetargeter, markers: Markers) -> Floats:
    return speaker.layers(markers).channels(["weight.mouth.speech"])[:, 0]


def _row(take: str, closure: float | None, kind: str, weight: Floats, level: Floats, least: float) -> Row:
    sounding = level > least
    return {
        "take": take,
        "closure": "default" if closure is None else closure,
        "lips": kind,
        "frames": int(sounding.sum()),
        "speech there": float(weight[sounding].mean()),
        "speech elsewhere": float(weight[~sounding].mean()),
        "correlation": float(np.corrcoef(weight, level)[0, 1]),
    }
