"""`ridge`: a linear map, its penalty chosen by leaving labels out; the least that learning can do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core.arrays import Floats
from mien.retargeting.regression.learnt import LearntRegression, learn_regression
from mien.retargeting.regression.predictor import Predictor, linear
from mien.retargeting.samples import Samples

PENALTIES = np.geomspace(1e-8, 1e4, 49)
"""Those tried, relative to the mean eigenvalue of the centred Gram matrix."""


@dataclass(frozen=True)
class RidgeModel:
    """Linear regression with a quadratic penalty.

    The penalty is the one with the smallest leave-one-out error over all targets, in closed
    form (Allen's PRESS), of 49 between 1e-8 and 1e4.
    """

    def learn(self, given: Samples) -> LearntRegression:
        """Learn from the labelled rows."""
        return learn_regression(given, fit_ridge)


def fit_ridge(x: Floats, y: Floats) -> Predictor:
    """Return the linear predictor of rows `(l, d)` and targets `(l, c)`."""
    at, centre = x.mean(axis=0), y.mean(axis=0)
    gram = (x - at) @ (x - at).T
    dual, error = leave_one_out(gram, y - centre)
    coefficients = (x - at).T @ dual
    return linear(coefficients, centre - at @ coefficients, error)


def leave_one_out(gram: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return the dual coefficients of the best penalty, and the mean squared error of leaving rows out.

    Args:
        gram: `(l, l)` of centred rows, or of features.
        y: `(l, c)` centred targets.

    Returns:
        `(l, c)` and `(c,)`.
    """
    count = len(y)
    values, vectors = np.linalg.eigh(gram)
    values = np.maximum(values, 0.0)
    size = float(values.mean())
    if size <= 0 or count < 2:
        return np.zeros_like(y), np.asarray((y**2).mean(axis=0))
    turned, best = vectors.T @ y, (np.inf, np.zeros_like(y), np.zeros(y.shape[1]))
    for penalty in PENALTIES * size:
        dual = vectors @ (turned / (values + penalty)[:, None])
        leverage = 1 / count + (vectors**2) @ (values / (values + penalty))
        left_out = penalty * dual / np.maximum(1 - leverage, 1e-9)[:, None]
        error = (left_out**2).mean(axis=0)
        if float(error.sum()) < best[0]:
            best = (float(error.sum()), dual, error)
    return best[1], best[2]
