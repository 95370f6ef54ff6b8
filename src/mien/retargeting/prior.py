"""What makes a face more likely before any marker is looked at: a table of priors on the weights.

Every prior is a quadratic form in the weights, made once for a character, and perhaps a share
of their absolute values.  The solve is therefore the same lasso whichever is chosen, and as exact.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mien.core import Mesh, Rig
from mien.core.arrays import Floats
from mien.geometry.laplacian import cotangent_laplacian

KEPT = 0.95
"""The share of the shapes' variance that the principal components of `pca` explain."""


@dataclass(frozen=True)
class Prior:
    """A prior on the weights, `µ (wᵀ G w + share Σ |w|)`.

    Attributes:
        about: what it prefers.
        quadratic: makes `G` `(K, K)` of a character and the length of a human centimetre on it.
        usual: µ where none is given: the published one, and what costs as much fit as it does (figure 14).
        absolute: the share of Σ |w|.
    """

    about: str
    quadratic: Callable[[Rig, float], Floats]
    usual: float
    absolute: float = 0.0


def bending(rig: Rig, centimetre: float) -> Floats:
    """Return the `(K, K)` Gram matrix of `L ΔV` over the full mesh, divided by `N` (Ribera et al. 2017, eq. 15).

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


def squares(rig: Rig, centimetre: float) -> Floats:
    """Return the identity: small weights are more likely, whatever they move."""
    del centimetre
    return np.eye(len(rig.blendshapes))


def mahalanobis(rig: Rig, centimetre: float) -> Floats:
    """Return the squared Mahalanobis distance of `ΔV w` from the neutral among the rig's own shapes, over `K`.

    The covariance is that of probabilistic PCA (Tipping and Bishop 1999): the components that
    explain `KEPT` of the variance have their own, all others share their mean.  With all
    components kept it would be `|w|²`: shapes that are one each are equally likely.

    Args:
        rig: the character.
        centimetre: a human centimetre in the character's unit, which cancels.
    """
    flat = rig.blendshapes.deltas.reshape(len(rig.blendshapes), -1) / centimetre
    values, vectors = np.linalg.eigh(flat @ flat.T)
    values, vectors = np.maximum(values[::-1], 0), vectors[:, ::-1]
    count = int(np.searchsorted(np.cumsum(values), KEPT * values.sum())) + 1
    rest = values[count:][values[count:] > VANISHING * values[0]]
    variance = np.concatenate([values[:count], np.full(len(values) - count, rest.mean() if len(rest) else np.inf)])
    ratio = np.divide(values, variance, out=np.zeros_like(values), where=variance > 0)
    return np.asarray((vectors * ratio) @ vectors.T)


VANISHING = 1e-12
"""Variance below this share of the largest is rounding, and says nothing about what is likely."""


def nothing(rig: Rig, centimetre: float) -> Floats:
    """Return zeros: no face is more likely than another."""
    return 0 * squares(rig, centimetre)


PRIORS: dict[str, Prior] = {
    "geometric": Prior("a surface that bends little (Ribera et al. 2017, eq. 15)", bending, 0.3),
    "l2": Prior("small weights, by their squares", squares, 5e-5),
    "elastic-net": Prior("small and few weights, by squares and absolute values", squares, 2e-5, absolute=1.0),
    "pca": Prior("what the principal components of the rig's own shapes show", mahalanobis, 2e-4),
    "none": Prior("nothing", nothing, 0.0),
}
"""Every prior by its name; one row each."""
