"""A whole pose from a few of its entries, by the poses that exist (character posing, Bouaziz and Pauly 2014, §3).

A linear completion spreads two entries over all others, faintly, and past what was ever seen.  Poses are
not like that: most entries of most poses are at rest.  The median of the poses that are alike in what is
given says which entries move at all; how far is halfway between it and the linear completion.
"""

from __future__ import annotations

import numpy as np

from mien.core.arrays import Floats
from mien.retargeting.transport.principal import PrincipalSpace

ALIKE = 0.7
"""Distance, over the largest standard deviation of an entry, at which a pose counts about half."""
LOOSE = 0.3
"""Variance, over the largest of an entry, by which what is given may miss when it speaks for all others linearly."""
MOVED = 0.1
"""Share of the largest standard deviation: an entry whose median is closer to its rest than this keeps the median."""


def completed(given: Floats, space: PrincipalSpace, poses: Floats) -> Floats:
    """Return a pose `(k,)` of which a few entries are given, the others NaN; those stay within what `poses` show.

    Args:
        given: `(k,)`, at least one entry not NaN.
        space: the principal components of the poses.
        poses: `(n, k)` complete.
    """
    said = ~np.isnan(given)
    size = float(poses.std(axis=0).max()) or 1.0
    apart = (((poses[:, said] - given[said]) / size) ** 2).sum(axis=1)
    typical = weighted_median(poses, np.exp(-(apart - apart.min()) / (2 * ALIKE**2)))
    linear = np.clip(space.loosened(LOOSE).completed(given[None])[0], poses.min(axis=0), poses.max(axis=0))
    moved = np.abs(typical - np.median(poses, axis=0)) > MOVED * size
    return np.where(said, given, np.where(moved, (typical + linear) / 2, typical))


def weighted_median(rows: Floats, weights: Floats) -> Floats:
    """Return for each column of rows `(n, k)` the value at which half of the weight `(n,)` is reached."""
    order = np.argsort(rows, axis=0, kind="stable")
    reached = np.cumsum(weights[order], axis=0)
    at = (reached >= reached[-1] / 2).argmax(axis=0)[None]
    return np.asarray(np.take_along_axis(np.take_along_axis(rows, order, axis=0), at, axis=0)[0])
