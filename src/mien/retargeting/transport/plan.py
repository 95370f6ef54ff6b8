"""The entropic optimal transport plan between two clouds of equal weight (Cuturi 2013)."""

from __future__ import annotations

import numpy as np

from mien.core.arrays import Floats

SMALLEST = 1e-280
"""LinearRadialKernel entries below it count as this: a row far from all others still finds a partner."""


def transport_plan(cost: Floats, softness: float, iterations: int = 100) -> Floats:
    """Return the plan `(n, m)` that moves n equal masses to m equal masses at the least cost, less its entropy.

    Minimises `⟨P, C⟩ + ε Σ P log P` over plans with row sums `1/n` and column sums `1/m` by
    Sinkhorn's alternating scaling, which ends on the rows: those sums are exact.

    Args:
        cost: `(n, m)`.
        softness: ε, in units of the cost: near 0 the plan is an assignment, large it is uniform.
        iterations: scalings of rows and columns.
    """
    n, m = cost.shape
    reduced = cost - cost.min(axis=1, keepdims=True)
    reduced -= reduced.min(axis=0, keepdims=True)
    kernel = np.maximum(np.exp(-reduced / softness), SMALLEST)
    rows = np.full(n, 1 / n)
    for _ in range(iterations):
        columns = 1 / (m * (rows @ kernel))
        rows = 1 / (n * (kernel @ columns))
    return np.asarray(rows[:, None] * kernel * columns)
