"""Smooth minimisation with an honest account of how far it got.

Likelihoods of Gaussian processes are minimised over thousands of numbers at once.  What
matters to the caller, beside the minimum, is whether it is one: the objective, the norm
of what is left of the gradient, and why the search stopped.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from mien.core.arrays import Floats

Objective = Callable[[Floats], tuple[float, Floats]]
Bounds = Sequence[tuple[float | None, float | None]]


@dataclass(frozen=True, eq=False)
class Minimum:
    """Where a search ended.

    Attributes:
        x: `(n,)` the point.
        value: the objective there.
        gradient: the largest entry of the gradient there, those that push against a bound left out.
        iterations: of the search.
        evaluations: of the objective.
        converged: whether the gradient is as small as asked.
        message: why the search stopped, in words.
    """

    x: Floats
    value: float
    gradient: float
    iterations: int
    evaluations: int
    converged: bool
    message: str


def minimise(
    objective: Objective,
    start: Floats,
    bounds: Bounds | None = None,
    *,
    gradient: float = 1e-3,
    iterations: int = 1000,
) -> Minimum:
    """Minimise a smooth function by L-BFGS with bounds, on one thread.

    Matrices of a few hundred rows are multiplied faster on one core than divided among
    several; and on one thread the result is the same on every run.

    Args:
        objective: returns value and gradient `(n,)`; infinity where it is not defined.
        start: `(n,)` where to begin.
        bounds: lowest and highest of each number, None where there is none.
        gradient: the largest entry of the gradient at which to stop.
        iterations: the most to make.
    """
    from scipy.optimize import minimize
    from threadpoolctl import threadpool_limits

    options = {"maxiter": iterations, "maxfun": 2 * iterations, "gtol": gradient, "ftol": 1e-15, "maxcor": 20}
    with threadpool_limits(limits=1):
        found = minimize(objective, start, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
    left = float(np.abs(_projected(found.x, found.jac, bounds)).max(initial=0.0))
    return Minimum(
        found.x,
        float(found.fun),
        left,
        int(found.nit),
        int(found.nfev),
        bool(left <= gradient),
        str(found.message).strip().capitalize(),
    )


def _projected(x: Floats, gradient: Floats, bounds: Bounds | None) -> Floats:
    """Return the gradient without what pushes against a bound."""
    if bounds is None:
        return gradient
    low = np.array([-np.inf if b[0] is None else b[0] for b in bounds])
    high = np.array([np.inf if b[1] is None else b[1] for b in bounds])
    return np.asarray(x - np.clip(x - gradient, low, high))
