"""The likelihood of observations under a Gaussian process, exactly (Bouaziz and Pauly 2014, eq. 1 and 2).

Only the Gram matrix of the observations enters, so 300 dimensions cost what one costs.
Targets that are not labelled leave the likelihood: columns that miss the same rows form a
block of their own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg.blas import dsyrk
from scipy.linalg.lapack import dpotrf, dpotri, dpotrs

from mien.core.arrays import Floats, Ints
from mien.solve.gaussian_kernel import Kernel
from mien.solve.gaussian_pairs import fill_kernel, pull


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
            part, pulled, logs_pulled = _of_block(block, np.ascontiguousarray(z[block.rows]), kernel)
            value += part
            by_z[block.rows] += pulled
            by_logs[:2] += logs_pulled[:2]
            by_logs[2] -= logs_pulled[2] * (kernel.noise - self.floor)
        return value, by_z, by_logs


def _of_block(block: Block, points: Floats, kernel: Kernel) -> tuple[float, Floats, tuple[float, float, float]]:
    """Return a block's value, and its derivatives by the points `(r, q)` and by height, steepness and noise."""
    count = len(block.columns)
    smooth, pulled = np.empty((len(points), len(points))), np.empty_like(points)
    fill_kernel(points, kernel.height, kernel.steepness, kernel.noise, smooth)
    # The matrix is symmetric, so its transpose is the same in the order of columns that LAPACK writes to.
    factor, failed = dpotrf(smooth.copy().T, lower=1, overwrite_a=1, clean=0)
    if failed:
        raise np.linalg.LinAlgError("the kernel matrix is not positive definite")
    log_determinant = 2 * float(np.log(factor.diagonal()).sum())
    weights = dpotrs(factor, block.turned, lower=1)[0]
    inverse = dpotri(factor, lower=1, overwrite_c=1)[0]
    by = dsyrk(-0.5, weights, beta=0.5 * count, c=inverse, lower=1, overwrite_c=1)
    value = 0.5 * count * log_determinant + 0.5 * float(np.vdot(weights, block.turned))
    return value, pulled, pull(points, smooth, kernel.height, kernel.steepness, by, pulled)


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
