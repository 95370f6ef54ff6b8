"""Figure 16: mouths that are much alike, and how far the user can go from our shapes to the warp's.

    python -m benchmarks.paper_figures.range_of_motion.mouths

The weights of the mesh and cross-expression terms grow by powers of ten, as the paper offers; the
shapes then go over into the warp's.  All are solved by our default, since the published sparsity silences
what is subtle.
"""

from __future__ import annotations

import numpy as np

from benchmarks.paper_figures.range_of_motion.performers import acted, cases, found_shapes, name_of, solved
from benchmarks.paper_figures.rig_transfer.command import run
from benchmarks.paper_figures.rig_transfer.drawing import camera, sitter
from benchmarks.paper_figures.rig_transfer.faces import Settings
from benchmarks.report import Row, publish
from mien.core import Clip, Rig
from mien.core.arrays import Floats, Ints
from mien.evaluate import Case
from mien.evaluate.metrics import shape_error
from mien.look.portrait import Portrait
from mien.look.sheet import Labelled, save_png, sheet
from mien.look.sheet import Row as Strip
from mien.retargeting.range_of_motion import RangeOfMotion
from mien.vocabularies.anthropometry import same_landmarks

BLENDS = (1.0, 10.0, 100.0, 1e4)
"""Factors on both terms."""
SUBTLE = 0.15, 0.6
"""The strongest mouth shape of a subtle frame lies between these."""
MOUTH = ("ibug_48", "ibug_51", "ibug_54", "ibug_57")
AROUND = 2.0
"""The picture reaches this many times as far from the middle of the mouth as its landmarks do."""


def mouths(settings: Settings) -> None:
    """Measure who takes whose place at the mouth, and picture frames where it happens."""
    rows: list[Row] = []
    strips = []
    for case in cases(settings):
        frames = subtle(case)
        if not len(frames):
            continue
        clips: dict[str, Clip] = {}
        for label, found in _results(case).items():
            clips[label] = solved(case, found, {})
            rows.append({**_measured(case, clips[label], frames, label), **_shapes(case, found)})
        strips.append(_strip(case, clips, int(frames[len(frames) // 2]), settings))
    save_png(settings.out / "figure16.png", sheet(strips, ""))
    about = "Subtle mouth shapes, our shapes blended into the warp's (figure 16)"
    publish("range_of_motion_mouths", about, rows, ("numpy", "scipy", "mien"), settings.results)


def subtle(case: Case) -> Ints:
    """Return the frames of the test in which one mouth shape is a little active, and stronger than all others."""
    values = _mouth(case, case.truth_range)
    strongest = values.max(axis=1, initial=0.0)
    return np.flatnonzero((strongest > SUBTLE[0]) & (strongest < SUBTLE[1]))


def _results(case: Case) -> dict[str, Floats]:
    """Return the published shapes with the weights of both terms times each factor, and the others."""
    found = found_shapes(case)
    blends = {
        f"aligned x {factor:g}": RangeOfMotion(shapes="alignment", mesh=0.01 * factor, cross=0.1 * factor)
        for factor in BLENDS
    }
    aligned = {label: method.align(case.prepared, case.character).personal for label, method in blends.items()}
    return aligned | {label: found[label] for label in ("ours", "RBF", "EBFR")}


def _mouth(case: Case, clip: Clip) -> Floats:
    names = case.character.blendshapes.names
    kept = [
        k for k, name in enumerate(names) if any(word in name.lower() for word in ("mouth", "jaw", "lip", "cheekpuff"))
    ]
    usable = np.flatnonzero(case.shown)
    return np.asarray(clip.channels(names)[:, [k for k in kept if k in usable]])


def _measured(case: Case, clip: Clip, frames: Ints, label: str) -> Row:
    right, found = _mouth(case, case.truth_range)[frames], _mouth(case, clip)[frames]
    first = right.argmax(axis=1)
    rows = np.arange(len(frames))
    return {
        "character": name_of(case),
        "shapes": label,
        "frames": len(frames),
        "same shape strongest": float((found.argmax(axis=1) == first).mean()),
        "its gain": float(found[rows, first].sum() / right[rows, first].sum()),
        "others' weight over it": float((found.sum(axis=1) - found[rows, first]).sum() / right[rows, first].sum()),
    }


def _shapes(case: Case, found: Floats) -> Row:
    warped = found_shapes(case)["RBF"]
    every = np.ones(len(warped), dtype=bool)
    return {
        "off the warp's": shape_error(found, warped, every),
        "off the actor's": shape_error(found, case.shapes("range"), case.shown),
    }


def _closer(rig: Rig, size: int) -> Portrait:
    """Frame the mouth alone."""
    return sitter(
        rig, size=size, at=camera(rig, names=[name for _, name in same_landmarks(MOUTH, rig.landmarks)], around=AROUND)
    )


def _strip(case: Case, clips: dict[str, Clip], frame: int, settings: Settings) -> Strip:
    person, face = (_closer(rig, settings.tile) for rig in (case.actor, case.character))
    names = case.character.blendshapes.names
    pictures = [Labelled(person.picture(acted(case)[frame]), f"actor, frame {frame}")]
    pictures.append(Labelled(face.picture(case.truth_range.channels(names)[frame]), "right"))
    pictures += [Labelled(face.picture(clip.channels(names)[frame]), label) for label, clip in clips.items()]
    return Strip(name_of(case), tuple(pictures))


if __name__ == "__main__":
    run(__doc__, mouths)
