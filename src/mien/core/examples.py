"""Frames of a performance that a person has labelled with character parameters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core.arrays import Floats, Ints, distinct, floats, indices


@dataclass(frozen=True, eq=False)
class Examples:
    """Labelled frames.

    Attributes:
        frames: `(E,)` frame numbers of the training take.
        names: `K` parameter names.
        values: `(E, K)` the parameters at those frames; NaN where not labelled.
    """

    frames: Ints
    names: tuple[str, ...]
    values: Floats

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "names", distinct(self.names, "example parameters"))
        put(self, "values", floats(self.values, (None, len(self.names)), "example values", nan=True))
        put(self, "frames", indices(self.frames, (len(self.values),), np.iinfo(np.int64).max, "example frames"))
