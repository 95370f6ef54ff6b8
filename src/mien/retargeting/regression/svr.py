"""`svr`: support vector regression (Drucker et al. 1996), one per target, by scikit-learn."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from mien.core import MissingPackage
from mien.core.arrays import Floats, Ints
from mien.retargeting.regression.learnt import LearntRegression, learn_regression
from mien.retargeting.regression.predictor import Predictor
from mien.retargeting.samples import Samples
from mien.solve.gaussian_kernel import squared_distances

FOLDS = 5
COSTS = (1.0, 10.0, 100.0)
WIDTHS = (0.5, 1.0, 2.0, 4.0)
"""Of the Gaussian, in units of the median distance of labels."""
TUBE = 0.02
"""ε: errors below this share of the targets' largest deviation are free."""


@dataclass(frozen=True)
class SvrModel:
    """ε-insensitive support vector regression with the Gaussian kernel.

    Cost and width are those with the smallest squared error over all targets in five-fold
    cross-validation on the labels, of 12 combinations; ε is 0.02 of the largest deviation.
    """

    def learn(self, given: Samples) -> LearntRegression:
        """Learn from the labelled rows.

        Raises:
            MissingPackage: scikit-learn is not installed.
        """
        return learn_regression(given, fit_support_vectors)


def fit_support_vectors(x: Floats, y: Floats) -> Predictor:
    """Return the predictor of rows `(l, d)` and targets `(l, c)`."""
    try:
        from sklearn.svm import SVR
    except ImportError:
        raise MissingPackage("support vector regression", "scikit-learn", "regression") from None
    typical = float(np.median(squared_distances(x, x)[np.triu_indices(len(x), 1)])) if len(x) > 1 else 1.0
    choices = [(cost, 1 / (width**2 * max(typical, 1e-9))) for cost, width in product(COSTS, WIDTHS)]
    folds = np.arange(len(x), dtype=np.int64) % min(FOLDS, len(x))
    errors = [_left_out(SVR, x, y, folds, cost, steepness) for cost, steepness in choices]
    best = int(np.argmin([error.sum() for error in errors]))
    cost, steepness = choices[best]
    coefficients, intercept = _fit(SVR, x, y, cost, steepness)
    return Predictor(x, steepness, coefficients, intercept, errors[best], np.zeros((0, 0)))


def _left_out(svr: Any, x: Floats, y: Floats, folds: Ints, cost: float, steepness: float) -> Floats:
    """Return the mean squared error per target on rows that were left out, `(c,)`."""
    error = np.zeros(y.shape[1])
    for fold in range(int(folds.max()) + 1):
        out = folds == fold
        if out.all():
            return np.asarray(((y - y.mean(axis=0)) ** 2).mean(axis=0))
        coefficients, intercept = _fit(svr, x[~out], y[~out], cost, steepness)
        features = np.exp(-0.5 * steepness * squared_distances(x[out], x[~out]))
        error += ((features @ coefficients + intercept - y[out]) ** 2).sum(axis=0)
    return error / len(y)


def _fit(svr: Any, x: Floats, y: Floats, cost: float, steepness: float) -> tuple[Floats, Floats]:
    gram = np.exp(-0.5 * steepness * squared_distances(x, x))
    coefficients, intercept = np.zeros(y.shape), np.zeros(y.shape[1])
    for c in range(y.shape[1]):
        if np.ptp(y[:, c]) <= 2 * TUBE:
            intercept[c] = (y[:, c].max() + y[:, c].min()) / 2
            continue
        fitted = svr(kernel="precomputed", C=cost, epsilon=TUBE).fit(gram, y[:, c])
        coefficients[fitted.support_, c] = fitted.dual_coef_[0]
        intercept[c] = fitted.intercept_[0]
    return coefficients, intercept
