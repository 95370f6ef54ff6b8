"""Figures 6 and 7: the layers' weights over time, and when the mouth speaks."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from benchmarks.paper_figures.layers.performances import (
    POINTS,
    SMOOTH,
    SPOKEN,
    Performance,
    spoken,
    studio,
)
from benchmarks.paper_figures.layers.reconstruction import COLOURS, INK
from benchmarks.report import Row
from benchmarks.speed.frames import spread
from mien.core import Labels, Rig
from mien.core.arrays import Floats
from mien.io.files import written_whole
from mien.library.cast import EXTREMES, cast_member
from mien.library.expressions.scripts import SCRIPTS
from mien.look.portrait import Portrait
from mien.look.sheet import telling_frames
from mien.retargeting.layers import LayeredFace, rig_face
from mien.retargeting.layers.decompose import Decomposer
from mien.rigging.baking import scripted
from mien.library.generic import generic_rig
from mien.vocabularies import match
from mien.vocabularies.arkit import ARKIT_NAMES

ROUNDED = ("mouth_funnel_dl", "mouth_funnel_dr", "mouth_pucker_l", "mouth_pucker_r", "mouth_oh_c", "mouth_oo_c")
CLOSED = ("mouth_press_l", "mouth_press_r", "mouth_suck_dl", "mouth_suck_dr", "mouth_suck_ul", "mouth_suck_ur")
SOUNDS = {"rounded": ("viseme_O", "viseme_U", "viseme_RR"), "any": None}


def weight_plot(take: Performance, folder: Path, frames: int = 300) -> None:
    """Picture the weights of a take's first seconds above the frames they belong to: `figure7.png`."""
    found = take.decomposer().decompose(take.moved[:frames], take.fps)
    chosen = telling_frames(take.weights[:frames], 8)
    sitter = Portrait.of(take.rig, size=(180, 180))
    figure = Figure(figsize=(11, 6.2), layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(4, len(chosen), height_ratios=[1.6, 1, 1, 1])
    for column, frame in enumerate(chosen):
        axes = figure.add_subplot(grid[0, column])
        axes.imshow(sitter.picture(take.weights[frame]))
        axes.set_title(f"frame {frame}", fontsize=8, color=INK)
        axes.axis("off")
    for row, region in enumerate(take.face.regions.names, start=1):
        axes = figure.add_subplot(grid[row, :])
        names = [layer.name for layer in take.face.layers]
        axes.stackplot(
            np.arange(len(found.weights)), found.weights[:, row - 1].T, colors=[COLOURS[n] for n in names], labels=names
        )
        for frame in chosen:
            axes.axvline(frame, color="white", linewidth=0.8)
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
    posed, shaped = cast_member("actor", EXTREMES), cast_member("actor", tuple(ARKIT_NAMES))
    rows: list[Row] = []
    for name in SPOKEN if folder is not None else ():
        assert folder is not None
        clip = spoken(folder, name)
        weight = _mouth_speech(posed, shaped, clip.values @ match(clip.names, ARKIT_NAMES).matrix.T)
        lips = studio(folder, name, (ROUNDED, CLOSED))
        said = {"rounded": lips[:, 0], "closed": lips[:, 1], "rounded or closed": lips.max(axis=1)}
        rows += [_row(name, kind, weight, level, float(np.quantile(level, 0.75))) for kind, level in said.items()]
    script = SCRIPTS["sentence"]
    weight = _mouth_speech(posed, posed, scripted(generic_rig().anatomy.scripts["sentence"], posed.blendshapes).values)
    visemes = [n for n in script.names if n.startswith("viseme_")]
    for kind, names in (("rounded", [n for n in visemes if n[7:] in ("O", "U", "RR")]), ("any viseme", visemes)):
        rows.append(_row("the built-in sentence", kind, weight, script.channels(names).max(axis=1), 0.4))
    return rows


def _row(take: str, kind: str, weight: Floats, level: Floats, least: float) -> Row:
    sounding = level > least
    return {
        "take": take,
        "lips": kind,
        "frames": int(sounding.sum()),
        "weight there": float(weight[sounding].mean()),
        "weight elsewhere": float(weight[~sounding].mean()),
        "correlation": float(np.corrcoef(weight, level)[0, 1]),
    }


def _mouth_speech(posed: Rig, shaped: Rig, weights: Floats) -> Floats:
    """Return the weight of speech at the mouth while a rig plays weights, in layers of the named extremes."""
    whole = rig_face(posed)
    moving = np.flatnonzero(np.linalg.norm(posed.blendshapes.deltas, axis=2).max(axis=0) > 1e-3)
    rows = moving[spread(posed.neutral.vertices[moving], POINTS)]
    layers = tuple(replace(layer, offsets=100 * layer.offsets[:, rows]) for layer in whole.layers)
    face = LayeredFace(100 * whole.rest[rows], layers, Labels(whole.regions.names, whole.regions.of[rows]))
    moved = 100 * np.tensordot(weights, shaped.blendshapes.deltas[:, rows], axes=1)
    found = Decomposer(face, np.ones(len(rows)), SMOOTH).decompose(moved)
    return np.asarray(found.weights[:, face.regions.names.index("mouth"), face.layer("speech")])
