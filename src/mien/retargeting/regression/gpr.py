"""`gpr`: Gaussian-process regression (Williams and Rasmussen 1995), one kernel for all targets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core.arrays import Floats
from mien.retargeting.regression.learnt import LearntRegression, learn_regression
from mien.retargeting.regression.predictor import Predictor
from mien.retargeting.samples import Samples
from mien.solve.gaussian_kernel import BOUNDS, Kernel, squared_distances
from mien.solve.minimise import minimise
from mien.solve.process_likelihood import DenseLikelihood, inverse_of

WIDTHS = (0.3, 1.0, 3.0)
"""Starts of the kernel's width, in units of the median distance of labels: the likelihood has several maxima."""


@dataclass(frozen=True)
class GprModel:
    """Gaussian-process regression with the Gaussian kernel.

    Height, width and noise maximise the marginal likelihood of the labels, from three
    starts, the best kept.
    """

    def learn(self, given: Samples) -> LearntRegression:
        """Learn from the labelled rows."""
        return learn_regression(given, fit_process)


def fit_process(x: Floats, y: Floats) -> Predictor:
    """Return the posterior mean and variance of rows `(l, d)` and targets `(l, c)`."""
    centre = y.mean(axis=0)
    likelihood = DenseLikelihood.of(y - centre)
    typical = float(np.median(squared_distances(x, x)[np.triu_indices(len(x), 1)])) if len(x) > 1 else 1.0
    scale = max(typical, 1e-9)
    at = x / np.sqrt(scale)

    def objective(logs: Floats) -> tuple[float, Floats]:
        try:
            value, _, gradient = likelihood(at, logs)
        except np.linalg.LinAlgError:
            return np.inf, np.zeros(3)
        return value, gradient

    bounds = [(float(low), float(high)) for low, high in BOUNDS]
    starts = [np.log([1.0, 1 / width**2, 100.0]) for width in WIDTHS]
    found = min((minimise(objective, start, bounds, gradient=1e-4) for start in starts), key=lambda m: m.value)
    kernel = Kernel.of(found.x)
    inverse, _ = inverse_of(kernel(at, at), kernel.noise)
    top = kernel.height + kernel.noise
    return Predictor(
        x,
        kernel.steepness / scale,
        kernel.height * (inverse @ (y - centre)),
        centre,
        np.full(y.shape[1], top),
        kernel.height**2 * inverse / top,
    )
