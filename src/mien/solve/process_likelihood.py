"""The likelihood of observations under a Gaussian process, exactly (Bouaziz and Pauly 2014, eq. 1 and 2).

Only the Gram matrix of the observations enters, so 300 dimensions cost what one costs.
Targets that are not labelled leave the likelihood: columns that miss the same rows form a
block of their own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotri

from mien.core.arrays import Floats, Ints
from mien.solve.gaussian_kernel import Kernel


@dataclass(frozen=True, eq=False)
class Block:
    """Columns that are given in the same rows.

    Attributes:
        rows: `(r,)` the rows that give them.
        columns: `(c,)` which columns they are.
        values: `(r, c)`.
        turned: `(r, t)` the values in as few columns as they have rank: the likelihood depends on
            `values @ values.T` alone, and 300 markers that move in 50 ways then cost 50.
    """

    rows: Ints
    columns: Ints
    values: Floats
    turned: Floats


def blocks(values: Floats) -> tuple[Block, ...]:
    """Divide rows `(n, d)`, NaN where not given, into complete blocks, the column order kept."""
    given = ~np.isnan(values)
    patterns, which = np.unique(given, axis=1, return_inverse=True)
    found = []
    for p in range(patterns.shape[1]):
        rows, columns = np.flatnonzero(patterns[:, p]), np.flatnonzero(which.ravel() == p)
        if rows.size:
            part = values[np.ix_(rows, columns)]
            found.append(Block(rows, columns, part, part @ _directions(part)))
    return tuple(found)


def _directions(values: Floats) -> Floats:
    """Return orthonormal directions `(c, t)` that hold all of the rows."""
    _, size, directions = np.linalg.svd(values, full_matrices=False)
    return np.asarray(directions[size > 1e-10 * size.max(initial=0.0)].T)


@dataclass(frozen=True, eq=False)
class DenseLikelihood:
    """`½ d log|K| + ½ tr(K⁻¹ Y Yᵀ)`, summed over blocks.

    Attributes:
        parts: complete blocks of the observations.
        floor: under the noise variance.
    """

    parts: tuple[Block, ...]
    floor: float = 0.0

    @classmethod
    def of(cls, values: Floats, floor: float = 0.0) -> DenseLikelihood:
        """Return the likelihood of observations `(n, d)`, NaN where not given."""
        return cls(blocks(values), floor)

    def __call__(self, z: Floats, logs: Floats) -> tuple[float, Floats, Floats]:
        """Return the negative log likelihood and its derivatives by the inputs `(n, q)` and `log Φ` `(3,)`.

        Raises:
            LinAlgError: the kernel matrix is not positive definite.
        """
        kernel = Kernel.of(logs, self.floor)
        value, by_z, by_logs = 0.0, np.zeros_like(z), np.zeros(3)
        for block in self.parts:
            points, count = z[block.rows], len(block.columns)
            smooth = kernel(points, points)
            inverse, log_determinant = inverse_of(smooth, kernel.noise)
            weights = inverse @ block.turned
            value += 0.5 * count * log_determinant + 0.5 * float((weights * block.turned).sum())
            by = 0.5 * (count * inverse - weights @ weights.T)
            by_z[block.rows] += 2 * kernel.points_gradient(points, points, smooth, by)
            by_logs[:2] += kernel.logs_gradient(points, points, smooth, by)
            by_logs[2] -= float(by.trace()) * (kernel.noise - self.floor)
        return value, by_z, by_logs


def inverse_of(smooth: Floats, noise: float) -> tuple[Floats, float]:
    """Return `(smooth + noise I)⁻¹` and the logarithm of the determinant.

    Raises:
        LinAlgError: the matrix is not positive definite.
    """
    noisy = smooth.copy()
    noisy[np.diag_indices(len(noisy))] += noise
    factor, failed = dpotrf(noisy, lower=1)
    if failed:
        raise np.linalg.LinAlgError("the kernel matrix is not positive definite")
    lower, _ = dpotri(factor, lower=1)
    lower = np.tril(lower)
    return lower + np.tril(lower, -1).T, 2 * float(np.log(factor.diagonal()).sum())
