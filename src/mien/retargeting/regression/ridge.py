"""`ridge`: a linear map, its penalty chosen by leaving labels out; the least that learning can do."""

from __future__ import annotations

from dataclasses import dataclass

from mien.core.arrays import Floats
from mien.retargeting.regression.learnt import LearntRegression, learn_regression
from mien.retargeting.regression.predictor import Predictor, linear
from mien.retargeting.samples import Samples
from mien.solve.ridge import linear_map


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
    return linear(*linear_map(x, y))
