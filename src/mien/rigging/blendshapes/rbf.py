"""Deltas through the landmark warp: where it takes the moved point, less where it takes the point at rest.

The usual baseline: a radial basis function of a few landmarks (here the biharmonic thin
plate) bends space, and the shapes with it.  Close landmarks bend it sharply, so fine
shapes around lids and lips are distorted most.
"""

from __future__ import annotations

import numpy as np

from mien.core.arrays import Floats
from mien.core.mesh import SurfacePoints
from mien.rigging.dense import DenseFit


def transfer(deltas: Floats, fit: DenseFit, back: SurfacePoints) -> Floats:
    """Move shapes `(K, Ns, 3)` onto target vertices whose points on the source are `back`; `(K, M, 3)`."""
    rest = back.of(fit.source.vertices)
    there = fit.warp(rest)
    result = np.zeros((len(deltas), *rest.shape))
    for shape, delta in zip(result, deltas, strict=True):
        moved = back.of(delta)
        rows = np.flatnonzero(moved.any(axis=1))
        if len(rows):
            shape[rows] = fit.warp(rest[rows] + moved[rows]) - there[rows]
    return result
