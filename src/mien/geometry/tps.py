"""The thin-plate spline in space: the smoothest map that takes some points to others.

Orvalho, Zacur, Susin, eq. 1-3, with the biharmonic kernel `U(x, p) = |x - p|`.  The
saddle-point system of the paper is reduced to the complement of the affine maps,
where the kernel matrix is definite, and solved by Cholesky.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, qr
from scipy.spatial.distance import cdist
from threadpoolctl import threadpool_limits

from mien.core.arrays import Floats
from mien.core.errors import InputError

BLOCK = 2_000_000
"""Distances worked out at a time, so that memory stays small on large meshes."""


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
        warped = self.affine[0] + flat @ self.affine[1:]
        rows = max(1, BLOCK // len(self.centres))
        for first in range(0, len(flat), rows):
            some = slice(first, first + rows)
            warped[some] += cdist(flat[some], self.centres) @ self.bend
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
    kernel = cdist(sources, sources)
    _check_distinct(kernel, float(spread[0]))
    kernel[np.diag_indices(count)] -= smoothing
    polynomial = np.hstack([np.ones((count, 1)), (sources - centre) / spread[0]])
    reflect = _Reflectors.of(polynomial)
    turned, goals = reflect.both_sides(kernel), reflect.transposed(targets)
    bend = np.zeros(np.shape(goals))
    if count > 4:
        # |x - p| is conditionally negative definite: its negative is definite off the affine maps.
        # More threads than free cores make this many times slower, and one is fast.
        with threadpool_limits(1, "blas"):
            definite = (-turned[4:, 4:]).T  # symmetric, and laid out as LAPACK wants it
            bend[4:] = -cho_solve(cho_factor(definite, lower=True, overwrite_a=True, check_finite=False), goals[4:])
    left_over = goals[:4] - turned[:4, 4:] @ bend[4:]
    scaled = np.linalg.solve(reflect.corner, left_over)
    linear = scaled[1:] / spread[0]
    return ThinPlate(sources, reflect.applied(bend), np.vstack([scaled[:1] - centre @ linear, linear]))


def _check_distinct(distances: Floats, extent: float) -> None:
    """Raise if two points coincide, telling them from the diagonal of their distances `(M, M)`."""
    count = len(distances)
    off_diagonal = distances.ravel()[1:].reshape(count - 1, count + 1)[:, :-1]
    if off_diagonal.min() < 1e-9 * extent:
        row, column = np.unravel_index(int(np.argmin(off_diagonal)), off_diagonal.shape)
        flat = int(row) * (count + 1) + int(column) + 1
        i, j = sorted(divmod(flat, count))
        raise InputError(f"points {i} and {j} of a warp coincide; remove one of them.")


@dataclass(frozen=True, eq=False)
class _Reflectors:
    """The orthogonal factor `Q = I - V T Vᵀ` of four columns (Schreiber & Van Loan 1989), never written out.

    Attributes:
        vectors: `(M, 4)` V.
        triangle: `(4, 4)` T.
        corner: `(4, 4)` the triangular factor of the columns.
    """

    vectors: Floats
    triangle: Floats
    corner: Floats

    @classmethod
    def of(cls, columns: Floats) -> _Reflectors:
        (packed, tau), corner = qr(columns, mode="raw")
        vectors = np.tril(packed[:, :4], -1)
        vectors[np.arange(4), np.arange(4)] = 1
        triangle = np.zeros((4, 4))
        for k in range(4):
            triangle[:k, k] = -tau[k] * triangle[:k, :k] @ (vectors[:, :k].T @ vectors[:, k])
            triangle[k, k] = tau[k]
        return cls(vectors, triangle, corner[:4])

    def applied(self, values: Floats) -> Floats:
        """Return `Q x` for `x` `(M, C)`."""
        return np.asarray(values - self.vectors @ (self.triangle @ (self.vectors.T @ values)))

    def transposed(self, values: Floats) -> Floats:
        """Return `Qᵀ x` for `x` `(M, C)`."""
        return np.asarray(values - self.vectors @ (self.triangle.T @ (self.vectors.T @ values)))

    def both_sides(self, matrix: Floats) -> Floats:
        """Return `Qᵀ A Q` for a symmetric `A` `(M, M)`, as an update of rank eight."""
        reached = matrix @ self.vectors @ self.triangle
        reached -= self.vectors @ (self.triangle.T @ (self.vectors.T @ reached)) / 2
        change = np.hstack([self.vectors, reached]) @ np.hstack([reached, self.vectors]).T
        return np.asarray(matrix - change)
