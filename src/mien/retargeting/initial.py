"""A character's blendshapes carried onto the actor by a warp: the guess that alignment starts from."""

from __future__ import annotations

import numpy as np

from mien.core.arrays import Floats
from mien.geometry.tps import fit_thin_plate
from mien.retargeting.terms import Terms


def warped_shapes(terms: Terms, smoothing: float = 0.0) -> Floats:
    """Return the initial guess `Δg = TPS(s_0 + Δs) - TPS(s_0)` (Ribera et al. 2017, §4.4).

    The thin-plate warp takes the character's neutral points to the actor's.  Where it is
    smoothed it does not quite reach them, which is why `TPS(s_0)` and not `a_0` is taken off.

    Args:
        terms: actor and character in common terms.
        smoothing: 0 interpolates, as printed.

    Returns:
        `(K, M, 3)` [cm].
    """
    warp = fit_thin_plate(terms.character_neutral, terms.actor_neutral, smoothing)
    return np.asarray(warp(terms.character_neutral + terms.deltas) - warp(terms.character_neutral))
