"""The retargeting energy as small matrices, and its solution frame by frame.

Ribera et al. 2017, eq. 2, 15 and 16:

    min_w  1/M |Δa - Σ w_k Δp_k|²  +  µ/N |L ΔV w|²  +  ν/K Σ c_k |w_k|

with another prior in place of the second term if one is chosen (`PRIORS`), plus, when
asked, `s |w - w_before|²`, a penalty on the difference of symmetric pairs, and damping,
`ρ/M Σ |Δp_k|² w_k²`: what shapes that are a little wrong, each on its own, would add to
the error.  `Δp` are the actor's own blendshapes at the markers, so everything a frame needs
is one `K × K` Gram matrix and one `K`-vector: a lasso in a fixed matrix.  On a rig with
correctives `w` are the weights of all shapes as the free ones drive them (`solve.driven`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from mien.core import Correctives, InputError
from mien.core.arrays import Flags, Floats, Ints
from mien.core.errors import unknown
from mien.retargeting.prior import PRIORS
from mien.retargeting.settings import SolveSettings
from mien.solve import LassoProblem, LassoSolution, solve_driven, solve_lasso, symmetric_penalty

RATE = 30.0
"""The frame rate for which the smoothness is stated."""
TOLERANCE = 1e-8
"""KKT residual to reach: tight, so that nearly equal shapes share their weight alike on every run and machine."""


@dataclass(frozen=True, eq=False)
class FrameSolver:
    """Everything a frame needs: solve for weights given displacements of the markers.

    Attributes:
        shapes: `(K, M, 3)` the actor's own blendshapes `Δp` [cm].
        confidence: `(M,)` how much each marker counts.
        regular: `(K, K)` prior, damping and symmetry as a quadratic form, as added to the Gram matrix.
        l1: `(K,)` ν/K times each shape's factor, and what the prior adds.
        lower, upper: `(K,)` bounds of the weights.
        exclusive: `(P, 2)` pairs never active together.
        settings: as asked for.
        correctives: which weights follow from others; None if all are free.
    """

    shapes: Floats
    confidence: Floats
    regular: Floats
    l1: Floats
    lower: Floats
    upper: Floats
    exclusive: Ints
    settings: SolveSettings
    correctives: Correctives | None = None

    @property
    def convex(self) -> bool:
        """Whether a whole take is one convex problem in which every frame is like this one."""
        return not len(self.exclusive) and self.correctives is None

    def problem(self, seen: Flags) -> tuple[LassoProblem, Floats]:
        """Return the problem for frames that see these markers `(M,)`, and `2/M Δp` for its data vectors."""
        weight = np.where(seen, self.confidence, 0.0)
        scaled = self.shapes * (2 * weight / max(weight.sum(), 1e-12))[:, None]
        k = len(self.shapes)
        gram = scaled.reshape(k, -1) @ self.shapes.reshape(k, -1).T + self.regular
        return LassoProblem(gram, self.l1, self.lower, self.upper, self.exclusive), scaled.reshape(k, -1)

    def batch(self, take: Floats, fps: float = RATE) -> tuple[Floats, float]:
        """Solve a take frame after frame, each from the one before.

        Args:
            take: `(F, M, 3)` displacements [cm]; NaN where a marker is missing.
            fps: frames per second, for the smoothness.

        Returns:
            `(F, K)` weights, and the largest KKT residual. A frame that sees nothing holds
            the one before.
        """
        seen = ~np.isnan(take[..., 0])
        data = np.where(seen[..., None], take, 0.0).reshape(len(take), -1)
        weights = np.zeros((len(take), len(self.shapes)))
        problems: dict[bytes, tuple[LassoProblem, Floats]] = {}
        before: Floats | None = None
        worst = 0.0
        for begin, end in _runs(seen):
            if not seen[begin].any():
                weights[begin:end] = 0.0 if before is None else before
                continue
            key = seen[begin].tobytes()
            if key not in problems:
                problems[key] = self.problem(seen[begin])
            problem, scaled = problems[key]
            solved = self._minimised(problem, data[begin:end] @ scaled.T, before, fps)
            weights[begin:end] = solved.weights
            before = solved.weights[-1]
            worst = max(worst, float(solved.kkt.max()))
        return weights, worst

    def step(self, displacements: Floats, before: Floats | None, fps: float = RATE) -> Floats:
        """Solve one frame `(M, 3)` from the weights before it: what `batch` does, one frame at a time."""
        seen = ~np.isnan(displacements[:, 0])
        if not seen.any():
            return np.zeros(len(self.shapes)) if before is None else before
        problem, scaled = self._whole if seen.all() else self.problem(seen)
        q = np.where(seen[:, None], displacements, 0.0).ravel() @ scaled.T
        return self._minimised(problem, q, before, fps).weights

    def _minimised(self, problem: LassoProblem, q: Floats, before: Floats | None, fps: float) -> LassoSolution:
        """Solve one frame or several that see the same markers, given their data vectors too."""
        smoothness = self._smoothness(fps)
        if self.correctives is not None:
            return solve_driven(problem, self.correctives, q, before, smoothness=smoothness, tol=TOLERANCE)
        return solve_lasso(problem, q, before, smoothness=smoothness, tol=TOLERANCE)

    def _smoothness(self, fps: float) -> float:
        """Return what a squared change between frames costs: a weight that moves at one speed pays alike at any rate."""
        return self.settings.smooth * (fps / RATE) ** 2

    @cached_property
    def _whole(self) -> tuple[LassoProblem, Floats]:
        return self.problem(np.ones(self.shapes.shape[1], dtype=bool))


def _runs(seen: Flags) -> list[tuple[int, int]]:
    """Return `[begin, end)` of runs of frames that see the same markers."""
    cuts = np.flatnonzero((seen[1:] != seen[:-1]).any(axis=1)) + 1
    edges = [0, *cuts.tolist(), len(seen)]
    return list(pairwise(edges))


def frame_solver(
    shapes: Floats,
    names: Sequence[str],
    unlikely: Floats,
    confidence: Floats,
    settings: SolveSettings,
    cost: Floats | None = None,
    correctives: Correctives | None = None,
) -> FrameSolver:
    """Assemble the per-frame problem (eq. 16).

    Args:
        shapes: `(K, M, 3)` the actor's own blendshapes [cm].
        names: their `K` names.
        unlikely: `(K, K)` quadratic form of the prior, see `PRIORS`.
        confidence: `(M,)` how much each marker counts.
        settings: the knobs.
        cost: `(K,)` factors on ν, see `visibility`; 1 if None.
        correctives: which weights follow from others.

    Raises:
        InputError: a setting names an unknown shape, or pairs exclude each other on a rig with correctives.
    """
    k = len(names)
    symmetric = pair_indices(names, settings.symmetric)
    movement = (shapes**2).sum(axis=2) @ confidence / max(confidence.sum(), 1e-12)
    regular = 2 * settings.prior * unlikely + 2 * settings.damping * np.diag(movement)
    regular += symmetric_penalty(k, [(int(a), int(b)) for a, b in symmetric], settings.symmetry)
    l1 = settings.sparsity / k * (np.ones(k) if cost is None else cost)
    for name, factor in settings.shape_sparsity.items():
        if name not in names:
            raise InputError(unknown("blendshape", name, names))
        l1[names.index(name)] *= factor
    l1 += settings.prior * PRIORS[settings.prior_kind].absolute
    low, high = settings.bounds or (-np.inf, np.inf)
    off = np.isin(names, settings.kept_at_rest(names))
    lower, upper = np.where(off, 0.0, low), np.where(off, 0.0, high)
    exclusive = pair_indices(names, settings.exclusive)
    if correctives is not None and len(exclusive):
        raise InputError("exclusive pairs cannot be kept on a rig with correctives; leave out one or the other.")
    return FrameSolver(shapes, confidence, regular, l1, lower, upper, exclusive, settings, correctives)


def pair_indices(names: Sequence[str], pairs: Sequence[tuple[str, str]]) -> Ints:
    """Return `(P, 2)` rows of named pairs of shapes.

    Raises:
        InputError: a name is unknown.
    """
    for name in (n for pair in pairs for n in pair):
        if name not in names:
            raise InputError(unknown("blendshape", name, names))
    return np.array([[names.index(a), names.index(b)] for a, b in pairs], dtype=np.int64).reshape(-1, 2)
