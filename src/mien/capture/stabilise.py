"""Taking the head's motion out of the face's, and keeping it for the character."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mien.core.arrays import Floats, Ints
from mien.core.errors import InputError
from mien.core.units import human_centimetre
from mien.geometry.align import head_motion, inverse_rigid, transform

SOFTNESS_CM = 0.15
"""A point this far off the skull's motion, on a human face, has lost three quarters of its say."""
QUIETEST = 1 / 3
"""At least this share of the points keeps a say: left to fewer and fewer, the last two always agree."""


@dataclass(frozen=True, eq=False)
class Stabiliser:
    """What is needed to hold a head still: the face at rest and how much each point moves on it.

    Attributes:
        neutral: `(M, 3)` the face at rest.
        stability: `(M,)` each point's say in where the skull is; 0 leaves it out.
        softness: the residual at which a point loses most of its say in a frame, in the unit of the points.
    """

    neutral: Floats
    stability: Floats
    softness: float

    def __call__(self, points: Floats) -> tuple[Floats, Floats]:
        """Hold the head still.

        Args:
            points: `(F, M, 3)`, NaN where missing.

        Returns:
            The points with the head at rest `(F, M, 3)`, and the motion taken out `(F, 4, 4)`.
        """
        motion, _ = head_motion(self.neutral, points, self.stability, softness=self.softness)
        return transform(inverse_rigid(motion), points), motion


def learn_stabiliser(neutral: Floats, points: Floats, rigid: Ints | Sequence[int] = ()) -> Stabiliser:
    """Learn from a take which points ride rigidly on the skull.

    Points that keep moving against the rest (jaw, lips, brows) lose their say for the
    whole take, on top of the frame-by-frame reweighting; in a take that moves the whole
    face, what counts as moving is measured by its quietest third.  Naming rigid points
    (a headband, the nose bridge) leaves the others out altogether.

    Args:
        neutral: `(M, 3)`.
        points: `(F, M, 3)` the training take, NaN where missing.
        rigid: indices of points known to ride on the skull; at least 3, or none.

    Raises:
        InputError: one or two rigid points, which cannot fix a head.
    """
    softness = SOFTNESS_CM * human_centimetre(neutral)
    chosen = np.asarray(rigid, dtype=np.int64)
    if len(chosen):
        if len(chosen) < 3:
            raise InputError(f"{len(chosen)} rigid markers cannot fix the head's motion; name at least 3, or none.")
        stability = np.zeros(len(neutral))
        stability[chosen] = 1
        return Stabiliser(neutral, stability, softness)
    stability = np.ones(len(neutral))
    take = points[:: max(1, len(points) // 600)]
    for _ in range(4):
        _, residuals = head_motion(neutral, take, stability, softness=softness)
        spread = _mostly_within(residuals)
        known = spread[np.isfinite(spread)]
        scale = max(softness, float(np.quantile(known, QUIETEST))) if len(known) else softness
        stability = 1 / (1 + (spread / scale) ** 2) ** 2
    return Stabiliser(neutral, stability, softness)


def _mostly_within(residuals: Floats) -> Floats:
    """Return `(M,)` what four fifths of each point's residuals `(F, M)` stay within; infinite if it is never seen."""
    gaps = np.isnan(residuals)
    spread = np.full(residuals.shape[1], np.inf)
    whole = ~gaps.any(axis=0)
    if whole.any():
        spread[whole] = np.quantile(residuals[:, whole], 0.8, axis=0)
    for m in np.flatnonzero(gaps.any(axis=0) & ~gaps.all(axis=0)):
        spread[m] = np.quantile(residuals[~gaps[:, m], m], 0.8)
    return spread
