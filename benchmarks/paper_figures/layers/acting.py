"""Figures 9 and 10: one sentence on five characters, and closed lips."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from benchmarks.paper_figures.layers.talking import CAST, babble, cast, fitted, seen, sentence
from benchmarks.report import Row
from mien.core import Clip, Rig
from mien.core.arrays import Floats
from mien.library.expressions.scripts import SENTENCE
from mien.look.movie import sampled, write_movie
from mien.look.portrait import Portrait, frame_clip
from mien.look.sheet import Labelled, Row as Strip, save_png, sheet

FRAMES = (0, 33, 42, 55, 80, 98, 135, 175, 215, 260, 300)
"""At rest, w-o-w, blink, I, idea, you, that, a smile that blinks."""
FILM_FPS = 30.0
INNER_LIPS = (("ibug_61", "ibug_67"), ("ibug_62", "ibug_66"), ("ibug_63", "ibug_65"))


def actings(script: Clip) -> dict[str, Clip]:
    """Return what everyone does while the actor plays a script; the actor itself plays it."""
    return {"actor": script} | {name: fitted(name).retarget(seen(script))[0] for name in CAST[1:]}


def film(folder: Path, quick: bool) -> None:
    """Picture the sentence on all five side by side, as `figure10.png` and `figure10.mp4`."""
    clips = actings(sentence())
    sitters = {
        name: Portrait.of(cast(name), size=(200, 200), camera=frame_clip(cast(name), clip))
        for name, clip in clips.items()
    }
    rows = [
        Strip(name, tuple(Labelled(sitters[name].picture(clip.values[f]), f"{f / clip.fps:.2f} s") for f in FRAMES))
        for name, clip in clips.items()
    ]
    save_png(folder / "figure10.png", sheet(rows, SENTENCE))
    if quick:
        return
    length, fps = len(clips["actor"]), clips["actor"].fps
    large = {
        name: Portrait.of(cast(name), size=(320, 320), camera=frame_clip(cast(name), clip))
        for name, clip in clips.items()
    }
    pictures = (
        np.concatenate([large[name].picture(clip.values[f], edges="quick") for name, clip in clips.items()], axis=1)
        for f in sampled(length, fps, FILM_FPS)
    )
    write_movie(folder / "figure10.mp4", pictures, FILM_FPS)


def closure_rows(folder: Path) -> list[Row]:
    """Measure how far the mouths are open at /p/ and at /a/, without and with feelings, and picture it in `closed.png`."""
    script = babble()
    shut, wide = (script.channels([name])[:, 0] > least for name, least in (("viseme_PP", 0.95), ("viseme_aa", 0.75)))
    feeling = {"none": (0, 120), "joy": (135, 240), "surprise": (255, 360)}
    clips = actings(script)
    rows: list[Row] = []
    for name, clip in clips.items():
        gaps = np.stack([gap_mm(cast(name), weights) for weights in clip.values])
        for felt, (begin, end) in feeling.items():
            inside = (np.arange(len(gaps)) >= begin) & (np.arange(len(gaps)) < end)
            rows.append(
                {
                    "character": name,
                    "feeling": felt,
                    "gap at /p/ mm": float(gaps[inside & shut].mean()),
                    "most": float(gaps[inside & shut].max()),
                    "gap at /a/ mm": float(gaps[inside & wide].mean()),
                    "gap of its own /p/ mm": float(gap_mm(cast(name), _own(cast(name), "viseme_PP"))),
                }
            )
    frames = [
        int(np.flatnonzero(mask & (np.arange(len(shut)) >= begin))[2])
        for begin, _ in feeling.values()
        for mask in (shut, wide)
    ]
    words = [f"{sound}, {felt}" for felt in feeling for sound in ("/p/", "/a/")]
    strips = []
    for name, clip in clips.items():
        sitter = Portrait.of(cast(name), size=(200, 200), camera=frame_clip(cast(name), clip))
        strips.append(
            Strip(name, tuple(Labelled(sitter.picture(clip.values[f]), w) for f, w in zip(frames, words, strict=True)))
        )
    save_png(folder / "closed.png", sheet(strips, "/pa/ without feeling, with joy, with surprise"))
    return rows


def gap_mm(rig: Rig, weights: Floats) -> float:
    """Return how far a mouth is open: between the inner lips, over all mouths, or how far the door stands off its own /p/."""
    vertices, groups = rig.pose(weights), rig.neutral.groups
    if "door" in groups:
        shut = (
            rig.blendshapes.deltas[rig.blendshapes.index("viseme_PP")][groups["door"]]
            + rig.neutral.vertices[groups["door"]]
        )
        off = vertices[groups["door"]] - shut
        return float(1000 * np.linalg.norm(off - off.mean(axis=0), axis=1).max())
    mouths = [(groups[n], groups[n.replace("upper", "lower")]) for n in groups if n.startswith("upper_lip_")]
    if "sea" in groups:
        return float(1000 * np.mean([cKDTree(vertices[low]).query(vertices[up])[0].mean() for up, low in mouths]))
    pairs = [(rig.landmarks[a].of(vertices)[0], rig.landmarks[b].of(vertices)[0]) for a, b in INNER_LIPS]
    return float(1000 * np.mean([np.linalg.norm(a - b) for a, b in pairs]))


def _own(rig: Rig, extreme: str) -> Floats:
    return np.eye(len(rig.blendshapes))[rig.blendshapes.index(extreme)]
