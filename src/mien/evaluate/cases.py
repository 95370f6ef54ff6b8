"""A case: an actor and a character of equal semantics, what a method may see, and the right answer."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from mien.capture import Neutral, trace
from mien.core import Blendshapes, Clip, Correspondence, Examples, InputError, Markers, Rig, SurfacePoints
from mien.core.arrays import Floats, Ints
from mien.evaluate.conditions import Conditions, captured
from mien.evaluate.metrics import millimetre
from mien.evaluate.truth import Semantics, shown_range
from mien.evaluate.yardstick import Yardstick, yardstick
from mien.geometry.correspond import mesh_points, place, spread_points
from mien.io.documents import join
from mien.retargeting.prepare import Prepared, prepare
from mien.vocabularies import match

UNSEEN = 0.02
"""A shape that moves no paired point by this share of a centimetre on a human face cannot be seen."""


@dataclass(frozen=True, eq=False)
class Case:
    """Everything to try a method on.

    A method sees `character`, `pairs`, `training`, `test`, `neutral` and `head_moves`;
    the rest is the truth.

    Attributes:
        name: `actor>character take`, and what is special.
        actor: the rig with the actor's true shapes.
        character: the rig.
        pairs: which marker is which point of the character (and of the actor).
        training: `F'` frames of markers that cover the range of motion.
        test: `F` frames of markers.
        neutral: the actor at rest, or None if it is to be found.
        head_moves: whether head motion is mixed in.
        recording: the test's weights in the names they were recorded in.
        truth: `F` frames of the character's true weights, as recorded.
        truth_range: the same, of the range shown in training.
        lesson: the same of the training take, frame for frame: what a person would label it with.
        true_shapes: `(K, M, 3)` the actor's own version of each shape of the character, in the actor's unit.
        range_shapes: the same at the full range of the training take.
        seen: `(K,)` shapes that the actor has and that move a paired point.
        shown: `(K,)` those among them that the training take shows.
        stride: the vertex error, which takes longest, is measured every so many frames.
    """

    name: str
    actor: Rig
    character: Rig
    pairs: Correspondence
    training: Markers
    test: Markers
    neutral: Neutral | None
    head_moves: bool
    recording: Clip
    truth: Clip
    truth_range: Clip
    lesson: Clip
    true_shapes: Floats
    range_shapes: Floats
    seen: np.ndarray
    shown: np.ndarray
    stride: int = 1

    @cached_property
    def prepared(self) -> Prepared:
        """The training take beside the character, in common terms."""
        return prepare(self.character, self.training, self.pairs, neutral=self.neutral, head_moves=self.head_moves)

    @cached_property
    def yardsticks(self) -> dict[str, Yardstick]:
        """The two truths, by name, ready for results to be measured against."""
        unit = millimetre(self.character)
        truths = {"absolute": (self.truth, self.seen), "range": (self.truth_range, self.shown)}
        return {
            name: yardstick(self.character, np.asarray(clip.values), counted, unit, self.stride)
            for name, (clip, counted) in truths.items()
        }

    def labels(self, frames: Ints) -> Examples:
        """Return the right answer at some frames of the training take."""
        return Examples(frames, self.lesson.names, np.asarray(self.lesson.values)[frames])

    def shapes(self, truth: str) -> Floats:
        """Return the actor's own shapes in one of the truths, `(K, M, 3)` [cm of a human face]."""
        shapes = self.true_shapes if truth == "absolute" else self.range_shapes
        return np.asarray(shapes / self.prepared.terms.centimetre)


def make_case(
    name: str,
    actor: Rig,
    character: Rig,
    meanings: Semantics,
    pairs: Correspondence,
    training: Clip,
    test: Clip,
    conditions: Conditions,
    *,
    stride: int = 1,
    neutral_known: bool = True,
) -> Case:
    """Let an actor perform and work out what is right.

    Args:
        name: what to call it.
        actor: the rig of the actor, with landmarks.
        character: the rig, with landmarks.
        meanings: of the character's shapes in the actor's.
        pairs: with points on the actor.
        training: recorded weights in any spelling of the actor's names; frames of NaN are left out.
        test: the same, of the take to retarget.
        conditions: of the capture.
        stride: measure the vertex error every so many frames.
        neutral_known: whether the method is given the neutral or has to find it.

    Raises:
        InputError: the pairs have no points on the actor.
    """
    if pairs.source is None:
        raise InputError("a case needs pairs with points on the actor's mesh; make them from landmarks or vertices.")
    rng = np.random.default_rng(conditions.seed)
    unit = millimetre(actor)
    played = {"training": on_actor(_tracked(training), actor), "test": on_actor(_tracked(test), actor)}
    takes = {
        key: captured(trace(actor, clip, pairs.source, pairs.names), conditions, unit, rng)
        for key, clip in played.items()
    }
    full, shown = shown_range(played["training"].values)
    seen = meanings.driven & visible(character, pairs)
    kept = _tracked(test)
    weights = np.asarray(played["test"].values)
    names = character.blendshapes.names
    deltas = pairs.source.of(actor.blendshapes.deltas)
    return Case(
        name,
        actor,
        character,
        pairs,
        takes["training"],
        takes["test"],
        Neutral(pairs.source.of(actor.neutral.vertices), None, float("nan")) if neutral_known else None,
        conditions.head,
        kept,
        Clip(names, weights @ meanings.drivers.T * seen, kept.fps),
        Clip(names, (weights / full) @ meanings.drivers.T * seen, kept.fps),
        Clip(names, (np.asarray(played["training"].values) / full) @ meanings.drivers.T * seen, training.fps),
        np.tensordot(meanings.parts, deltas, axes=1),
        np.tensordot(meanings.parts * full, deltas, axes=1),
        seen,
        seen & ~((meanings.drivers > 0) & ~shown).any(axis=1),
        stride,
    )


def on_actor(clip: Clip, actor: Rig) -> Clip:
    """Give recorded weights the actor's own shape names."""
    names = actor.blendshapes.names
    return replace(clip, names=names, values=match(clip.names, names).apply(np.asarray(clip.values)))


def visible(character: Rig, pairs: Correspondence) -> np.ndarray:
    """Return `(K,)` whether each shape moves a paired point enough to be seen."""
    moved = np.linalg.norm(pairs.target.of(character.blendshapes.deltas), axis=2).max(axis=1)
    return np.asarray(moved > UNSEEN * 10 * millimetre(character))


def without(rig: Rig, names: tuple[str, ...]) -> Rig:
    """Return a rig without these shapes."""
    keep = [i for i, name in enumerate(rig.blendshapes.names) if name not in names]
    shapes = Blendshapes(tuple(rig.blendshapes.names[i] for i in keep), rig.blendshapes.deltas[keep])
    return replace(rig, blendshapes=shapes)


def same_vertices(character: Rig, count: int) -> Correspondence:
    """Pair a character with an actor on the same vertices, at points spread over the face.

    Of the evenly spread points with the landmarks among them, the `count` farthest from
    each other are taken, beginning at the tip of the nose.
    """
    landmarks = join(list(character.landmarks.values()))
    spread = spread_points(character.neutral, landmarks, max(count, len(landmarks) + 1))
    points = spread.take(_farthest(spread.of(character.neutral.vertices), count))
    return Correspondence(tuple(f"m{i:02d}" for i in range(count)), points, points)


def across(actor: Rig, character: Rig, count: int) -> Correspondence:
    """Pair an actor with a character of another topology through their landmarks."""
    shared = [name for name in actor.landmarks if name in character.landmarks]
    mine, theirs = join([actor.landmarks[n] for n in shared]), join([character.landmarks[n] for n in shared])
    points = spread_points(actor.neutral, mine, max(count, len(shared) + 1))
    placed = place(mesh_points(actor.neutral, points, mine), mine.of(actor.neutral.vertices), character.neutral, theirs)
    corners, weights = placed.points.corners.copy(), placed.points.weights.copy()
    corners[: len(shared)], weights[: len(shared)] = theirs.corners, theirs.weights
    target = SurfacePoints(corners, weights)
    there = target.of(character.neutral.vertices)
    confidence = np.asarray(placed.confidence).copy()
    confidence[: len(shared)] = 1
    distinct = np.isin(np.arange(len(points)), np.unique(there, axis=0, return_index=True)[1])
    usable = np.flatnonzero(distinct & (confidence > 0))
    rows = usable[_farthest(points.of(actor.neutral.vertices)[usable], min(count, len(usable)))]
    names = tuple(f"m{i:02d}" for i in range(len(rows)))
    return Correspondence(names, target.take(rows), points.take(rows), confidence[rows])


def _farthest(points: Floats, count: int) -> Ints:
    """Return the rows of `count` points, each the farthest from those before, in ascending order."""
    if count >= len(points):
        return np.arange(len(points))
    chosen = [int(np.argmax(points[:, 2]))]
    gap = np.linalg.norm(points - points[chosen[0]], axis=1)
    for _ in range(count - 1):
        chosen.append(int(np.argmax(gap)))
        gap = np.minimum(gap, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return np.sort(np.array(chosen, dtype=np.int64))


def _tracked(clip: Clip) -> Clip:
    good = ~np.isnan(clip.values).any(axis=1)
    return Clip(clip.names, clip.values[good], clip.fps)
