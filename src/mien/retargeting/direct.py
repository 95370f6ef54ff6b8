"""`direct`: the character's own shapes, merely scaled and turned onto the actor; the least a method can do."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from mien.core.arrays import Floats
from mien.retargeting.guess import GuessMethod
from mien.retargeting.settings import SolveSettings
from mien.retargeting.terms import Terms


@dataclass(frozen=True)
class Direct(GuessMethod):
    """Take the character's blendshapes for the actor's and solve.

    Attributes:
        solve: the per-frame solve.
    """

    name: ClassVar[str] = "direct"
    about: ClassVar[str] = "the character's shapes as they are, scaled and turned onto the actor; a baseline"

    solve: SolveSettings = field(default_factory=SolveSettings)

    def shapes(self, terms: Terms) -> Floats:
        """Return the character's shapes on the actor, `(K, M, 3)` [cm]."""
        return terms.deltas
