"""General solvers, frame by frame on the same shapes.

Install: SciPy is there with mien; `pip install scikit-learn` for the lasso and the elastic net.

The unregularised ones (`nnls`, `lsq_linear`) have no weight to tune.  Those of scikit-learn get
mien's own sparsity, brought to their scale: they divide the squared error by twice the number
of rows, mien by the number of points.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from benchmarks.peers.adapter import Absent, Peer, SolverMethod, frame_by_frame
from mien.core.arrays import Floats
from mien.retargeting.settings import SolveSettings

OURS = SolveSettings()
MIXED = 0.5
"""The share of the L1 term in the elastic net, scikit-learn's own default."""


def nonnegative(matrix: Floats, right: Floats) -> Floats:
    """Solve by Lawson and Hanson's active set."""
    from scipy.optimize import nnls

    return np.asarray(nnls(matrix, right)[0])


def bounded(matrix: Floats, right: Floats) -> Floats:
    """Solve between mien's bounds by the trust-region reflective method."""
    from scipy.optimize import lsq_linear

    assert OURS.bounds is not None
    return np.asarray(lsq_linear(matrix, right, bounds=OURS.bounds).x)


def regularised(model: Any, matrix: Floats, right: Floats) -> Floats:
    """Solve with one of scikit-learn's coordinate descents, weights not negative."""
    alpha = OURS.sparsity / (6 * matrix.shape[1])
    extra = {"l1_ratio": MIXED} if model.__name__ == "ElasticNet" else {}
    fitted = model(alpha=alpha, positive=True, fit_intercept=False, max_iter=20_000, **extra).fit(matrix, right)
    return np.asarray(fitted.coef_)


def scikit(name: str) -> SolverMethod:
    try:
        from sklearn import linear_model
    except ImportError:
        raise Absent("scikit-learn is not installed") from None
    return SolverMethod(frame_by_frame(partial(regularised, getattr(linear_model, name))))


SOLVERS = (
    Peer(
        "scipy-nnls",
        "SciPy's non-negative least squares",
        "with mien",
        lambda: SolverMethod(frame_by_frame(nonnegative)),
    ),
    Peer("scipy-bounded", "SciPy's bounded least squares", "with mien", lambda: SolverMethod(frame_by_frame(bounded))),
    Peer("sklearn-lasso", "scikit-learn's lasso", "pip install scikit-learn", lambda: scikit("Lasso")),
    Peer("sklearn-elastic", "scikit-learn's elastic net", "pip install scikit-learn", lambda: scikit("ElasticNet")),
)
