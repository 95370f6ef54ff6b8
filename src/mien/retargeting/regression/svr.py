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
TUNED = 6
"""Principal components of the targets that cost and width are chosen by."""
TUBE = 0.02
"""ε: errors below this share of the targets' largest deviation are free."""


@dataclass(frozen=True)
class SvrModel:
    """ε-insensitive support vector regression with the Gaussian kernel.

    Cost and width are shared by all targets: those with the smallest squared error in five-fold
    cross-validation on the labels, of 12 combinations; ε is 0.02 of the largest deviation.  The error
    is that of the targets' first principal components, six at most, which hold most of it and cost a
    tenth of the search over all targets.
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
    tuned = principal_targets(y)
    errors = [_left_out(SVR, x, tuned, folds, cost, steepness).sum() for cost, steepness in choices]
    best = int(np.argmin(errors))
    cost, steepness = choices[best]
    coefficients, intercept = _fit(SVR, x, y, cost, steepness)
    left = errors[best] / max(float(tuned.var(axis=0).sum()), 1e-300)
    return Predictor(x, steepness, coefficients, intercept, left * y.var(axis=0), np.zeros((0, 0)))


def principal_targets(y: Floats) -> Floats:
    """Return the first principal components `(l, p)` of targets `(l, c)`: six, or fewer that hold all of the variance."""
    u, size, _ = np.linalg.svd(y - y.mean(axis=0), full_matrices=False)
    count = max(1, min(TUNED, int((size > 1e-9 * max(float(size[0]), 1e-300)).sum())))
    return np.asarray(u[:, :count] * size[:count])


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
