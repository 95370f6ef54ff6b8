"""Deltas through the dense correspondence: each vertex moves as its point on the source does.

The displacement of the source point is interpolated in its triangle, on its own side of
lips and lids, then turned and scaled as `maps` says (expression cloning in the sense of
Noh & Neumann 2001).
"""

from __future__ import annotations

import numpy as np

from mien.core.arrays import Floats
from mien.core.mesh import SurfacePoints
from mien.rigging.dense import DenseFit
from mien.rigging.maps import overall, stretch


def transfer(deltas: Floats, fit: DenseFit, back: SurfacePoints) -> Floats:
    """Move shapes `(K, Ns, 3)` onto target vertices whose points on the source are `back`; `(K, M, 3)`."""
    turned = back.of(deltas) @ overall(fit).rotation.T
    return np.asarray(turned * stretch(fit, back.of(fit.source.vertices))[:, None])
