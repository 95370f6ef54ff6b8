"""Figures 9 and 10: one sentence on five characters, and closed lips."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from benchmarks.paper_figures.layers.performances import SPOKEN, spoken
from benchmarks.paper_figures.layers.talking import (
    CAST,
    FEELINGS,
    SAYING,
    arkit_actor,
    babble,
    cast,
    fitted,
    in_arkit,
    seen,
    sentence,
)
from benchmarks.report import Row
from mien.core import Clip, Markers, Rig
from mien.core.arrays import Floats, Ints
from mien.library.expressions.scripts import SENTENCE
from mien.look.movie import sampled, write_movie
from mien.look.portrait import Portrait, frame_clip
from mien.look.sheet import Labelled, save_png, sheet
from mien.look.sheet import Row as Strip
from mien.retargeting.layers import LayeredRetargeter, split_clip, split_rig
from mien.vocabularies.openings import INNER_LIPS

FRAMES = (0, 33, 42, 55, 80, 98, 135, 175, 215, 260, 300)
"""At rest, w-o-w, blink, I, idea, you, that, a smile that blinks."""
FILM_FPS = 30.0


def actings(script: Clip) -> dict[str, tuple[Rig, Clip]]:
    """Return what everyone does while the actor plays a script, as animated files show it; the actor itself plays it."""
    markers = seen(script)
    return {"actor": (cast("actor"), script)} | {name: exactly(name, fitted(name), markers) for name in CAST[1:]}


def exactly(name: str, made: LayeredRetargeter, markers: Markers) -> tuple[Rig, Clip]:
    """Return one of the cast with shapes split by region, and the weights of those."""
    rig = split_rig(cast(name), made.character)
    clip = split_clip(made.character, made.layers(markers))
    return rig, Clip(rig.blendshapes.names, clip.channels(rig.blendshapes.names), clip.fps)


def film(folder: Path, quick: bool) -> None:
    """Picture the sentence on all five side by side, as `figure10.png` and `figure10.mp4`."""
    shown = actings(sentence())
    sitters = {
        name: Portrait.of(rig, size=(200, 200), camera=frame_clip(rig, clip)) for name, (rig, clip) in shown.items()
    }
    rows = [
        Strip(name, tuple(Labelled(sitters[name].picture(clip.values[f]), f"{f / clip.fps:.2f} s") for f in FRAMES))
        for name, (_, clip) in shown.items()
    ]
    save_png(folder / "figure10.png", sheet(rows, SENTENCE))
    if quick:
        return
    length, fps = len(shown["actor"][1]), shown["actor"][1].fps
    large = {
        name: Portrait.of(rig, size=(320, 320), camera=frame_clip(rig, clip)) for name, (rig, clip) in shown.items()
    }
    pictures = (
        np.concatenate(
            [large[name].picture(clip.values[f], edges="quick") for name, (_, clip) in shown.items()], axis=1
        )
        for f in sampled(length, fps, FILM_FPS)
    )
    write_movie(folder / "figure10.mp4", pictures, FILM_FPS)


def closure_rows(folder: Path) -> list[Row]:
    """Measure how far mouths are open at /p/ and at /a/, with each feeling, and picture them in `closed.png`."""
    rig, clip, said = babble()
    own, split, markers = {"actor": (rig, clip)}, {"actor": (rig, clip)}, seen(clip, rig)
    for name in CAST[1:]:
        made = fitted(name)
        own[name] = cast(name), made.retarget(markers)[0]
        split[name] = exactly(name, made, markers)
    feeling = np.minimum((np.arange(len(said)) / said.fps / SAYING).astype(int), len(FEELINGS) - 1)
    sounds = {"/p/": said.channels(["viseme_PP"])[:, 0] > 0.999, "/a/": said.channels(["viseme_aa"])[:, 0] > 0.999}
    sounds["/p/"] &= said.channels(["viseme_aa"])[:, 0] == 0
    sounds["/a/"] &= said.channels(["viseme_PP"])[:, 0] == 0
    rows: list[Row] = []
    for name in own:
        measured = [_gaps(cast(name), *acted) for acted in (split[name], own[name])]
        pressed = gap_mm(cast(name), _own(cast(name), "viseme_PP"))
        for k, felt in enumerate(FEELINGS):
            shut, wide = (mask & (feeling == k) for mask in sounds.values())
            exact, projected = measured
            rows.append(
                {
                    "character": name,
                    "feeling": felt,
                    "gap at /p/ mm": float(exact[shut].mean()),
                    "most": float(exact[shut].max()),
                    "on its own shapes": float(projected[shut].mean()),
                    "gap at /a/ mm": float(exact[wide].mean()),
                    "of its own /p/ mm": pressed,
                }
            )
    shown = [
        (f"{sound}, {felt}", int(np.flatnonzero(mask & (feeling == k))[-1]))
        for k, felt in enumerate(FEELINGS)
        for sound, mask in sounds.items()
    ]
    strips = []
    for name, (whole, played) in split.items():
        sitter = Portrait.of(whole, size=(200, 200), camera=frame_clip(whole, played))
        strips.append(Strip(name, tuple(Labelled(sitter.picture(played.values[f]), label) for label, f in shown)))
    save_png(folder / "closed.png", sheet(strips, "/pa/ with three feelings"))
    return rows


def speech_closure_rows(folder: Path) -> list[Row]:
    """Measure how far the cast's mouths are open where an actor's lips close in recorded speech."""
    rows: list[Row] = []
    for take in SPOKEN:
        clip = in_arkit(spoken(folder, take))
        markers, opened = seen(clip, arkit_actor()), _gaps(arkit_actor(), arkit_actor(), clip)
        shut = closures(opened, clip.fps)
        for name in CAST[1:]:
            made = fitted(name)
            rig, played = exactly(name, made, markers)
            gaps = np.array([_open(cast(name), rig.pose(played.values[f])) for f in shut])
            rows.append(
                {
                    "take": take,
                    "character": name,
                    "closures": len(shut),
                    "the actor's gap mm": float(opened[shut].mean()),
                    "gap mm": float(gaps.mean()),
                    "most": float(gaps.max()),
                    "at rest mm": gap_mm(cast(name), np.zeros(len(cast(name).blendshapes))),
                }
            )
    return rows


def closures(opened: Floats, fps: float) -> Ints:
    """Return frames in which lips that were 3 mm apart within half a second before are closest, within 1.3 mm."""
    window = round(fps / 2)
    found: list[int] = []
    for f in range(window, len(opened) - 1):
        least = opened[f] < 1.3 and opened[f] <= min(opened[f - 1], opened[f + 1])
        if least and opened[f - window : f].max() > 3 and not (found and f - found[-1] <= window // 2):
            found.append(f)
    return np.array(found, np.int64)


def _gaps(rig: Rig, posed: Rig, clip: Clip) -> Floats:
    """Return `(F,)` how far a mouth is open while a rig on its vertices plays a clip [mm]."""
    return np.array([_open(rig, posed.pose(weights)) for weights in clip.values])


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
    pairs = [[rig.landmarks[f"ibug_{n}"].of(vertices)[0] for n in facing] for facing in INNER_LIPS]
    return float(1000 * np.mean([np.linalg.norm(a - b) for a, b in pairs]))


def _own(rig: Rig, extreme: str) -> Floats:
    return np.asarray(np.eye(len(rig.blendshapes))[rig.blendshapes.index(extreme)])
