"""What a retargeting method is, and what fitting one returns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, Protocol

from mien.capture import Neutral
from mien.core import Clip, Correspondence, Examples, Markers, Report, Rig
from mien.core.arrays import Floats


class Retargeter(Protocol):
    """A fitted method: frozen, shareable, and the same answer for whole takes and frame by frame.

    Of a method that is not `causal`, frame by frame is an approximation, since it knows no later frames.
    """

    def retarget(self, performance: Any) -> tuple[Clip, Report]:
        """Map a whole performance onto the character."""
        ...

    def start(self) -> Any:
        """Return the state before the first frame."""
        ...

    def step(self, state: Any, frame: Floats) -> tuple[Any, Floats]:
        """Map one frame, knowing only what came before.

        Args:
            state: what the step before returned.
            frame: the frame, in the performance's own terms.

        Returns:
            The state for the next frame, and `(K,)` weights.
        """
        ...


class Method(Protocol):
    """Frozen parameters of one published system or baseline.

    A method whose whole takes depend on later frames says so: `causal: ClassVar[bool] = False`.
    """

    name: ClassVar[str]
    about: ClassVar[str]
    needs: ClassVar[str]

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
    ) -> Retargeter:
        """Learn all that is needed to map this actor onto this character."""
        ...
