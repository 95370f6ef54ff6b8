"""Labels that nobody has to make: the actor did the list of docs/calibration-take.md, in its order.

What is found is put before a person all the same, in a table and in pictures: an actor who
was asked for a snarl may have done something else.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mien.capture import fill_gaps
from mien.capture.holds import Hold
from mien.core import Examples, InputError, Note, Rig
from mien.core.arrays import Floats
from mien.io.examples import read_examples
from mien.io.formats import read_rig
from mien.job.label import DIGITS, SIZE, TABLE, Choice, beside, check_frames, joined, parameters
from mien.job.labelled import Target
from mien.job.likeness import actor_pictures
from mien.job.model import SUFFIX
from mien.job.pairs import find_pairs
from mien.job.performance import Performance, load_performance
from mien.retargeting.listed import Listed, recognise
from mien.retargeting.prepare import Prepared, prepare
from mien.retargeting.rows import MarkerRows
from mien.vocabularies import ARKIT_NAMES, match
from mien.vocabularies.calibration import EXPRESSIONS, list_weights

NAMES = tuple(EXPRESSIONS)
BACKWARDS = 0.55
"""A take that the list fits backwards to this share of how it fits is another: half of it was found by chance."""


def choose_listed(
    performance: Path,
    character: Path,
    folder: Path,
    *,
    actor: Path | None = None,
    pairs: Path | None = None,
    landmarks: tuple[Path, Path] | None = None,
) -> Choice:
    """Find the expressions of the list in a take, and label them.

    Args:
        performance: what the actor did: the list in its order, perhaps with something left out or in between.
        character: the rig.
        folder: where the table is or will be; expressions with a row there are left as they are.
        actor: the rig that weights play on.
        pairs: which point is which.
        landmarks: a landmark file for each side.

    Raises:
        FileError: a file is missing or damaged.
        InputError: the character has too few of the list's shapes, or the take is not of the list.
    """
    if character.suffix.lower() == SUFFIX:
        raise InputError(f"{character} is a model; --list compares the actor with the character: give its rig.")
    before = read_examples(folder / TABLE) if (folder / TABLE).exists() else None
    take, rig = load_performance(performance, actor), read_rig(character)
    names = parameters(Target(rig))
    if take.markers is None and take.actor is None:
        raise InputError(f"{performance} holds weights; give the rig they were recorded on with --actor.")
    found, notes = find_pairs(take, rig, pairs=pairs, landmarks=landmarks)
    points = take.points(found)
    prepared = prepare(rig, points, found, neutral=take.neutral(found), head_moves=take.head_moves)
    weights = labels_of(rig.blendshapes.names)
    listed = recognise(prepared, np.nan_to_num(weights))
    _check(listed, prepared.fps, performance, rig)
    known = np.zeros(0, dtype=np.int64) if before is None else before.frames
    check_frames(known, len(prepared.take))
    new = np.array([not any(h.first <= f <= h.last for f in known) for h in listed.holds])
    frames, entries = listed.frames[new], listed.entries[new]
    columns = [rig.blendshapes.names.index(name) for name in names]
    rows = Examples(frames, names, np.round(weights[entries][:, columns], DIGITS))
    return Choice(
        frames,
        joined(before, rows),
        _pictures(take, prepared, rig, frames, weights[entries]),
        True,
        (*notes, *prepared.notes, *_notes(listed, prepared.fps)),
        tuple(NAMES[e] for e in entries),
    )


def labels_of(names: tuple[str, ...]) -> Floats:
    """Return the weights of a character's shapes in each expression of the list, `(29, K)`.

    Args:
        names: of its shapes; what is none of Apple's by any spelling is NaN.
    """
    found = match(ARKIT_NAMES, names)
    weights = found.apply(list_weights())
    weights[:, np.isin(names, found.unmatched_target)] = np.nan
    return weights


def _pictures(
    performance: Performance, prepared: Prepared, rig: Rig, frames: np.ndarray, poses: Floats
) -> tuple[np.ndarray, ...]:
    """Picture the actor, and beside it the character as it is labelled."""
    terms = prepared.terms
    reading = MarkerRows(
        prepared.pairs.names, prepared.neutral.points, terms.centimetre, prepared.stabiliser, terms.placement
    )
    markers = fill_gaps(performance.points(prepared.pairs).only(prepared.pairs.names))
    return beside(actor_pictures(performance, markers, reading, frames, SIZE), rig, np.nan_to_num(poses))


def _check(listed: Listed, fps: float, performance: Path, rig: Rig) -> None:
    half, count = len(NAMES) / 2, len(listed.entries)
    by_hand = "Choose frames to label by hand with `mien label` without --list."
    if listed.seen.sum() < half:
        raise InputError(
            f"only {listed.seen.sum()} of the {len(NAMES)} expressions of the list move a paired point of {rig.name} "
            f"({', '.join(rig.blendshapes.names[:5])} …): its shapes have other names than Apple's. {by_hand}"
        )
    if count < half or listed.backwards > BACKWARDS:
        at = [f"{NAMES[e]} at {_second(h, fps)}" for e, h in zip(listed.entries, listed.holds, strict=True)]
        raise InputError(
            f"{performance} does not look like a take of the list: {count} of {len(NAMES)} expressions were found in its "
            f"order ({', '.join(at) or 'none'}). Holds that are none of it: {len(listed.others)}. "
            "The list must be done in the order of docs/calibration-take.md, each expression held for a second, with the "
            f"face at rest in between. {by_hand}"
        )


def _notes(listed: Listed, fps: float) -> tuple[Note, ...]:
    notes = []
    lost = [name for i, name in enumerate(NAMES) if i not in listed.entries]
    if lost:
        text = f"{len(lost)} of {len(NAMES)} expressions of the list were not recognised and have no label: {', '.join(lost)}."
        notes.append(Note("expressions-not-found", text, lost[0]))
    if listed.others:
        at = ", ".join(_second(hold, fps) for hold in listed.others[:8])
        text = f"the face is also held in what is nothing in the list, or badly like it, at {at}."
        notes.append(Note("holds-not-listed", text, at))
    return tuple(notes)


def _second(hold: Hold, fps: float) -> str:
    return f"{(hold.first + hold.last) / 2 / fps:.1f} s"
