"""Movement that no marker sees must be paid for.

An eye that looks aside drags its lid along by a fraction of a millimetre.  Solving for
the lid alone, a sparse set of markers happily turns the eye to explain a squint.  A
shape is therefore dearer the more it moves the face out of the markers' sight.
"""

from __future__ import annotations

import numpy as np

from mien.core import Correspondence, Rig
from mien.core.arrays import Floats

IN_SIGHT = 3.0
"""A shape may move the face this many times farther somewhere than at any marker, at no extra cost."""
STEEPNESS = 4
DEAREST = 1e4


def cost_of_unseen(rig: Rig, pairs: Correspondence) -> Floats:
    """Return the factor on ν of each shape, `(K,)`, at least 1.

    It is `(ratio / 3)⁴` where a shape moves the mesh by `ratio` times more than 3 times
    what it moves any paired point.

    Args:
        rig: the character.
        pairs: which of its points have a marker.
    """
    deltas = rig.blendshapes.deltas
    anywhere = np.linalg.norm(deltas, axis=2).max(axis=1)
    in_sight = np.linalg.norm(pairs.target.of(deltas), axis=2).max(axis=1)
    ratio = np.divide(anywhere, in_sight, out=np.full(len(deltas), np.inf), where=in_sight > 0)
    ratio[anywhere == 0] = 1
    return np.asarray(np.clip((ratio / IN_SIGHT) ** STEEPNESS, 1.0, DEAREST))
