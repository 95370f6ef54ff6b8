"""What the compiled inside of the layered problem works on: the problem, one frame of it, and scratch.

The `n` unknowns `z` are the weights `W` (region after region, one per layer) followed by the
coefficients `α` (layer after layer).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from mien.core.arrays import Flags, Floats, Ints
from mien.solve.simplex_kernels import Work, scratch

ROUNDING = 1e-14
"""Rises of the objective below this share of its parts are rounding."""


class Problem(NamedTuple):
    """What all frames share.

    Attributes:
        gram: `(m, N, N)` `A_l`.
        blocks: `(m + J + 1,)` where each region's weights and each layer's coefficients begin in `z`, and where it ends.
        starts: `(J + 1,)` where each layer's coefficients begin among the coefficients, and where these end.
        region: `r`, the region of the bias; -1 for none.
        layer: `s`, the layer of the bias; -1 for none.
        target: `(K_s,)` `α_m`, the coefficients it draws that layer to.
    """

    gram: Floats
    blocks: Ints
    starts: Ints
    region: int
    layer: int
    target: Floats


class Frame(NamedTuple):
    """The problem of one frame.

    Attributes:
        problem: what all frames share.
        c: `(m, N)` `c_l`.
        energy: `‖x̂‖²`.
        gamma: γ.
        smooth: λ; 0 where no frame came before.
        before: `(n,)` the unknowns of the frame before; not read where λ is 0.
    """

    problem: Problem
    c: Floats
    energy: float
    gamma: float
    smooth: float
    before: Floats


class Parts(NamedTuple):
    """Scratch of a frame.

    Attributes:
        outputs: `(m, J, N)` `A_l α_j`.
        products: `(m, J, J)` `α_jᵀ A_l α_j'`.
        match: `(m, J)` `c_lᵀ α_j`.
        residual: `(m, N)` `A_l y_l − c_l`.
        shares: `(m, N)` the weight of each coefficient's layer in each region.
        g: `(n,)` the gradient.
        matrix: `(n, n)` the Hessian.
        block: `(N, N)` the matrix of the half-step of the coefficients.
        small: `(J, J)` the matrix of the half-step of one region's weights.
        q: `(n,)` the linear term of a half-step.
        slope: `(n,)` the gradient of a quadratic.
        goal, trial, second: `(n,)` unknowns that are tried.
        free: `(n,)` which unknowns are positive, or to become so.
        used: `(N,)` which coefficients are not 0, in order.
        pair: `(2,)` borders of a single block, from 0.
        work: scratch of the simplices.
    """

    outputs: Floats
    products: Floats
    match: Floats
    residual: Floats
    shares: Floats
    g: Floats
    matrix: Floats
    block: Floats
    small: Floats
    q: Floats
    slope: Floats
    goal: Floats
    trial: Floats
    second: Floats
    free: Flags
    used: Ints
    pair: Ints
    work: Work


@njit(cache=True, nogil=True)
def parts_for(problem: Problem) -> Parts:
    """Return the scratch of a problem."""
    regions, size, _ = problem.gram.shape
    layers, n = len(problem.starts) - 1, problem.blocks[-1]
    return Parts(
        outputs=np.empty((regions, layers, size)),
        products=np.empty((regions, layers, layers)),
        match=np.empty((regions, layers)),
        residual=np.empty((regions, size)),
        shares=np.empty((regions, size)),
        g=np.empty(n),
        matrix=np.empty((n, n)),
        block=np.empty((size, size)),
        small=np.empty((layers, layers)),
        q=np.empty(n),
        slope=np.empty(n),
        goal=np.empty(n),
        trial=np.empty(n),
        second=np.empty(n),
        free=np.empty(n, np.bool_),
        used=np.empty(size, np.int64),
        pair=np.zeros(2, np.int64),
        work=scratch(n),
    )


@njit(cache=True, nogil=True)
def rounding(frame: Frame) -> float:
    """Return by how much the objective may rise for no reason but rounding."""
    return ROUNDING * max((1.0 - frame.gamma) * frame.energy, frame.gamma, 1e-300)
