"""The frames worth learning from (Ribera et al. 2017, §4.2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from mien.core.arrays import Floats, Ints

GAUSSIAN_SIGMA = 0.6
"""A Gaussian three frames wide: truncated after one frame on each side."""

ROUNDING = 1e-7
"""Rises and falls of this share of the highest peak are rounding: where the face rests there is no peak."""


@dataclass(frozen=True, eq=False)
class Keys:
    """Key expressions of a take.

    Attributes:
        frames: `(E,)` frame numbers, increasing.
        cumulative: `(F,)` the summed similarity whose peaks they are (figure 8).
    """

    frames: Ints
    cumulative: Floats


def key_expressions(enhanced: Floats, prominence: float = 0.0) -> Keys:
    """Pick the local maxima of the similarity summed over all shapes.

    Args:
        enhanced: `(K, F)` similarities.
        prominence: how far a peak must stand out from its surroundings, as a share of
            the range of the summed similarity; 0 takes every local maximum, as printed.
    """
    smooth = gaussian_filter1d(enhanced, GAUSSIAN_SIGMA, axis=1, truncate=1 / GAUSSIAN_SIGMA, mode="nearest")
    cumulative = smooth.sum(axis=0)
    return Keys(_peaks(cumulative, prominence * float(np.ptp(cumulative))), cumulative)


def _peaks(signal: Floats, prominence: float) -> Ints:
    """Local maxima, ends included, a plateau counted once; the best frame alone if there is none."""
    if prominence > 0:
        from scipy.signal import find_peaks  # slow to import, and not needed for the printed method

        padded = np.concatenate([[signal.min()], signal, [signal.min()]])
        found = find_peaks(padded, prominence=prominence)[0] - 1
    else:
        change = np.diff(signal, prepend=-np.inf, append=-np.inf)
        change = np.where(np.abs(change) > ROUNDING * np.abs(signal).max(), np.sign(change), 0)
        slopes = np.flatnonzero(change)  # plateaus fall out here
        tops = (change[slopes[:-1]] > 0) & (change[slopes[1:]] < 0)
        found = (slopes[:-1][tops] + slopes[1:][tops] - 1) // 2
    return found if len(found) else np.array([int(np.argmax(signal))])
