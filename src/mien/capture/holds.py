"""Finding where in a take the face is held in an expression.

A look to the side moves a few points of the lids by a millimetre, an open jaw the chin by
three centimetres: each point is measured by its own farthest movement, and the few points
that are farthest out speak for the face.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter

from mien.core.arrays import Floats, Ints

LOOKED_AT_HZ = 30.0
"""Faster takes are thinned to about this."""
MEDIAN_S = 0.5
"""Movements shorter than half of this, such as blinks, are no expression and disappear in the median."""
FLOOR_CM = 0.3
"""A point that never moves this far is measured by it, so that its noise is not taken for movement."""
FARTHEST, SPEAKERS = 0.99, 0.98
"""Quantile over the frames that is a point's farthest movement; and over the points, that is the face's."""
HYSTERESIS = 0.7
"""A hold ends where the movement is below this share of what it takes to begin one."""
SHORTEST_S = 0.5
CALM, ROUNDS = 0.15, 3
"""A face is surely at rest in this share of a take's frames; and how often the rest is found by those, and they by it."""


@dataclass(frozen=True)
class Hold:
    """A stretch of frames in which the face is away from rest.

    Attributes:
        first, last: frames, both within.
    """

    first: int
    last: int

    @property
    def plateau(self) -> Ints:
        """The frames of the middle half, which leave out how the expression came and went."""
        quarter = (self.last - self.first) // 4
        return np.arange(self.first + quarter, self.last - quarter + 1)

    def overlaps(self, other: Hold) -> bool:
        """Return whether two holds share a frame."""
        return self.first <= other.last and other.first <= self.last

    def contains(self, other: Hold) -> bool:
        """Return whether another hold is a part of this one."""
        return self != other and self.first <= other.first and other.last <= self.last


def movement(take: Floats, fps: float) -> Floats:
    """Return how far the face is from rest in each frame, as a share of how far it ever goes.

    Args:
        take: `(F, M, 3)` displacements from the neutral [cm of a human face]; a point not seen counts as at rest.
        fps: frame rate.

    Returns:
        `(F,)` between 0 and about 1.
    """
    step = max(1, round(fps / LOOKED_AT_HZ))
    width = round(MEDIAN_S * fps / step) | 1
    smooth = median_filter(np.nan_to_num(take[::step]), size=(width, 1, 1), mode="nearest")
    out = np.linalg.norm(smooth, axis=2)
    out /= np.maximum(np.quantile(out, FARTHEST, axis=0), FLOOR_CM)
    return np.repeat(np.quantile(out, SPEAKERS, axis=1), step)[: len(take)]


def from_rest(take: Floats, fps: float) -> Floats:
    """Return a take with its calmest frames as its rest.

    A neutral found as the face that a take returns to most often is the mean of what lies close to it, small
    expressions too, and by as much off.

    Args:
        take: `(F, M, 3)` displacements from the neutral [cm of a human face]; NaN where not seen.
        fps: frame rate.
    """
    for _ in range(ROUNDS):
        moved = movement(take, fps)
        take = take - mean_face(take[moved <= np.quantile(moved, CALM)], nowhere=0.0)
    return take


def mean_face(frames: Floats, nowhere: float = np.nan) -> Floats:
    """Return the mean `(M, 3)` of what is seen in frames `(F, M, 3)`, and a value where a point is seen in none."""
    seen = np.asarray(~np.isnan(frames).any(axis=2))
    count = seen.sum(axis=0)[:, None]
    mean = np.where(seen[..., None], frames, 0).sum(axis=0) / np.maximum(count, 1)
    return np.asarray(np.where(count > 0, mean, nowhere))


def find_holds(moved: Floats, fps: float, away: float) -> tuple[Hold, ...]:
    """Find the stretches in which the face is away from rest, blinks left out.

    Args:
        moved: `(F,)` as `movement` gives it.
        fps: frame rate.
        away: how far from rest begins a hold.
    """
    edges = np.diff(np.concatenate([[0], moved > HYSTERESIS * away, [0]]).astype(int))
    stretches = zip(np.flatnonzero(edges > 0).tolist(), (np.flatnonzero(edges < 0) - 1).tolist(), strict=True)
    return tuple(
        Hold(first, last)
        for first, last in stretches
        if last - first + 1 >= SHORTEST_S * fps and moved[first : last + 1].max() > away
    )
