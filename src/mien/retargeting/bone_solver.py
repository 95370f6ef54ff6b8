"""The per-frame solve on what bones really do: Gauss-Newton on the skinned positions.

A rotation is no straight line, so shapes are only its chord.  Here the same energy is
minimised with the points where the skin has them,

    min_w  1/M |Δa - p(w)|²  +  the other terms of `energy`,   p(w) = Σ w_k Δp_k + A (x(w) - x(0) - Σ w_k Δs_k)

`x` are the character's points as the joints carry them, `Δs` the shapes that the method
was fitted with, `Δp` the actor's own version of them, and `A` takes the character's
lengths and directions to the actor's.  Each step is the energy's own lasso around the last
weights, with the derivatives of `p` in place of the shapes.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from mien.core import Correspondence, Markers, Report, Rig
from mien.core.arrays import Flags, Floats, matching
from mien.geometry.bones import Bones, CarriedPoints
from mien.retargeting.energy import RATE, TOLERANCE, FrameSolver
from mien.retargeting.shape_retargeter import ShapeRetargeter
from mien.solve import LassoProblem, solve_lasso

MOST_STEPS = 5
SETTLED = 1e-3
"""A step that changes no weight by more than this is the last."""
FAR = 0.1
"""After a step that changes no weight by more than this, the derivatives from before it still serve."""


@dataclass(frozen=True, eq=False, kw_only=True)
class BoneSolver(FrameSolver):
    """A frame's problem on skinned points.

    Attributes:
        carried: the character's paired points and the joints that carry them.
        to_actor: `(3, 3)` from the character's displacements, as rows, to the actor's [cm].
    """

    carried: CarriedPoints
    to_actor: Floats

    @property
    def convex(self) -> bool:
        """Turning bones are not."""
        return False

    def displaced(self, weights: Floats) -> Floats:
        """Return the actor's points `p`, `(…, M, 3)` [cm] from neutral, under weights `(…, K)`."""
        return self._seen_from_actor(weights, self.carried.at(weights))

    def batch(self, take: Floats, fps: float = RATE) -> tuple[Floats, float]:
        """Solve a take as `step` does, frame after frame; see `FrameSolver.batch`."""
        weights = np.zeros((len(take), len(self.shapes)))
        before: Floats | None = None
        worst = 0.0
        for f, frame in enumerate(take):
            weights[f], residual = self._settled(frame, before, fps)
            before, worst = weights[f], max(worst, residual)
        return weights, worst

    def step(self, displacements: Floats, before: Floats | None, fps: float = RATE) -> Floats:
        """Solve one frame `(M, 3)` [cm] from the weights before it."""
        return self._settled(displacements, before, fps)[0]

    def _settled(self, frame: Floats, before: Floats | None, fps: float) -> tuple[Floats, float]:
        """Return the weights of a frame, and the KKT residual of the last step."""
        seen = ~np.isnan(frame[:, 0])
        weights = np.zeros(len(self.shapes)) if before is None else before
        if not seen.any():
            return weights, 0.0
        follow = 0.0 if before is None else 2 * self._smoothness(fps)
        last, change, residual = weights, np.inf, 0.0
        root = self._roots(seen)
        for _ in range(MOST_STEPS):
            if change > FAR:
                points, slopes = self.around(weights)
                rows = (slopes * root[:, None]).reshape(len(slopes), -1)
                problem = self._linear(rows, follow)
            else:
                points = self.displaced(weights)
            wanted = np.where(seen[:, None], frame - points, 0.0) * root[:, None]
            q = rows @ (wanted.ravel() + weights @ rows) + follow * last
            solved = solve_lasso(problem, q, weights, tol=TOLERANCE)
            change = float(np.abs(solved.weights - weights).max())
            weights, residual = solved.weights, float(solved.kkt)
            if change < SETTLED:
                break
        return weights, residual

    def around(self, weights: Floats) -> tuple[Floats, Floats]:
        """Return `p` `(M, 3)` and its derivatives `(K, M, 3)` [cm]."""
        points, slopes = self.carried.around(weights)
        return self._seen_from_actor(weights, points), self._beside_chords + slopes @ self.to_actor

    def _seen_from_actor(self, weights: Floats, points: Floats) -> Floats:
        """Return what the actor's points do `(…, M, 3)` [cm] where the character's are at `points` [m]."""
        own = np.tensordot(weights, self._beside_chords, axes=1)
        return np.asarray(own + (points - self.carried.rest) @ self.to_actor)

    @cached_property
    def _beside_chords(self) -> Floats:
        """`(K, M, 3)` what the actor's shapes have beyond the chords of the character's bones [cm]."""
        return self.shapes - self.carried.chords @ self.to_actor

    def _roots(self, seen: Flags) -> Floats:
        """Return `(M,)` the square roots of what a squared displacement of each marker costs."""
        weight = np.where(seen, self.confidence, 0.0)
        return np.asarray(np.sqrt(2 * weight / max(weight.sum(), 1e-12)))

    def _linear(self, rows: Floats, follow: float) -> LassoProblem:
        """Return the energy around some weights, given `(K, 3 M)` weighted derivatives and what following costs."""
        gram = rows @ rows.T + self.regular
        gram.flat[:: len(gram) + 1] += follow
        return LassoProblem(gram, self.l1, self.lower, self.upper, self.exclusive)


@dataclass(frozen=True, eq=False)
class BoneRetargeter(ShapeRetargeter):
    """A fitted method whose shapes stand for bones, and whose solve knows what the bones really do."""

    def _report(self, take: Floats, weights: Floats, residual: float, markers: Markers) -> Report:
        """Judge the fit by where the bones carry the points, not by their chords."""
        assert isinstance(self.solver, BoneSolver)
        bent = self.solver.displaced(weights) - np.tensordot(weights, self.shapes, axes=1)
        return super()._report(take - bent, weights, residual, markers)


def on_bones(fitted: ShapeRetargeter, rig: Rig, pairs: Correspondence, bones: Bones) -> BoneRetargeter:
    """Return a method, fitted to the shapes that stand for bones, that solves for the bones themselves.

    Args:
        fitted: the method.
        rig: the character.
        pairs: all the pairs that the method was given.
        bones: what the parameters do to the joints.
    """
    points = pairs.target.take(matching(pairs.names, fitted.markers))
    solver = BoneSolver(
        **{field.name: getattr(fitted.solver, field.name) for field in fields(FrameSolver)},
        carried=CarriedPoints.of(rig, points, bones),
        to_actor=fitted.placement.rotation / (fitted.placement.scale * fitted.centimetre),
    )
    kept = {field.name: getattr(fitted, field.name) for field in fields(ShapeRetargeter)}
    return BoneRetargeter(**{**kept, "solver": solver})
