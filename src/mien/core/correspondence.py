"""Which point of the actor is which point of the character."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core.arrays import Flags, Floats, Ints, distinct, floats
from mien.core.errors import InputError
from mien.core.mesh import SurfacePoints


@dataclass(frozen=True, eq=False)
class Correspondence:
    """Pairs of a source point and a point on the character's surface.

    Attributes:
        names: `M` distinct names of the pairs; for captured markers, the markers' names.
        source: the points on the actor's mesh, or None when the source is markers by name.
        target: the points on the character's mesh.
        confidence: `(M,)` between 0 and 1.
    """

    names: tuple[str, ...]
    target: SurfacePoints
    source: SurfacePoints | None = None
    confidence: Floats | None = None

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "names", distinct(self.names, "pairs"))
        m = len(self.names)
        if len(self.target) != m or (self.source is not None and len(self.source) != m):
            points = len(self.target) if len(self.target) != m or self.source is None else len(self.source)
            raise InputError(f"{m} pair names do not match {points} points.")
        confidence = floats(np.ones(m) if self.confidence is None else self.confidence, (m,), "pair confidences")
        if ((confidence < 0) | (confidence > 1)).any():
            raise InputError(
                f"pair confidences must be between 0 and 1, but reach from {confidence.min():g} to {confidence.max():g}."
            )
        put(self, "confidence", confidence)

    def __len__(self) -> int:
        return len(self.names)

    def take(self, rows: Ints | Flags) -> Correspondence:
        """Keep the pairs at `rows`."""
        assert self.confidence is not None
        ids = np.arange(len(self))[rows]
        return Correspondence(
            tuple(self.names[i] for i in ids),
            self.target.take(ids),
            None if self.source is None else self.source.take(ids),
            self.confidence[ids],
        )
