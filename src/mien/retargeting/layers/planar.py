"""Head motion of points tracked in an image: the 2-D counterpart of `geometry.align.head_motion`.

Kholgade, Matthews, Sheikh (2011, §4) track eyes and lips in video and align these 2-D points
to their mean apart from the 3-D markers.  A face that nears the camera grows, so the motion is
a similarity; points that move on the face lose their say, frame by frame.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core import InputError
from mien.core.arrays import Floats
from mien.core.units import human_centimetre

Complexes = NDArray[np.complex128]

SOFTNESS_CM = 0.15
"""A point this far off the head's motion, on a human face, has lost three quarters of its say."""
ROUNDS = 12
"""Rounds of reweighting."""


@dataclass(frozen=True, eq=False)
class PlanarStabiliser:
    """Holds a head still in an image.

    Attributes:
        neutral: `(M, 2)` the points at rest; at least 2.
        softness: the residual at which a point loses most of its say.
    """

    neutral: Floats
    softness: float

    def __call__(self, points: Floats, before: complex = 1 + 0j) -> tuple[Floats, Complexes]:
        """Hold the head still.

        Args:
            points: `(F, M, 2)`, NaN where missing.
            before: the factor of the frame before the first, which a frame with fewer than 2 points keeps.

        Returns:
            The points with the head at rest `(F, M, 2)`, and the motion taken out as complex
            factor and offset `(F, 2)`: a turn and a scale, then a shift.
        """
        rest = self.neutral[:, 0] + 1j * self.neutral[:, 1]
        seen = ~np.isnan(points[..., 0])
        here = np.where(seen, points[..., 0], 0.0) + 1j * np.where(seen, points[..., 1], 0.0)
        weights = seen.astype(np.float64)
        for _ in range(ROUNDS):
            factor, offset = _similarities(rest, here, weights)
            off = np.abs(here - factor[:, None] * rest - offset[:, None])
            weights = seen / (1 + (off / self.softness) ** 2) ** 2
        usable = seen.sum(axis=1) >= 2
        last = np.maximum.accumulate(np.where(usable, np.arange(len(points)), -1))
        factor = np.where(last >= 0, factor[last], before)
        offset = np.where(last >= 0, offset[last], 0.0)
        still = (here - offset[:, None]) / factor[:, None]
        held = np.where(seen[..., None], np.stack([still.real, still.imag], axis=2), np.nan)
        return held, np.stack([factor, offset], axis=1)


def planar_stabiliser(neutral: Floats) -> PlanarStabiliser:
    """Return what holds 2-D points `(M, 2)` still.

    Raises:
        InputError: fewer than 2 points, or all the same.
    """
    if len(neutral) < 2:
        raise InputError(f"{len(neutral)} planar points cannot fix the head in an image; give at least 2.")
    return PlanarStabiliser(neutral, SOFTNESS_CM * human_centimetre(neutral))


def _similarities(rest: Complexes, here: Complexes, weights: Floats) -> tuple[Complexes, Complexes]:
    """Return complex factors and offsets `(F,)` of the weighted least-squares similarities."""
    w = weights / np.maximum(weights.sum(axis=1, keepdims=True), 1e-300)
    centre_rest, centre_here = w @ rest, (w * here).sum(axis=1)
    a, b = rest - centre_rest[:, None], here - centre_here[:, None]
    power = (w * np.abs(a) ** 2).sum(axis=1)
    factor = np.where(power > 0, (w * np.conj(a) * b).sum(axis=1) / np.maximum(power, 1e-300), 1.0)
    return factor, centre_here - factor * centre_rest
