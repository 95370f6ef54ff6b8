"""Sparse weights of a rig with correctives: shapes whose weights are products of other shapes' weights.

    min_w ½ u(w)ᵀ Q u(w) − qᵀ u(w) + Σ_k l1_k |w_k|,   lower ≤ w ≤ upper

where `u(w)` are the weights of all shapes, those of the correctives as their drivers say.  It is
the lasso of every other rig with `u(w)` in place of `w`, so `Q` and `q` are the same and a frame
costs the same however many points were captured.  Racković et al. 2023 solve it for pairs of
drivers, as a quartic in one weight after another; here all weights move together.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from mien.core.arrays import Floats, floats
from mien.core.correctives import Correctives
from mien.core.errors import InputError
from mien.solve.driven_kernels import Rules, minimise_driven_frames
from mien.solve.lasso import LassoProblem, LassoSolution, frames_of


def solve_driven(
    problem: LassoProblem,
    correctives: Correctives,
    q: ArrayLike,
    start: ArrayLike | None = None,
    *,
    smoothness: float = 0.0,
    tol: float = 1e-6,
    max_steps: int = 200,
) -> LassoSolution:
    """Find a minimum for one frame or a clip, each frame from the one before.

    The problem is not convex: the minimum found is the one that the frame before leads to.
    Smoothness, the order of frames and `start` are as in `solve_lasso`.

    Args:
        problem: what all frames share, in all `K` shapes; penalty and bounds of a corrective are not used.
        correctives: which shapes follow from which.
        q: `(K,)` or `(F, K)` data vectors.
        start: `(K,)` weights of the frame before; those of correctives are not used.
        smoothness: `S`, in the unit of `Q`, on the weights that are free.
        tol: the KKT residual to reach, relative as in `LassoProblem.kkt`.
        max_steps: steps after which a frame is given up; `converged` tells.

    Returns:
        Weights of all shapes, and the residual in the free ones.

    Raises:
        InputError: shapes or pairs that do not go together, or a value of `q` that is not finite.
    """
    if not (np.isfinite(smoothness) and smoothness >= 0):
        raise InputError(f"the smoothness must be a finite number, 0 or more, but is {smoothness}.")
    if not tol > 0:
        raise InputError(f"the tolerance must be positive, but is {tol}.")
    if len(problem.exclusive):
        raise InputError("pairs that exclude each other and correctives cannot be solved for together; leave one out.")
    size = len(problem)
    rules = rules_of(correctives, size)
    values = frames_of(q, size)
    frames = np.ascontiguousarray(np.atleast_2d(values))
    before = np.zeros(size) if start is None else floats(start, (size,), "the starting weights")
    weights, left = np.empty_like(frames), np.empty(len(frames))
    steps = np.empty(len(frames), np.int64)
    scale = problem.scale(frames)
    free = rules[0]
    minimise_driven_frames(
        rules,
        problem.gram,
        problem.l1[free],
        problem.lower[free],
        problem.upper[free],
        float(smoothness),
        start is not None,
        frames,
        weights,
        left,
        steps,
        before[free],
        tol * scale,
        int(max_steps),
    )
    kkt = left / np.where(left > 0, scale, 1.0)
    shape = values.shape[:-1]
    return LassoSolution(
        weights.reshape(values.shape), kkt.reshape(shape), steps.reshape(shape), bool((kkt <= tol).all())
    )


@lru_cache(maxsize=8)
def rules_of(correctives: Correctives, size: int) -> Rules:
    """Return the correctives of `size` shapes as the kernels read them.

    Raises:
        InputError: they name a shape that is not there.
    """
    if correctives.last >= size:
        raise InputError(f"the correctives name a shape beyond the {size} of the problem.")
    free = np.setdiff1d(np.arange(size), correctives.shapes)
    among = np.full(size + 1, -1, np.int64)
    among[free] = np.arange(len(free))
    begin, end = correctives.spans
    bends: list[Floats] = [correctives.places(int(k)) for k in free]
    start = np.concatenate([[0], np.cumsum([len(b) for b in bends])]).astype(np.int64)
    return (
        free,
        np.array(correctives.shapes),
        among[correctives.drivers],
        begin,
        np.array(correctives.at),
        end,
        start,
        np.concatenate([*bends, np.empty(0)]),
    )
