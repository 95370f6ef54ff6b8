"""`rbf`: the initial guess alone, the character's shapes warped onto the actor.

The proportion matching of Seol et al. 2012.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from mien.core.arrays import Floats
from mien.retargeting.guess import GuessMethod
from mien.retargeting.initial import warped_shapes
from mien.retargeting.settings import SolveSettings, in_range
from mien.retargeting.terms import Terms


@dataclass(frozen=True)
class Rbf(GuessMethod):
    """Warp the character's blendshapes onto the actor's proportions and solve.

    Attributes:
        smoothing: of the warp (0: interpolating).
        solve: the per-frame solve.
    """

    name: ClassVar[str] = "rbf"
    about: ClassVar[str] = "the character's shapes warped onto the actor; a baseline that needs no range of motion"

    smoothing: float = 0.0
    solve: SolveSettings = field(default_factory=SolveSettings)

    def __post_init__(self) -> None:
        in_range(self, smoothing=(0, np.inf))

    def shapes(self, terms: Terms) -> Floats:
        """Return the character's shapes carried onto the actor, `(K, M, 3)` [cm]."""
        return warped_shapes(terms, self.smoothing)
