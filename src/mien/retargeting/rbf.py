"""`rbf`: the initial guess alone, the character's shapes warped onto the actor (Seol et al. 2012's proportion matching)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

from mien.capture import Neutral
from mien.core import Clip, Correspondence, Examples, Markers, Rig
from mien.retargeting.energy import SolveSettings
from mien.retargeting.initial import warped_shapes
from mien.retargeting.prepare import prepare
from mien.retargeting.shape_retargeter import ShapeRetargeter, check_markers, shape_retargeter


@dataclass(frozen=True)
class Rbf:
    """Warp the character's blendshapes onto the actor's proportions and solve.

    Attributes:
        smoothing: of the warp (0: interpolating).
        solve: the per-frame solve.
    """

    name: ClassVar[str] = "rbf"
    about: ClassVar[str] = "the character's shapes warped onto the actor; a baseline that needs no range of motion"
    needs: ClassVar[str] = "markers or an animated face, pairs or landmarks"

    smoothing: float = 0.0
    solve: SolveSettings = field(default_factory=SolveSettings)

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
    ) -> ShapeRetargeter:
        """Warp the blendshapes; the take only serves to find the neutral and the skull."""
        del examples
        take, correspondence = check_markers(training, pairs, self.name)
        prepared = prepare(character, take, correspondence, neutral=neutral, rigid=rigid, head_moves=head_moves)
        return shape_retargeter(self.name, character, prepared, warped_shapes(prepared.terms, self.smoothing), self.solve)
