"""Layers that share a face: weights of layers per region, and shares of extremes per layer, found together.

With bases `B_j`, region masks `M_l` and displacements `x̂`, each frame poses (Kholgade,
Matthews, Sheikh 2011, §4, its augmented problem multiplied by 1 − γ):

    min  (1−γ) ‖x̂ − Σ_jl w_jl M_l B_j α_j‖² + γ (‖w_·r − e_s‖² + ‖α_s − α_m‖²)
         + λ (‖W − W_before‖² + ‖α − α_before‖²)

over `W` with the weights of each region, and `α` with the coefficients of each layer, on
the unit simplex.  Dividing by 1 − γ, as printed, has the same minimiser and blows up where
γ is 1.  Of the data only `A_l = Bᵀ M_l B` (once) and `c_l = Bᵀ M_l x̂` (each frame) are
needed, so the cost does not depend on the number of points.

The problem is bilinear: a solution is a point from which no first-order move improves, found
downhill from the frame before.  The paper hands it to interior-point and SQP codes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise, product

import numpy as np
from numpy.typing import ArrayLike

from mien.core.arrays import Floats, Ints, floats
from mien.core.errors import InputError
from mien.solve.layered_descent import Frames, History, descend, descend_frames
from mien.solve.layered_frame import Frame, Problem, parts_for
from mien.solve.layered_terms import correlate, gradient, objective
from mien.solve.simplex_kernels import kkt
from mien.solve.symmetric import semidefinite

TOLERANCE = 1e-10
"""KKT residual to reach, over the scale of the frame's gradient."""
MOST_STARTS = 81
"""The first frame is solved from no more starts than this."""
AS_GOOD = 1e-10
"""Starts whose objectives differ by less than this share of the scale are as good; the first of them is kept."""
MAX_ROUNDS = 500
"""Rounds of alternation and Newton steps after which a frame is given up; `converged` tells."""


@dataclass(frozen=True, eq=False)
class Bias:
    """What the bias γ draws to: one region to one layer, and that layer to some coefficients.

    Attributes:
        region: `r`, the region (the mouth).
        layer: `s`, the layer (speech).
        coefficients: `(K_s,)` shares `α_m` (the closed lips of /m/).
    """

    region: int
    layer: int
    coefficients: Floats


@dataclass(frozen=True, eq=False)
class LayeredProblem:
    """The part of the problem that all frames share.

    Attributes:
        gram: `(m, N, N)` `A_l = Bᵀ M_l B` for each of the `m` regions; the `N` columns of `B` are
            the extremes of the first layer, then of the second, and so on.
        sizes: `K_j`, how many extremes each of the `J` layers has.
        smooth: λ.
        bias: what γ draws to; None for none.

    Raises:
        InputError: shapes do not match, a matrix is not positive semi-definite, or λ is negative.
    """

    gram: Floats
    sizes: tuple[int, ...]
    smooth: float = 0.0
    bias: Bias | None = None
    compiled: Problem = field(init=False, repr=False)
    top: float = field(init=False, repr=False)

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "sizes", tuple(int(k) for k in self.sizes))
        if not self.sizes or min(self.sizes) < 1:
            raise InputError(f"every layer needs at least one extreme; the sizes are {list(self.sizes)}.")
        size = sum(self.sizes)
        matrices = floats(self.gram, (None, size, size), "the Gram matrices")
        if not len(matrices):
            raise InputError("a face in layers needs at least one region.")
        whole = [semidefinite(matrix, f"the Gram matrix of region {r}") for r, matrix in enumerate(matrices)]
        put(self, "gram", np.ascontiguousarray(whole))
        if not (np.isfinite(self.smooth) and self.smooth >= 0):
            raise InputError(f"the smoothness must be a finite number, 0 or more, but is {self.smooth}.")
        put(self, "compiled", self._compiled())
        put(self, "top", float(self.gram.sum(axis=0).diagonal().max()))

    @property
    def regions(self) -> int:
        """How many regions there are, `m`."""
        return len(self.gram)

    @property
    def layers(self) -> int:
        """How many layers there are, `J`."""
        return len(self.sizes)

    @cached_property
    def starts(self) -> Ints:
        """`(J + 1,)` where each layer's coefficients begin."""
        return np.concatenate([[0], np.cumsum(self.sizes)]).astype(np.int64)

    def _compiled(self) -> Problem:
        starts = self.starts
        first = self.regions * self.layers
        blocks = np.concatenate([np.arange(0, first, self.layers), first + starts]).astype(np.int64)
        if self.bias is None:
            return Problem(self.gram, blocks, starts, -1, -1, np.zeros(0))
        region, layer = self.bias.region, self.bias.layer
        if not (0 <= region < self.regions and 0 <= layer < self.layers):
            raise InputError(
                f"the bias is towards layer {layer} in region {region}, "
                f"but there are {self.layers} layers and {self.regions} regions."
            )
        target = floats(self.bias.coefficients, (self.sizes[layer],), "the coefficients of the bias")
        return Problem(self.gram, blocks, starts, int(region), int(layer), target.copy())

    def frame(self, c: Floats, energy: float, gamma: float, before: Floats | None) -> Frame:
        """Return the problem of one frame, see `evaluate`."""
        smooth = 0.0 if before is None else float(self.smooth)
        old = np.zeros(self.compiled.blocks[-1]) if before is None else np.array(before, np.float64)
        return Frame(self.compiled, np.ascontiguousarray(c), float(energy), float(gamma), smooth, old)

    def scale(self, gamma: Floats) -> Floats:
        """Return the gradient that counts as 1 in a KKT residual, for biases `(…)`.

        It is what the largest extreme, the bias and the smoothness pull: `2 ((1−γ) max diag Σ A_l + γ + λ)`.
        """
        biased = 0.0 if self.bias is None else gamma
        return np.asarray(np.maximum(2 * ((1 - gamma) * self.top + biased + self.smooth), 1e-300))

    def evaluate(
        self,
        weights: Floats,
        coefficients: Floats,
        c: Floats,
        energy: float,
        gamma: float = 0.0,
        before: Floats | None = None,
    ) -> tuple[float, Floats, float]:
        """Return a frame's objective, its gradient `(m J + N,)`, and the KKT residual, at any point.

        Args:
            weights: `(m, J)`.
            coefficients: `(N,)`.
            c: `(m, N)` `Bᵀ M_l x̂`.
            energy: `‖x̂‖²`.
            gamma: γ.
            before: `(m J + N,)` the unknowns of the frame before; no smoothness if None.
        """
        z = np.concatenate([np.asarray(weights, np.float64).ravel(), coefficients])
        frame, parts = self.frame(c, energy, gamma, before), parts_for(self.compiled)
        correlate(frame, z, parts)
        value = objective(frame, z, parts) + (1 - gamma) * energy
        gradient(frame, z, parts)
        residual = kkt(self.compiled.blocks, z, parts.g) / float(self.scale(np.array(gamma)))
        return float(value), parts.g.copy(), float(residual)


@dataclass(frozen=True, eq=False)
class LayeredSolution:
    """Weights and coefficients, and how good they are.

    Attributes:
        weights: `(F, m, J)` weight of each layer in each region, the paper's `W`.
        coefficients: `(F, N)` shares of the extremes, the paper's `α`.
        objective: `(F,)` each frame's minimum.
        kkt: `(F,)` by how much the gradient of a used share exceeds the least of its simplex, at
            most, over `LayeredProblem.scale`: 0 where no first-order move improves.
        rounds: `(F,)` rounds of alternation and Newton steps.
        converged: whether every frame's residual is within the tolerance.
    """

    weights: Floats
    coefficients: Floats
    objective: Floats
    kkt: Floats
    rounds: Ints
    converged: bool

    @property
    def last(self) -> Floats:
        """`(m J + N,)` the unknowns of the last frame: the start of the next."""
        return np.concatenate([self.weights[-1].ravel(), self.coefficients[-1]])


def solve_layered(
    problem: LayeredProblem,
    data: ArrayLike,
    energy: ArrayLike,
    gamma: ArrayLike | None = None,
    before: ArrayLike | None = None,
    *,
    tol: float = TOLERANCE,
    max_rounds: int = MAX_ROUNDS,
) -> LayeredSolution:
    """Solve frames in order, each from the one before.

    The first frame, if none came before it, has no smoothness term and is solved from several
    starts, see `first_starts`; the best solution is kept, the first of equals: a face at rest is
    all of the first layer.  Passing each frame's `last` as the next one's `before` gives the same
    numbers, to the bit, as all frames at once.

    Args:
        problem: what all frames share.
        data: `(F, m, N)` `c_l = Bᵀ M_l x̂`.
        energy: `(F,)` `‖x̂‖²`.
        gamma: `(F,)` the bias γ, 0 to 1; 0 if None.
        before: `(m J + N,)` the unknowns of the frame before.
        tol: the KKT residual to reach.
        max_rounds: rounds after which a frame is given up; `converged` tells.

    Raises:
        InputError: wrong shapes, or a value that is not finite.
    """
    size, first = sum(problem.sizes), problem.regions * problem.layers
    c = np.array(floats(data, (None, problem.regions, size), "the data vectors"), order="C")
    power = np.array(floats(energy, (len(c),), "the energies"))
    bias = np.array(floats(np.zeros(len(c)) if gamma is None else gamma, (len(c),), "the biases"))
    if len(bias) and not (bias.min() >= 0 and bias.max() <= 1):
        raise InputError(f"the bias must lie between 0 and 1, but reaches from {bias.min():g} to {bias.max():g}.")
    if problem.bias is None:
        bias[:] = 0.0
    scale = problem.scale(bias)
    count, unknowns = len(c), first + size
    z, rounds = np.empty((count, unknowns)), np.zeros(count, np.int64)
    frames = Frames(c, power, bias, tol * scale, z, np.empty(count), np.empty(count), rounds)
    begin = 0
    if before is None and count:
        z[0], frames.objective[0], frames.left[0], rounds[0] = _best_start(
            problem, c[0], power[0], bias[0], tol, max_rounds
        )
        begin, before = 1, z[0]
    old = np.array(floats(np.asarray(before), (unknowns,), "the frame before"))
    descend_frames(tuple(problem.compiled), float(problem.smooth), tuple(frames), begin, old, int(max_rounds))
    return LayeredSolution(
        z[:, :first].reshape(-1, problem.regions, problem.layers),
        z[:, first:],
        frames.objective,
        frames.left / scale,
        rounds,
        bool((frames.left <= frames.tolerance).all()),
    )


def first_starts(problem: LayeredProblem, c: Floats) -> Floats:
    """Return `(S, m J + N)` starts for a frame with none before it.

    Each way of giving every region to one layer (only each layer alone, where there are more than
    `MOST_STARTS` ways), the first layer first, every layer beginning with the extreme that fits
    its regions best; and equal shares of everything.
    """
    regions, layers, starts = problem.regions, problem.layers, problem.starts
    misfit = problem.gram.diagonal(axis1=1, axis2=2) - 2 * c
    ways = list(product(range(layers), repeat=regions)) if layers**regions <= MOST_STARTS else []
    found = []
    for way in ways or [(j,) * regions for j in range(layers)]:
        weights = np.eye(layers)[list(way)]
        alpha = np.zeros(sum(problem.sizes))
        for j, (a, b) in enumerate(pairwise(starts)):
            own = weights[:, j] if weights[:, j].any() else np.ones(regions)
            alpha[a + int(np.argmin(own @ misfit[:, a:b]))] = 1.0
        found.append(np.concatenate([weights.ravel(), alpha]))
    found.append(np.concatenate([np.full(regions * layers, 1 / layers), *(np.full(k, 1 / k) for k in problem.sizes)]))
    return np.stack(found)


def descend_from(
    problem: LayeredProblem,
    start: Floats,
    c: Floats,
    energy: float,
    gamma: float = 0.0,
    before: Floats | None = None,
    *,
    tol: float = TOLERANCE,
    max_rounds: int = MAX_ROUNDS,
) -> tuple[Floats, float, float, int, Floats]:
    """Solve one frame from one start.

    Returns:
        The unknowns, the objective, the KKT residual, the rounds, and the objective without its
        constant after every half-step of the way, which never rises.
    """
    z, history = np.array(start, np.float64), History(np.empty(4 * max_rounds + 4), np.zeros(1, np.int64))
    frame, scale = problem.frame(c, energy, gamma, before), float(problem.scale(np.array(gamma)))
    value, left, rounds = descend(frame, z, tol * scale, int(max_rounds), parts_for(problem.compiled), history)
    return z, float(value), float(left) / scale, int(rounds), history.values[: history.length[0]]


def _best_start(
    problem: LayeredProblem, c: Floats, energy: float, gamma: float, tol: float, max_rounds: int
) -> tuple[Floats, float, float, int]:
    scale = float(problem.scale(np.array(gamma)))
    tries = [
        descend_from(problem, start, c, energy, gamma, tol=tol, max_rounds=max_rounds)
        for start in first_starts(problem, c)
    ]
    best = min(value for _, value, *_ in tries)
    z, value, left, rounds, _ = next(found for found in tries if found[1] <= best + AS_GOOD * scale)
    return z, value, left * scale, rounds


def layer_weights(starts: Sequence[int] | Ints, weights: Floats, coefficients: Floats) -> Floats:
    """Return `y_lk = w_jl α_jk` `(…, m, N)`, the weight of every extreme in every region."""
    counts = np.diff(np.asarray(starts))
    return np.asarray(np.repeat(weights, counts, axis=-1) * coefficients[..., None, :])
