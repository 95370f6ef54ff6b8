"""`cross-mapping`: radial basis functions in the principal space of the capture (Deng et al. 2006)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core.arrays import Floats
from mien.retargeting.regression.learnt import LearntRegression, learn_regression
from mien.retargeting.regression.predictor import Predictor
from mien.retargeting.samples import Samples
from mien.solve.gaussian_kernel import squared_distances
from mien.solve.ridge import leave_one_out

WIDTHS = (0.5, 1.0, 2.0, 4.0, 8.0)
"""Of the basis functions, in units of the median distance of labels."""


@dataclass(frozen=True)
class CrossMappingModel:
    """Gaussian basis functions at the labelled frames, their coefficients fitted by ridge regression.

    Frames are compared in the principal components that hold a share of the capture's
    variance, unlabelled frames included. Width and penalty are those with the smallest
    leave-one-out error, in closed form.

    Attributes:
        share: of the variance that the principal components hold.
    """

    share: float = 0.95

    def learn(self, given: Samples) -> LearntRegression:
        """Learn from the labelled rows."""
        return learn_regression(given, fit_basis, self.share)


def fit_basis(x: Floats, y: Floats) -> Predictor:
    """Return the predictor of rows `(l, d)` and targets `(l, c)`."""
    centre = y.mean(axis=0)
    distances = squared_distances(x, x)
    typical = float(np.median(distances[np.triu_indices(len(x), 1)])) if len(x) > 1 else 1.0
    fits = []
    for width in WIDTHS:
        steepness = 1 / (width**2 * max(typical, 1e-9))
        features = np.exp(-0.5 * steepness * distances)
        dual, error = leave_one_out(features @ features.T, y - centre)
        fits.append((float(error.sum()), steepness, features.T @ dual, error))
    _, steepness, coefficients, error = min(fits, key=lambda fit: fit[0])
    return Predictor(x, steepness, coefficients, centre, error, np.zeros((0, 0)))
