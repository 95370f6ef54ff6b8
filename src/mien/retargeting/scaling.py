"""Bring a space to the size the published constants are for: centred, and divided by one number."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core.arrays import Floats


@dataclass(frozen=True, eq=False)
class Scaling:
    """One mean per dimension and one scale for all, so that dimensions keep their relative size.

    Attributes:
        mean: `(d,)`.
        scale: the largest standard deviation of a dimension.
    """

    mean: Floats
    scale: float

    @classmethod
    def of(cls, rows: Floats) -> Scaling:
        """Return the scaling of rows `(n, d)`, NaN left out; scale 1 if nothing varies."""
        mean = np.nanmean(rows, axis=0)
        scale = float(np.nanstd(rows, axis=0).max())
        return cls(mean, scale if scale > 1e-12 * max(1.0, float(np.abs(mean).max())) else 1.0)

    def __call__(self, rows: Floats) -> Floats:
        """Scale rows `(…, d)`."""
        return np.asarray((rows - self.mean) / self.scale)

    def undo(self, rows: Floats) -> Floats:
        """Return rows `(…, d)` in their own units."""
        return np.asarray(rows * self.scale + self.mean)
