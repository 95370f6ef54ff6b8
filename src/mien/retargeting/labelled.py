"""Labelled frames of a take, checked, and the frames beside them that nobody labelled."""

from __future__ import annotations

import numpy as np

from mien.core import Examples, InputError, Note
from mien.core.arrays import Floats, Ints

AS_IF_SEEN = 0.003, 1.0
"""Least and most noise that a capture is believed to have, over its largest deviation."""


def checked_examples(examples: Examples | None, frames: int, method: str) -> Examples:
    """Return labels that a take of so many frames can be learned from.

    Raises:
        InputError: there are none, one lies outside of the take, or one frame has two different ones.
    """
    if examples is None or not len(examples.frames) or np.isnan(examples.values).all():
        raise InputError(
            f"the method {method!r} learns from labelled frames, but there are none; give at least one, better 10 that "
            "show different expressions, with --examples. `mien label` chooses frames and makes a file to fill in."
        )
    if examples.frames.max() >= frames:
        outside = [str(f) for f in examples.frames if f >= frames]
        which = f"frame {outside[0]} is" if len(outside) == 1 else f"frames {', '.join(outside[:6])} are"
        raise InputError(
            f"{which} labelled ({len(outside)} in all), but outside of the training take of {frames} frames "
            f"(0 … {frames - 1}). Correct the labels, or give the take that was labelled."
        )
    for frame in np.flatnonzero(np.bincount(examples.frames) > 1):
        _check_agreement(examples, int(frame))
    return _once(examples)


def _check_agreement(examples: Examples, frame: int) -> None:
    twins = examples.values[examples.frames == frame]
    known = ~np.isnan(twins).all(axis=0)
    apart = np.nanmax(twins[:, known], axis=0, initial=-np.inf) - np.nanmin(twins[:, known], axis=0, initial=np.inf)
    if (apart > 1e-9).any():
        worst = np.flatnonzero(known)[int(np.argmax(apart))]
        given = ", ".join(f"{v:g}" for v in twins[:, worst] if not np.isnan(v))
        raise InputError(
            f"frame {frame} is labelled {len(twins)} times with different poses: {examples.names[worst]!r} is {given}; "
            "keep the right one."
        )


def _once(examples: Examples) -> Examples:
    """Merge labels that repeat a frame, and leave out parameters that no label gives."""
    frames, place = np.unique(examples.frames, return_inverse=True)
    values = np.full((len(frames), len(examples.names)), np.nan)
    for row, at in zip(examples.values, place.ravel(), strict=True):
        values[at] = np.where(np.isnan(values[at]), row, values[at])
    given = ~np.isnan(values).all(axis=0)
    names = tuple(name for name, known in zip(examples.names, given, strict=True) if known)
    return Examples(frames, names, values[:, given])


def doubts(labels: Examples, take: Floats) -> tuple[Note, ...]:
    """Return what is doubtful about labels of a take `(F, d)`."""
    notes = []
    blind = labels.frames[np.isnan(take[labels.frames]).all(axis=1)]
    if len(blind):
        listed = ", ".join(map(str, blind[:6]))
        text = f"{len(blind)} labelled frames see nothing of the actor and only count as poses: {listed}."
        notes.append(Note("labels-empty", text, f"frame {blind[0]}"))
    spread = np.nanmax(labels.values, axis=0) - np.nanmin(labels.values, axis=0)
    constant = [name for name, range_ in zip(labels.names, spread, strict=True) if range_ <= 0]
    if constant and len(labels.frames) > 1:
        text = (
            f"{len(constant)} parameters have the same value in all labels and will keep it: {', '.join(constant[:8])}."
        )
        notes.append(Note("parameters-constant", text, constant[0]))
    if len(labels.frames) == 1:
        text = "there is a single label, so every frame becomes much the same pose; label more."
        notes.append(Note("one-label", text, f"frame {labels.frames[0]}"))
    return tuple(notes)


def unlabelled(take: Floats, labelled: Ints, count: int) -> Ints:
    """Return at most `count` frames of a take `(F, d)`, evenly over those that are whole and not labelled."""
    free = np.setdiff1d(np.arange(len(take)), labelled)
    whole = free[~np.isnan(take[free]).any(axis=1)]
    free = whole if len(whole) >= min(count, len(free)) else free[~np.isnan(take[free]).all(axis=1)]
    chosen = free[evenly(len(free), count)]
    return np.sort(np.concatenate([chosen, _for_the_rare(take, np.concatenate([labelled, chosen]))]))


def _for_the_rare(take: Floats, chosen: Ints) -> Ints:
    """Return further frames, so that each column that is ever seen is seen in one."""
    seen = ~np.isnan(take)
    found: list[int] = []
    for column in np.flatnonzero(seen.any(axis=0) & ~seen[chosen].any(axis=0)):
        if not seen[found, column].any():
            found.append(int(np.argmax(seen[:, column])))
    return np.array(found, dtype=np.int64)


def evenly(length: int, count: int) -> Ints:
    """Return at most `count` of so many rows, evenly."""
    if length <= count:
        return np.arange(length)
    return np.asarray(np.round((np.arange(count) + 0.5) * length / count - 0.5), dtype=np.int64)


def capture_noise(take: Floats) -> tuple[float, float]:
    """Return the standard deviations of a capture's noise and of a frame's change, over the largest deviation.

    The noise is what third differences in time hold, which smooth movement leaves out; the
    change is what is left of first differences.

    Args:
        take: `(F, d)` rows that follow each other, NaN where not seen.
    """
    spread = float(np.nanstd(take, axis=0).max()) if len(take) else 0.0
    third = np.diff(take, 3, axis=0)
    third = third[~np.isnan(third)]
    if spread <= 0 or not third.size:
        return 0.03, np.inf
    noise = float(np.median(np.abs(third))) / 0.6745 / np.sqrt(20)
    first = np.diff(take, axis=0)
    change = np.sqrt(max(float(np.nanmean(first**2)) - 2 * noise**2, 0.0))
    return float(np.clip(noise / spread, *AS_IF_SEEN)), float(np.clip(change / spread, 0.01, 10.0))
