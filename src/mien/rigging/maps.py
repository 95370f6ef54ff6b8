"""How a displacement turns and grows on its way from one face to another.

A delta of the source is turned by the one rotation that brings the faces' landmarks
together, and scaled by how much the warp enlarges the neighbourhood: a larger mouth
opens further.  Expression cloning (Noh & Neumann 2001) turns and stretches by the local
frame of every vertex; between real heads that was measured to follow the shapes of the
target no better, and worse where landmarks are close together.
"""

from __future__ import annotations

import numpy as np

from mien.core.arrays import Floats
from mien.core.units import human_centimetre
from mien.geometry.align import Similarity, similarity
from mien.rigging.dense import DenseFit


def overall(fit: DenseFit) -> Similarity:
    """Return the similarity that brings the source's landmarks to the target's."""
    return similarity(fit.warp.centres, fit.warp(fit.warp.centres))


def stretch(fit: DenseFit, points: Floats) -> Floats:
    """Return how much the warp enlarges the surroundings of points `(M, 3)` of the source, `(M,)`.

    The mean singular value of the warp's slope over two centimetres of a human face: the
    derivative itself jumps at every landmark.
    """
    step = human_centimetre(fit.warp.centres)
    ahead = [fit.warp(points + step * axis) - fit.warp(points - step * axis) for axis in np.eye(3)]
    slope = np.stack(ahead, axis=2) / (2 * step)
    return np.asarray(np.linalg.svd(slope, compute_uv=False).mean(axis=1))
