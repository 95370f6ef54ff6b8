"""The map from the latent space to one observation space: mean and variance (eq. 16 to 18).

Exact and sparse kernels end in the same form, a weighted sum of kernels at some centres,
so that what maps a frame need not know how it was learned.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from mien.core.arrays import Floats, Ints
from mien.retargeting.latent.search import SMALLEST
from mien.retargeting.latent.sparse import JITTER
from mien.solve.gaussian_kernel import Kernel
from mien.solve.process_likelihood import blocks, inverse_of


@dataclass(frozen=True, eq=False)
class Regressor:
    """A Gaussian process from latent points to scaled observations.

    Attributes:
        centres: `(n, q)` the latent or inducing points.
        kernel: of the space.
        coefficients: `(n, d)`, so that the mean is `k(z) @ coefficients`.
        reductions: `(b, n, n)`, so that the variance is `k(z, z) − k(z) @ reduction @ k(z)`.
        kind: `(d,)` which of the reductions each dimension has; dimensions that are given in
            the same rows share one.
    """

    centres: Floats
    kernel: Kernel
    coefficients: Floats
    reductions: Floats
    kind: Ints

    @classmethod
    def exact(cls, z: Floats, kernel: Kernel, values: Floats) -> Regressor:
        """Return the regressor of latent points `(n, q)` and observations `(n, d)`, NaN where not given."""
        parts = blocks(values)
        coefficients = np.zeros(values.shape)
        reductions = np.zeros((len(parts), len(z), len(z)))
        kind = np.zeros(values.shape[1], dtype=np.int64)
        for b, block in enumerate(parts):
            points = z[block.rows]
            inverse, _ = inverse_of(kernel(points, points), kernel.noise)
            coefficients[np.ix_(block.rows, block.columns)] = inverse @ block.values
            reductions[b][np.ix_(block.rows, block.rows)] = inverse
            kind[block.columns] = b
        return cls(z, kernel, coefficients, reductions, kind)

    @classmethod
    def sparse(cls, z: Floats, u: Floats, kernel: Kernel, values: Floats) -> Regressor:
        """Return the regressor of inducing points `(k, q)`."""
        parts = blocks(values)
        coefficients = np.zeros((len(u), values.shape[1]))
        reductions = np.zeros((len(parts), len(u), len(u)))
        kind = np.zeros(values.shape[1], dtype=np.int64)
        uu = kernel(u, u) + JITTER * kernel.height * np.eye(len(u))
        factor = cho_factor(uu)
        for b, block in enumerate(parts):
            fu = kernel(z[block.rows], u)
            diagonal = kernel.height + kernel.noise - (fu * cho_solve(factor, fu.T).T).sum(axis=1)
            inner = cho_factor(uu + fu.T @ (fu / diagonal[:, None]))
            coefficients[:, block.columns] = cho_solve(inner, fu.T @ (block.values / diagonal[:, None]))
            reductions[b] = cho_solve(factor, np.eye(len(u))) - cho_solve(inner, np.eye(len(u)))
            kind[block.columns] = b
        return cls(u, kernel, coefficients, reductions, kind)

    def mean(self, z: Floats) -> Floats:
        """Return the mean at latent points `(f, q)`: `(f, d)`."""
        return np.asarray(self.kernel(z, self.centres) @ self.coefficients)

    def variance(self, z: Floats) -> Floats:
        """Return the predictive variance at latent points `(f, q)`, noise included: `(f, d)`."""
        k = self.kernel(z, self.centres)
        reduced = np.stack([((k @ reduction) * k).sum(axis=1) for reduction in self.reductions])
        found = self.kernel.height + self.kernel.noise - reduced
        return np.asarray(np.maximum(found, SMALLEST)[self.kind].T)
