"""Ridge regression, its penalty chosen by leaving rows out, in closed form (Allen's PRESS)."""

from __future__ import annotations

import numpy as np

from mien.core.arrays import Floats

PENALTIES = np.geomspace(1e-8, 1e4, 49)
"""Those tried, relative to the mean eigenvalue of the centred Gram matrix."""


def linear_map(x: Floats, y: Floats) -> tuple[Floats, Floats, Floats]:
    """Return slopes `(d, c)`, offset `(c,)` and the mean squared error of rows left out `(c,)`.

    Args:
        x: `(l, d)`.
        y: `(l, c)`.
    """
    at, centre = x.mean(axis=0), y.mean(axis=0)
    dual, error = leave_one_out((x - at) @ (x - at).T, y - centre)
    slopes = (x - at).T @ dual
    return slopes, centre - at @ slopes, error


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
