"""The thin-plate spline in space: the smoothest map that takes some points to others.

Orvalho, Zacur, Susin, eq. 1-3, with the biharmonic kernel `U(x, p) = |x - p|`.  The
saddle-point system of the paper is reduced to the complement of the affine maps,
where the kernel matrix is definite, and solved by Cholesky.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.spatial.distance import cdist

from mien.core.arrays import Floats
from mien.core.errors import InputError


@dataclass(frozen=True, eq=False)
class ThinPlate:
    """A fitted warp: `x ↦ Σ_i w_i |x - p_i| + a_0 + A x`.

    Attributes:
        centres: `(M, 3)` the points `p`.
        bend: `(M, C)` the weights `w`.
        affine: `(4, C)` the rows `a_0` and `Aᵀ`.
    """

    centres: Floats
    bend: Floats
    affine: Floats

    def __call__(self, points: Floats) -> Floats:
        """Warp positions `(…, 3)`."""
        flat = np.reshape(points, (-1, 3))
        warped = cdist(flat, self.centres) @ self.bend + self.affine[0] + flat @ self.affine[1:]
        return np.asarray(warped.reshape(*np.shape(points)[:-1], -1))

    def jacobian(self, points: Floats) -> Floats:
        """Return the derivative `(M', C, 3)` at points `(M', 3)`; a centre itself counts as flat."""
        offset = points[:, None] - self.centres
        distance = np.linalg.norm(offset, axis=2, keepdims=True)
        direction = np.divide(offset, distance, out=np.zeros_like(offset), where=distance > 0)
        return np.asarray(np.einsum("mpa,pc->mca", direction, self.bend) + self.affine[1:].T)


def fit_thin_plate(sources: Floats, targets: Floats, smoothing: float = 0.0) -> ThinPlate:
    """Fit the warp that takes `sources` to `targets`.

    Args:
        sources: `(M, 3)` distinct points, not all in one plane.
        targets: `(M, C)` where they go.
        smoothing: 0 interpolates exactly; larger trades closeness for straightness, in
            units of length.  Affine maps are reproduced exactly at any value.

    Raises:
        InputError: fewer than 4 points, coinciding points, or points in one plane.
    """
    count = len(sources)
    if count < 4:
        raise InputError(f"a warp needs at least 4 points, got {count}.")
    centre = sources.mean(axis=0)
    spread = np.linalg.svd(sources - centre, compute_uv=False)
    if spread[2] < 1e-6 * spread[0]:
        raise InputError("the points of a warp lie in one plane; add one off it, such as the nose tip.")
    distances = cdist(sources, sources)
    close = distances + np.eye(count) * spread[0]
    if close.min() < 1e-9 * spread[0]:
        i, j = np.unravel_index(int(np.argmin(close)), close.shape)
        raise InputError(f"points {i} and {j} of a warp coincide; remove one of them.")
    polynomial = np.hstack([np.ones((count, 1)), (sources - centre) / spread[0]])
    full, corner = np.linalg.qr(polynomial, mode="complete")
    affine_part, rest = full[:, :4], full[:, 4:]
    # |x - p| is conditionally negative definite: its negative is definite off the affine maps.
    definite = rest.T @ (smoothing * np.eye(count) - distances) @ rest
    bend = -rest @ cho_solve(cho_factor(definite), rest.T @ targets) if count > 4 else np.zeros_like(targets)
    left_over = affine_part.T @ (targets - distances @ bend + smoothing * bend)
    scaled = np.linalg.solve(corner[:4], left_over)
    linear = scaled[1:] / spread[0]
    return ThinPlate(sources, bend, np.vstack([scaled[:1] - centre @ linear, linear]))
