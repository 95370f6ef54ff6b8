"""The frames of a take that serve as examples: as unlike each other as k-means finds them."""

from __future__ import annotations

import numpy as np
from scipy.cluster.vq import vq

from mien.core.arrays import Floats, Ints

MOST = 3000
"""Longer takes are thinned to about this many frames before they are clustered."""
ROUNDS = 50
"""Of moving the centres; most takes settle within 20."""


def distinct_frames(take: Floats, count: int) -> Ints:
    """Return the frames closest to the centres of clusters of all frames (Ribera et al. 2017, §6.1).

    The centres start at frames each as far as possible from those before, so nothing is random.

    Args:
        take: `(F, M, 3)` displacements, NaN where missing; frames that miss a marker are no examples.
        count: how many clusters; the frames are fewer where the take has fewer.

    Returns:
        `(E,)` frame numbers, increasing.
    """
    whole = np.flatnonzero(~np.isnan(take).any(axis=(1, 2)))
    whole = whole[:: max(1, len(whole) // MOST)]
    rows = take[whole].reshape(len(whole), -1)
    if len(rows) <= count:
        return whole
    centres = rows[_apart(rows, count)]
    for _ in range(ROUNDS):
        nearest, _ = vq(rows, centres)
        moved = np.stack(
            [rows[nearest == c].mean(axis=0) if (nearest == c).any() else centres[c] for c in range(count)]
        )
        if np.array_equal(moved, centres):
            break
        centres = moved
    chosen, _ = vq(centres, rows)
    return np.asarray(whole[np.unique(chosen)])


def _apart(rows: Floats, count: int) -> Ints:
    """Return rows each the farthest from those before, beginning with the one farthest from rest."""
    chosen = [int(np.argmax((rows**2).sum(axis=1)))]
    gap = np.full(len(rows), np.inf)
    while len(chosen) < count:
        gap = np.minimum(gap, ((rows - rows[chosen[-1]]) ** 2).sum(axis=1))
        chosen.append(int(np.argmax(gap)))
    return np.array(chosen, dtype=np.int64)
