"""The geometric prior: a face that bends less is more likely (Ribera et al. 2017, §5)."""

from __future__ import annotations

import numpy as np

from mien.core import Mesh, Rig
from mien.core.arrays import Floats
from mien.geometry.laplacian import cotangent_laplacian


def bending(rig: Rig, centimetre: float) -> Floats:
    """Return the `(K, K)` Gram matrix of `L ΔV` over the full mesh, divided by `N` (eq. 15).

    Args:
        rig: the character.
        centimetre: a human centimetre in the character's unit.
    """
    mesh: Mesh = rig.neutral
    laplacian = cotangent_laplacian(mesh.vertices / centimetre, mesh.triangles)
    k, n, _ = rig.blendshapes.deltas.shape
    columns = rig.blendshapes.deltas.transpose(1, 0, 2).reshape(n, k * 3) / centimetre
    bent = np.asarray(laplacian @ columns).reshape(n, k, 3).transpose(0, 2, 1).reshape(n * 3, k)
    return np.asarray(bent.T @ bent / n)
