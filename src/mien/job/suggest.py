"""Which frames of a performance to label next."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mien.core import Clip, Examples, InputError, Markers
from mien.core.arrays import Floats, Ints
from mien.job.model import load_model
from mien.job.performance import Performance, load_performance
from mien.job.request import Fitted
from mien.job.retarget import frames_of
from mien.retargeting.by_example import ExampleRetargeter
from mien.retargeting.samples import Samples
from mien.retargeting.shape_retargeter import ShapeRetargeter
from mien.retargeting.suggest import suggest


@dataclass(frozen=True, eq=False)
class Suggested:
    """Frames to label, the most telling first.

    Attributes:
        frames: `(count,)` of the performance.
        gain: `(count,)` the share of today's doubt that each label takes away, given those before.
        fps: frame rate of the performance.
    """

    frames: Ints
    gain: Floats
    fps: float

    def as_json(self) -> dict[str, Any]:
        """Return the document for scripts."""
        rows = zip(self.frames.tolist(), self.gain.tolist(), strict=True)
        return {"frames": [{"frame": f, "time": round(f / self.fps, 4), "gain": round(g, 5)} for f, g in rows]}


@dataclass(frozen=True, eq=False)
class Asked:
    """A performance beside the model that is to learn from it.

    Attributes:
        fitted: the model.
        performance: what the actor did.
        frames: the same as the model reads it.
        rows: `(F, d)` its rows.
        shown: `(l, d)` the rows that the model was shown with labels; the actor at rest, if it learned from none.
        labels: those labels, or None.
    """

    fitted: Fitted
    performance: Performance
    frames: Markers | Clip
    rows: Floats
    shown: Floats
    labels: Examples | None = None


def ask(performance: Path, model: Path, actor: Path | None = None, character: Path | None = None) -> Asked:
    """Read a performance as a fitted model reads it.

    Raises:
        FileError: a file is missing or damaged.
        InputError: the model has no use for labels, or reads another kind of performance.
    """
    fitted = load_model(model, character)
    retargeter = fitted.retargeter
    if not isinstance(retargeter, ExampleRetargeter | ShapeRetargeter):
        raise InputError(
            f"{model} has no use for labelled frames; fit with a method that has: --method range-of-motion, or latent."
        )
    played = load_performance(performance, actor)
    frames = frames_of(fitted, played)
    if isinstance(retargeter, ExampleRetargeter):
        return Asked(fitted, played, frames, retargeter.rows(frames)[0], retargeter.shown, retargeter.labels)
    assert isinstance(frames, Markers)
    moved = retargeter.displacements(frames.points)[0]
    rows = moved.reshape(len(moved), -1)
    return Asked(fitted, played, frames, rows, np.zeros((1, rows.shape[1])))


def suggest_frames(asked: Asked, count: int) -> Suggested:
    """Choose the frames whose labels would leave the least doubt over the performance.

    Raises:
        InputError: fewer frames than asked for.
    """
    return chosen(asked.shown, asked.rows, count, asked.frames.fps)


def chosen(shown: Floats, rows: Floats, count: int, fps: float) -> Suggested:
    """Choose rows `(F, d)` to label beside those `(l, d)` that are."""
    usable = np.flatnonzero(~np.isnan(rows).all(axis=1) & ~_among(rows, shown))
    given = Samples(shown, np.zeros((len(shown), 1)), rows[usable], np.zeros((0, 1)))
    found = suggest(given, count)
    return Suggested(usable[found.frames], found.gain, fps)


def _among(rows: Floats, shown: Floats) -> Any:
    """Return which rows are among those shown."""
    known = {row.tobytes() for row in np.ascontiguousarray(shown)}
    return np.array([row.tobytes() in known for row in np.ascontiguousarray(rows)], dtype=bool)
