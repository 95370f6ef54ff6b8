"""One file of weights against another: what `mien evaluate` does."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mien.core import Clip, InputError, Note, Rig
from mien.core.arrays import Floats
from mien.evaluate.metrics import HEAD_M, active_per_frame, millimetre
from mien.evaluate.yardstick import Figures, Yardstick, yardstick
from mien.io.documents import landmarks_on_mesh, read_landmarks
from mien.io.formats import read_clip, read_rig
from mien.vocabularies import match


@dataclass(frozen=True, eq=False)
class Evaluation:
    """What a comparison found.

    Attributes:
        frames: how many frames were compared.
        figures: by name, see `Yardstick.measure`.
        notes: what was left out.
    """

    frames: int
    figures: Figures
    notes: tuple[Note, ...]


def evaluate(result: Path, truth: Path, character: Path | None = None) -> Evaluation:
    """Compare a file of weights with the true one.

    Args:
        result: weights over time, in any format with animation.
        truth: the same performance's true weights, in any spelling of the same names.
        character: the rig that both play on, for errors in millimetres; its shapes are
            then the ones compared.

    Raises:
        FileError: a file is missing, damaged, or holds no animation.
        InputError: no name is shared, the numbers of frames differ, or no frame is tracked in both.
    """
    got, meant = read_clip(result), read_clip(truth)
    if len(got) != len(meant):
        raise InputError(
            f"{result} has {len(got)} frames and {truth} has {len(meant)}; the truth must be of the same performance, "
            "frame for frame."
        )
    rig = None if character is None else _with_landmarks(read_rig(character))
    names = meant.names if rig is None else rig.blendshapes.names
    notes: list[Note] = []
    weights, right = (_named(clip, names, path, notes) for clip, path in ((got, result), (meant, truth)))
    tracked = ~(np.isnan(weights).any(axis=1) | np.isnan(right).any(axis=1))
    if not tracked.any():
        raise InputError(f"no frame has values in both {result} and {truth}: tracking was lost throughout.")
    if not tracked.all():
        text = f"{int((~tracked).sum())} frames without tracking are left out."
        notes.append(Note("frames-left-out", text, str(truth)))
    counted = np.ones(len(names), dtype=bool)
    if rig is None:
        against = Yardstick(names, right[tracked], counted)
    else:
        unit, more = _millimetre(rig)
        notes += more
        against = yardstick(rig, right[tracked], counted, unit)
    figures = against.measure(weights[tracked])
    return Evaluation(int(tracked.sum()), figures | {"active": active_per_frame(weights[tracked])}, tuple(notes))


def _named(clip: Clip, names: tuple[str, ...], path: Path, notes: list[Note]) -> Floats:
    """Return a clip's weights under these names, noting those that it lacks."""
    found = match(clip.names, names)
    if not found.matrix.any():
        raise InputError(
            f"no channel of {path} ({', '.join(clip.names[:6])} …) means the same as any of {', '.join(names[:6])} …; "
            "convert one of the files with mien convert, or check that they are of the same character."
        )
    if found.unmatched_target:
        listed = ", ".join(found.unmatched_target[:12]) + (" …" if len(found.unmatched_target) > 12 else "")
        notes.append(
            Note(
                "shapes-absent", f"{len(found.unmatched_target)} shapes are absent and count as 0: {listed}.", str(path)
            )
        )
    return found.apply(np.asarray(clip.values))


def _with_landmarks(rig: Rig) -> Rig:
    beside = None if rig.source is None else rig.source.with_suffix(".landmarks.json")
    if rig.landmarks or beside is None or not beside.is_file():
        return rig
    return replace(rig, landmarks=landmarks_on_mesh(read_landmarks(beside), rig.neutral, beside))


def _millimetre(rig: Rig) -> tuple[float, tuple[Note, ...]]:
    if rig.landmarks:
        return millimetre(rig), ()
    height = float(np.ptp(rig.neutral.vertices, axis=0).max())
    text = f"{rig.name} has no landmarks beside it, so its longest side is taken for 23 cm, and lids and lips are not measured."
    return height / (1000 * HEAD_M), (Note("no-landmarks", text, rig.name),)
