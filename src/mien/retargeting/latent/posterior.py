"""What learning minimises: the negative logarithm of the posterior of latent points and kernels (eq. 4)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array

from mien.core.arrays import Floats, Ints
from mien.retargeting.latent.sparse import SparseLikelihood
from mien.solve.gaussian_kernel import BOUNDS
from mien.solve.process_likelihood import DenseLikelihood


@dataclass(frozen=True, eq=False)
class Unknowns:
    """All that learning searches.

    Attributes:
        z: `(n, q)` latent points.
        logs_x, logs_y: `(3,)` `log Φ` of either space.
        inducing_x, inducing_y: `(k, q)` inducing points of either space; none if it is exact.
    """

    z: Floats
    logs_x: Floats
    logs_y: Floats
    inducing_x: Floats
    inducing_y: Floats

    def flat(self) -> Floats:
        """Return all numbers in one row."""
        parts = (self.z, self.inducing_x, self.inducing_y, self.logs_x, self.logs_y)
        return np.concatenate([part.ravel() for part in parts])

    def filled(self, flat: Floats) -> Unknowns:
        """Return unknowns of these shapes with the numbers of `flat`."""
        q = self.z.shape[1]
        sizes = np.cumsum([self.z.size, self.inducing_x.size, self.inducing_y.size, 3])
        z, ux, uy, logs_x, logs_y = np.split(flat, sizes)
        return Unknowns(z.reshape(-1, q), logs_x, logs_y, ux.reshape(-1, q), uy.reshape(-1, q))

    def bounds(self) -> list[tuple[float | None, float | None]]:
        """Return the limits of each number: none for points, those of `BOUNDS` for kernels."""
        free = self.z.size + self.inducing_x.size + self.inducing_y.size
        return [(None, None)] * free + [(float(low), float(high)) for low, high in (*BOUNDS, *BOUNDS)]


@dataclass(frozen=True, eq=False)
class Posterior:
    """`−log P(X|Z) − log P(Y|Z) − log P(Z)`, up to a constant.

    Attributes:
        source, target: the likelihoods of either space.
        rows_x, rows_y: which latent points each space has an observation of.
        precision: `(n, n)` `L = MᵀM + I` (eq. 5).
        shape: of the unknowns.
    """

    source: DenseLikelihood | SparseLikelihood
    target: DenseLikelihood | SparseLikelihood
    rows_x: Ints
    rows_y: Ints
    precision: csr_array
    shape: Unknowns

    def floored(self, floor: float) -> Posterior:
        """Return the same with another floor under the noise variances."""
        return replace(self, source=replace(self.source, floor=floor), target=replace(self.target, floor=floor))

    def __call__(self, flat: Floats) -> tuple[float, Floats]:
        """Return the value and its gradient; infinity where a kernel matrix cannot be factored."""
        at = self.shape.filled(flat)
        pull = self.precision @ at.z
        try:
            x, x_z, x_u, x_logs = _likelihood(self.source, at.z[self.rows_x], at.inducing_x, at.logs_x)
            y, y_z, y_u, y_logs = _likelihood(self.target, at.z[self.rows_y], at.inducing_y, at.logs_y)
        except np.linalg.LinAlgError:
            return np.inf, np.zeros_like(flat)
        by_z = pull.copy()
        by_z[self.rows_x] += x_z
        by_z[self.rows_y] += y_z
        value = x + y + 0.5 * float((at.z * pull).sum())
        return value, Unknowns(by_z, x_logs, y_logs, x_u, y_u).flat()


def _likelihood(
    likelihood: DenseLikelihood | SparseLikelihood, z: Floats, inducing: Floats, logs: Floats
) -> tuple[float, Floats, Floats, Floats]:
    if isinstance(likelihood, SparseLikelihood):
        return likelihood(z, inducing, logs)
    value, by_z, by_logs = likelihood(z, logs)
    return value, by_z, np.zeros_like(inducing), by_logs
