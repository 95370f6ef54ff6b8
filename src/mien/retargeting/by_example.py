"""What methods share that learn from labelled frames: from takes and characters to rows of numbers, and back.

A character's parameters may be anything with numbers; the names and values of the
labelled frames say what they are.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from mien.capture import Neutral
from mien.core import Clip, Correspondence, Examples, InputError, Markers, Note, Report, Rig
from mien.core.arrays import Flags, Floats
from mien.core.errors import unknown
from mien.geometry.align import Similarity
from mien.io.table import ranges
from mien.retargeting.divide import divided
from mien.retargeting.labelled import checked_examples, doubts, evenly, unlabelled
from mien.retargeting.regions import Apart, ApartModel, KnowsPoses
from mien.retargeting.rows import ChannelRows, MarkerRows, read_training
from mien.retargeting.samples import Learner, Learnt, Samples
from mien.retargeting.settings import in_range


@dataclass(frozen=True, eq=False)
class ExampleRetargeter:
    """A learned map and how frames become its rows.

    Attributes:
        method: the method's name.
        names: `K` parameters of the character.
        reading: how frames become rows.
        learnt: the map.
        fps: frame rate of the training take.
        labels: what was learned from.
        shown: `(l, d)` rows of the labelled frames.
        figures: of the fit, for the report.
        bounds: lowest and highest value of a parameter, or None.
        notes: of the fit.
    """

    method: str
    names: tuple[str, ...]
    reading: MarkerRows | ChannelRows
    learnt: Learnt
    fps: float
    labels: Examples
    shown: Floats
    figures: Mapping[str, Any]
    bounds: tuple[float, float] | None = None
    notes: tuple[Note, ...] = ()

    @property
    def markers(self) -> tuple[str, ...] | None:
        """Names of the actor's points; None if frames are weights."""
        return self.reading.names if isinstance(self.reading, MarkerRows) else None

    @property
    def placement(self) -> Similarity | None:
        """From the actor's space to the character's; None if frames are weights."""
        return self.reading.placement if isinstance(self.reading, MarkerRows) else None

    @property
    def knows_poses(self) -> bool:
        """Whether poses can be completed."""
        parts = [part.learnt for part in self.learnt.parts] if isinstance(self.learnt, Apart) else [self.learnt]
        return all(isinstance(part, KnowsPoses) for part in parts)

    def retarget(self, performance: Any) -> tuple[Clip, Report]:
        """Map a take onto the character.

        Raises:
            InputError: another kind of performance than the training take, a marker or channel
                is unknown, or no frame sees any.
        """
        rows, head = self.rows(performance)
        blind = np.asarray(np.isnan(rows).all(axis=1))
        if blind.all():
            raise InputError("no frame of the performance sees anything that the method was fitted to.")
        notes = [*self.notes, *performance.notes]
        if blind.any():
            text = f"{int(blind.sum())} frames see nothing and hold the frame before: {ranges(np.flatnonzero(blind).tolist())}."
            notes.append(Note("frames-held", text))
        values = self._within(_held(self.learnt.map(rows), blind))
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

    def rows(self, performance: Any) -> tuple[Floats, Floats | None]:
        """Return a take as rows `(F, d)` and the character's head motion `(F, 4, 4)`.

        Raises:
            InputError: another kind of performance, or a marker or channel is unknown.
        """
        wanted = Markers if isinstance(self.reading, MarkerRows) else Clip
        if not isinstance(performance, wanted):
            raise InputError(
                f"the method was fitted to {_KINDS[wanted]}, but the performance is {_KINDS[type(performance)]}; "
                "give the same kind."
            )
        return self.reading.rows(performance)  # type: ignore[arg-type]

    def start(self) -> tuple[Any, Any, Floats | None]:
        """Begin with no frame before."""
        return self.reading.start(), self.learnt.start(), None

    def step(self, state: tuple[Any, Any, Floats | None], frame: Floats) -> tuple[tuple[Any, Any, Floats], Floats]:
        """Map one frame, NaN where missing, to `(K,)` parameters."""
        reading, row = self.reading.step(state[0], frame)
        learnt, values = self.learnt.step(state[1], row)
        if state[2] is not None and np.isnan(row).all():
            values = state[2]
        values = self._within(values)
        return (reading, learnt, values), values

    def complete(self, given: Mapping[str, float]) -> Floats:
        """Complete a pose of which a few parameters are given.

        Args:
            given: by name; what is given stays as it is.

        Returns:
            `(K,)` parameters.

        Raises:
            InputError: nothing is given, a name is unknown, or the method knows no poses.
        """
        if not self.knows_poses:
            raise InputError(
                f"the method {self.method!r} learned how frames become poses, but not what poses there are; to complete "
                "poses, fit with --method latent."
            )
        pose = np.full(len(self.names), np.nan)
        for name, value in given.items():
            if name not in self.names:
                raise InputError(unknown("parameter", name, self.names))
            pose[self.names.index(name)] = value
        assert isinstance(self.learnt, KnowsPoses | Apart)
        found = self.learnt.complete(pose)
        return np.where(np.isnan(pose), self._within(found[0] if isinstance(found, tuple) else found), pose)

    def _within(self, values: Floats) -> Floats:
        return values if self.bounds is None else np.clip(values, *self.bounds)


_KINDS: Mapping[type[Any], str] = {Markers: "markers", Clip: "weights"}


def _held(values: Floats, blind: Flags) -> Floats:
    """Return values `(F, K)` in which rows of blind frames repeat the row before."""
    last = np.maximum.accumulate(np.where(blind, -1, np.arange(len(values))))
    return np.where((last >= 0)[:, None], values[np.maximum(last, 0)], values)


@dataclass(frozen=True)
class ExampleMethod(ABC):
    """A method that learns from labelled frames.

    Attributes:
        count: unlabelled frames taken from the training take, and from the character's animations, evenly.
        bounds: lowest and highest value of a parameter, or None for no bounds.
        animations: existing clips of the character; their frames are targets without a source.
        regions: words in the names of the upper face's parameters, learned apart from the others; `auto` for usual ones.
    """

    name: ClassVar[str]
    about: ClassVar[str]
    needs: ClassVar[str] = "markers, an animated face or weights; a few labelled frames"
    by_example: ClassVar[bool] = True

    count: int = 100
    bounds: tuple[float, float] | None = None
    animations: tuple[Clip, ...] = ()
    regions: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        in_range(self, count=(0, 10_000))
        if self.bounds is not None and not self.bounds[0] < self.bounds[1]:
            raise InputError(f"the bounds must rise, but are {self.bounds[0]:g} … {self.bounds[1]:g}.")

    @abstractmethod
    def learner(self, take: Floats) -> Learner:
        """Return the model for a take `(F, d)`, whose frames follow each other."""

    def fit(
        self,
        character: Rig | None,
        training: Markers | Clip,
        pairs: Correspondence | None = None,
        *,
        neutral: Neutral | None = None,
        rigid: Sequence[str] = (),
        head_moves: bool = True,
        examples: Examples | None = None,
    ) -> ExampleRetargeter:
        """Learn from labelled frames, and from frames that are not.

        Args:
            character: where head motion goes; None if it is parameters alone.
            training: the take that is labelled.
            pairs: which marker is which point of the character; only to place head motion.
            neutral: the actor at rest at the take's markers; found in the take if None.
            rigid: markers that ride on the skull.
            head_moves: whether there is head motion to take out.
            examples: the labels; their names are the parameters.

        Raises:
            InputError: no labels, labels outside of the take, or labels that contradict each other.
        """
        labels = checked_examples(examples, len(training), self.name)
        read = read_training(training, character, pairs, neutral, rigid, head_moves)
        shown = read.take[labels.frames]
        free = unlabelled(read.take, labels.frames, self.count)
        samples = Samples(shown, labels.values, read.take[free], self._targets(labels.names))
        learner = self.learner(read.take)
        figures: dict[str, Any] = {"labels": len(labels.frames)}
        figures["unlabelled"] = [len(samples.X_only), len(samples.Y_only)]
        if self.regions:
            sources, targets = divided(self.regions, labels.names, read.how)
            learner = ApartModel(learner, sources, targets)
            figures["regions"] = [[labels.names[i] for i in region] for region in targets]
        learnt = learner.learn(samples)
        if read.neutral_frame is not None:
            figures["neutral_frame"] = read.neutral_frame
        said = (*read.notes, *doubts(labels, read.take))
        codes = {note.code for note in said}
        notes = (*said, *(note for note in learnt.notes if note.code not in codes))
        return ExampleRetargeter(
            self.name, labels.names, read.how, learnt, read.fps, labels, shown, figures, self.bounds, notes
        )

    def _targets(self, names: tuple[str, ...]) -> Floats:
        """Return rows `(n, K)` of the character's animations, at most `count` of them, evenly."""
        rows = [np.zeros((0, len(names)))]
        for clip in self.animations:
            if not set(names) & set(clip.names):
                raise InputError(
                    f"the character's animation ({', '.join(clip.names[:5])} …) shares no parameter with the labels "
                    f"({', '.join(names[:5])} …)."
                )
            values = np.where(np.isin(names, clip.names), clip.channels(names), np.nan)
            rows.append(values[~np.isnan(values).all(axis=1)])
        every = np.concatenate(rows)
        return every[evenly(len(every), self.count)]
