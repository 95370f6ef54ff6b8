"""`spacetime`: positions and movements of a whole clip in one solve (Seol et al. 2012).

Seol et al. start from the principle that actor and character should move alike, not merely stand
alike: they match derivatives in time, which over a clip is a Poisson equation in the frames, and
combine it with a prior of the character's expressions.

What is settled by us:

- **Boundary conditions.** They fix expressions, such as the neutral, at the ends of a clip and
  where an animator asks for one.  Here every frame's own positions do that, each as a term of weight 1
  beside the movements' λ (`velocity`); nothing has to be known about the ends.
- **The prior** is that of the per-frame solve: damping, sparsity and bounds, or any chosen there.
- **Movements are in the actor's space**, of the markers, as in the range-of-motion paper's
  comparison (its figure 13); with the actor's shapes found by its method or by the warp alone (`shapes`).
- **The answer is exact**, to a stated optimality residual, with bounds and missing markers: block
  Cholesky steps over the clip's frames.  Where nothing is bounded, sparse or missing, the system is
  diagonal in a cosine basis of time and one congruence of the shapes.

A whole clip cannot be solved live: `step` keeps the past fixed and does not know the future.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from mien.capture import Neutral
from mien.core import Clip, Correspondence, Examples, InputError, Markers, Rig
from mien.retargeting.actor_shapes import actor_shapes, check_shapes
from mien.retargeting.prepare import prepare
from mien.retargeting.settings import SolveSettings, in_range
from mien.retargeting.shape_retargeter import check_markers, shape_retargeter
from mien.retargeting.spacetime.retargeter import SpacetimeRetargeter

PAPER: Mapping[str, Any] = {
    **{"velocity": 10.0, "prior": 0.003, "prior_kind": "pca"},
    **{"damping": 0.0, "sparsity": 0.0, "smooth": 0.0, "bounds": None, "off": (), "unseen": False},
}
"""Near their form: movements first, a prior of the character's own shapes, and nothing else."""


@dataclass(frozen=True)
class Spacetime:
    """The space-time method.

    Attributes:
        shapes: how the actor's own blendshapes are found: `range-of-motion`, `alignment` (as its paper
            has it), or `rbf`, the warp alone.
        velocity: λ, how much movements count beside positions, at 30 frames a second and alike at any rate.
        full_range: for `range-of-motion`, whether the training take shows what it shows at full strength.
        solve: what else is paid.
    """

    name: ClassVar[str] = "spacetime"
    about: ClassVar[str] = "positions and movements of a whole clip in one solve (Seol et al. 2012)"
    needs: ClassVar[str] = "markers or an animated face, pairs or landmarks"
    causal: ClassVar[bool] = False
    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = {"paper": PAPER}

    shapes: str = "range-of-motion"
    velocity: float = 1.0
    full_range: bool = True
    solve: SolveSettings = field(default_factory=SolveSettings)

    def __post_init__(self) -> None:
        check_shapes(self.shapes)
        in_range(self, velocity=(0, 1e6))
        if len(self.solve.exclusive) > 0:
            raise InputError(
                "the method 'spacetime' solves all frames at once, which it cannot with exclusive; leave exclusive out, or use "
                "the method 'range-of-motion'."
            )

    def fit(
        self,
        character: Rig,
        training: Markers | Clip,
        pairs: Correspondence | None = None,
        *,
        neutral: Neutral | None = None,
        rigid: Sequence[str] = (),
        head_moves: bool = True,
        examples: Examples | None = None,
    ) -> SpacetimeRetargeter:
        """Find the actor's own blendshapes; clips are solved when they are retargeted.

        Raises:
            InputError: as `range-of-motion`; or the character has correctives.
        """
        if character.correctives is not None:
            raise InputError(
                f"{character.name} has correctives, shapes whose weights are products of others, which the method 'spacetime' "
                "cannot solve for over a whole clip; use the method 'range-of-motion'."
            )
        take, correspondence = check_markers(training, pairs, self.name)
        prepared = prepare(character, take, correspondence, neutral=neutral, rigid=rigid, head_moves=head_moves)
        found = actor_shapes(
            self.shapes, prepared, character, self.solve, full_range=self.full_range, examples=examples
        )
        fitted = shape_retargeter(self.name, character, prepared, np.asarray(found), self.solve)
        return SpacetimeRetargeter.of(fitted, self.velocity)
