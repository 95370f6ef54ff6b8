"""Blendshapes and weights in turn, until examples are explained.

With the examples `A_j`, the actor's shapes `P_i`, the generic rig's on the actor `G_i`, the weights
`α_ij` and their first guess `α*_ij`, and `D` the differences along edges (`edges`), all at the markers:

    E = Σ_j |D (A_j − Σ_i α_ij P_i)|²  +  β Σ_i Σ_r ω_ir |(D (P_i − G_i))_r|²  +  γ s Σ_ij (α_ij − α*_ij)²

Li, Weise, Pauly (2010) alternate between two steps.  *Blendshapes*, with the weights fixed: fit and
regularisation of each triangle's frame `M` in the gradient domain, `E_fit + β E_reg`, with
`ω_i = ((1 + ‖M_i‖_F) / (κ + ‖M_i‖_F))^θ`, κ = 0.1, θ = 2, where `‖M_i‖` is how much the generic shape deforms
the triangle: what it leaves alone stays alone.  *Weights*, with the blendshapes fixed: least squares over
vertices, plus `γ (α − α*)²`.  β and γ fall from one iteration to the next, from 0.5 and 1000 to 0.1 and 100
in ten.  (We have the energies and constants at second hand, so we do not cite their numbers.)

What is settled by us: edges of markers instead of frames of triangles; the generic shapes are carried
to the actor by the same warp as in the range-of-motion paper; deformation is the change of an edge in
centimetres on a human face; and the fit is one and the same in both steps, in differences along edges,
those to the skull included.  So there is one energy, which every step lowers, and falling β and γ lower
it too.  Their γ is for positions in a unit we do not know: ours is multiplied by `s`, the mean of
`|D G_i|²`, and begins at 10, which measures best of 0.1, 1 and 10.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import LinearOperator, cg

from mien.core.arrays import Floats
from mien.retargeting.example_based.edges import Edges
from mien.retargeting.settings import in_range
from mien.solve import LassoProblem, solve_lasso

KAPPA, THETA = 0.1, 2
PRECISION, MOST = 1e-9, 500
"""Relative residual of the shapes' step, and the most iterations it takes for it."""


@dataclass(frozen=True)
class Schedule:
    """How strongly the guess holds, from the first iteration to the last.

    Attributes:
        beta: on the shapes, first.
        beta_left: the share of it that is left in the last iteration.
        gamma: on the weights, first.
        gamma_left: the share of it that is left in the last iteration.
        iterations: how many.
    """

    beta: float = 0.5
    beta_left: float = 0.2
    gamma: float = 10.0
    gamma_left: float = 0.1
    iterations: int = 10

    def __post_init__(self) -> None:
        in_range(self, beta=(1e-6, 1e6), gamma=(0, 1e6), beta_left=(1e-6, 1), gamma_left=(0, 1), iterations=(1, 1000))

    def at(self, iteration: int) -> tuple[float, float]:
        """Return β and γ of an iteration."""
        share = iteration / max(1, self.iterations - 1)
        return self.beta * (1 - share * (1 - self.beta_left)), self.gamma * (1 - share * (1 - self.gamma_left))


@dataclass(frozen=True, eq=False)
class Rigging:
    """The problem: examples, and what is known of shapes and weights before.

    Attributes:
        edges: of the markers.
        examples: `(J, M, 3)` `A` [cm].
        generic: `(K, M, 3)` `G`, the generic rig's shapes on the actor [cm].
        guess: `(J, K)` `α*`.
        lower, upper: `(K,)` bounds of the weights.
    """

    edges: Edges
    examples: Floats
    generic: Floats
    guess: Floats
    lower: Floats
    upper: Floats

    @property
    def resistance(self) -> Floats:
        """`(K, R)` ω: how much each edge of each shape keeps to the generic rig."""
        change = np.linalg.norm(self.edges.of(self.generic), axis=2)
        return np.asarray(((1 + change) / (KAPPA + change)) ** THETA)

    @property
    def size(self) -> float:
        """The scale `s` of γ: the mean over the shapes of the squared differences along edges [cm²]."""
        return float((self.edges.of(self.generic) ** 2).sum() / max(len(self.generic), 1)) or 1.0

    def energy(self, shapes: Floats, weights: Floats, beta: float, gamma: float) -> float:
        """Return `E` [cm²]."""
        fit = self.edges.of(self.examples - np.tensordot(weights, shapes, axes=1))
        changed = self.edges.of(shapes - self.generic)
        away = float(((weights - self.guess) ** 2).sum())
        held = float((self.resistance[..., None] * changed**2).sum())
        return float((fit**2).sum()) + beta * held + gamma * self.size * away

    def shapes(self, start: Floats, weights: Floats, beta: float) -> Floats:
        """Return the shapes that minimise `E` with the weights fixed, `(K, M, 3)` [cm].

        The normal equations couple all shapes at all markers; they are solved by conjugate gradients from
        `start`, preconditioned by each marker's own `K × K` block.
        """
        gram, hold = weights.T @ weights, beta * self.resistance
        shape = start.shape

        def normal(flat: Floats) -> Floats:
            along = self.edges.of(flat.reshape(shape))
            pulled = np.tensordot(gram, along, axes=1) + hold[..., None] * along
            return self.edges.back(pulled).ravel()

        load = np.tensordot(weights.T, self.edges.of(self.examples), axes=1)
        load = self.edges.back(load + hold[..., None] * self.edges.of(self.generic)).ravel()
        squared = self.edges.differences.power(2)
        blocks = np.asarray(squared.sum(axis=0)).ravel()[:, None, None] * gram
        blocks += (squared.T @ hold.T)[:, :, None] * np.eye(len(start))
        inverse = np.linalg.inv(blocks)

        def precondition(flat: Floats) -> Floats:
            return np.asarray((inverse @ flat.reshape(shape).transpose(1, 0, 2)).transpose(1, 0, 2)).ravel()

        size = (load.size, load.size)
        found, _ = cg(
            LinearOperator(size, matvec=normal, dtype=np.float64),
            load,
            start.ravel(),
            rtol=PRECISION,
            maxiter=MOST,
            M=LinearOperator(size, matvec=precondition, dtype=np.float64),
        )
        return np.asarray(found.reshape(shape))

    def weights(self, shapes: Floats, gamma: float) -> Floats:
        """Return the weights within their bounds that minimise `E` with the shapes fixed, `(J, K)`."""
        along = self.edges.of(shapes).reshape(len(shapes), -1)
        wanted = self.edges.of(self.examples).reshape(len(self.examples), -1)
        pull = gamma * self.size
        gram = along @ along.T + pull * np.eye(len(shapes))
        problem = LassoProblem(gram, np.zeros(len(shapes)), self.lower, self.upper)
        return solve_lasso(problem, wanted @ along.T + pull * self.guess, tol=1e-10).weights


@dataclass(frozen=True, eq=False)
class Rigged:
    """What came of it.

    Attributes:
        shapes: `(K, M, 3)` the actor's own [cm].
        weights: `(J, K)` of the examples.
        energies: `E` before the first step and after every step [cm²], never rising.
    """

    shapes: Floats
    weights: Floats
    energies: tuple[float, ...]


def rig_by_example(problem: Rigging, schedule: Schedule) -> Rigged:
    """Alternate between shapes and weights, holding less and less to the guess."""
    shapes, weights = problem.generic, np.clip(problem.guess, problem.lower, problem.upper)
    energies = [problem.energy(shapes, weights, *schedule.at(0))]
    for iteration in range(schedule.iterations):
        beta, gamma = schedule.at(iteration)
        shapes = problem.shapes(shapes, weights, beta)
        energies.append(problem.energy(shapes, weights, beta, gamma))
        weights = problem.weights(shapes, gamma)
        energies.append(problem.energy(shapes, weights, beta, gamma))
    return Rigged(shapes, weights, tuple(energies))
