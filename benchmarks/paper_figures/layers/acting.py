"""Figures 9 and 10: one sentence on five characters, and closed lips."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from benchmarks.paper_figures.layers.talking import CAST, FEELINGS, SAYING, babble, cast, fitted, seen, sentence
from benchmarks.report import Row
from mien.core import Clip, Rig
from mien.core.arrays import Floats
from mien.library.expressions.scripts import SENTENCE
from mien.look.movie import sampled, write_movie
from mien.look.portrait import Portrait, frame_clip
from mien.look.sheet import Labelled, save_png, sheet
from mien.look.sheet import Row as Strip
from mien.retargeting.layers import split_clip, split_rig

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
    """Measure how far mouths are open at /p/ and at /a/, with each feeling, and picture them in `closed.png`."""
    rig, clip, said = babble()
    rigs = {"actor": rig} | {name: cast(name) for name in CAST[1:]}
    clips, split = {"actor": clip}, {"actor": (rig, clip)}
    for name in CAST[1:]:
        retargeter, markers = fitted(name), seen(clip, rig)
        clips[name] = retargeter.retarget(markers)[0]
        exact = split_rig(cast(name), retargeter.character)
        played = split_clip(retargeter.character, retargeter.layers(markers))
        split[name] = exact, Clip(exact.blendshapes.names, played.channels(exact.blendshapes.names), played.fps)
    feeling = np.minimum((np.arange(len(said)) / said.fps / SAYING).astype(int), len(FEELINGS) - 1)
    sounds = {"/p/": said.channels(["viseme_PP"])[:, 0] > 0.999, "/a/": said.channels(["viseme_aa"])[:, 0] > 0.999}
    sounds["/p/"] &= said.channels(["viseme_aa"])[:, 0] == 0
    sounds["/a/"] &= said.channels(["viseme_PP"])[:, 0] == 0
    rows: list[Row] = []
    for name, shown_clip in clips.items():
        gaps = np.array([gap_mm(rigs[name], weights) for weights in shown_clip.values])
        own = gap_mm(cast(name), _own(cast(name), "viseme_PP"))
        for k, felt in enumerate(FEELINGS):
            shut, wide = (gaps[mask & (feeling == k)] for mask in sounds.values())
            exact, played = split[name]
            frames = np.flatnonzero(sounds["/p/"] & (feeling == k))
            rows.append(
                {
                    "character": name,
                    "feeling": felt,
                    "gap at /p/ mm": float(shut.mean()),
                    "most": float(shut.max()),
                    "with --split": float(np.mean([_open(cast(name), exact.pose(played.values[f])) for f in frames])),
                    "gap at /a/ mm": float(wide.mean()),
                    "of its own /p/ mm": own,
                }
            )
    shown = [
        (f"{sound}, {felt}", int(np.flatnonzero(mask & (feeling == k))[-1]))
        for k, felt in enumerate(FEELINGS)
        for sound, mask in sounds.items()
    ]
    strips = []
    for name, played in clips.items():
        sitter = Portrait.of(rigs[name], size=(200, 200), camera=frame_clip(rigs[name], played))
        strips.append(Strip(name, tuple(Labelled(sitter.picture(played.values[f]), label) for label, f in shown)))
    save_png(folder / "closed.png", sheet(strips, "/pa/ with three feelings"))
    return rows


def gap_mm(rig: Rig, weights: Floats) -> float:
    """Return how far the mouth of a posed rig is open [mm], see `_open`."""
    return _open(rig, rig.pose(weights))


def _open(rig: Rig, vertices: Floats) -> float:
    """Return the mean distance of the inner lips over all mouths; or how much the door is deformed against its own /p/ [mm]."""
    groups = rig.neutral.groups
    if "door" in groups:
        door, shape = groups["door"], rig.blendshapes.deltas[rig.blendshapes.index("viseme_PP")]
        off = vertices[door] - rig.neutral.vertices[door] - shape[door]
        return float(1000 * np.linalg.norm(off - off.mean(axis=0), axis=1).max())
    if "sea" in groups:
        mouths = [(ids, groups[name.replace("upper", "lower")]) for name, ids in groups.items() if "upper_lip_" in name]
        return float(1000 * np.mean([cKDTree(vertices[low]).query(vertices[up])[0].mean() for up, low in mouths]))
    pairs = [(rig.landmarks[a].of(vertices)[0], rig.landmarks[b].of(vertices)[0]) for a, b in INNER_LIPS]
    return float(1000 * np.mean([np.linalg.norm(a - b) for a, b in pairs]))


def _own(rig: Rig, extreme: str) -> Floats:
    return np.asarray(np.eye(len(rig.blendshapes))[rig.blendshapes.index(extreme)])
