"""Weights of a whole clip at once, where each frame is tied to its neighbours.

    min_x  Σ_f ½ x_fᵀ A_f x_f − Σ_f x_fᵀ V_f x_{f+1} − Σ_f load_fᵀ x_f + Σ_fk l1_k |x_fk|,   lower ≤ x ≤ upper

is what matching movements over a clip comes to (Seol et al. 2012).  `solve_clip` finds the optimum
for any such problem; `solve_uniform` is the fast way where all frames are alike and nothing is bounded.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mien.core.arrays import Flags, Floats, Ints, floats, indices
from mien.core.errors import InputError
from mien.solve import spacetime_kernels as kernels
from mien.solve.symmetric import semidefinite

HALVINGS = 12
"""How often a step that does not lower the objective is halved before the sweeps go on alone."""
SWEEPS = 4
"""Between steps on the free set; they find out what is free."""


@dataclass(frozen=True, eq=False)
class ClipProblem:
    """A problem whose frames are tied to their neighbours; the whole must be convex.

    Frames share blocks, and pairs of frames links, by number: most clips have a handful of either.

    Attributes:
        blocks: `(B, K, K)` symmetric; `A_f = blocks[which[f]]`, ties to the neighbours included.
        which: `(F,)` rows of `blocks`.
        links: `(L, K, K)` symmetric; `V_f = links[joined[f]]`.
        joined: `(F − 1,)` rows of `links`.
        load: `(F, K)`.
        l1: `(K,)` penalty per unit of |weight|.
        lower, upper: `(K,)` bounds, infinite where there is none.

    Raises:
        InputError: shapes do not fit, or a load is not finite.
    """

    blocks: Floats
    which: Ints
    links: Floats
    joined: Ints
    load: Floats
    l1: Floats
    lower: Floats
    upper: Floats

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "load", floats(self.load, (None, None), "the load"))
        frames, size = self.load.shape
        for name in ("blocks", "links"):
            put(self, name, floats(np.ascontiguousarray(getattr(self, name)), (None, size, size), f"the {name}"))
        put(self, "which", indices(self.which, (frames,), len(self.blocks), "the blocks of frames"))
        put(self, "joined", indices(self.joined, (max(frames - 1, 0),), len(self.links), "the links of frames"))
        put(self, "l1", floats(self.l1, (size,), "the l1 penalty"))
        for name in ("lower", "upper"):
            value = np.ascontiguousarray(getattr(self, name), dtype=np.float64)
            if value.shape != (size,) or np.isnan(value).any():
                raise InputError(f"the {name} bounds must be {size} numbers, one per shape, but have {value.shape}.")
            put(self, name, value)
        if (self.lower > self.upper).any() or (self.l1 < 0).any():
            raise InputError("bounds must not cross, and the l1 penalty must not be negative.")

    @cached_property
    def scale(self) -> float:
        """The gradient that counts as 1 in a KKT residual: the larger of the curvatures and the loads."""
        used = self.blocks[np.unique(self.which)]
        curve = np.einsum("bkk->bk", used).max(initial=0.0)
        return float(max(curve, np.abs(self.load).max(initial=0.0)))

    @cached_property
    def chain(self) -> tuple[Floats, Ints, Floats, Flags, Ints]:
        """The matrices as the kernels take them: which links are diagonal stands beside them."""
        off = self.links * (1 - np.eye(self.links.shape[-1]))
        return self.blocks, self.which, self.links, np.asarray(~off.any(axis=(1, 2))), self.joined

    def gradient(self, x: Floats) -> Floats:
        """Return the gradient of the smooth part at `x` `(F, K)`."""
        g = np.empty_like(x)
        kernels.gradients(*self.chain, self.load, x, g)
        return g

    def objective(self, x: Floats) -> float:
        """Return the energy at `x` `(F, K)`."""
        return float(kernels.objective(self.load, self.l1, x, self.gradient(x)))

    def kkt(self, x: Floats) -> float:
        """Return how far `x` `(F, K)` is from optimal: the largest distance of 0 from a subdifferential, over `scale`."""
        worst = kernels.residual(self.l1, self.lower, self.upper, x, self.gradient(x))
        return float(worst / self.scale) if worst > 0 else 0.0


@dataclass(frozen=True, eq=False)
class ClipSolution:
    """Weights of a clip, and how good they are.

    Attributes:
        weights: `(F, K)`; zeros are exact.
        kkt: the residual, see `ClipProblem.kkt`.
        rounds: of sweeps and steps.
        converged: whether the residual is within the tolerance.
    """

    weights: Floats
    kkt: float
    rounds: int
    converged: bool


def solve_clip(problem: ClipProblem, start: Floats, *, tol: float = 1e-8, max_rounds: int = 200) -> ClipSolution:
    """Find the optimal weights of a clip.

    Args:
        problem: convex.
        start: `(F, K)` weights to begin with, such as each frame's own optimum.
        tol: the KKT residual to reach.
        max_rounds: rounds after which it is given up; `converged` tells.
    """
    x = np.clip(floats(start, problem.load.shape, "the starting weights"), problem.lower, problem.upper)
    limits = (problem.l1, problem.lower, problem.upper)
    rounds, left = 0, problem.kkt(x)
    while left > tol and rounds < max_rounds:
        for number in range(SWEEPS):
            kernels.sweep(*problem.chain, problem.load, *limits, x, number % 2 == 1)
        x = _newton_step(problem, x)
        rounds, left = rounds + 1, problem.kkt(x)
    return ClipSolution(x, left, rounds, left <= tol)


def _newton_step(problem: ClipProblem, x: Floats) -> Floats:
    """Return lower weights on the way to the minimum over the free coordinates; `x` itself if there are none."""
    g, d, count = problem.gradient(x), np.zeros_like(x), np.empty(len(x), np.int64)
    free, limits = np.empty(x.shape, np.int64), (problem.l1, problem.lower, problem.upper)
    kernels.free_sets(problem.blocks, problem.which, *limits, x, free, count)
    kernels.newton_direction(*problem.chain, problem.l1, x, g, free, count, d)
    before = kernels.objective(problem.load, problem.l1, x, g)
    candidate = np.empty_like(x)
    for halving in range(HALVINGS):
        kernels.moved(*limits, x, d, 0.5**halving, candidate)
        if problem.objective(candidate) < before:
            return candidate
    return x


def solve_uniform(gram: Floats, link: Floats, load: Floats) -> Floats:
    """Solve an unbounded clip whose frames are all alike, `(I ⊗ gram + L ⊗ link) x = load`.

    `L` is the Laplacian of the chain of frames, so `½ x_fᵀ gram x_f` and `½ |x_{f+1} − x_f|²` in `link` are
    what is paid.  The cosine transform diagonalises `L`, and one congruence both matrices:
    `O(F K² + F K log F)`.

    Args:
        gram, link: `(K, K)` symmetric positive semi-definite.
        load: `(F, K)`.

    Returns:
        `(F, K)`; the smallest solution where there are many.

    Raises:
        InputError: a matrix is not positive semi-definite.
    """
    from scipy import fft  # a while to import, and most clips are bounded

    gram, link = semidefinite(gram, "the Gram matrix"), semidefinite(link, "the link")
    values, vectors = np.linalg.eigh(gram + link)
    kept = values > len(values) * np.finfo(np.float64).eps * max(values[-1], 0.0)
    white = vectors[:, kept] / np.sqrt(values[kept])
    share, turn = np.linalg.eigh(white.T @ link @ white)
    basis = white @ turn
    stiffness = 2 - 2 * np.cos(np.pi * np.arange(len(load)) / max(len(load), 1))
    share = np.clip(share, 0.0, 1.0)
    curve = (1 - share) + stiffness[:, None] * share
    hat = fft.dct(load @ basis, type=2, norm="ortho", axis=0)
    solved = np.divide(hat, curve, out=np.zeros_like(hat), where=curve > 1e-13)
    return np.asarray(fft.idct(solved, type=2, norm="ortho", axis=0) @ basis.T)
