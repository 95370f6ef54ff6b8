"""What methods share that guess the actor's shapes from the two neutrals alone, without a range of motion."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import ClassVar

from mien.capture import Neutral
from mien.core import Clip, Correspondence, Examples, Markers, Rig
from mien.core.arrays import Floats
from mien.retargeting.prepare import prepare
from mien.retargeting.settings import SolveSettings
from mien.retargeting.shape_retargeter import ShapeRetargeter, check_markers, shape_retargeter
from mien.retargeting.terms import Terms


class GuessMethod(ABC):
    """A method whose only learning is a guess of the actor's shapes.

    Attributes:
        solve: the per-frame solve.
    """

    name: ClassVar[str]
    needs: ClassVar[str] = "markers or an animated face, pairs or landmarks"
    solve: SolveSettings

    @abstractmethod
    def shapes(self, terms: Terms) -> Floats:
        """Return the guess, `(K, M, 3)` [cm]."""

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
        """Guess the shapes; the take only serves to find the neutral and the skull."""
        del examples
        take, correspondence = check_markers(training, pairs, self.name)
        prepared = prepare(character, take, correspondence, neutral=neutral, rigid=rigid, head_moves=head_moves)
        return shape_retargeter(self.name, character, prepared, self.shapes(prepared.terms), self.solve)
