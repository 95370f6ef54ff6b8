"""Sparse weights from a fixed Gram matrix: the problem every frame of a performance poses.

Once the shapes are known, fitting a frame needs only `Q` (the same for all frames)
and one vector `q`, however many points were captured:

    min_w ½ wᵀQw − qᵀw + Σ_k l1_k |w_k|,   lower ≤ w ≤ upper

is Ribera et al. 2017, eq. 16, exactly: its fit, prior and sparsity terms are `Q`, `q`
and `l1`.  The paper approximates the absolute value by reweighted least squares; here
the optimum itself is found, so that a shape that is not needed is exactly 0.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from mien.core.arrays import Floats, Ints, floats, indices
from mien.core.errors import InputError
from mien.solve.coordinate_descent import minimise_frames
from mien.solve.symmetric import semidefinite


@dataclass(frozen=True, eq=False)
class LassoProblem:
    """The part of the problem that all frames share.

    Attributes:
        gram: `(K, K)` symmetric positive semi-definite `Q`; rank-deficient is fine.
        l1: `(K,)` or one number, penalty per unit of |weight|; 0 for a plain least squares.
        lower, upper: `(K,)` or one number, bounds of the weights; infinite where there is none.
        exclusive: `(P, 2)` pairs of shapes of which at most one may be non-zero.

    Raises:
        InputError: `gram` is not positive semi-definite, a penalty is negative, bounds
            cross, or a bound keeps an exclusive shape from being 0.
    """

    gram: Floats
    l1: Floats
    lower: Floats = field(default_factory=lambda: np.array(-np.inf))
    upper: Floats = field(default_factory=lambda: np.array(np.inf))
    exclusive: Ints = field(default_factory=lambda: np.empty((0, 2), np.int64))

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "gram", semidefinite(self.gram, "the Gram matrix"))
        size = len(self.gram)
        put(self, "l1", floats(_per_shape(self.l1, size, "the l1 penalty"), (size,), "the l1 penalty"))
        if (self.l1 < 0).any():
            worst = int(self.l1.argmin())
            raise InputError(f"the l1 penalty must not be negative, but is {self.l1[worst]:g} for shape {worst}.")
        put(self, "lower", _per_shape(self.lower, size, "the lower bound"))
        put(self, "upper", _per_shape(self.upper, size, "the upper bound"))
        usable = (self.lower <= self.upper) & (self.lower < np.inf) & (self.upper > -np.inf)
        if not usable.all():
            k = int(np.argmin(usable))
            raise InputError(f"no weight of shape {k} lies between its bounds {self.lower[k]:g} and {self.upper[k]:g}.")
        put(self, "exclusive", indices(self.exclusive, (None, 2), size, "exclusive pairs"))
        self._check_pairs()

    def _check_pairs(self) -> None:
        for a, b in self.exclusive:
            if a == b:
                raise InputError(f"an exclusive pair needs two different shapes, but shape {a} is paired with itself.")
            for k in (a, b):
                if not self.lower[k] <= 0 <= self.upper[k]:
                    raise InputError(
                        f"shape {k} is in an exclusive pair, so it must be allowed to be 0, "
                        f"but its bounds are {self.lower[k]:g} and {self.upper[k]:g}."
                    )

    def __len__(self) -> int:
        return len(self.gram)

    def objective(self, weights: Floats, q: Floats) -> Floats:
        """Return the energy of weights `(…, K)` for data vectors `(…, K)`."""
        quadratic = np.einsum("...k,...k->...", weights, 0.5 * weights @ self.gram - q)
        return np.asarray(quadratic + np.abs(weights) @ self.l1)

    def scale(self, q: Floats) -> Floats:
        """Return the gradient that counts as 1 in a KKT residual, for data vectors `(…, K)`.

        It is the larger of max diag Q (the pull of the largest shape at weight 1) and
        max |q| (the pull of the frame), so residuals depend neither on the unit of length
        nor on how the energy is weighted.
        """
        return np.asarray(np.maximum(self.gram.diagonal().max(), np.abs(q).max(axis=-1, initial=0.0)))

    def kkt(self, weights: Floats, q: Floats) -> Floats:
        """Return how far weights `(…, K)` are from optimal, ignoring the exclusive pairs.

        The largest distance of 0 from a coordinate's subdifferential (bounds included), over
        `scale`: 0 at the optimum.
        """
        gradient = weights @ self.gram - q
        above = gradient + np.where(weights > 0, self.l1, -self.l1)
        below = gradient - np.where(weights < 0, self.l1, -self.l1)
        too_high = np.where(weights > self.lower, above, 0.0)
        too_low = np.where(weights < self.upper, -below, 0.0)
        worst = np.maximum(too_high, too_low).max(axis=-1, initial=0.0)
        return np.asarray(worst / np.where(worst > 0, self.scale(q), 1.0))


@dataclass(frozen=True, eq=False)
class LassoSolution:
    """Weights, and how good they are.

    Attributes:
        weights: `(K,)` or `(F, K)`, as `q` was; zeros are exact.
        kkt: `()` or `(F,)` residual per frame, see `LassoProblem.kkt`; of the problem without the
            zeroed members where pairs exclude each other, and with the smoothness term where there is one.
        sweeps: `()` or `(F,)` rounds of coordinate descent per frame.
        converged: whether every frame's residual is within the tolerance.
    """

    weights: Floats
    kkt: Floats
    sweeps: Ints
    converged: bool


def solve_lasso(
    problem: LassoProblem,
    q: ArrayLike,
    start: ArrayLike | None = None,
    *,
    smoothness: float = 0.0,
    tol: float = 1e-6,
    max_sweeps: int = 1000,
) -> LassoSolution:
    """Find the optimal weights of one frame or of a clip (Ribera et al. 2017, eq. 16).

    A clip is solved in order, each frame from the one before.  Passing each frame's
    weights as the next one's `start` gives the same numbers as the whole clip at once.

    With `smoothness` `S` each frame also pays `S ‖w − w_prev‖²` against the frame before
    (`start`, for the first; none without one).  The term vanishes for a held pose, so it
    delays but never weakens an expression.

    Exclusive pairs make the problem non-convex.  The convex problem is solved first; where
    both members of a pair are active, both ways of zeroing one are tried and the better is
    kept.  That is the optimum when one pair is violated; with several they are settled one
    after the other, in the order given, which may miss the best combination.

    Args:
        problem: what all frames share.
        q: `(K,)` or `(F, K)` data vectors.
        start: `(K,)` weights of the frame before.
        smoothness: `S`, in the unit of `Q`; larger follows more slowly.
        tol: the KKT residual to reach, see `LassoProblem.kkt`.
        max_sweeps: rounds after which a frame is given up; `converged` tells.

    Raises:
        InputError: wrong shapes, or a value of `q` that is not finite (the frame is named).
    """
    if not (np.isfinite(smoothness) and smoothness >= 0):
        raise InputError(f"the smoothness must be a finite number, 0 or more, but is {smoothness}.")
    if not tol > 0:
        raise InputError(f"the tolerance must be positive, but is {tol}.")
    values = frames_of(q, len(problem))
    frames = np.ascontiguousarray(np.atleast_2d(values))
    w = np.zeros(len(problem)) if start is None else np.array(floats(start, (len(problem),), "the starting weights"))
    weights, left = np.empty_like(frames), np.empty(len(frames))
    sweeps = np.empty(len(frames), np.int64)
    scale = problem.scale(frames)
    minimise_frames(
        problem.gram,
        problem.l1.copy(),
        problem.lower.copy(),
        problem.upper.copy(),
        problem.exclusive,
        float(smoothness),
        start is not None,
        frames,
        weights,
        left,
        sweeps,
        w,
        tol * scale,
        int(max_sweeps),
    )
    kkt = left / np.where(left > 0, scale, 1.0)
    shape = values.shape[:-1]
    return LassoSolution(
        weights.reshape(values.shape), kkt.reshape(shape), sweeps.reshape(shape), bool((kkt <= tol).all())
    )


def symmetric_penalty(size: int, pairs: Iterable[tuple[int, int]], strength: float) -> Floats:
    """Return the `(size, size)` matrix to add to `Q` so that each pair pays `strength (w_a − w_b)²`.

    Raises:
        InputError: a shape does not exist or the strength is negative.
    """
    if not (np.isfinite(strength) and strength >= 0):
        raise InputError(f"the strength of a symmetry must be a finite number, 0 or more, but is {strength}.")
    rows = indices(np.array(list(pairs), np.int64).reshape(-1, 2), (None, 2), size, "symmetric pairs")
    difference = np.zeros((len(rows), size))
    np.add.at(difference, (np.arange(len(rows)), rows[:, 0]), 1.0)
    np.add.at(difference, (np.arange(len(rows)), rows[:, 1]), -1.0)
    return np.asarray(2 * strength * difference.T @ difference)


def _per_shape(value: ArrayLike, size: int, what: str) -> Floats:
    array = np.asarray(value, dtype=np.float64)
    if array.shape not in ((), (size,)) or np.isnan(array).any():
        raise InputError(f"{what} must be one number or {size}, one per shape, without NaN; got shape {array.shape}.")
    return np.array(np.broadcast_to(array, (size,)))


def frames_of(q: ArrayLike, size: int) -> Floats:
    """Return data vectors `(size,)` or `(F, size)` as they are.

    Raises:
        InputError: another shape, or a value that is not finite (the frame is named).
    """
    values = np.asarray(q, dtype=np.float64)
    if values.ndim not in (1, 2) or values.shape[-1] != size:
        raise InputError(f"the data vectors must have shape ({size},) or (frames, {size}), but have {values.shape}.")
    bad = ~np.isfinite(np.atleast_2d(values)).all(axis=1)
    if bad.any():
        raise InputError(
            f"the data vector of frame {int(bad.argmax())} is not finite (and {int(bad.sum()) - 1} more): "
            "fill or leave out frames that were not tracked before solving."
        )
    return values
