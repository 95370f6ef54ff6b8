"""`copy`: same name, same weight.  The baseline whenever both sides share a vocabulary."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from mien.capture import Neutral
from mien.core import Clip, Correspondence, Examples, InputError, Markers, Note, Report, Rig
from mien.core.arrays import Floats
from mien.vocabularies import match


@dataclass(frozen=True, eq=False)
class Copier:
    """A fixed map from the performance's channels to the character's shapes.

    Attributes:
        sources: `J` channel names of the performance.
        names: `K` shape names of the character.
        matrix: `(K, J)`, so that weights are `matrix @ values`.
        notes: names that only one side has.
    """

    sources: tuple[str, ...]
    names: tuple[str, ...]
    matrix: Floats
    notes: tuple[Note, ...] = ()

    def retarget(self, performance: Clip) -> tuple[Clip, Report]:
        """Copy a clip's weights; frames without tracking hold the last good one."""
        values, lost = held(performance.channels(self.sources))
        notes = list(self.notes) + list(performance.notes)
        if lost:
            notes.append(Note("frames-held", f"{lost} frames without tracking hold the last good frame."))
        clip = Clip(
            self.names,
            values @ self.matrix.T,
            performance.fps,
            performance.head,
            performance.eyes,
            start=performance.start,
        )
        return clip, Report("copy", np.zeros(0), notes=tuple(notes))

    def start(self) -> Floats:
        """Begin at the neutral."""
        return np.zeros(len(self.names))

    def step(self, state: Floats, frame: Floats) -> tuple[Floats, Floats]:
        """Copy one frame `(J,)`; NaN holds the last."""
        weights = state if np.isnan(frame).any() else self.matrix @ frame
        return weights, weights


@dataclass(frozen=True)
class Copy:
    """Give each shape the weight of the channel that means the same."""

    name: ClassVar[str] = "copy"
    about: ClassVar[str] = "same name, same weight, in any spelling, split or merged sides"
    needs: ClassVar[str] = "weights with names the character shares"

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
    ) -> Copier:
        """Match the names of a clip's channels to a character's shapes; the rest is not used.

        Raises:
            InputError: the performance is markers, or no name is shared.
        """
        del pairs, neutral, rigid, head_moves, examples
        if not isinstance(training, Clip):
            raise InputError(
                "the method 'copy' maps weights to weights, but the performance is markers; use range-of-motion."
            )
        found = match(training.names, character.blendshapes.names)
        if not found.matrix.any():
            raise InputError(
                f"no channel of the performance ({', '.join(training.names[:6])} …) means the same as a shape of {character.name} "
                f"({', '.join(character.blendshapes.names[:6])} …); give the actor's rig with --actor and use range-of-motion."
            )
        notes = []
        for code, side, names in (
            ("channels-unused", "channels of the performance have no shape", found.unmatched_source),
            ("shapes-undriven", "shapes of the character have no channel", found.unmatched_target),
        ):
            if names:
                notes.append(
                    Note(code, f"{len(names)} {side}: {', '.join(names[:12])}{' …' if len(names) > 12 else ''}.")
                )
        return Copier(training.names, character.blendshapes.names, found.matrix, tuple(notes))


def held(values: Floats) -> tuple[Floats, int]:
    """Replace NaN rows by the last good row (the first good one at the start); count them.

    Raises:
        InputError: no row is good.
    """
    good = ~np.isnan(values).any(axis=1)
    if not good.any():
        raise InputError("no frame of the performance has values: tracking was lost throughout.")
    last = np.maximum.accumulate(np.where(good, np.arange(len(values)), -1))
    last[last < 0] = np.argmax(good)
    return values[last], int((~good).sum())
