"""`example-based`: the actor's shapes from a few frames whose weights are roughly known (Li, Weise, Pauly 2010).

Set up as the range-of-motion paper does to compare itself with it (§6.1): 15 examples, those frames of the
training take closest to the centres that k-means finds; the generic rig warped onto the actor to begin
with; and the weights that the range-of-motion method gives those frames as a first guess.  Frames that a
person has labelled are the examples instead, with their labels for the guess.  On a rig with correctives
the first guess keeps to them, and the weights that follow are free.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from mien.capture import Neutral
from mien.core import Clip, Correspondence, Examples, InputError, Markers, Note, Rig
from mien.core.arrays import Floats, Ints
from mien.core.errors import unknown
from mien.retargeting.actor_shapes import actor_shapes, check_shapes
from mien.retargeting.energy import frame_solver
from mien.retargeting.example_based.choose import distinct_frames
from mien.retargeting.example_based.edges import marker_edges
from mien.retargeting.example_based.rigging import Rigged, Rigging, Schedule, rig_by_example
from mien.retargeting.initial import warped_shapes
from mien.retargeting.labelled import checked_examples
from mien.retargeting.prepare import Prepared, prepare
from mien.retargeting.settings import SolveSettings, in_range
from mien.retargeting.shape_retargeter import ShapeRetargeter, check_markers, shape_retargeter

SHOWN = 0.1
"""A shape whose weight stays below this in all examples is not shown by any."""


@dataclass(frozen=True)
class ExampleBased:
    """The example-based method.

    Attributes:
        count: examples taken from the training take, if none are labelled.
        first_weights: whose shapes give the examples' first weights: `range-of-motion`, `alignment` or `rbf`.
        full_range: for `range-of-motion`, whether the training take shows what it shows at full strength.
        schedule: how strongly the guesses hold.
        solve: the per-frame solve.
    """

    name: ClassVar[str] = "example-based"
    about: ClassVar[str] = "shapes fitted to a few distinct frames of the take (Li et al. 2010); a comparator"
    needs: ClassVar[str] = "markers or an animated face, pairs or landmarks; labelled frames if there are any"

    count: int = 15
    first_weights: str = "range-of-motion"
    full_range: bool = True
    schedule: Schedule = field(default_factory=Schedule)
    solve: SolveSettings = field(default_factory=SolveSettings)

    def __post_init__(self) -> None:
        check_shapes(self.first_weights)
        in_range(self, count=(1, 10_000))

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
        """Fit the actor's shapes to examples.

        Args:
            character: the rig.
            training: markers; where the examples come from.
            pairs: which marker is which point of the character.
            neutral: the actor at rest; found in the take if None.
            rigid: markers known to ride on the skull.
            head_moves: whether there is head motion to take out.
            examples: labelled frames to use; shapes that are not labelled there get their first weights as usual.

        Raises:
            InputError: as `range-of-motion`; or a labelled frame misses a marker.
        """
        take, correspondence = check_markers(training, pairs, self.name)
        prepared = prepare(character, take, correspondence, neutral=neutral, rigid=rigid, head_moves=head_moves)
        names = character.blendshapes.names
        frames, rigged = self.rig(prepared, character, examples)
        notes = _remarks(frames, rigged, names, self.solve)
        return shape_retargeter(self.name, character, prepared, rigged.shapes, self.solve, notes=notes)

    def rig(self, prepared: Prepared, character: Rig, examples: Examples | None = None) -> tuple[Ints, Rigged]:
        """Return the frames used as examples, and what was fitted to them."""
        names, correctives = character.blendshapes.names, character.correctives
        labels = None if examples is None else checked_examples(examples, len(prepared.take), self.name)
        frames = distinct_frames(prepared.take, self.count) if labels is None else labels.frames
        shown = prepared.take[frames]
        if not len(frames) or np.isnan(shown).any():
            raise InputError(
                "the method 'example-based' needs frames that see every paired marker, but "
                + ("none does" if not len(frames) else f"labelled frame {_blind(frames, shown)} does not")
                + "; leave the worst markers out of the pairs, or label other frames."
            )
        solve = self.solve
        first = actor_shapes(
            self.first_weights, prepared, character, solve, full_range=self.full_range, examples=labels
        )
        none = np.zeros((len(names), len(names)))
        solver = frame_solver(first, names, none, np.asarray(prepared.pairs.confidence), solve, correctives=correctives)
        guess = np.stack([solver.step(moved, None) for moved in shown])
        if labels is not None:
            guess = _labelled(guess, labels, names)
        generic = warped_shapes(prepared.terms)
        edges = marker_edges(prepared.terms.actor_neutral)
        problem = Rigging(edges, shown, generic, guess, solver.lower, solver.upper)
        return frames, rig_by_example(problem, self.schedule)


def _blind(frames: Ints, shown: Floats) -> int:
    return int(frames[np.isnan(shown).any(axis=(1, 2))][0])


def _labelled(guess: Floats, labels: Examples, names: Sequence[str]) -> Floats:
    """Return the first weights `(J, K)`, those that are labelled replaced by their labels."""
    result = guess.copy()
    for name, values in zip(labels.names, labels.values.T, strict=True):
        if name not in names:
            raise InputError(f"the examples label an {unknown('blendshape', name, names)}")
        column = list(names).index(name)
        result[:, column] = np.where(np.isnan(values), result[:, column], values)
    return result


def _remarks(frames: Ints, rigged: Rigged, names: Sequence[str], solve: SolveSettings) -> tuple[Note, ...]:
    """Return which frames were used, and which shapes none of them shows."""
    listed = ", ".join(map(str, frames[:20]))
    used = Note("examples", f"{len(frames)} frames of the training take are the examples: {listed}.")
    off = solve.kept_at_rest(names)
    strongest = np.abs(rigged.weights).max(axis=0)
    weak = [name for name, most in zip(names, strongest, strict=True) if most < SHOWN and name not in off]
    if not weak:
        return (used,)
    text = f"{len(weak)} shapes are in none of the examples and stay the character's own, warped: {', '.join(weak)}."
    return used, Note("shapes-without-evidence", text)
