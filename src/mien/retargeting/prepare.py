"""What every marker-based method starts from: the pairs it can use, the take held still, common terms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mien.capture import Neutral, Stabiliser, fill_gaps, find_neutral, learn_stabiliser
from mien.core import Correspondence, InputError, Markers, Note, Rig
from mien.core.arrays import Flags, Floats
from mien.retargeting.terms import Terms, common_terms

STILL_CM = 0.05
"""A take in which no point ever leaves its neutral by this much shows no movement."""


@dataclass(frozen=True, eq=False)
class Prepared:
    """An actor's take beside a character, in common terms.

    Attributes:
        pairs: the correspondence in use.
        terms: actor and character in human centimetres.
        stabiliser: holds the head still; None if the head does not move in the performance.
        take: `(F, M, 3)` displacements from the neutral `Δa` [cm]; NaN where missing.
        fps: its frame rate.
        neutral: where the neutral came from.
        notes: what was settled, filled or left out.
    """

    pairs: Correspondence
    terms: Terms
    stabiliser: Stabiliser | None
    take: Floats
    fps: float
    neutral: Neutral
    notes: tuple[Note, ...]


def prepare(
    character: Rig,
    training: Markers,
    pairs: Correspondence,
    *,
    neutral: Neutral | None = None,
    rigid: Sequence[str] = (),
    head_moves: bool = True,
) -> Prepared:
    """Bring a training take and a character into the same terms.

    Args:
        character: a rig with blendshapes.
        training: the actor's range-of-motion take; other markers than the paired ones are ignored.
        pairs: which marker is which point of the character.
        neutral: the actor at rest at the paired points; found in the take if None.
        rigid: names of markers that ride on the skull.
        head_moves: whether the take holds head motion to take out.

    Raises:
        InputError: no usable blendshapes, too few pairs, no neutral, no movement, or
            actor and character that do not fit each other.
    """
    _check_character(character)
    kept, dropped = _usable(pairs, training)
    if neutral is not None:
        neutral = _at(neutral, kept)
    pairs = pairs.take(kept)
    markers = fill_gaps(training.only(pairs.names))
    rest = find_neutral(markers) if neutral is None else neutral
    terms = common_terms(rest.points, character, pairs)
    stabiliser = None
    still = markers.points
    if head_moves:
        known = [pairs.names.index(name) for name in rigid if name in pairs.names]
        if rigid and len(known) < 3:
            raise InputError(
                f"of the rigid markers {', '.join(rigid)}, only {len(known)} are paired; at least 3 must be."
            )
        stabiliser = learn_stabiliser(rest.points, markers.points, known)
        still, _ = stabiliser(markers.points)
    take = (still - rest.points) / terms.centimetre
    reach = np.nanmax(np.linalg.norm(take, axis=2), initial=0.0)
    if not reach > STILL_CM:
        raise InputError(
            f"the training take of {len(take)} frames shows no movement (no point leaves the neutral by more than "
            f"{reach * 10:.2f} mm); give a take in which the actor moves the face, with --training if it is another file."
        )
    return Prepared(pairs, terms, stabiliser, take, markers.fps, rest, (*markers.notes, *dropped, *terms.notes))


def _check_character(character: Rig) -> None:
    shapes = character.blendshapes
    if len(shapes) == 0:
        raise InputError(
            f"{character.name} has no blendshapes (morph targets), so there is nothing to animate; "
            "export it with its shapes, or give another character."
        )
    if len(shapes.empty) == len(shapes):
        raise InputError(
            f"all {len(shapes)} blendshapes of {character.name} are empty; the export lost their displacements."
        )


def _at(neutral: Neutral, kept: Flags) -> Neutral:
    """Return a neutral `(M, 3)` at the pairs that are kept `(M,)`."""
    if len(neutral.points) != len(kept):
        raise InputError(
            f"the neutral has {len(neutral.points)} points, but there are {len(kept)} pairs; give it a point for each."
        )
    return replace(neutral, points=neutral.points[kept])


def _usable(pairs: Correspondence, training: Markers) -> tuple[Flags, tuple[Note, ...]]:
    """Return `(M,)` which pairs to keep: not those whose marker the take never sees, or whose place is a guess."""
    training.index(pairs.names)
    seen = np.asarray(training.only(pairs.names).seen.any(axis=0))
    sure = np.asarray(pairs.confidence) > 0
    notes = []
    for what, keep in (("never-seen", seen), ("no-place", sure)):
        names = [n for n, k in zip(pairs.names, keep, strict=True) if not k]
        if names:
            why = (
                "its marker is never seen in the take"
                if what == "never-seen"
                else "no place on the character passed the checks"
            )
            notes.append(
                Note(
                    f"pairs-{what}", f"{len(names)} pairs are left out because {why}: {', '.join(names[:8])}.", names[0]
                )
            )
    if (seen & sure).sum() < 4:
        raise InputError(
            f"only {(seen & sure).sum()} of {len(pairs)} pairs are usable; at least 4, spread over the face, are needed."
        )
    return np.asarray(seen & sure), tuple(notes)
