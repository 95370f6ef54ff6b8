"""What methods share that learn from labelled frames: from takes and characters to rows of numbers, and back.

A character's parameters may be anything with numbers; the names and values of the
labelled frames say what they are.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from mien.capture import Neutral, Stabiliser
from mien.core import Clip, Correspondence, Examples, InputError, Markers, Note, Report, Rig
from mien.core.arrays import Floats, Ints
from mien.geometry.align import Similarity, inverse_rigid, transform
from mien.retargeting.prepare import prepare
from mien.retargeting.samples import Learner, Learnt, Samples
from mien.retargeting.settings import in_range
from mien.retargeting.shape_retargeter import check_markers


@dataclass(frozen=True, eq=False)
class MarkerRows:
    """How frames of markers become rows: displacements from the neutral [cm of a human face], the head held still.

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
    """How a clip becomes rows: its channels as they are.

    Attributes:
        names: `J` channels.
    """

    names: tuple[str, ...]

    def rows(self, performance: Clip) -> tuple[Floats, Floats | None]:
        """Return `(F, J)` rows and the head motion."""
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
class ExampleRetargeter:
    """A learned map and how frames become its rows.

    Attributes:
        method: the method's name.
        names: `K` parameters of the character.
        reading: how frames become rows.
        learnt: the map.
        fps: frame rate of the training take.
        figures: of the fit, for the report.
        notes: of the fit.
    """

    method: str
    names: tuple[str, ...]
    reading: MarkerRows | ChannelRows
    learnt: Learnt
    fps: float
    figures: dict[str, Any]
    notes: tuple[Note, ...] = ()

    def retarget(self, performance: Any) -> tuple[Clip, Report]:
        """Map a take onto the character.

        Raises:
            InputError: another kind of performance than the training take, a marker or channel
                is unknown, or no frame sees any.
        """
        wanted = Markers if isinstance(self.reading, MarkerRows) else Clip
        if not isinstance(performance, wanted):
            raise InputError(
                f"the method was fitted to {wanted.__name__.lower()}, but the performance is "
                f"{type(performance).__name__.lower()}; give the same kind."
            )
        rows, head = self.reading.rows(performance)  # type: ignore[arg-type]
        blind = np.isnan(rows).all(axis=1)
        if blind.all():
            raise InputError("no frame of the performance sees anything that the method was fitted to.")
        notes = [*self.notes, *performance.notes]
        if blind.any():
            notes.append(Note("frames-held", f"{int(blind.sum())} frames see no marker and hold the frame before."))
        values = self.learnt.map(rows)
        deviation = np.sqrt(self.learnt.variance(rows)).mean(axis=1)
        figures = {
            "frames": len(rows),
            "fps": performance.fps,
            "missing_samples": int(np.isnan(rows).sum()),
            "uncertainty": [round(float(x), 5) for x in deviation],
            **self.figures,
        }
        clip = Clip(self.names, values, performance.fps, head)
        return clip, Report(self.method, np.full(len(rows), np.nan), figures=figures, notes=tuple(notes))

    def start(self) -> tuple[Any, Any]:
        """Begin with no frame before."""
        return self.reading.start(), self.learnt.start()

    def step(self, state: tuple[Any, Any], frame: Floats) -> tuple[tuple[Any, Any], Floats]:
        """Map one frame, NaN where missing, to `(K,)` parameters."""
        reading, row = self.reading.step(state[0], frame)
        learnt, values = self.learnt.step(state[1], row)
        return (reading, learnt), values


@dataclass(frozen=True)
class ExampleMethod(ABC):
    """A method that learns from labelled frames.

    Attributes:
        count: unlabelled frames taken from the training take, evenly over it.
        animations: existing clips of the character; their frames are targets without a source.
    """

    name: ClassVar[str]
    about: ClassVar[str]
    needs: ClassVar[str] = "markers or weights, labelled frames; pairs or landmarks if markers"
    by_example: ClassVar[bool] = True

    count: int = 100
    animations: tuple[Clip, ...] = ()

    def __post_init__(self) -> None:
        in_range(self, count=(0, 10_000))

    @abstractmethod
    def learner(self, take: Floats) -> Learner:
        """Return the model for a take `(F, d)`, whose frames follow each other."""

    def fit(
        self,
        character: Rig,
        training: Markers | Clip,
        pairs: Correspondence | None = None,
        *,
        neutral: Neutral | None = None,
        rigid: Sequence[str] = (),
        head_moves: bool = True,
        examples: Examples | None = None,
    ) -> ExampleRetargeter:
        """Learn from labelled frames, and from frames that are not.

        Raises:
            InputError: no labels, labels outside of the take, or labels that contradict each other.
        """
        reading, take, fps, notes = _reading(character, training, pairs, neutral, rigid, head_moves, self.name)
        labels = checked_examples(examples, len(take), self.name)
        free = unlabelled(take, labels.frames, self.count)
        samples = Samples(take[labels.frames], labels.values, take[free], self._targets(labels.names))
        learnt = self.learner(take).learn(samples)
        figures = {
            "labels": len(labels.frames),
            "unlabelled": [len(samples.X_only), len(samples.Y_only)],
        }
        return ExampleRetargeter(self.name, labels.names, reading, learnt, fps, figures, (*notes, *learnt.notes))

    def _targets(self, names: tuple[str, ...]) -> Floats:
        """Return rows `(n, K)` of the character's animations, at most `count` of them, evenly."""
        rows = [np.zeros((0, len(names)))]
        for clip in self.animations:
            if not set(names) & set(clip.names):
                raise InputError(
                    f"the character's animation shares no parameter with the labels ({', '.join(names[:5])} …)."
                )
            known = np.isin(names, clip.names)
            values = np.where(known, clip.channels(names), np.nan)
            rows.append(values[~np.isnan(values).all(axis=1)])
        every = np.concatenate(rows)
        return every[_evenly(len(every), self.count)]


def _reading(
    character: Rig,
    training: Markers | Clip,
    pairs: Correspondence | None,
    neutral: Neutral | None,
    rigid: Sequence[str],
    head_moves: bool,
    method: str,
) -> tuple[MarkerRows | ChannelRows, Floats, float, tuple[Note, ...]]:
    """Return how frames become rows, the training take as rows, its frame rate and notes."""
    if isinstance(training, Clip):
        moving = np.nanmax(training.values, axis=0, initial=-np.inf) > np.nanmin(
            training.values, axis=0, initial=np.inf
        )
        names = tuple(name for name, moves in zip(training.names, moving, strict=True) if moves)
        if not names:
            raise InputError("no channel of the training take ever changes; give a take in which the actor moves.")
        return ChannelRows(names), training.channels(names), training.fps, training.notes
    markers, correspondence = check_markers(training, pairs, method)
    prepared = prepare(character, markers, correspondence, neutral=neutral, rigid=rigid, head_moves=head_moves)
    terms = prepared.terms
    reading = MarkerRows(
        prepared.pairs.names, prepared.neutral.points, terms.centimetre, prepared.stabiliser, terms.placement
    )
    return reading, prepared.take.reshape(len(prepared.take), -1), prepared.fps, prepared.notes


def checked_examples(examples: Examples | None, frames: int, method: str) -> Examples:
    """Return labels that a take of so many frames can be learned from.

    Raises:
        InputError: there are none, one lies outside of the take, or one frame has two different ones.
    """
    if examples is None or not len(examples.frames) or np.isnan(examples.values).all():
        raise InputError(
            f"the method {method!r} learns from labelled frames, but there are none; give at least one, better 10 that "
            "show different expressions."
        )
    if examples.frames.max() >= frames:
        outside = [int(f) for f in examples.frames if f >= frames]
        raise InputError(
            f"{len(outside)} labels lie outside of the training take of {frames} frames (0 … {frames - 1}): "
            f"frames {', '.join(map(str, outside[:6]))}. Correct them, or give the take that was labelled."
        )
    for frame in np.flatnonzero(np.bincount(examples.frames) > 1):
        twins = examples.values[examples.frames == frame]
        known = twins[:, ~np.isnan(twins).all(axis=0)]
        apart = np.nanmax(known, axis=0, initial=-np.inf) - np.nanmin(known, axis=0, initial=np.inf)
        if (apart > 1e-9).any():
            worst = np.flatnonzero(~np.isnan(twins).all(axis=0))[int(np.argmax(apart))]
            given = ", ".join(f"{v:g}" for v in twins[:, worst] if not np.isnan(v))
            raise InputError(
                f"frame {frame} is labelled {len(twins)} times with different poses: {examples.names[worst]!r} is {given}; "
                "keep the right one."
            )
    return _once(examples)


def _once(examples: Examples) -> Examples:
    """Merge labels that repeat a frame, and leave out parameters that no label gives."""
    frames, place = np.unique(examples.frames, return_inverse=True)
    values = np.full((len(frames), len(examples.names)), np.nan)
    for row, at in zip(examples.values, place.ravel(), strict=True):
        values[at] = np.where(np.isnan(values[at]), row, values[at])
    given = ~np.isnan(values).all(axis=0)
    names = tuple(name for name, known in zip(examples.names, given, strict=True) if known)
    return Examples(frames, names, values[:, given])


def unlabelled(take: Floats, labelled: Ints, count: int) -> Ints:
    """Return at most `count` frames of a take `(F, d)`, evenly over those that are whole and not labelled."""
    free = np.setdiff1d(np.arange(len(take)), labelled)
    whole = free[~np.isnan(take[free]).any(axis=1)]
    free = whole if len(whole) >= min(count, len(free)) else free[~np.isnan(take[free]).all(axis=1)]
    return free[_evenly(len(free), count)]


def _evenly(length: int, count: int) -> Ints:
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
    return float(np.clip(noise / spread, 0.003, 1.0)), float(np.clip(change / spread, 0.01, 10.0))
