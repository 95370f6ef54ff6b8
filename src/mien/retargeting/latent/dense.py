"""The likelihood of one observation space given the latent points, exactly (eq. 1 and 2).

Only the Gram matrix of the observations enters, so 300 dimensions cost what one costs.
Targets that are not labelled leave the likelihood: columns that miss the same rows form a
block of their own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_solve, cholesky

from mien.core.arrays import Floats, Ints
from mien.retargeting.latent.kernel import Kernel


@dataclass(frozen=True, eq=False)
class Block:
    """Columns that are given in the same rows.

    Attributes:
        rows: `(r,)` the rows that give them.
        columns: `(c,)` which columns they are.
        values: `(r, c)`.
    """

    rows: Ints
    columns: Ints
    values: Floats


def blocks(values: Floats) -> tuple[Block, ...]:
    """Divide rows `(n, d)`, NaN where not given, into complete blocks, the column order kept."""
    given = ~np.isnan(values)
    patterns, which = np.unique(given, axis=1, return_inverse=True)
    found = []
    for p in range(patterns.shape[1]):
        rows, columns = np.flatnonzero(patterns[:, p]), np.flatnonzero(which.ravel() == p)
        if rows.size:
            found.append(Block(rows, columns, values[np.ix_(rows, columns)]))
    return tuple(found)


@dataclass(frozen=True, eq=False)
class DenseLikelihood:
    """`½ d log|K| + ½ tr(K⁻¹ Y Yᵀ)`, summed over blocks.

    Attributes:
        parts: per block, its rows, its Gram matrix `(r, r)` and its number of columns.
        floor: under the noise variance.
    """

    parts: tuple[tuple[Ints, Floats, int], ...]
    floor: float = 0.0

    @classmethod
    def of(cls, values: Floats, floor: float = 0.0) -> DenseLikelihood:
        """Return the likelihood of observations `(n, d)`, NaN where not given."""
        return cls(tuple((b.rows, b.values @ b.values.T, len(b.columns)) for b in blocks(values)), floor)

    def __call__(self, z: Floats, logs: Floats) -> tuple[float, Floats, Floats]:
        """Return the negative log likelihood and its derivatives by the latent points `(n, q)` and `log Φ` `(3,)`.

        Raises:
            LinAlgError: the kernel matrix is not positive definite.
        """
        kernel = Kernel.of(logs, self.floor)
        value, by_z, by_logs = 0.0, np.zeros_like(z), np.zeros(3)
        for rows, gram, count in self.parts:
            points = z[rows]
            smooth = kernel(points, points)
            factor = cholesky(smooth + kernel.noise * np.eye(len(rows)), lower=True)
            inverse = cho_solve((factor, True), np.eye(len(rows)))
            explained = inverse @ gram
            value += count * float(np.log(factor.diagonal()).sum()) + 0.5 * float(explained.trace())
            by = 0.5 * (count * inverse - explained @ inverse)
            by_z[rows] += 2 * kernel.points_gradient(points, points, smooth, by)
            by_logs[:2] += kernel.logs_gradient(points, points, smooth, by)
            by_logs[2] -= float(by.trace()) * (kernel.noise - self.floor)
        return value, by_z, by_logs
