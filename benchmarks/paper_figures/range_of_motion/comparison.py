"""Figures 12, 13 and 15: our shapes, the warp's and those from examples, frame by frame and over whole clips.

    python -m benchmarks.paper_figures.range_of_motion.comparison

Figure 12 has sparsity alone for a prior, as in the paper; once with its constant, once in our own solve.
Semantics are the correlation of weights with the right ones, intensity their gain; right is that the actor's
full range is the character's full range.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from benchmarks.paper_figures.range_of_motion.performers import (
    acted,
    cases,
    found_shapes,
    frames_of,
    name_of,
    solved,
    unlikeness,
)
from benchmarks.paper_figures.rig_transfer.command import run
from benchmarks.paper_figures.rig_transfer.drawing import sitter
from benchmarks.paper_figures.rig_transfer.faces import Settings
from benchmarks.report import Row, publish
from mien.core import Clip
from mien.evaluate import Case
from mien.look.sheet import Labelled, save_png, sheet
from mien.look.sheet import Row as Strip
from mien.retargeting.settings import PAPER
from mien.retargeting.spacetime.method import PAPER as SPACETIME

SPARSITY_ALONE = {**PAPER, "prior": 0.0}
OWN: Mapping[str, Any] = {}
LIVE = {"ahead": False}


class Column(NamedTuple):
    """One result of a figure.

    Attributes:
        label: what it is called.
        shapes: the actor's shapes, a key of `found_shapes`.
        settings: of the solve.
        velocity: λ of a solve over the whole clip; None for one frame after the other.
        solve: what the solve is called.
        pictured: whether it is in the picture, or only in the table.
    """

    label: str
    shapes: str
    settings: Mapping[str, Any] = OWN
    velocity: float | None = None
    solve: str = "ours"
    pictured: bool = True


KINDS = ("ours", "aligned", "RBF", "EBFR")
MOVEMENT = {key: value for key, value in SPACETIME.items() if key != "velocity"}
FIGURES: Mapping[str, tuple[Column, ...]] = {
    "12": (
        *(Column(kind, kind) for kind in KINDS),
        *(Column(kind, kind, SPARSITY_ALONE, None, "published", False) for kind in KINDS),
    ),
    "13": tuple(Column(f"{kind} + SFC", kind, OWN, 1.0) for kind in KINDS[:3]),
    "15": (
        Column("ours", "ours", LIVE, solve="live"),
        Column("ours, prior", "ours", LIVE | {"prior": 0.3}, solve="live"),
        Column("SFC", "RBF", OWN, 1.0),
        Column("SFC, movement", "RBF", MOVEMENT, SPACETIME["velocity"], "movement"),
    ),
}
"""`aligned`: shapes as published; `ours`: our default's; `live`: no frame knows the next, as in the paper."""
MEASURED = ("correlation", "correlation_each", "gain", "vertex_mm", "lid_mm", "lip_mm", "jerk")


def comparison(settings: Settings) -> None:
    """Make all three figures and their table."""
    rows: list[Row] = []
    strips: dict[str, list[Strip]] = {figure: [] for figure in FIGURES}
    for case in cases(settings):
        for figure, columns in FIGURES.items():
            clips = {}
            for column in columns:
                clip = solved(case, found_shapes(case)[column.shapes], column.settings, column.velocity)
                rows.append({"figure": figure, **_measured(case, column, clip)})
                if column.pictured:
                    clips[column.label] = clip
            strips[figure].append(_strip(case, clips, settings))
        print(f"{name_of(case)} compared", flush=True)
    for figure, found in strips.items():
        save_png(settings.out / f"figure{figure}.png", sheet(found, ""))
    about = "Ours, RBF, example-based and space-time on characters less and less like the actor (figures 12, 13, 15)"
    publish("range_of_motion_comparison", about, rows, ("numpy", "scipy", "mien"), settings.results)


def _measured(case: Case, column: Column, clip: Clip) -> Row:
    against = case.yardsticks["range"]
    figures = against.measure(clip.channels(against.names))
    return {
        "character": name_of(case),
        "unlike": unlikeness(case),
        "shapes": column.label,
        "solve": column.solve,
        **{key: float(figures[key]) for key in MEASURED if key in figures},
    }


def _strip(case: Case, clips: Mapping[str, Clip], settings: Settings) -> Strip:
    person, face = sitter(case.actor, size=settings.tile), sitter(case.character, size=settings.tile)
    names, mine = case.character.blendshapes.names, acted(case)
    pictures = []
    for frame in frames_of(case, 2):
        pictures.append(Labelled(person.picture(mine[frame]), f"actor, frame {frame}"))
        right = np.asarray(case.truth_range.channels(names))[frame]
        pictures.append(Labelled(face.picture(right), "right"))
        pictures += [Labelled(face.picture(clip.channels(names)[frame]), label) for label, clip in clips.items()]
    return Strip(name_of(case), tuple(pictures))


if __name__ == "__main__":
    run(__doc__, comparison)
