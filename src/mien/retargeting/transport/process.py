"""Gaussian-process regression with a linear and a radial part, tuned by its evidence.

Face parameters depend on markers almost linearly, with corrections: the linear part extrapolates,
the radial part bends.  All targets share one kernel and have their own amplitude.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.optimize import minimize
from scipy.spatial.distance import cdist

from mien.core.arrays import Floats

PRIOR = (0.5, 0.5, 1.0, 0.05)
"""Medians of the log-normal priors of linear part, radial part, length and noise."""
PRIOR_SPREAD = (2.0, 2.0, 1.0, 2.5)
BOUNDS = ((-9.0, 5.0), (-9.0, 5.0), (-3.0, 4.0), (-16.0, 1.0))
"""Of the logarithms."""
STARTS = ((0.5, 0.5, 1.0, 0.05), (1.0, 0.05, 1.0, 0.01), (1.0, 0.01, 1.0, 1e-5))
JITTER = 1e-9


@dataclass(frozen=True)
class LinearRadialKernel:
    """`linear ⟨x, x'⟩/size + radial exp(−‖x − x'‖² / 2 length apart) + noise δ`.

    Attributes:
        linear, radial: amplitudes of the parts.
        length: squared length scale, in units of `apart`.
        noise: variance of the targets' noise, the signal's being about 1.
        size: mean squared length of the rows the kernel was made for.
        apart: their median squared distance.
    """

    linear: float
    radial: float
    length: float
    noise: float
    size: float
    apart: float

    def between(self, a: Floats, b: Floats) -> Floats:
        """Return the covariances `(n, m)` of rows `(n, r)` and `(m, r)`, without noise."""
        radial = self.radial * np.exp(-cdist(a, b, "sqeuclidean") / (2 * self.length * self.apart))
        return np.asarray(self.linear * (a @ b.T) / self.size + radial)

    def at(self, a: Floats) -> Floats:
        """Return the prior variances `(n,)` at rows `(n, r)`, without noise."""
        return np.asarray(self.linear * (a**2).sum(axis=1) / self.size + self.radial)


@dataclass(frozen=True, eq=False)
class Process:
    """A Gaussian process given what it was told.

    Attributes:
        kernel: its covariance.
        inputs: `(n, r)`.
        mean: `(k,)` of the targets.
        weights: `(n, k)` of the kernel row of a new input.
        factor: lower Cholesky factor of the covariance of the inputs, noise included.
        amplitude: `(k,)` variance of each target per unit of the kernel.
    """

    kernel: LinearRadialKernel
    inputs: Floats
    mean: Floats
    weights: Floats
    factor: Floats
    amplitude: Floats

    @classmethod
    def told(cls, kernel: LinearRadialKernel, inputs: Floats, targets: Floats, noise: Floats | None = None) -> Process:
        """Condition on targets `(n, k)` at inputs `(n, r)`, of given noise variances `(n,)` or the kernel's."""
        own = np.full(len(inputs), kernel.noise) if noise is None else noise
        covariance = kernel.between(inputs, inputs) + np.diag(own + JITTER)
        mean = targets.mean(axis=0)
        factor = cho_factor(covariance, lower=True)
        weights = cho_solve(factor, targets - mean)
        amplitude = ((targets - mean) * weights).mean(axis=0)
        # In the order that a file keeps, so that a model read back computes the very same numbers.
        weights, lower = np.ascontiguousarray(weights), np.ascontiguousarray(np.tril(factor[0]))
        return cls(kernel, inputs, mean, weights, lower, np.maximum(amplitude, 0.0))

    def expected(self, rows: Floats) -> Floats:
        """Return the expected targets `(m, k)` at rows `(m, r)`."""
        return np.asarray(self.kernel.between(rows, self.inputs) @ self.weights + self.mean)

    def doubt(self, rows: Floats) -> Floats:
        """Return the variance `(m,)` left at rows `(m, r)`, for targets of unit amplitude."""
        reach = solve_triangular(self.factor, self.kernel.between(self.inputs, rows), lower=True)
        return np.asarray(np.maximum(self.kernel.at(rows) - (reach**2).sum(axis=0), 0.0))

    def variance(self, rows: Floats) -> Floats:
        """Return the predictive variance `(m, k)` at rows `(m, r)`."""
        return self.doubt(rows)[:, None] * self.amplitude


def kernel_for(inputs: Floats, logs: tuple[float, float, float, float]) -> LinearRadialKernel:
    """Return the kernel of these numbers (not their logarithms), sized for inputs `(n, r)`."""
    squared = cdist(inputs, inputs, "sqeuclidean")
    apart = squared[squared > 0]
    size = float((inputs**2).sum(axis=1).mean())
    return LinearRadialKernel(*logs, size or 1.0, float(np.median(apart)) if apart.size else 1.0)


def most_evident(inputs: Floats, targets: Floats) -> LinearRadialKernel:
    """Return the kernel under which targets `(n, k)` at inputs `(n, r)` are the most probable (a priori included)."""
    centred = targets - targets.mean(axis=0)
    size = float(np.sqrt((centred**2).mean()))
    if len(inputs) < 3 or size < 1e-12 * max(1.0, float(np.abs(targets).max())):
        return kernel_for(inputs, PRIOR)
    unit = kernel_for(inputs, PRIOR)
    parts = inputs @ inputs.T / unit.size, cdist(inputs, inputs, "sqeuclidean") / (2 * unit.apart)
    outer, count = (centred / size) @ (centred / size).T, targets.shape[1]
    found = [
        minimize(evidence, np.log(start), (*parts, outer, count), jac=True, method="L-BFGS-B", bounds=BOUNDS)
        for start in STARTS
    ]
    best = min(found, key=lambda one: float(one.fun))
    linear, radial, length, noise = (float(value) for value in np.exp(best.x))
    return LinearRadialKernel(linear, radial, length, noise, unit.size, unit.apart)


def evidence(logs: Floats, products: Floats, distances: Floats, outer: Floats, count: int) -> tuple[float, Floats]:
    """Return the negative log evidence and priors of a kernel, and the gradient.

    Args:
        logs: `(4,)` logarithms of linear part, radial part, length and noise.
        products: `(n, n)` inner products of the inputs over their mean.
        distances: `(n, n)` half squared distances over their median.
        outer: `(n, n)` products of the centred targets, summed over targets.
        count: of targets.
    """
    linear, radial, length, noise = np.exp(logs)
    bump = radial * np.exp(-distances / length)
    covariance = linear * products + bump + (noise + JITTER) * np.eye(len(products))
    factor = cho_factor(covariance, lower=True)
    inverse = cho_solve(factor, np.eye(len(products)))
    off = (logs - np.log(PRIOR)) / np.square(PRIOR_SPREAD)
    value = count * np.log(np.diag(factor[0])).sum() + (inverse * outer).sum() / 2 + off @ (logs - np.log(PRIOR)) / 2
    slope = (count * inverse - inverse @ outer @ inverse) / 2
    parts = (linear * products, bump, bump * distances / length)
    along = [*((slope * part).sum() for part in parts), noise * np.trace(slope)]
    return float(value), np.array(along) + off
