"""Which frames to label next: those that tell most about all others.

The doubt a Gaussian process leaves does not depend on the labels' values, only on which rows have
one, so what a label would gain is known before it is made.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular

from mien.core import InputError
from mien.core.arrays import Floats, Ints
from mien.retargeting.samples import Samples
from mien.retargeting.transport.experts import stretch_of
from mien.retargeting.transport.principal import PrincipalSpace
from mien.retargeting.transport.process import LinearRadialKernel, kernel_for

RADIAL, NOISE = 0.3, 0.01
"""Of the kernel that frames are compared by, its linear part being 1: chosen once, since few labels don't tell it."""
POWER = 0.5
MOST = 3000
"""Unlabelled rows that are compared, evenly chosen if there are more."""


@dataclass(frozen=True, eq=False)
class Suggestion:
    """Frames to label, the most telling first.

    Attributes:
        frames: `(count,)` numbers of unlabelled source rows.
        gain: `(count,)` the share of all doubt over the unlabelled rows that each label would take away, given those before.
        doubt: the share of the variance over the unlabelled rows that is left after all of them.
    """

    frames: Ints
    gain: Floats
    doubt: float


def suggest(given: Samples, count: int) -> Suggestion:
    """Choose the unlabelled source rows whose labels would leave the least doubt over all of them.

    Greedy: each choice takes away the most of the summed predictive variance, those before it
    counted as labelled (active learning after Cohn, Ghahramani and Jordan 1996).

    Args:
        given: what is there so far; at least one label.
        count: how many to choose.

    Raises:
        InputError: fewer unlabelled source rows than asked for, or `count` is not positive.
    """
    if not 0 < count <= len(given.X_only):
        raise InputError(
            f"{count} frames to label were asked for, but there are {len(given.X_only)} unlabelled ones; "
            f"ask for 1 … {len(given.X_only)}."
        )
    space = PrincipalSpace.of(given.X)
    stretch = stretch_of(space, POWER)
    labelled = space.coordinates(given.X_labelled[given.seen & given.given]) * stretch
    among = np.unique(np.linspace(0, len(given.X_only) - 1, max(MOST, count)).astype(int))
    rows = space.coordinates(given.X_only[among]) * stretch
    kernel = kernel_for(np.concatenate([labelled, rows]), (1.0, RADIAL, 1.0, NOISE))
    found = _greedy(_left(kernel, labelled, rows), count, float(kernel.at(rows).sum()))
    return replace(found, frames=among[found.frames])


def _left(kernel: LinearRadialKernel, labelled: Floats, rows: Floats) -> Floats:
    """Return the covariance `(m, m)` of rows that labels leave."""
    covariance = kernel.between(labelled, labelled) + kernel.noise * np.eye(len(labelled))
    reach = solve_triangular(np.linalg.cholesky(covariance), kernel.between(labelled, rows), lower=True)
    return np.asarray(kernel.between(rows, rows) - reach.T @ reach)


def _greedy(covariance: Floats, count: int, prior: float) -> Suggestion:
    left = covariance.copy()
    start = float(np.trace(left))
    frames, gains = [], []
    open_ = np.ones(len(left), bool)
    for _ in range(count):
        gain = (left**2).sum(axis=0) / (np.diag(left) + NOISE)
        frame = int(np.argmax(np.where(open_, gain, -1.0)))
        left -= np.outer(left[:, frame], left[frame]) / (left[frame, frame] + NOISE)
        open_[frame] = False
        frames.append(frame)
        gains.append(float(gain[frame]) / max(start, 1e-300))
    return Suggestion(np.array(frames), np.array(gains), max(float(np.trace(left)), 0.0) / max(prior, 1e-300))
