"""The Gaussian kernel with noise (Bouaziz and Pauly 2014, eq. 3), and its derivatives.

Its three parameters are positive and span decades, so they are searched as logarithms.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core.arrays import Floats

START = np.log([1.0, 1.0, 100.0])
"""Where the search starts, as published: Φ = {1, 1, 100}."""
BOUNDS = ((np.log(1e-3), np.log(1e3)), (np.log(1e-3), np.log(1e3)), (np.log(1e-1), np.log(1e6)))
"""A noise variance below 1e-6 only makes the kernel matrix singular; clean captures run against it."""


@dataclass(frozen=True)
class Kernel:
    """`k(z, z') = θ1 exp(−θ2/2 |z − z'|²) + noise δ`.

    Attributes:
        height: θ1.
        steepness: θ2.
        noise: `1/θ3`, above a floor if there is one.
    """

    height: float
    steepness: float
    noise: float

    @classmethod
    def of(cls, logs: Floats, floor: float = 0.0) -> Kernel:
        """Return the kernel of `log Φ` `(3,)`, its noise variance lifted by a floor."""
        height, steepness, precision = np.exp(logs)
        return cls(float(height), float(steepness), float(1 / precision) + floor)

    def __call__(self, a: Floats, b: Floats) -> Floats:
        """Return the smooth part between points `(n, q)` and `(m, q)`: `(n, m)`."""
        return np.asarray(self.height * np.exp(-0.5 * self.steepness * squared_distances(a, b)))

    def logs_gradient(self, a: Floats, b: Floats, k: Floats, by: Floats) -> tuple[float, float]:
        """Return the derivatives by `log θ1` and `log θ2` of what has the derivative `by` `(n, m)` by the smooth part `k`."""
        pull = by * k
        return float(pull.sum()), float(-0.5 * self.steepness * (pull * squared_distances(a, b)).sum())

    def points_gradient(self, a: Floats, b: Floats, k: Floats, by: Floats) -> Floats:
        """Return the derivative by the points `a` `(n, q)` of what has the derivative `by` `(n, m)` by `k`."""
        pull = by * k
        return np.asarray(-self.steepness * (pull.sum(axis=1)[:, None] * a - pull @ b))


def squared_distances(a: Floats, b: Floats) -> Floats:
    """Return `|a_i − b_j|²` of points `(n, q)` and `(m, q)`, never negative."""
    found = (a * a).sum(axis=1)[:, None] + (b * b).sum(axis=1) - 2 * (a @ b.T)
    return np.asarray(np.maximum(found, 0.0, out=found))
