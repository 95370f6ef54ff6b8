"""How a performance becomes rows of numbers, for methods that know nothing of faces.

No point of the actor has to be a point of the character: all markers of the take are read, and
pairs only say where head motion goes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mien.capture import Neutral, Stabiliser, fill_gaps, find_neutral, learn_stabiliser
from mien.core import Clip, Correspondence, InputError, Markers, Note, Rig
from mien.core.arrays import Floats
from mien.core.units import human_centimetre
from mien.geometry.align import Similarity, inverse_rigid, transform
from mien.retargeting.terms import common_terms

FEWEST = 4
"""Markers that hold a head still and give it a size."""


@dataclass(frozen=True, eq=False)
class MarkerRows:
    """Frames of markers as rows: displacements from the neutral [cm of a human face], the head held still.

    Attributes:
        names: `M` markers.
        neutral: `(M, 3)` the actor at rest, in the performance's unit.
        centimetre: a human centimetre in that unit.
        stabiliser: holds the head still, or None if it does not move.
        placement: from the actor's space to the character's.
    """

    names: tuple[str, ...]
    neutral: Floats
    centimetre: float
    stabiliser: Stabiliser | None
    placement: Similarity

    @property
    def size(self) -> int:
        """Entries of a row."""
        return 3 * len(self.names)

    def rows(self, performance: Markers) -> tuple[Floats, Floats | None]:
        """Return `(F, 3M)` rows and the character's head motion `(F, 4, 4)`."""
        points, motion = performance.only(self.names).points, None
        if self.stabiliser is not None:
            points, motion = self.stabiliser(points)
        take = (points - self.neutral) / self.centimetre
        return take.reshape(len(take), -1), None if motion is None else self.placement.conjugate(motion)

    def start(self) -> Floats:
        """Begin with the head at rest."""
        return np.eye(4)

    def step(self, motion: Floats, frame: Floats) -> tuple[Floats, Floats]:
        """Return the head motion, and the row `(3M,)` of one frame `(M, 3)`."""
        points = np.asarray(frame, dtype=np.float64)[None]
        if self.stabiliser is not None:
            if (self.stabiliser.stability * ~np.isnan(points[0, :, 0]) > 0).sum() >= 3:
                motion = self.stabiliser(points)[1][0]
            points = transform(inverse_rigid(motion[None]), points)
        return motion, ((points - self.neutral) / self.centimetre).ravel()


@dataclass(frozen=True, eq=False)
class ChannelRows:
    """Frames of a clip as rows: its channels as they are.

    Attributes:
        names: `J` channels.
    """

    names: tuple[str, ...]

    @property
    def size(self) -> int:
        """Entries of a row."""
        return len(self.names)

    def rows(self, performance: Clip) -> tuple[Floats, Floats | None]:
        """Return `(F, J)` rows and the head motion.

        Raises:
            InputError: a channel of the training take is missing.
        """
        missing = [name for name in self.names if name not in performance.names]
        if missing:
            raise InputError(
                f"the performance lacks {len(missing)} channels of the training take, the first {missing[0]!r}."
            )
        return performance.channels(self.names), performance.head

    def start(self) -> None:
        """Begin with nothing to remember."""
        return

    def step(self, state: None, frame: Floats) -> tuple[None, Floats]:
        """Return one frame `(J,)` as it is."""
        return state, np.asarray(frame, dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Reading:
    """A training take, read.

    Attributes:
        how: turns further frames into rows.
        take: `(F, d)` its rows, NaN where not seen.
        fps: its frame rate.
        neutral_frame: where the actor's rest was found, if in the take.
        notes: what was filled or left out.
    """

    how: MarkerRows | ChannelRows
    take: Floats
    fps: float
    neutral_frame: int | None
    notes: tuple[Note, ...]


def read_training(
    training: Markers | Clip,
    character: Rig | None,
    pairs: Correspondence | None,
    neutral: Neutral | None,
    rigid: Sequence[str],
    head_moves: bool,
) -> Reading:
    """Read a take of either kind, see `read_weights` and `read_points`."""
    if isinstance(training, Clip):
        return read_weights(training)
    return read_points(training, character, pairs, neutral=neutral, rigid=rigid, head_moves=head_moves)


def read_weights(training: Clip) -> Reading:
    """Read a take of weights; channels that never change say nothing and are left out.

    Raises:
        InputError: no channel ever changes.
    """
    low = np.nanmin(training.values, axis=0, initial=np.inf)
    moving = np.nanmax(training.values, axis=0, initial=-np.inf) > low
    names = tuple(name for name, moves in zip(training.names, moving, strict=True) if moves)
    if not names:
        raise InputError("no channel of the training take ever changes; give a take in which the actor moves.")
    empty = np.asarray(np.isnan(training.values).all(axis=0))
    gone = [name for name, never in zip(training.names, empty, strict=True) if never]
    notes = training.notes
    if gone:
        text = f"{len(gone)} channels never have a value and are left out: {', '.join(gone[:8])}."
        notes = (*notes, Note("channels-never-seen", text, gone[0]))
    return Reading(ChannelRows(names), training.channels(names), training.fps, None, notes)


def read_points(
    training: Markers,
    character: Rig | None,
    pairs: Correspondence | None = None,
    *,
    neutral: Neutral | None = None,
    rigid: Sequence[str] = (),
    head_moves: bool = True,
) -> Reading:
    """Read a take of markers.

    Args:
        training: the take; markers that are never seen are left out.
        character: where head motion goes; None if it has no mesh.
        pairs: where markers are on the character; upright and centre on centre if None.
        neutral: the actor at rest at the take's markers; found in the take if None.
        rigid: markers that ride on the skull.
        head_moves: whether there is head motion to take out.

    Raises:
        InputError: too few markers are seen, no frame sees all of them, or a rigid one is unknown.
    """
    training.index(rigid)
    seen = np.asarray(training.seen.any(axis=0))
    gone = [name for name, s in zip(training.names, seen, strict=True) if not s]
    kept = [name for name, s in zip(training.names, seen, strict=True) if s]
    if len(kept) < FEWEST:
        raise InputError(
            f"only {len(kept)} of {len(training.names)} markers are ever seen in the training take; at least {FEWEST}, "
            "spread over the face, are needed."
        )
    markers = fill_gaps(training.only(kept))
    rest = find_neutral(markers) if neutral is None else Neutral(neutral.points[seen], neutral.frame, neutral.dwell)
    stabiliser, still = None, markers.points
    if head_moves:
        known = [kept.index(name) for name in rigid if name in kept]
        stabiliser = learn_stabiliser(rest.points, still, known)
        still, _ = stabiliser(still)
    centimetre = human_centimetre(rest.points)
    how = MarkerRows(tuple(kept), rest.points, centimetre, stabiliser, _placement(tuple(kept), rest, character, pairs))
    notes = markers.notes
    if gone:
        text = f"{len(gone)} markers are never seen and left out: {', '.join(gone[:8])}."
        notes = (*notes, Note("markers-never-seen", text, gone[0]))
    take = ((still - rest.points) / centimetre).reshape(len(still), -1)
    return Reading(how, take, markers.fps, rest.frame, notes)


def _placement(
    names: tuple[str, ...], rest: Neutral, character: Rig | None, pairs: Correspondence | None
) -> Similarity:
    """Place the actor on the character, or on a human of its own if it has no mesh."""
    if character is not None and pairs is not None:
        usable = np.isin(pairs.names, names) & (np.asarray(pairs.confidence) > 0)
        if usable.sum() >= FEWEST:
            paired = pairs.take(usable)
            rows = [names.index(name) for name in paired.names]
            return common_terms(rest.points[rows], character, paired).placement
    centimetre, centre = 0.01, np.zeros(3)
    if character is not None:
        vertices = character.neutral.vertices
        centimetre, centre = human_centimetre(vertices), vertices.mean(axis=0)
    scale = centimetre / human_centimetre(rest.points)
    shift = centre - scale * rest.points.mean(axis=0)
    return Similarity(scale, np.eye(3), shift, float("nan"), float("nan"))
