"""Problems on the unit simplex: shares that are not negative and sum to 1.

Layers mix expressions by shares (Kholgade, Matthews, Sheikh 2011, §3.1): projections
onto one simplex, and convex quadratics over one simplex or several, are solved exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mien.core.arrays import Floats, Ints, floats
from mien.core.errors import InputError
from mien.solve.simplex_kernels import kkt, minimise_faces, minimise_simplices, quadratic_gradient, scratch
from mien.solve.symmetric import semidefinite

FEW = 6
"""Up to so many variables all faces of a simplex are tried; with more they are walked along."""


@dataclass(frozen=True, eq=False)
class SimplexSolution:
    """Shares, and how good they are.

    Attributes:
        x: `(n,)` shares; zeros are exact, and each block sums to 1.
        kkt: by how much the gradient of a used share exceeds the least of its block, over the
            largest curvature: 0 at the optimum.
        steps: active-set steps made.
    """

    x: Floats
    kkt: float
    steps: int


def project_simplex(points: ArrayLike) -> Floats:
    """Return the closest points of the unit simplex, exactly, for points `(…, n)`.

    The shares are `max(x − θ, 0)` with the one threshold `θ` at which they sum to 1, found
    from the sorted coordinates.

    Raises:
        InputError: there is no coordinate, or one is not finite.
    """
    x = np.asarray(points, dtype=np.float64)
    if not x.ndim or not x.shape[-1] or not np.isfinite(x).all():
        raise InputError(f"only finite points with at least one coordinate have a closest share; got shape {x.shape}.")
    falling = -np.sort(-x, axis=-1)
    above = np.cumsum(falling, axis=-1) - 1
    count = np.arange(1, x.shape[-1] + 1)
    last = (falling * count > above).sum(axis=-1, keepdims=True)
    threshold = np.take_along_axis(above, last - 1, axis=-1) / last
    return np.asarray(np.maximum(x - threshold, 0.0))


def simplex_qp(matrix: ArrayLike, q: ArrayLike) -> SimplexSolution:
    """Minimise `½ xᵀQx − qᵀx` over the unit simplex.

    Up to six variables it is a closed form: the best of the minima of all faces.

    Raises:
        InputError: `matrix` is not positive semi-definite, or shapes do not match.
    """
    size = len(np.atleast_1d(np.asarray(q)))
    if size > FEW:
        return solve_simplices(matrix, q, (size,))
    Q, b = semidefinite(matrix, "the matrix"), floats(q, (size,), "q")
    _check_size(Q, size)
    x = np.zeros(size)
    minimise_faces(Q, b.copy(), x, scratch(size))
    return _solution(Q, b, np.array([0, size]), x, 0)


def solve_simplices(
    matrix: ArrayLike,
    q: ArrayLike,
    sizes: Sequence[int],
    start: ArrayLike | None = None,
    *,
    tol: float = 1e-10,
    max_steps: int = 10_000,
) -> SimplexSolution:
    """Minimise `½ xᵀQx − qᵀx` over a product of unit simplices.

    Args:
        matrix: `(n, n)` positive semi-definite `Q`; rank-deficient is fine.
        q: `(n,)`.
        sizes: variables of each simplex; they sum to `n`.
        start: `(n,)` shares to start from; near the optimum few steps are needed. Equal shares if None.
        tol: KKT residual to reach, see `SimplexSolution.kkt`.
        max_steps: active-set steps after which it stops; the residual tells.

    Raises:
        InputError: `matrix` is not positive semi-definite, shapes do not match, or the start is not on the simplices.
    """
    counts = np.asarray(sizes, dtype=np.int64)
    if not len(counts) or counts.min() < 1:
        raise InputError(f"every simplex needs at least one variable; the sizes are {list(sizes)}.")
    starts = np.concatenate([[0], np.cumsum(counts)])
    Q, b = semidefinite(matrix, "the matrix"), floats(q, (int(starts[-1]),), "q")
    _check_size(Q, len(b))
    x = np.repeat(1.0 / counts, counts) if start is None else np.array(floats(start, b.shape, "the start"))
    if (x < 0).any() or np.abs(np.add.reduceat(x, starts[:-1]) - 1).max() > 1e-9:
        raise InputError("the start must hold shares: none negative, and those of each simplex with the sum 1.")
    tolerance = tol * _scale(Q, b)
    steps = minimise_simplices(
        Q, b.copy(), starts, x, np.empty_like(x), np.empty(len(x), np.bool_), scratch(len(x)), tolerance, max_steps
    )
    return _solution(Q, b, starts, x, int(steps))


def _solution(Q: Floats, b: Floats, starts: Ints, x: Floats, steps: int) -> SimplexSolution:
    g = np.empty_like(x)
    quadratic_gradient(Q, b.copy(), x, g)
    return SimplexSolution(x, float(kkt(starts, x, g)) / _scale(Q, b), steps)


def _scale(Q: Floats, b: Floats) -> float:
    return max(float(Q.diagonal().max()), float(np.abs(b).max()), 1e-300)


def _check_size(Q: Floats, size: int) -> None:
    if len(Q) != size:
        raise InputError(f"the matrix is for {len(Q)} variables, q for {size}.")
