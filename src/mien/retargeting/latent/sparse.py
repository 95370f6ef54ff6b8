"""The likelihood with inducing points, so that thousands of unlabelled rows cost `O(k² N)`.

The fully independent training conditional (Snelson and Ghahramani 2006; for latent
variable models Lawrence 2007): the kernel matrix becomes `Q + Λ` with
`Q = K_fu K_uu⁻¹ K_uf` and `Λ` the diagonal that `Q` misses, plus noise.  The `k` inducing
points are searched along with the latent ones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_solve, cholesky

from mien.core.arrays import Floats
from mien.solve.gaussian_kernel import Kernel
from mien.solve.process_likelihood import Block, blocks

JITTER = 1e-6
"""Added to `K_uu`, in units of θ1: inducing points may meet."""


@dataclass(frozen=True, eq=False)
class SparseLikelihood:
    """`½ d log|Q + Λ| + ½ tr((Q + Λ)⁻¹ Y Yᵀ)`, summed over blocks.

    Attributes:
        parts: complete blocks of the observations.
        floor: under the noise variance.
    """

    parts: tuple[Block, ...]
    floor: float = 0.0

    @classmethod
    def of(cls, values: Floats, floor: float = 0.0) -> SparseLikelihood:
        """Return the likelihood of observations `(n, d)`, NaN where not given."""
        return cls(blocks(values), floor)

    def __call__(self, z: Floats, u: Floats, logs: Floats) -> tuple[float, Floats, Floats, Floats]:
        """Return the negative log likelihood and its derivatives.

        Args:
            z: `(n, q)` latent points.
            u: `(k, q)` inducing points.
            logs: `(3,)` `log Φ`.

        Returns:
            The value, and its derivatives by the three.

        Raises:
            LinAlgError: a matrix is not positive definite.
        """
        kernel = Kernel.of(logs, self.floor)
        value, by_z, by_u, by_logs = 0.0, np.zeros_like(z), np.zeros_like(u), np.zeros(3)
        for block in self.parts:
            points = z[block.rows]
            part = _Part.of(kernel, points, u, block)
            by_fu, by_uu, by_diagonal = part.gradients()
            value += part.value()
            by_z[block.rows] += kernel.points_gradient(points, u, part.fu, by_fu)
            by_u += kernel.points_gradient(u, points, part.fu.T, by_fu.T)
            by_u += 2 * kernel.points_gradient(u, u, part.uu, by_uu)
            by_logs[:2] += kernel.logs_gradient(points, u, part.fu, by_fu)
            by_logs[:2] += kernel.logs_gradient(u, u, part.uu, by_uu)
            by_logs[0] += by_diagonal * kernel.height + JITTER * kernel.height * float(by_uu.trace())
            by_logs[2] -= by_diagonal * (kernel.noise - self.floor)
        return value, by_z, by_u, by_logs


@dataclass(frozen=True, eq=False)
class _Part:
    """One block's matrices: `n` rows, `k` inducing points, `c` turned columns of `count`."""

    values: Floats
    count: int
    fu: Floats
    uu: Floats
    projection: Floats
    diagonal: Floats
    uu_factor: Floats
    inner_factor: Floats

    @classmethod
    def of(cls, kernel: Kernel, points: Floats, u: Floats, block: Block) -> _Part:
        fu, uu = kernel(points, u), kernel(u, u)
        uu_factor = cholesky(uu + JITTER * kernel.height * np.eye(len(u)), lower=True)
        projection = cho_solve((uu_factor, True), fu.T).T
        diagonal = kernel.height + kernel.noise - (projection * fu).sum(axis=1)
        inner = uu + JITTER * kernel.height * np.eye(len(u)) + fu.T @ (fu / diagonal[:, None])
        return cls(
            block.turned,
            len(block.columns),
            fu,
            uu,
            projection,
            diagonal,
            uu_factor,
            cholesky(inner, lower=True),
        )

    def solve(self, right: Floats) -> Floats:
        """Return `(Q + Λ)⁻¹ right` by the matrix inversion lemma."""
        scaled = right / self.diagonal[:, None]
        inner = cho_solve((self.inner_factor, True), self.fu.T @ scaled)
        return np.asarray(scaled - (self.fu @ inner) / self.diagonal[:, None])

    def value(self) -> float:
        logs = np.log(self.diagonal).sum() / 2
        logs += np.log(self.inner_factor.diagonal()).sum() - np.log(self.uu_factor.diagonal()).sum()
        return self.count * float(logs) + 0.5 * float((self.values * self.solve(self.values)).sum())

    def gradients(self) -> tuple[Floats, Floats, float]:
        """Return the derivatives by `K_fu`, by `K_uu`, and by a constant added to the diagonal."""
        weights = self.solve(self.values)
        half = cho_solve((self.inner_factor, True), self.fu.T).T
        inverse_diagonal = 1 / self.diagonal - (half * self.fu).sum(axis=1) / self.diagonal**2
        by_diagonal = 0.5 * (self.count * inverse_diagonal - (weights**2).sum(axis=1))
        pull = 0.5 * (self.count * self.solve(self.projection) - weights @ (weights.T @ self.projection))
        pull -= by_diagonal[:, None] * self.projection
        return 2 * pull, -self.projection.T @ pull, float(by_diagonal.sum())
