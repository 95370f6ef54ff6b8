"""Holding a head still frame by frame, compiled: the same sums for a take and for its frames one by one.

The motion is that of `geometry.align.head_motion` (reweighted Procrustes).  There all frames
are one array, whose rounding depends on how many there are; here a stream gives what the take
gives to the bit, in some tens of microseconds a frame.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from mien.core.arrays import Floats

ROUNDS = 12
"""Rounds of reweighting, as `head_motion`."""


@njit(cache=True, nogil=True)
def hold_still(
    rest: Floats, stability: Floats, softness: float, points: Floats, before: Floats, still: Floats, motion: Floats
) -> None:
    """Find each frame's head motion and take it out.

    Args:
        rest: `(M, 3)` the face at rest.
        stability: `(M,)` how rigidly each point rides on the skull.
        softness: the residual at which a point's weight falls to a quarter.
        points: `(F, M, 3)`; NaN where missing.
        before: `(4, 4)` the motion that frames keep which see fewer than 3 steady points.
        still: `(F, M, 3)` filled with the points as if the head were at rest.
        motion: `(F, 4, 4)` filled with the motion taken out.
    """
    last = before
    for f in range(len(points)):
        motion[f] = last
        steady = 0
        for i in range(len(rest)):
            if stability[i] > 0 and not np.isnan(points[f, i, 0]):
                steady += 1
        if steady >= 3:
            weights = stability.copy()
            for turn in range(ROUNDS):
                if turn > 0:
                    reweigh(rest, stability, softness, points[f], motion[f], weights)
                rigid_fit(rest, points[f], weights, motion[f])
        last = motion[f]
        for i in range(len(rest)):
            for a in range(3):
                s = 0.0
                for b in range(3):
                    s += motion[f, b, a] * (points[f, i, b] - motion[f, b, 3])
                still[f, i, a] = s


@njit(cache=True, nogil=True)
def reweigh(rest: Floats, stability: Floats, softness: float, here: Floats, motion: Floats, weights: Floats) -> None:
    """Set the points' weights for how far they are off the motion."""
    for i in range(len(rest)):
        if np.isnan(here[i, 0]):
            continue
        off = 0.0
        for a in range(3):
            s = motion[a, 3] - here[i, a]
            for b in range(3):
                s += motion[a, b] * rest[i, b]
            off += s * s
        weights[i] = stability[i] / (1 + off / softness**2) ** 2


@njit(cache=True, nogil=True)
def rigid_fit(rest: Floats, here: Floats, weights: Floats, motion: Floats) -> None:
    """Set the weighted least-squares rigid motion `(4, 4)` from rest to a frame; NaN points are left out."""
    total, centre, target, moment = 0.0, np.zeros(3), np.zeros(3), np.zeros((3, 3))
    for i in range(len(rest)):
        if not np.isnan(here[i, 0]):
            total += weights[i]
            for a in range(3):
                centre[a] += weights[i] * rest[i, a]
                target[a] += weights[i] * here[i, a]
    if not total > 0:
        return
    centre /= total
    target /= total
    for i in range(len(rest)):
        if not np.isnan(here[i, 0]):
            for a in range(3):
                for b in range(3):
                    moment[a, b] += weights[i] * (here[i, a] - target[a]) * (rest[i, b] - centre[b])
    left, _, right = np.linalg.svd(moment)
    if np.linalg.det(left) * np.linalg.det(right) < 0:
        left[:, 2] = -left[:, 2]
    for a in range(3):
        shift = target[a]
        for b in range(3):
            turn = left[a, 0] * right[0, b] + left[a, 1] * right[1, b] + left[a, 2] * right[2, b]
            motion[a, b] = turn
            shift -= turn * centre[b]
        motion[a, 3] = shift
        motion[3, a] = 0.0
    motion[3, 3] = 1.0
