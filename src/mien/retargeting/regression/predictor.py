"""What every regression ends in: weighted features of a source row."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core.arrays import Floats
from mien.solve.gaussian_kernel import squared_distances

SMALLEST = 1e-12


@dataclass(frozen=True, eq=False)
class Predictor:
    """`y(x) = φ(x) @ coefficients + intercept`.

    Attributes:
        centres: `(n, d)` of the Gaussian features; empty if the features are the row itself.
        steepness: of the Gaussians, `φ = exp(−steepness/2 |x − centre|²)`.
        coefficients: `(n, c)`, or `(d, c)` for a linear map.
        intercept: `(c,)`.
        spread: `(c,)` the variance far from every centre; everywhere if there is no reduction.
        reduction: `(n, n)`, so that the variance is `spread (1 − φ @ reduction @ φ)`; or `(0, 0)`.
    """

    centres: Floats
    steepness: float
    coefficients: Floats
    intercept: Floats
    spread: Floats
    reduction: Floats

    def features(self, x: Floats) -> Floats:
        """Return the features of rows `(f, d)`."""
        if not len(self.centres):
            return x
        return np.asarray(np.exp(-0.5 * self.steepness * squared_distances(x, self.centres)))

    def mean(self, x: Floats) -> Floats:
        """Return `(f, c)`."""
        return np.asarray(self.features(x) @ self.coefficients + self.intercept)

    def variance(self, x: Floats) -> Floats:
        """Return `(f, c)`."""
        share = np.ones(len(x))
        if len(self.reduction):
            phi = self.features(x)
            share = np.maximum(1 - ((phi @ self.reduction) * phi).sum(axis=1), SMALLEST)
        return np.asarray(share[:, None] * self.spread)


def linear(coefficients: Floats, intercept: Floats, spread: Floats) -> Predictor:
    """Return a linear predictor from `(d, c)` coefficients."""
    none = np.zeros((0, len(coefficients)))
    return Predictor(none, 0.0, coefficients, intercept, spread, np.zeros((0, 0)))
