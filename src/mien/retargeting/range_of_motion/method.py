"""`range-of-motion`: actor-specific blendshapes with no examples at all (Ribera et al. 2017).

The steps are separate and each can be looked at: similarity, key expressions, the
actor's own shapes (refitted, or aligned as published), solve.

Differs from the paper: see `docs/range-of-motion.md`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from scipy import sparse

from mien.capture import Neutral
from mien.core import Clip, Correspondence, Examples, InputError, Markers, Note, Rig
from mien.core.arrays import Flags, Floats, Ints
from mien.core.errors import unknown
from mien.geometry.laplacian import cotangent_laplacian, triangulate_markers
from mien.retargeting.initial import warped_shapes
from mien.retargeting.labelled import checked_examples
from mien.retargeting.prepare import Prepared, prepare
from mien.retargeting.range_of_motion.alignment import Balance, alignment_problem
from mien.retargeting.range_of_motion.keys import Keys, key_expressions
from mien.retargeting.range_of_motion.refit import Refit, Take, personalise
from mien.retargeting.range_of_motion.second_opinion import heard, second_opinion
from mien.retargeting.range_of_motion.similarity import Similarity, similarity
from mien.retargeting.settings import PAPER, SolveSettings, in_range
from mien.retargeting.shape_retargeter import ShapeRetargeter, check_markers, shape_retargeter
from mien.solve import solve_sylvester


@dataclass(frozen=True, eq=False)
class Alignment:
    """What the fit found on the way, for reports and for looking into.

    Attributes:
        similarity: of every shape to every frame.
        keys: the key expressions.
        original: `(K, M, 3)` the character's shapes, scaled and turned onto the actor [cm].
        guess: `(K, M, 3)` what the shapes were found from: the warp for `alignment`, else `original` and what the
            generic rig makes of the same names [cm].
        personal: `(K, M, 3)` the actor's own blendshapes [cm].
        residual: relative residual of the alignment's normal equations; 0 for `refit`, which has none.
        opinion: for `refit`, the generic rig's share in the guess, by region of the face; empty where it has no say.
        notes: why it has none, if it could have had one.
    """

    similarity: Similarity
    keys: Keys
    original: Floats
    guess: Floats
    personal: Floats
    residual: float
    opinion: Mapping[str, float]
    notes: tuple[Note, ...] = ()


@dataclass(frozen=True)
class RangeOfMotion:
    """The range-of-motion method.

    Attributes:
        shapes: how the actor's own blendshapes are found: `refit` (the default, see
            `refit`), or `alignment`, the manifold alignment as published (eq. 4).
        full_range: for `refit`, whether the training take shows what it shows at full strength.
        second_opinion: for `refit`, whether the generic rig's shapes of the same names are asked too.
        steepness: `r` of eq. 7.
        mesh: α of eq. 4, on keeping the shape of the initial guess.
        cross: β of eq. 4, on keeping the relations among blendshapes.
        prominence: how far a key expression must stand out (0: every local maximum).
        keep: frames below this share of a shape's best similarity have no say (0: all have).
        smoothing: of the warp behind the initial guess (0: interpolating).
        refit: the scales of `refit`.
        solve: the per-frame solve.
    """

    name: ClassVar[str] = "range-of-motion"
    about: ClassVar[str] = (
        "the character's shapes aligned with the actor's range of motion, no examples (Ribera et al. 2017)"
    )
    needs: ClassVar[str] = "markers or an animated face, pairs or landmarks"
    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = {"paper": {"shapes": "alignment", **PAPER}}

    shapes: str = "refit"
    full_range: bool = True
    second_opinion: bool = True
    steepness: float = 15.0
    mesh: float = 0.01
    cross: float = 0.1
    prominence: float = 0.0
    keep: float = 0.0
    smoothing: float = 0.0
    refit: Refit = field(default_factory=Refit)
    solve: SolveSettings = field(default_factory=SolveSettings)

    def __post_init__(self) -> None:
        if self.shapes not in ("refit", "alignment"):
            raise InputError(unknown("way to find the actor's shapes", self.shapes, ("refit", "alignment")))
        in_range(self, steepness=(0, 500), mesh=(0, np.inf), cross=(0, np.inf), prominence=(0, 1), keep=(0, 1))
        in_range(self, smoothing=(0, np.inf))

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
    ) -> ShapeRetargeter:
        """Align a character's blendshapes with an actor's training take.

        Args:
            character: the rig.
            training: markers that cover the actor's range of motion.
            pairs: which marker is which point of the character.
            neutral: the actor at rest; found in the take if None.
            rigid: markers known to ride on the skull.
            head_moves: whether there is head motion to take out.
            examples: frames labelled with weights of shapes.  `refit` holds the weights fixed and takes the
                strength of shapes from them; for `alignment` they replace the automatic similarities of those
                shapes (§6.3).

        Raises:
            InputError: as `prepare`; or an example names an unknown shape or frame.
        """
        take, correspondence = check_markers(training, pairs, self.name)
        prepared = prepare(character, take, correspondence, neutral=neutral, rigid=rigid, head_moves=head_moves)
        alignment = self.align(prepared, character, examples)
        evidence, notes = evidence_of(alignment, prepared.terms.deltas, character.blendshapes.names)
        notes = (*notes, *alignment.notes, *_opinion_note(alignment.opinion))
        return shape_retargeter(
            self.name, character, prepared, alignment.personal, self.solve, evidence, notes, alignment
        )

    def align(self, prepared: Prepared, character: Rig, examples: Examples | None = None) -> Alignment:
        """Find the actor's own blendshapes: similarity, key expressions, alignment (§4)."""
        names, shapes = character.blendshapes.names, prepared.terms.deltas
        remarks: tuple[Note, ...] = ()
        if examples is not None:
            examples, remarks = _usable(checked_examples(examples, len(prepared.take), self.name), prepared.take)
        if self.shapes == "refit":
            prepared, repairs = _completed(prepared, names, self.solve.off)
            remarks += repairs
        frames = np.flatnonzero(~np.isnan(prepared.take).any(axis=(1, 2)))
        if not len(frames):
            raise InputError(
                "every frame of the training take misses too many paired markers; leave the worst ones out of the pairs."
            )
        alike = similarity(prepared.take[frames], shapes, self.steepness)
        enhanced, labelled = _with_examples(alike.enhanced, frames, names, examples)
        keys = key_expressions(enhanced, self.prominence)
        chosen = np.union1d(keys.frames, labelled)
        weights = _strongest(enhanced[:, chosen], self.keep)
        opinion: Mapping[str, float] = {}
        notes: tuple[Note, ...] = ()
        residual = 0.0
        if self.shapes == "alignment":
            guess, personal, residual = self._aligned(prepared, frames[chosen], weights, alike.between)
        else:
            take = replace(
                _take_of(prepared, frames, names, self.solve.off, examples), correctives=character.correctives
            )
            guess, opinion, notes = self._informed(prepared, character, take)
            personal = personalise(guess, take, self.refit, full_range=self.full_range)
        count = len(prepared.take)
        kept = Similarity(
            _over_take(alike.correlation, frames, count),
            alike.trust,
            _over_take(enhanced, frames, count),
            alike.between,
        )
        found = Keys(frames[chosen], _over_take(keys.cumulative, frames, count))
        return Alignment(kept, found, shapes, guess, personal, residual, opinion, (*remarks, *notes))

    def _aligned(
        self, prepared: Prepared, frames: Ints, weights: Floats, between: Floats
    ) -> tuple[Floats, Floats, float]:
        """Align as published (eq. 4); return the guess it starts from, the shapes, and the residual."""
        terms = prepared.terms
        guess = warped_shapes(terms, self.smoothing)
        laplacian, balance = marker_laplacian(terms.actor_neutral), Balance(self.mesh, self.cross)
        problem = alignment_problem(weights, prepared.take[frames], terms.deltas, guess, between, laplacian, balance)
        solution = solve_sylvester(problem.left, problem.right, problem.load, problem.guess)
        return guess, solution.P, solution.residual

    def _informed(
        self, prepared: Prepared, character: Rig, take: Take
    ) -> tuple[Floats, dict[str, float], tuple[Note, ...]]:
        """Return what the shapes are refitted from, the second opinion's share in each region, and why it has none."""
        own = prepared.terms.deltas
        if not self.second_opinion:
            return own, {}, ()
        opinion, notes = second_opinion(character, prepared)
        if opinion is None:
            return own, {}, notes
        return *heard(own, opinion, take, self.refit, full_range=self.full_range), notes


def marker_laplacian(neutral: Floats) -> sparse.csr_matrix:
    """Return the cotangent Laplacian of the triangulated markers (§4.4)."""
    return cotangent_laplacian(neutral, triangulate_markers(neutral))


def evidence_of(
    alignment: Alignment, shapes: Floats, names: Sequence[str]
) -> tuple[dict[str, float], tuple[Note, ...]]:
    """Say how well the take shows each shape: its best correlation with a key expression.

    Returns:
        Per shape between 0 and 1, and notes on shapes that the markers cannot see or the
        take does not show.
    """
    size = np.linalg.norm(shapes, axis=2).max(axis=1)
    best = np.maximum(alignment.similarity.correlation, 0).max(axis=1)
    unseen = size < UNSEEN_CM
    best[unseen] = 0
    notes = []
    blind = [n for n, u in zip(names, unseen, strict=True) if u]
    weak = [n for n, b, u in zip(names, best, unseen, strict=True) if b < WEAK_EVIDENCE and not u]
    if blind:
        notes.append(
            Note("shapes-unseen", f"{len(blind)} shapes move no paired point and stay at rest: {', '.join(blind)}.")
        )
    if weak:
        text = (
            f"{len(weak)} shapes have no frame in the training take that looks mainly like them; their direction is "
            f"not the take's: {', '.join(weak)}."
        )
        notes.append(Note("shapes-without-evidence", text))
    return {n: round(float(b), 4) for n, b in zip(names, best, strict=True)}, tuple(notes)


UNSEEN_CM = 0.02
"""A shape that moves no paired point by this much cannot be told from noise."""
WEAK_EVIDENCE = 0.3
"""Below this correlation no frame of the take looks like the shape."""
MISSING = 0.5
"""Frames that miss more than this share of the points say too little."""


def _opinion_note(shares: Mapping[str, float]) -> tuple[Note, ...]:
    said = ", ".join(f"{region} {share:.0%}" for region, share in shares.items() if share > 0)
    if not said:
        return ()
    text = (
        "the take is explained better if the built-in generic rig's shapes of the same names are heard beside the "
        f"character's own: {said}."
    )
    return (Note("second-opinion", text),)


def _take_of(
    prepared: Prepared, frames: Ints, names: Sequence[str], off: Sequence[str], examples: Examples | None
) -> Take:
    """Return what the shapes are found from."""
    labels = np.full((0 if examples is None else len(examples.frames), len(names)), np.nan)
    labelled = np.empty(0, np.int64)
    if examples is not None:
        labels[:, [list(names).index(name) for name in examples.names]] = examples.values
        labelled = examples.frames
    confidence = np.asarray(prepared.pairs.confidence)
    return Take(names, prepared.take[frames], confidence, off, prepared.take[labelled], labels)


def _completed(prepared: Prepared, names: Sequence[str], off: Sequence[str]) -> tuple[Prepared, tuple[Note, ...]]:
    """Put points that a frame misses where its other points put them, if it sees at least half of all; count such frames."""
    missing: Flags = np.isnan(prepared.take[..., 0])
    gappy = np.flatnonzero(missing.any(axis=1) & (missing.mean(axis=1) <= MISSING))
    if not len(gappy):
        return prepared, ()
    take, shapes = _take_of(prepared, gappy, names, off, None), prepared.terms.deltas
    fitted = np.tensordot(take.weights(shapes, take.frames, 1.0), shapes, axes=1)
    filled = prepared.take.copy()
    filled[gappy] = np.where(missing[gappy][..., None], fitted, take.frames)
    text = (
        f"{len(gappy)} of {len(missing)} frames of the training take miss some markers, which were put where the others "
        "have them."
    )
    return replace(prepared, take=filled), (Note("frames-completed", text),)


def _usable(examples: Examples, take: Floats) -> tuple[Examples, tuple[Note, ...]]:
    """Leave out labelled frames that see less than half of the points; say which."""
    blind = np.isnan(take[examples.frames, :, 0]).mean(axis=1) > MISSING
    if not blind.any():
        return examples, ()
    listed = ", ".join(map(str, examples.frames[blind][:6]))
    text = f"{int(blind.sum())} labelled frames miss more than half of the paired markers and are left out: {listed}."
    kept = Examples(examples.frames[~blind], examples.names, examples.values[~blind])
    return kept, (Note("labels-unseen", text, f"frame {examples.frames[blind][0]}"),)


def _over_take(values: Floats, frames: Ints, count: int) -> Floats:
    """Spread columns over all frames of the take; 0 where a marker was missing."""
    spread = np.zeros((*values.shape[:-1], count))
    spread[..., frames] = values
    return spread


def _strongest(weights: Floats, keep: float) -> Floats:
    return np.where(weights >= keep * weights.max(axis=1, keepdims=True), weights, 0.0)


def _with_examples(
    enhanced: Floats, frames: Ints, names: Sequence[str], examples: Examples | None
) -> tuple[Floats, Ints]:
    """Replace the similarities of labelled shapes by their labels; return the labelled columns too.

    A labelled frame that misses a point is not compared with anything, so it has no column.
    """
    if examples is None:
        return enhanced, np.empty(0, np.int64)
    for name in examples.names:
        if name not in names:
            raise InputError(f"the examples label an {unknown('blendshape', name, names)}")
    result = enhanced.copy()
    compared = np.isin(examples.frames, frames)
    columns = np.searchsorted(frames, examples.frames[compared])
    for name, values in zip(examples.names, examples.values[compared].T, strict=True):
        shown = np.nan_to_num(values) > 0
        if shown.any():
            row = np.zeros(enhanced.shape[1])
            row[columns[shown]] = values[shown]
            result[list(names).index(name)] = row
    return result, np.unique(columns)
