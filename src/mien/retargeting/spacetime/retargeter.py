"""The fitted form of a method that solves whole clips, and what is left of it frame by frame."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property

from mien.core.arrays import Floats
from mien.retargeting.movement import MovementSolver
from mien.retargeting.shape_retargeter import ShapeRetargeter, State


@dataclass(frozen=True, eq=False)
class SpacetimeRetargeter(ShapeRetargeter):
    """An actor's own blendshapes, solved over whole clips.

    A frame of a whole clip depends on the frames after it.  `step` cannot know them: it minimises the
    same energy with the past held fixed, which comes close (docs/comparators.md) but is not the same.

    Attributes:
        velocity: λ, how much movements count beside positions.
    """

    velocity: float = 1.0

    @classmethod
    def of(cls, fitted: ShapeRetargeter, velocity: float) -> SpacetimeRetargeter:
        """Return a retargeter with another solve."""
        return cls(**{f.name: getattr(fitted, f.name) for f in fields(ShapeRetargeter)}, velocity=velocity)

    def solved(self, take: Floats, fps: float) -> tuple[Floats, float]:
        """Return weights `(F, K)` of a take `(F, M, 3)` [cm], solved at once, and the KKT residual."""
        return self._movement.clip(take, fps)

    def step(self, state: State, frame: Floats) -> tuple[State, Floats]:
        """Map one frame of markers `(M, 3)`, NaN where missing, to `(K,)` weights, knowing only the past."""
        moved, motion = self.still(frame, state.motion)
        weights, left = self._movement.step(moved, state.weights, state.left, self.fps)
        return State(weights, motion, left), self.touching(weights[None], moved[None])[0]

    @property
    def ahead(self) -> bool:
        """A whole clip is solved at once."""
        return True

    @cached_property
    def _movement(self) -> MovementSolver:
        return MovementSolver(self.solver, self.velocity)
